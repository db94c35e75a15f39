"""Decoupling: mass distributions that are balanced and keep the inertia on the base constant.

The base feels a linkage like a rigid body if its momentum is ``M t`` with a constant M for
every twist t of the base and every motion of the joints. That is the balance of another
linkage, whose base moves freely and carries a body with the inertia ``-M``: all conditions are
linear in the parameters of the bodies and of that one, and have the same orders, ranks and
certainty. The body on the base is given by the others, so that both null spaces have the same
dimension. (J. J. de Jong, PhD thesis, University of Twente, section 2.4.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.conditions.collect import conditions_by_order, relative_tolerance
from balance.space.inertial_parameters.conversions import from_chain
from balance.space.momentum.regressor import parameters_per_body
from balance.space.spaces.compute_space import as_space, design_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.given_masses import residual_of
from balance.space.spaces.space_data import Order
from balance.space.spaces.subspace import subspace
from balance.support.tolerances import AS_GIVEN_RESIDUAL
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import (
    GROUND,
    Body,
    Joint,
    Linkage,
    LinkPose,
    UnassembledLinkage,
    names_of,
)
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import repr_lines

# Name of the base and of its joints, with signs in front where the file uses it.
BASE = "free_base"


@dataclass(frozen=True, eq=False)
class Decoupling:
    """Decoupled mass distributions of a linkage, and whether those of its file are.

    Attributes:
        space: the design space of balanced distributions that it was asked for.
        freed: the design space of the linkage on a base that moves freely and carries a body,
            the first of its bodies; of the same certainty as ``space``.
    """

    space: DesignSpace
    freed: DesignSpace = field(repr=False)

    def __repr__(self) -> str:
        """Three lines: the verdict, the space, its certainty."""
        return repr_lines(
            f"Decoupling of {self.space.linkage.name}",
            self.words,
            self.parts,
            self.freed.assurance,
        )

    @property
    def exact(self) -> bool | None:
        """Whether the masses of the file are decoupled at all orders; None without masses."""
        return self.freed.as_given.balanced

    @property
    def residual(self) -> float | None:
        """Residual of the conditions for the masses of the file; see `AsGiven`."""
        return self.freed.as_given.residual

    @cached_property
    def order(self) -> int | None:
        """Highest order of derivative up to which the masses of the file are decoupled.

        Order 0: no momentum at the reference pose; order k: nor in the derivatives of the
        momentum up to k, and those of the inertia on the base vanish up to k. If all orders
        are decoupled, the one at which the conditions are complete. None if order 0 is not,
        or without masses.
        """
        freed, last = self.freed, self.freed.orders[-1].order
        if self.exact is None or self.exact:
            return self.kmax if self.exact else None
        chain = freed.chain
        by_order = conditions_by_order(
            chain, freed.chain_transfers.rows, False, relative_tolerance(chain), last
        )
        held = -1
        for order, conditions in enumerate(by_order):
            force = freed.balance == "force"
            residual = residual_of(freed.linkage, chain, freed.planar, force, conditions.rows)
            if residual is None or residual > AS_GIVEN_RESIDUAL:
                break
            held = order
        return held if held >= 0 else None

    @property
    def orders(self) -> tuple[Order, ...]:
        """Rank and nullity of the conditions on the bodies of the linkage, by order."""
        return tuple(o._replace(rank=o.rank - self._size) for o in self.freed.orders)

    @property
    def rank(self) -> int:
        """Number of independent conditions on the bodies of the linkage."""
        return self.freed.rank - self._size

    @property
    def nullity(self) -> int:
        """Dimension of the space of decoupled distributions."""
        return self.freed.nullity

    @property
    def serial_nullity(self) -> int:
        """Dimension of its part that the opened linkage has too."""
        return self.freed.serial_nullity

    @property
    def kmax(self) -> int | None:
        """First order at which the rank has its final value; None if no order reaches it."""
        return self.freed.kmax

    @property
    def parts(self) -> str:
        """Dimension and parts of the space of decoupled distributions, in words."""
        serial = self.serial_nullity
        return (
            f"{self.nullity} of {self.rank + self.nullity} dimensions: {serial} serial + "
            f"{self.nullity - serial} parallel"
        )

    @property
    def words(self) -> str:
        """The verdict on the masses of the file in one line."""
        if self.exact is None:
            return "no masses"
        if self.exact:
            return "yes: balanced, and the inertia on the base is constant"
        if not self.space.as_given.balanced:
            return "no: not balanced"
        first = 0 if self.order is None else self.order + 1
        return f"no: balanced, but the inertia on the base changes at order {first}"

    @cached_property
    def basis(self) -> Array:
        """Basis of the decoupled distributions, in rows and units of ``space.basis``.

        Shape (parameters, nullity); the first ``serial_nullity`` columns span the serial part.
        """
        return self.decoupled_space.basis

    @cached_property
    def decoupled_space(self) -> DesignSpace:
        """The decoupled distributions as a design space, for `balance.masses.feasible`.

        Its transfers are those of the linkage on the ground.
        """
        space, given = self.space, self.freed.basis[self._size :]
        G, serial = from_chain(space.chain.frame, space.planar, False), self.serial_nullity
        blocks = given.reshape(-1, len(G), given.shape[1])
        columns = np.asarray(np.linalg.solve(G, blocks), np.float64).reshape(given.shape)
        decoupled = subspace(space, columns[:, :serial], columns[:, serial:], self.orders)
        return replace(decoupled, poses=self.freed.poses, settled=self.freed.settled)

    @property
    def _size(self) -> int:
        """Number of parameters of the body on the base."""
        return parameters_per_body(self.space.planar, False)

    def to_dict(self) -> dict[str, object]:
        """Convert to the entry ``decoupled`` of the report, ready for JSON."""
        return {
            "order": self.order,
            "exact": self.exact,
            "residual": self.residual,
            "words": self.words,
            "orders": [order._asdict() for order in self.orders],
            "kmax": self.kmax,
            "rank": self.rank,
            "nullity": self.nullity,
            "serial": self.serial_nullity,
            "parallel": self.nullity - self.serial_nullity,
            "certainty": self.freed.level,
            "basis": self.basis.tolist(),
        }


def decoupling(space: DesignSpace | LinkageLike) -> Decoupling:
    """Find the mass distributions that are balanced and keep the inertia on the base constant.

    A linkage with such masses is decoupled: a base that moves feels it like a rigid body, and
    does not drive its joints. The conditions are ``h_w = 0`` and ``∂M = 0`` in every motion,
    with the inertia M of all bodies together about a point of the base (see
    `balance.space.locked_inertia`), six by six, or three by three in a plane.

    Args:
        space: a design space for dynamic balance, or the linkage, its path or its name. If it
            is certified, so is the result.

    Returns:
        Rank by order and a basis of the decoupled distributions; whether the masses of the
        file are decoupled, and up to which order.

    Raises:
        UsageError: the space is one for force balance.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, section 2.4.

    Example:
        >>> import balance
        >>> decoupled = balance.space.decoupling(balance.design_space("robot.urdf"))
        >>> [order.rank for order in decoupled.orders], decoupled.words
        ([3, 7, 8], 'no: not balanced')
    """
    space = as_space(space)
    if space.balance != "dynamic":
        raise UsageError("decoupling is about dynamic balance: leave out the force balance")
    linkage = _with_free_base(space)
    motion = _free_base_motion(space, linkage)
    freed = design_space(
        linkage, motion, max_order=space.highest_order, spatial=not space.planar
    )
    certified = isinstance(space, CertifiedSpace)
    return Decoupling(space, certify(freed) if certified else freed)


def _with_free_base(space: DesignSpace) -> Linkage:
    """Put the linkage of a design space on a base that moves freely.

    The base has six degrees of freedom, or three in the plane of the motion. Its parameters
    are the negative of those of all bodies together, so that the masses of the file have no
    momentum when the base moves with the linkage locked at the reference pose.

    Args:
        space: a design space of the linkage.

    Returns:
        The linkage at the same pose; the joints of the base come before its own, and the base
        before its bodies.
    """
    linkage = space.linkage
    joints = tuple(_base_joints(space))
    count = len(joints)

    def shifted(link: int) -> int:
        return count - 1 if link == GROUND else link + count

    given = np.array([body.inertia for body in linkage.bodies]).reshape(-1, 10)
    base = Body(joints[0].whole, count - 1, freeze(-given.sum(axis=0)), freeze(np.eye(4)))
    entries = {f.name: getattr(linkage, f.name) for f in fields(UnassembledLinkage)}
    draft = UnassembledLinkage(
        **entries
        | {
            "joints": (
                *joints,
                *(replace(j, parent=shifted(j.parent)) for j in linkage.joints),
            ),
            "bodies": (base, *(replace(b, link=shifted(b.link)) for b in linkage.bodies)),
            "loops": tuple(
                replace(x, end=shifted(x.end), successor=shifted(x.successor))
                for x in linkage.loops
            ),
            "mimics": tuple(
                replace(x, joint=x.joint + count, source=x.source + count)
                for x in linkage.mimics
            ),
            "named_inputs": (),
            "notices": (),
            "places": {
                name: LinkPose(shifted(place.link), place.pose)
                for name, place in linkage.places.items()
            },
            "tree": None if linkage.tree is None else _tree_with(linkage.tree, joints),
            "displaced": _displaced(linkage, count),
            "other_poses": (),
        }
    )
    return assemble(draft, (*names_of(joints), *linkage.inputs), exactly=True)


def _free_base_motion(space: DesignSpace, linkage: Linkage) -> Motion | None:
    """Extend the motion of a design space by free motion of the base.

    Args:
        space: the design space of the linkage on the ground.
        linkage: the result of `_with_free_base`.
    """
    motion = space.motion
    if motion is None:
        return None
    if motion.relations:
        return Motion.parse(motion.relations, linkage.inputs)
    count = len(linkage.inputs) - len(motion.inputs)
    rows, columns = motion.basis.shape
    basis = np.zeros((count + rows, count + columns))
    basis[:count, :count] = np.eye(count)
    basis[count:, count:] = motion.basis
    return Motion((*linkage.inputs[:count], *motion.inputs), (), freeze(basis))


def _base_joints(space: DesignSpace) -> Iterator[Joint]:
    """Make the joints of the base: translations first, and rotations about the middle."""
    frame = space.chain.frame
    names = {*names_of(space.linkage.joints), *space.linkage.places}
    name = BASE
    while any(taken.startswith(name) for taken in names):
        name = f"_{name}"
    # In a plane, two translations along it and a rotation about its normal.
    axes = frame.R if space.planar else np.eye(3)
    steps = [("prismatic", n) for n in axes[: 2 if space.planar else 3]]
    steps += [("revolute", n) for n in axes[2 if space.planar else 0 :]]
    for k, (kind, n) in enumerate(steps):
        turning = kind == "revolute"
        screw = [n, np.cross(frame.origin, n)] if turning else [np.zeros(3), n]
        yield Joint(
            f"{name}.{k}",
            kind,
            k - 1,
            freeze(np.concatenate(screw)),
            freeze(frame.origin),
            numbered=True,
        )


def _displaced(linkage: Linkage, count: int) -> Array | None:
    """Return the positions of all joints; those of the base are zero."""
    if linkage.displaced is None:
        return None
    return freeze(np.concatenate([np.zeros(count), linkage.displaced]))


def _tree_with(tree: Element, joints: Sequence[Joint]) -> Element:
    """Put the base joints under the root link of a tree of elements, at its frame."""
    carried = {
        side.attributes["link"]
        for joint in tree.every("joint")
        for side in joint.every("child")
    }
    roots = [link.name for link in tree.every("link") if link.name not in carried]
    added = [make_elements.link(joint.name) for joint in joints]
    added.append(make_elements.link(joints[0].whole))
    ends = [item.name for item in added]
    at = np.zeros(3)
    for joint, parent, child in zip(joints, ends, ends[1:], strict=False):
        turning = joint.kind == "revolute"
        here = joint.point if turning else at
        axis = number_words(joint.screw[:3] if turning else joint.screw[3:])
        kind = "continuous" if turning else "prismatic"
        step = _origin(here - at)
        added.append(make_elements.joint(joint.name, kind, parent, child, step, (axis, "")))
        at = here
    fixed = make_elements.joint(joints[0].whole, "fixed", ends[-1], roots[0], _origin(-at))
    return replace(tree, children=(*added, fixed, *tree.children))


def _origin(shift: Array) -> Element:
    """Make the ``<origin>`` of a translation (3,), metres."""
    return Element("origin", {"xyz": number_words(shift)})
