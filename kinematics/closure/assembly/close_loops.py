"""Close the loops of a linkage whose file pose leaves them open.

Newton steps of least norm close a pose that is nearly closed without moving it along its
freedoms. Where they fail, or move the links far, closed poses are looked for from the pose of
the file and from seeded poses around it, and the one of least motion is taken; see
`kinematics.closure.assembly.nearest_pose`. The pose found becomes the reference pose.

With the joints held that most loops share, a component may fall apart into pieces that move
independently. A start from which one piece closes with probability p closes n of them at once
with pⁿ only; one by one, every piece takes the start that suits it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from kinematics.closure.assembly.closed_component import (
    ClosedComponent,
    closing_notices,
    joint_motion,
    mobility_notices,
    open_loop_error,
    other_poses_of,
    sum_positions,
)
from kinematics.closure.assembly.closure_residual import (
    displacement_residual,
    minimise_residual,
    newton_closure,
    weld_gaps,
)
from kinematics.closure.assembly.nearest_pose import OpenLoops, closed_poses, motion_weights
from kinematics.closure.assembly.rereference import rereference
from kinematics.closure.mobility.components import Component, split_components
from kinematics.closure.mobility.first_order import closure_equations
from kinematics.closure.newton import forward_kinematics
from kinematics.model.chain import arrange_loops, extent, loop_joints
from kinematics.model.linkage import UnassembledLinkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import LeastNorm, gauss_newton, never_stop
from kinematics.numerics.tolerances import (
    ALMOST_CLOSED_RESIDUAL,
    NEAR_MOTION,
    NEARBY_MOTION_RELATIVE,
    NEARLY_CLOSING_STEP_RELATIVE,
    OTHER_MOTION_RELATIVE,
    OTHER_POSE_DISTANCE,
)

Repair = Callable[[UnassembledLinkage, Sequence[int], float, float], UnassembledLinkage | str]
CloseComponent = Callable[[Component], ClosedComponent | str]

# Random starts: how many near the pose of the file, and their mean distance from it in each
# joint (radians, characteristic lengths); the same of further ones, if no start closes.
NEAR_STARTS, NEAR_DISTANCE = 28, 0.3
FAR_STARTS, FAR_DISTANCES = 8, (0.1, 0.3, 1.0, 3.0)
STARTS = 1 + NEAR_STARTS + len(FAR_DISTANCES) * FAR_STARTS
# Closed poses of a component that are kept.
MAX_POSES = 3
# Seed of the random starts.
SEED = 0
# Most units of the joints alone in that of a chain: the joints are in one place otherwise.
MOST_UNITS = 1e3
# Weight of the motion of joints that other joints should spare; those of others are up to 1.
PREFERENCE = 10.0
# Motion, over the root of the closure residual at the pose of the file, up to which a closed
# pose is that pose: at a dead centre it is of the size of 1.
MOTION_PER_ROOT_OF_RESIDUAL = 30.0
# Most joints that are held for a component to fall apart.
MAX_HELD = 3


def close_loops(
    draft: UnassembledLinkage,
    repair: Repair | None = None,
    held: frozenset[int] = frozenset(),
    preferred: frozenset[int] = frozenset(),
) -> UnassembledLinkage:
    """Move a linkage to a pose that closes its loops; unchanged if its own pose does.

    Components are closed one by one, with tolerances relative to their own size. A notice
    states how far the loops were open, which pose was taken, and which joint moved furthest.

    Args:
        draft: the linkage as its file describes it.
        repair: repair of a component whose loops almost close, such as
            `kinematics.closure.assembly.repair_axes.repair_component`. Its arguments are the
            draft with welds moved to close the loops, the joints of the component, and the
            largest angle (rad) and distance (m) by which welds were moved; it returns a draft,
            or why it cannot.
        held: numbers of joints that do not move; with a joint its mimic joints.
        preferred: numbers of joints that should move little: their motion has weight 10.

    Returns:
        The draft with closed loops, a notice if joints were moved, and other closed poses
        nearby.

    Raises:
        OpenLoopError: no start leads to a closed pose.
        MobilityError: a component is too small for double precision.
    """
    if all(np.array_equal(loop.gap, np.eye(4)) for loop in draft.loops):
        return draft
    parts = split_components(draft, held)
    loose = set(range(len(draft.loops))).difference(*(part.loops for part in parts))
    if any(not np.array_equal(draft.loops[k].gap, np.eye(4)) for k in loose):
        raise open_loop_error(draft, "", STARTS)
    outcomes = [_close_component(part, repair, preferred) for part in parts]
    for each in outcomes:
        if isinstance(each, str):
            raise open_loop_error(draft, each, STARTS)
    closings = [each for each in outcomes if isinstance(each, ClosedComponent)]
    chain = arrange_loops(draft)
    q = sum_positions(draft, chain.units, [(each.part, each.q) for each in closings])
    notices = closing_notices(max(closings, key=joint_motion))
    there = replace(
        rereference(draft, chain, q),
        notices=(*draft.notices, *notices, *mobility_notices(draft, chain.units, closings)),
        other_poses=other_poses_of(draft, chain.units, closings),
    )
    for each in closings:
        if each.open and repair is not None:
            better = repair(there, each.part.joints.tolist(), *each.open)
            if isinstance(better, str):
                raise open_loop_error(draft, better, STARTS)
            there = better
    return there


def _close_component(
    part: Component, repair: Repair | None, preferred: frozenset[int] = frozenset()
) -> ClosedComponent | str:
    """Close the loops of a component; if no pose does, return a hint for the user."""
    part = _without_masses(part)
    gaps, home, hint = weld_gaps(part), np.zeros(part.joints.size), ""
    weights = motion_weights(part)
    chosen = np.isin(part.joints, list(preferred))
    weights[chosen] = PREFERENCE
    loops, rng = OpenLoops(part.chain, gaps), np.random.default_rng(SEED)
    first = newton_closure(part.chain, gaps, home)
    if first is not None:
        motion = float(np.linalg.norm(loops.within_turn(first) * weights))
        if motion <= NEAR_MOTION:
            return ClosedComponent(part, first, motion=motion)
    starts = [home, *([] if first is None else [first])]
    starts += list(_random_starts(rng, home.size, NEAR_STARTS, NEAR_DISTANCE))
    further = [_random_starts(rng, home.size, FAR_STARTS, each) for each in FAR_DISTANCES]
    if chosen.any():
        starts += list(np.concatenate(further))
    nearest = _nearest_pose(part, loops, weights, np.array(starts))
    if nearest is None:
        q, pieces = close_by_pieces(part, partial(_close_component, repair=None))
        if q is not None and (whole := _nearest_pose(part, loops, weights, q[None])):
            nearest = whole._replace(pieces=pieces)
    if nearest is not None:
        if repair is None or not _is_another_pose(part, nearest):
            return nearest
        repaired = _close_with_repair(part, repair)
        return nearest if isinstance(repaired, str) else repaired
    if repair is not None:
        repaired = _close_with_repair(part, repair)
        if not isinstance(repaired, str):
            return repaired
        hint = repaired
    return _nearest_pose(part, loops, weights, np.concatenate(further)) or hint


def _is_another_pose(part: Component, closed: ClosedComponent) -> bool:
    """Whether a closed pose is too far from that of the file to be the same up to rounding.

    Next to a dead centre, loops that are open by ε close after motions of about √ε. Where
    nothing that near closes loops that are all but closed, their axes are rounded.
    """
    home = forward_kinematics(part.chain, np.zeros(part.joints.size))
    residual = np.abs(displacement_residual(part.chain, weld_gaps(part), home)).max()
    near = MOTION_PER_ROOT_OF_RESIDUAL * np.sqrt(residual)
    return bool(residual <= ALMOST_CLOSED_RESIDUAL and closed.motion > near)


def _without_masses(part: Component) -> Component:
    """Return a component in units of its joints alone: other masses lead to the same pose.

    Where the joints are all but in one place, masses count for the unit of length.
    """
    bare = part._replace(draft=replace(part.draft, bodies=()))
    frame = extent(bare.draft)
    return bare.in_frame(frame) if frame.length > part.chain.frame.length / MOST_UNITS else part


def _nearest_pose(
    part: Component, loops: OpenLoops, weights: Array, starts: Array
) -> ClosedComponent | None:
    """Find the closed pose of least motion from many starts; None if there is none."""
    gaps = weld_gaps(part)
    poses = closed_poses(loops, weights, starts)
    closures: list[tuple[Array, float]] = []
    for rough in poses:
        motion = float(np.linalg.norm(rough * weights))
        if closures and motion > NEARBY_MOTION_RELATIVE * closures[0][1]:
            break
        apart = [np.linalg.norm(loops.within_turn(rough - q) * weights) for q, _ in closures]
        if apart and min(apart) <= OTHER_MOTION_RELATIVE * closures[0][1]:
            continue
        if len(closures) < MAX_POSES:
            q = newton_closure(part.chain, gaps, rough)
            closures += [] if q is None else [(q, float(np.linalg.norm(q * weights)))]
    if not closures:
        return None
    (q, motion), *others = closures
    return ClosedComponent(part, q, len(poses), motion, tuple(others))


def _random_starts(rng: np.random.Generator, joints: int, count: int, distance: float) -> Array:
    """Draw joint positions (count, joints) of which the mean square is ``distance²``."""
    direction = rng.standard_normal((count, joints))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    reach = rng.uniform(0.0, np.sqrt(3.0) * distance, (count, 1))
    return np.asarray(direction * reach * np.sqrt(joints))


def nearby_starts(part: Component) -> Array:
    """Find joint positions of closed poses some distance from the reference pose.

    Args:
        part: a component whose loops are closed at the reference pose.

    Returns:
        Joint positions (poses, n), in its units, the least motion first.
    """
    rng, count = np.random.default_rng(SEED), part.joints.size
    starts = [_random_starts(rng, count, FAR_STARTS, each) for each in FAR_DISTANCES]
    loops, weights = OpenLoops(part.chain, weld_gaps(part)), motion_weights(part)
    q = closed_poses(loops, weights, np.concatenate(starts), slide=False)
    return q[np.abs(q).max(axis=1, initial=0.0) > OTHER_POSE_DISTANCE]


def _close_with_repair(part: Component, repair: Repair) -> ClosedComponent | str:
    """Close a component up to a small gap and repair its axes; explain if the repair fails.

    Steps leave out directions in which the loops hardly open: those are freedoms that
    rounded axes block.
    """
    scaled = part.in_frame(extent(part.draft))
    chain, gaps, home = scaled.chain, weld_gaps(scaled), np.zeros(part.joints.size)
    for far in (False, True):
        q = minimise_residual(chain, gaps, home) if far else home
        rule = LeastNorm(NEARLY_CLOSING_STEP_RELATIVE, longest=0.5)
        q = gauss_newton(
            closure_equations(chain, gaps), q, rule, never_stop, never_stop, 10
        ).last.next
        entries = displacement_residual(chain, gaps, forward_kinematics(chain, q))
        D = entries[: 12 * len(gaps)].reshape(-1, 3, 4)
        angle, distance = (float(np.abs(part).max()) for part in (D[..., :3], D[..., 3]))
        if max(angle, distance) <= ALMOST_CLOSED_RESIDUAL:
            residual = angle, distance * chain.frame.length
            better = repair(rereference(part.draft, chain, q), range(q.size), *residual)
            return (
                better if isinstance(better, str) else ClosedComponent(scaled, q, open=residual)
            )
    return ""


def close_by_pieces(part: Component, close: CloseComponent) -> tuple[Array | None, int]:
    """Find a closed pose of a component at which the joints that its pieces share rest.

    Args:
        part: a component whose loops are open.
        close: closes one piece, or returns a hint.

    Returns:
        Positions of its joints (n,), in its own units, and how many pieces it has; None if it
        does not fall apart, or a piece does not close.
    """
    pieces = _split(part)
    q = np.zeros(part.joints.size)
    for piece in pieces:
        closed = close(piece)
        if isinstance(closed, str) or closed.open:
            return None, len(pieces)
        q += closed.part.all_positions(closed.q, part.chain.units)
    return (q if pieces else None), len(pieces)


def _split(part: Component) -> list[Component]:
    """Split a component by holding up to `MAX_HELD` joints; no pieces if it stays whole."""
    held: set[int] = set()
    for _ in range(MAX_HELD):
        shared = _most_shared(part, held)
        if shared is None:
            return []
        held |= _followers(part, shared)
        pieces = split_components(part.draft, frozenset(held))
        moved = {k for piece in pieces for k in piece.loops}
        if len(moved) < len(part.draft.loops):  # a loop without joints stays open
            return []
        if sum(bool(piece.loops) for piece in pieces) > 1:
            return pieces
    return []


def _most_shared(part: Component, held: set[int]) -> int | None:
    """Find the joint of the tree that most loops share, the first of equals, if two do."""
    counts: Counter[int] = Counter()
    for loop in part.draft.loops:
        counts.update(loop_joints(part.chain.parent, loop.end, loop.successor) - held)
    most = max(counts.values(), default=0)
    return min(j for j, count in counts.items() if count == most) if most > 1 else None


def _followers(part: Component, joint: int) -> set[int]:
    """Find a joint and those that mimic relations couple to it."""
    joints = {joint}
    for _ in part.draft.mimics:
        for mimic in part.draft.mimics:
            if {mimic.joint, mimic.source} & joints:
                joints |= {mimic.joint, mimic.source}
    return joints
