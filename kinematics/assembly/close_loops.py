"""Close the loops of a linkage whose file pose leaves them open.

Newton steps of least norm close a pose that is nearly closed without moving it along its
freedoms. Where they fail, damped steps on all joints first bring the two sides of every weld
together, from the pose of the file and then from seeded poses ever further away from it. The
pose found becomes the reference pose.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.assembly.rereference import rereference
from kinematics.closure.newton import Pose, forward_kinematics
from kinematics.errors import OpenLoopError
from kinematics.linalg.gauss_newton import (
    Iterate,
    LeastNorm,
    gauss_newton,
    never_stop,
    step_grows,
)
from kinematics.mobility.components import Component, split_components
from kinematics.mobility.first_order import closure_equations
from kinematics.model.arrays import Chain
from kinematics.model.chain import arrange_loops, extent, paths
from kinematics.model.full_turns import position_text, wrap_turns
from kinematics.model.linkage import Notice, UnassembledLinkage
from kinematics.spatial.screws import hat
from kinematics.tolerances import (
    ALMOST_CLOSED_RESIDUAL,
    CLOSING_STEP_RELATIVE,
    CLOSURE_RESIDUAL,
    NEARLY_CLOSING_STEP_RELATIVE,
    OTHER_POSE_DISTANCE,
    UNMOVED_DISTANCE,
)

__all__ = [
    "close_loops",
    "nearby_starts",
]

Array = NDArray[np.float64]
Repair = Callable[[UnassembledLinkage, Sequence[int], float, float], UnassembledLinkage | str]

# Distances from the pose of the file (radians, characteristic lengths) of random starts.
START_DISTANCES = (0.1, 0.3, 1.0, 3.0)
# Number of random starts at each distance.
STARTS_PER_DISTANCE = 8
# Seed of the random starts; notices name it.
SEED = 0


def close_loops(draft: UnassembledLinkage, repair: Repair | None = None) -> UnassembledLinkage:
    """Move a linkage to a pose that closes its loops; unchanged if its own pose does.

    Components are closed one by one, with tolerances relative to their own size. A notice
    states how far the loops were open, which start led to the solution, and which joint moved
    furthest.

    Args:
        draft: the linkage as its file describes it.
        repair: repair of a component whose loops almost close, such as
            `kinematics.assembly.repair_axes.repair_component`. Its arguments are the draft with
            welds moved to close the loops, the joints of the component, and the largest angle
            (rad) and distance (m) by which welds were moved; it returns a draft, or why it
            cannot.

    Returns:
        The draft with closed loops, and a notice if joints were moved.

    Raises:
        OpenLoopError: no start leads to a closed pose.
        MobilityError: a component is too small for double precision.
    """
    if all(np.array_equal(loop.gap, np.eye(4)) for loop in draft.loops):
        return draft
    parts = split_components(draft)
    loose = set(range(len(draft.loops))).difference(*(part.loops for part in parts))
    if any(not np.array_equal(draft.loops[k].gap, np.eye(4)) for k in loose):
        raise _open_loop_error(draft, "")
    found = [_close_component(part, repair) for part in parts]
    for each in found:
        if isinstance(each, str):
            raise _open_loop_error(draft, each)
    closings = [each for each in found if isinstance(each, _ClosedComponent)]
    chain = arrange_loops(draft)
    q = np.zeros(len(draft.joints))
    for each in closings:
        q += each.part.all_positions(each.q, chain.units)
    furthest = max(closings, key=_joint_motion)
    there = replace(
        rereference(draft, chain, q), notices=(*draft.notices, *_closing_notices(furthest))
    )
    for each in closings:
        if each.open and repair is not None:
            better = repair(there, each.part.joints.tolist(), *each.open)
            if isinstance(better, str):
                raise _open_loop_error(draft, better)
            there = better
    return there


class _ClosedComponent(NamedTuple):
    """A closed pose of a component.

    Attributes:
        part: the component.
        q: positions of its joints, in its own units.
        start: number of the start that led there.
        open: angle and distance (metres) by which welds stay open; empty if they do not.
    """

    part: Component
    q: Array
    start: int
    open: tuple[float, ...] = ()


def _joint_motion(closing: _ClosedComponent) -> float:
    """Compute how far joints moved; 0 if welds were moved instead."""
    q, _ = wrap_turns(closing.part.draft.joints, closing.q)
    size = float(np.abs(q).max())
    return size if size > ALMOST_CLOSED_RESIDUAL or not closing.open else 0.0


def _close_component(part: Component, repair: Repair | None) -> _ClosedComponent | str:
    """Close the loops of a component; if no pose does, return a hint for the user."""
    gaps, hint = _weld_gaps(part), ""
    for number, start in enumerate(_start_positions(part.joints.size)):
        q = _solve_from(part.chain, gaps, start)
        if q is not None:
            return _ClosedComponent(part, q, number)
        if number == 0 and repair is not None:
            found = _close_with_repair(part, repair)
            if not isinstance(found, str):
                return found
            hint = found
    return hint


def _weld_gaps(part: Component) -> Array:
    """Compute displacements of the welds of a component in its coordinates; (loops, 4, 4)."""
    gaps = [_to_chain_frame(part.chain, loop.gap) for loop in part.draft.loops]
    return np.reshape(gaps, (-1, 4, 4))


def nearby_starts(chain: Chain) -> Iterator[Array]:
    """Yield joint positions of closed poses some distance from the reference pose.

    Args:
        chain: the linkage as arrays, with loops closed at the reference pose.

    Returns:
        Joint positions (n,), chain units.
    """
    gaps = np.tile(np.eye(4), (len(chain.ends), 1, 1))
    for start in _start_positions(chain.parent.size):
        q = _solve_from(chain, gaps, start)
        if q is not None and np.abs(q).max() > OTHER_POSE_DISTANCE:
            yield q


def _start_positions(joints: int) -> Iterator[Array]:
    """Yield the pose of the file, then random poses ever further from it."""
    yield np.zeros(joints)
    rng = np.random.default_rng(SEED)
    for distance in START_DISTANCES:
        for _ in range(STARTS_PER_DISTANCE):
            yield rng.uniform(-distance, distance, joints)


def _solve_from(chain: Chain, gaps: Array, start: Array) -> Array | None:
    """Find joint positions near ``start`` that close the loops; None if there are none."""
    if (q := _newton_closure(chain, gaps, start)) is not None:
        return q
    return _newton_closure(chain, gaps, _minimise_opening(chain, gaps, start))


def _minimise_opening(chain: Chain, gaps: Array, start: Array) -> Array:
    """Find joint positions near ``start`` that leave the loops open as little as possible."""
    from scipy.optimize import least_squares

    before = paths(chain.parent)
    q: Array = least_squares(
        lambda q: _loop_residual(chain, gaps, forward_kinematics(chain, q)), start,
        lambda q: _residual_jacobian(chain, gaps, before, forward_kinematics(chain, q)),
        max_nfev=200,
    ).x  # fmt: skip
    return q


def _close_with_repair(part: Component, repair: Repair) -> _ClosedComponent | str:
    """Close a component up to a small gap and repair its axes; explain if the repair fails.

    Steps leave out directions in which the loops hardly open: those are freedoms that
    rounded axes block.
    """
    scaled = part.in_frame(extent(part.draft))
    chain, gaps, home = scaled.chain, _weld_gaps(scaled), np.zeros(part.joints.size)
    for far in (False, True):
        q = _minimise_opening(chain, gaps, home) if far else home
        rule = LeastNorm(NEARLY_CLOSING_STEP_RELATIVE, longest=0.5)
        q = gauss_newton(
            closure_equations(chain, gaps), q, rule, never_stop, never_stop, 10
        ).last.next
        D = _loop_residual(chain, gaps, forward_kinematics(chain, q))[: 12 * len(gaps)].reshape(
            -1, 3, 4
        )
        angle, distance = (float(np.abs(part).max()) for part in (D[..., :3], D[..., 3]))
        if max(angle, distance) <= ALMOST_CLOSED_RESIDUAL:
            left = angle, distance * chain.frame.length
            better = repair(rereference(part.draft, chain, q), range(q.size), *left)
            return better if isinstance(better, str) else _ClosedComponent(scaled, q, 0, left)
    return ""


def _newton_closure(chain: Chain, gaps: Array, q: Array) -> Array | None:
    """Close the loops by Newton steps of least norm, as long as they shrink; None if they fail.

    One more step follows after the loops are closed, so that they are closed to round-off.
    """

    def closed(path: Sequence[Iterate]) -> bool:
        pose = forward_kinematics(chain, path[-1].x)
        opening = float(np.abs(_loop_residual(chain, gaps, pose)).max())
        return opening <= CLOSURE_RESIDUAL and (
            len(path) == 1 or path[-2].size <= CLOSURE_RESIDUAL
        )

    equations, rule = closure_equations(chain, gaps), LeastNorm(CLOSING_STEP_RELATIVE)
    last, solved = gauss_newton(equations, q, rule, closed, step_grows(0.5), 10)
    return last.x if solved else None


def _loop_residual(chain: Chain, gaps: Array, pose: Pose) -> Array:
    """Compute the entries of ``D - 1`` for every loop, then the errors of mimic joints.

    D carries the successor side of the weld to its end side. Unlike the twist of D, the entries
    vanish at no other pose than a closed one, not even where D is half a turn.
    """
    D = _weld_displacements(chain, gaps, pose)
    return np.concatenate([(D - np.eye(4))[:, :3].ravel(), chain.mimics @ pose.q])


def _residual_jacobian(chain: Chain, gaps: Array, before: Array, pose: Pose) -> Array:
    """Compute derivatives of the openness by joint position: ``s D`` to the end, less ``D s``.

    Args:
        chain: the linkage as arrays.
        gaps: displacements of the welds at the reference pose (loops, 4, 4).
        before: that of `kinematics.model.chain.paths`.
        pose: the pose.
    """
    D, s = _weld_displacements(chain, gaps, pose)[:, None], hat(pose.screws)
    ends, successors = (before[side][..., None, None] for side in chain.ends.T)
    entries = (ends * (s @ D) - successors * (D @ s))[..., :3, :]
    return np.concatenate([entries.transpose(0, 2, 3, 1).reshape(-1, len(s)), chain.mimics])


def _weld_displacements(chain: Chain, gaps: Array, pose: Pose) -> Array:
    """Compute displacements D of every loop, from its successor side to its end side."""
    padded = np.concatenate([pose.H, np.eye(4)[None]])  # link -1 is the ground
    ends, successors = padded[chain.ends[:, 0]], padded[chain.ends[:, 1]]
    D: Array = ends @ np.linalg.inv(gaps) @ np.linalg.inv(successors)
    return D


def _closing_notices(found: _ClosedComponent) -> list[Notice]:
    """Make the notice about the pose that was found."""
    if _joint_motion(found) <= UNMOVED_DISTANCE:
        return []
    chain, number, joints = found.part.chain, found.start, found.part.draft.joints
    q, _ = wrap_turns(joints, found.q)
    home = forward_kinematics(chain, np.zeros(q.size))
    opening = np.abs(_loop_residual(chain, _weld_gaps(found.part), home)).max()
    furthest = int(np.argmax(np.abs(q)))
    joint = joints[furthest]
    start = "the pose of the file" if number == 0 else f"random start {number} (seed {SEED})"
    text = (
        f"the loops were open by {opening:.2g} (radians, characteristic lengths); closed from "
        f"{start}; joint '{joint.name}' moved furthest, by "
        f"{position_text(joint, q[furthest] * chain.units[furthest])}"
    )
    return [Notice("assembled", text)]


def _open_loop_error(draft: UnassembledLinkage, hint: str) -> OpenLoopError:
    """Make the error for the loop that is furthest open in the file."""
    worst, distance, angle = draft.loops[0], 0.0, 0.0
    for loop in draft.loops:
        p = draft.joints[loop.end].point
        gap = float(np.linalg.norm(loop.gap[:3, :3] @ p + loop.gap[:3, 3] - p))
        cosine = 0.5 * (np.trace(loop.gap[:3, :3]) - 1.0)
        turn = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        if gap + turn > distance + angle:
            worst, distance, angle = loop, gap, turn
    starts = 1 + len(START_DISTANCES) * STARTS_PER_DISTANCE
    return OpenLoopError(draft.source, worst.name, distance, angle, starts, hint)


def _to_chain_frame(chain: Chain, H: Array) -> Array:
    """Convert a displacement of inertial space to the coordinates of the chain."""
    out, o = H.copy(), chain.frame.origin
    out[:3, 3] = (H[:3, :3] @ o + H[:3, 3] - o) / chain.frame.length
    return out
