"""Components of a linkage: joints that loops and mimic relations couple, in own coordinates.

Loops that share no joint and no mimic relation move independently. Tolerances in a loop are
relative to the size of its component, not to that of the linkage: a four-bar at the end of a
long arm has the mobility that it has without the arm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kinematics.closure.mobility.first_order import first_order
from kinematics.closure.series import loop_matrix
from kinematics.errors import MobilityError
from kinematics.model.arrays import Chain, Frame
from kinematics.model.chain import arrange_loops, carriers, clusters, extent, move_chain
from kinematics.model.linkage import Mimic, UnassembledLinkage
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.tolerances import COINCIDENT_JOINTS_RELATIVE, COMPONENT_SIZE_RELATIVE


class Component(NamedTuple):
    """Joints that depend on one another, without the rest of the linkage.

    Attributes:
        joints: their numbers in the linkage (n,), ascending.
        draft: a linkage of these joints alone; all others are locked.
        chain: its arrays, in its own coordinates and units of its own size.
        loops: numbers of its loops in the linkage.
    """

    joints: IntArray
    draft: UnassembledLinkage
    chain: Chain
    loops: tuple[int, ...]

    def with_columns(self, whole: Chain) -> Chain:
        """Choose the joints and columns that are independent in the whole chain for its own."""
        independent = np.ones(whole.parent.size, dtype=bool)
        independent[whole.dependent] = False
        indices = np.flatnonzero(independent[self.joints])
        joints = self.joints[indices]
        ratio = whole.units[joints] / self.chain.units[indices]
        basis = ratio[:, None] * whole.columns[joints]
        return move_chain(self.chain, indices, basis[:, np.any(basis != 0.0, axis=0)])

    def in_frame(self, frame: Frame) -> Component:
        """Return the same component in other coordinates."""
        return self._replace(chain=arrange_loops(self.draft, frame))

    def all_positions(self, q: Array, units: Array) -> Array:
        """Extend positions of its joints to all joints of the linkage, 0 for other components.

        Args:
            q: positions of the joints of the component (n,), in its own units.
            units: unit of each joint of the linkage, in metres or radians; `Chain.units`.
        """
        out = np.zeros(units.size)
        out[self.joints] = q * self.chain.units / units[self.joints]
        return out


def split_components(
    draft: UnassembledLinkage,
    locked: frozenset[int] = frozenset(),
    *,
    whole: Chain | None = None,
) -> list[Component]:
    """Split a linkage into its components.

    Args:
        locked: numbers of joints that are kept out of them, as if they were rigid; with a
            joint its mimic joints.
        whole: its arrays, from `kinematics.model.chain.arrange_loops`, if they are at hand.

    Raises:
        MobilityError: a component is too small for double precision, beside its distance from
            the ground.
    """
    whole = arrange_loops(draft) if whole is None else whole
    groups = clusters(whole, locked)
    moving = all(loop.end != loop.successor for loop in draft.loops)
    if moving and groups == [list(range(len(draft.joints)))]:
        part = replace(draft, places={}, displaced=None, other_poses=())
        _check_size(part)
        return [Component(whole.joints, part, whole, tuple(range(len(draft.loops))))]
    return [component_of(draft, group) for group in groups]


def component_of(draft: UnassembledLinkage, joints: Sequence[int]) -> Component:
    """Make one component of a linkage.

    Args:
        joints: numbers of its joints, ascending: a group of `kinematics.model.chain.clusters`.

    Raises:
        MobilityError: it is too small for double precision.
    """
    number = {joint: k for k, joint in enumerate(joints)}
    carried = carriers([joint.parent for joint in draft.joints], joints).tolist()
    ends = {k: (carried[x.end], carried[x.successor]) for k, x in enumerate(draft.loops)}
    loops = tuple(k for k, (end, successor) in ends.items() if end != successor)
    part = replace(
        draft,
        joints=tuple(
            replace(draft.joints[j], parent=carried[draft.joints[j].parent]) for j in joints
        ),
        bodies=tuple(
            replace(body, link=number[body.link])
            for body in draft.bodies
            if body.link in number
        ),
        loops=tuple(
            replace(draft.loops[k], end=ends[k][0], successor=ends[k][1]) for k in loops
        ),
        mimics=tuple(_renumbered(x, number) for x in draft.mimics if x.joint in number),
        places={},
        displaced=None,
        other_poses=(),
    )
    _check_size(part)
    return Component(np.array(joints, dtype=np.int64), part, arrange_loops(part), loops)


def _renumbered(mimic: Mimic, number: Mapping[int, int]) -> Mimic:
    """Write a mimic relation with the numbers of a component.

    A joint of ratio zero rests, and its source is in no component with it: q = -q.
    """
    joint = number[mimic.joint]
    if mimic.source not in number:
        return Mimic(joint, joint, -1.0)
    return Mimic(joint, number[mimic.source], mimic.ratio)


def _check_size(part: UnassembledLinkage) -> None:
    """Refuse a component so small, beside its distance from the ground, that digits are lost.

    Only loops are closed in its own units: a component of joints that follow one another, such
    as a gear on an axis, may be of any size.

    Raises:
        MobilityError: it is too small for double precision.
    """
    if not part.loops:
        return
    size = extent(part).length
    far = max(float(np.abs(joint.point).max()) for joint in part.joints)
    if COINCIDENT_JOINTS_RELATIVE * far < size < COMPONENT_SIZE_RELATIVE * far:
        names = ", ".join(f"'{loop.name}'" for loop in part.loops[:3])
        raise MobilityError(
            f"{part.source}: the joints of loop {names} are {size:.1e} m apart, {far:.1e} m "
            "from the ground: too small for double precision there; write the file in a "
            "frame near that loop",
            joints=[joint.name for joint in part.joints],
        )


def component_freedoms(
    parts: Sequence[Component], count: int, ranks: Sequence[int | None] = ()
) -> tuple[Array, list[Array]]:
    """Compute the null space of the loop matrix of a linkage, component by component.

    Args:
        parts: the components of the linkage.
        count: number of its joints; those in no component are free.
        ranks: rank of the loop matrix of each component, None where its singular values
            decide.

    Returns:
        Orthonormal joint rates that close the loops (count, freedom); singular values of the
        loop matrix of each component.
    """
    outside = np.ones(count, dtype=bool)
    blocks, spectra = [], []
    for part, rank in zip(parts, ranks or [None] * len(parts), strict=True):
        outside[part.joints] = False
        free, values = first_order(loop_matrix(part.chain), rank=rank)
        block = np.zeros((count, free.shape[1]))
        block[part.joints] = free
        blocks.append(block)
        spectra.append(values)
    return np.hstack([np.eye(count)[:, outside], *blocks]), spectra
