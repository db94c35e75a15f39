"""Springs that balance gravity: stiffnesses, points, and the fewest of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from math import comb

import numpy as np

from balance.masses.payload import Payload, carrying, read_payload
from balance.masses.springs.attached_springs import AttachedSpring, attach_springs
from balance.masses.springs.both_ends import balance_springs, least_springs
from balance.masses.springs.catalogue_search import (
    SpringSet,
    balanced_of_catalogue,
    least_of_catalogue,
)
from balance.masses.springs.gradient_rows import point_at
from balance.masses.springs.spring import AttachedPoint, Spring
from balance.masses.springs.spring_balance import SpringBalance
from balance.masses.springs.spring_catalogue import (
    CatalogueSpring,
    Choice,
    check_catalogue,
    list_choices,
    stiffness_ranges,
    with_lengths,
)
from balance.masses.springs.spring_cone import SpringCone, balanced_unknowns, make_cone
from balance.masses.springs.spring_loads import MovedSpring, SpringLoads, moved_unknowns
from balance.masses.springs.spring_problem import SpringProblem
from balance.masses.springs.spring_proof import proved_certainty
from balance.masses.springs.spring_text import SpringRange, read_spring
from balance.space.spaces.certainty import Certainty
from balance.support.options import GRAVITY
from balance.support.tolerances import SPRING_ABSENT, SPRING_IN_MIDDLE, SPRING_TORQUE_LEFT
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import size_text

# Most springs, and most sets of them.
MAX_SPRINGS, MAX_SETS = 30, 4096


def springs(
    linkage: LinkageLike,
    between: str | Sequence[str],
    *,
    gravity: Sequence[float] = GRAVITY,
    catalogue: Sequence[float | tuple[float, float]] = (),
    ranges: Mapping[str, tuple[float, float]] | None = None,
    payload: Payload | str | None = None,
) -> SpringBalance:
    """Find springs between links of a linkage that balance gravity in every pose.

    A spring of stiffness k whose force vanishes at length 0 stores ``½ k |p_A - p_B|²``: linear
    in k, and in k times the coordinates of one end. One of free length L stores ``k L |p_A -
    p_B|`` less, linear in k and k L for given points. The sum with the energy of gravity is
    constant if its derivatives vanish at closed poses of all motions: linear conditions, of
    which a convex program finds the solution with stiffnesses that are not negative. The
    fewest springs are sought by trying all sets, the smallest first; of equal ones, those are
    taken of which the squares of k, and of k times the distance from the middle of a range in
    halves of it, have the least sum. Where no springs balance, those are given that leave the
    least root mean square of the torques of the inputs over the workspace.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        between: one or several springs, each as text: ``"base,arm"``, or
            ``"base@0,0,0:0.5 arm@0.2,0,0 k=100:200"``: two links, points in their frames in
            metres, and a stiffness in N/m. A number may be a range; where both ends of a spring
            have ranges, see `balance.masses.springs.both_ends`.
            Without points a spring ends at the centre of mass of the second link, and within a
            characteristic length about the joint by which that hangs on the first. ``L0=0.1``,
            or a range, is a free length, of springs with one point at each end.
        gravity: acceleration of gravity (3,), m/s², inertial frame.
        catalogue: stiffnesses that can be had, N/m, or pairs of stiffness and free length,
            metres; by default any.
        ranges: workspace: least and greatest displacement of inputs by name, radians and
            metres, for the least torque and for lengths; by default the limits in the file,
            without limits 1 rad or one characteristic length each way.
        payload: a load at a point of a link that is not in the file, or its text, such as
            ``"tool@0,0,0.1=0:2"``. For a range of loads the springs are those for its mean,
            which leave the least mean square of the torques over all loads; how points must
            move with the load to balance each of them is in ``SpringBalance.loads``.

    Returns:
        The springs, the smallest sets that balance, and the torques before and after.

    Raises:
        BodyError: a link is unknown, or has no mass where its centre is asked for.
        LinkageError: gravity does no work, the linkage does not move, or both ends of a spring
            are on one rigid body.
        PoseError: a range names no input, or no pose of the ranges is reached.
        UsageError: a spring or the payload cannot be read, there are too many springs, or both
            ends of one are free where loads vary.

    Source:
        S. K. Agrawal, A. Fattah, Mechanism and Machine Theory 39(12), 2004; S. R. Deepak, G.
        K. Ananthasuresh, Journal of Mechanisms and Robotics 4(3), 031014, 2012.

    Example:
        >>> import balance
        >>> answer = balance.springs(
        ...     "robot.urdf", "base@0.3,0,0 crank@0.1,0,0", gravity=(-9.81, 0, 0)
        ... )
        >>> answer.verdict
        'infeasible'
    """
    linkage = as_linkage(linkage)
    listed = check_catalogue(catalogue)
    texts = [between] if isinstance(between, str) else between
    asked = with_lengths([read_spring(text) for text in texts], listed)
    if not 0 < len(asked) <= MAX_SPRINGS:
        raise UsageError(f"{len(asked)} springs: give 1 to {MAX_SPRINGS}")
    g = np.asarray(gravity, dtype=np.float64)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        raise UsageError(f"gravity has three coordinates that are not all 0, not {gravity!r}")
    carried = read_payload(payload) if isinstance(payload, str) else payload
    # Points that nothing is said of are those without the load, for every load.
    asked = [spring.asked for spring in attach_springs(linkage, asked)]

    def problem_of(loaded: Linkage) -> SpringProblem:
        return SpringProblem(loaded, attach_springs(loaded, asked), g, ranges or {})

    problem = problem_of(linkage if carried is None else carrying(linkage, carried))
    answer = _find(problem, g, listed)
    if carried is None or not carried.varies:
        return replace(answer, payload=carried)
    open_length = next((spring for spring in problem.springs if spring.any_length), None)
    if open_length is not None:
        raise UsageError(
            f"spring '{open_length.asked.text}': for a range of loads give one free length"
        )
    paired = next((spring for spring in problem.springs if spring.paired), None)
    if paired is not None:
        raise UsageError(
            f"spring '{paired.asked.text}': for a range of loads one end may be free, not "
            "both: give one a point"
        )
    ends = [problem_of(carrying(linkage, carried, m)) for m in (carried.low, carried.high)]
    return replace(
        answer, payload=carried, loads=_loads(problem, ends, carried, listed, answer)
    )


def _find(
    problem: SpringProblem, gravity: Array, catalogue: Sequence[CatalogueSpring]
) -> SpringBalance:
    """Find the springs of a problem."""
    whole, given = problem.cone, [s.asked.stiffness for s in problem.springs]
    sure = True
    conditions, settled = problem.conditions
    rows = conditions.rows
    if catalogue:
        choices = list_choices(catalogue, [spring.asked for spring in problem.springs])
        (balanced, sure), every_set = balanced_of_catalogue(problem, rows, choices), True
        if not balanced:
            best = least_of_catalogue(problem, choices)
    else:
        balanced, every_set, sure = _smallest_sets(problem, rows, whole, given)
        if not balanced:
            x = least_springs(problem.torque_triangle, problem.springs, given, problem.unit)
            best = SpringSet(tuple(range(len(problem.springs))), x)
    if balanced:
        sizes = [float(sum(item.x[_starts(problem, item.used)])) for item in balanced]
        best = balanced[first_least(sizes)]
    x = _spread(problem, whole, best)
    unknowns = rows.shape[1] - 1
    unsigned = SpringCone(np.zeros((1, unknowns)), np.zeros(1), whole.starts)
    in_span = bool(balanced) or balanced_unknowns(rows, unsigned) is not None
    torque, count = problem.fresh_torque(x)
    certainty = _certainty(bool(balanced), settled, torque, count)
    springs = tuple(_springs(problem, whole, x, best.entries))
    proof, certainty = proved_certainty(
        problem, springs, gravity, bool(balanced), in_span, certainty
    )
    sets = list(dict.fromkeys(item.used for item in balanced))
    return SpringBalance(
        problem.linkage,
        (float(gravity[0]), float(gravity[1]), float(gravity[2])),
        springs,
        tuple(sets),
        every_set,
        unknowns,
        conditions.rank,
        in_span,
        problem.workspace[1],
        problem.torques(None),
        problem.torques(x),
        certainty,
        sure,
        proof,
        notices=_notices(springs),
    )


def _notices(springs: Sequence[Spring]) -> tuple[Notice, ...]:
    """Name the springs that push."""
    numbers = [str(number) for number, spring in enumerate(springs, 1) if spring.pushes]
    if not numbers:
        return ()
    text = (
        f"{'spring' if len(numbers) == 1 else 'springs'} {', '.join(numbers)}: in some poses "
        "shorter than the free length, where a spring pushes: a string or a hook cannot"
    )
    return (Notice("spring_pushes", text),)


def _loads(
    problem: SpringProblem,
    ends: Sequence[SpringProblem],
    payload: Payload,
    catalogue: Sequence[CatalogueSpring],
    answer: SpringBalance,
) -> SpringLoads:
    """Find what springs that stay leave for both ends of a range, and springs that move."""
    x = _unknowns(problem, answer)
    shares = []
    for end in ends:
        there = x * problem.unit / end.unit
        shares.append(
            float(np.linalg.norm(end.torques(there)) / np.linalg.norm(end.torques(None)))
        )
    rows = [end.conditions[0].rows for end in ends]
    weights = [end.unit / problem.unit for end in ends]
    texts = [spring.asked for spring in problem.springs]
    choices = [[text.stiffness for text in texts]]
    if catalogue:
        choices = [stiffness_ranges(choice) for choice in list_choices(catalogue, texts)]
    for ranges in choices:
        cone = make_cone(problem.springs, problem.unit, ranges)
        moved = moved_unknowns(rows, cone, weights)
        if moved is not None:
            return SpringLoads(payload, (shares[0], shares[1]), _moved_springs(problem, moved))
    return SpringLoads(payload, (shares[0], shares[1]), ())


def _unknowns(problem: SpringProblem, answer: SpringBalance) -> Array:
    """Read the unknowns of springs that were found, one end of each fixed at most."""
    parts = []
    for attached, spring in zip(problem.springs, answer.springs, strict=True):
        shares = [
            (2.0 * x - low - high) / (high - low)
            for end, there in zip(attached.asked.ends, spring.ends, strict=True)
            for x, (low, high) in zip(there.point, end.box or (), strict=True)
            if low < high
        ]
        parts.append(spring.stiffness / problem.unit * np.array([1.0, *shares]))
    return np.concatenate(parts)


def _moved_springs(
    problem: SpringProblem, moved: tuple[Array, Array]
) -> tuple[MovedSpring, ...]:
    """Describe the springs of unknowns for two loads."""
    listed, at = [], 0
    largest = max(float(np.abs(x).max()) for x in moved)
    for number, spring in enumerate(problem.springs, 1):
        k = float(moved[0][at])
        if k > SPRING_ABSENT * largest:
            places = []
            for x in moved:
                shares = np.clip(x[at + 1 : at + spring.columns] / k, -1.0, 1.0)
                points = _attached_points(spring, shares)
                places.append(np.array([end.point for end in points]))
            listed.append(MovedSpring(number, k * problem.unit, places[0], places[1]))
        at += spring.columns
    return tuple(listed)


def _starts(problem: SpringProblem, used: Sequence[int]) -> list[int]:
    """Give the places of the stiffnesses among the unknowns of some springs."""
    counts = [problem.springs[k].columns for k in used]
    return [sum(counts[:k]) for k in range(len(counts))]


def _smallest_sets(
    problem: SpringProblem, rows: Array, cone: SpringCone, given: Sequence[SpringRange]
) -> tuple[list[SpringSet], bool, bool]:
    """Find the smallest sets of springs that balance.

    Returns:
        The sets; whether all sets were tried; whether smaller ones, or all, are excluded.
    """
    count, tried, sure = len(cone.starts) - 1, 0, True
    for size in range(1, count + 1):
        if tried + comb(count, size) > MAX_SETS:
            break
        tried += comb(count, size)
        balanced = []
        for used in combinations(range(count), size):
            x, known = _balance(problem, rows, cone, used, [given[k] for k in used])
            balanced += [] if x is None else [SpringSet(used, x)]
            sure = sure and known
        if balanced:
            return balanced, True, sure
    else:
        return [], True, sure
    every = tuple(range(count))
    x, known = _balance(problem, rows, cone, every, given)
    return ([] if x is None else [SpringSet(every, x)]), False, sure and known


def _balance(
    problem: SpringProblem,
    rows: Array,
    cone: SpringCone,
    used: Sequence[int],
    ranges: Sequence[SpringRange],
) -> tuple[Array | None, bool]:
    """Balance with some of the springs; see `balance_springs`."""
    columns = [*cone.columns_of(used), rows.shape[1] - 1]
    chosen = [problem.springs[k] for k in used]
    return balance_springs(rows[:, columns], chosen, ranges, problem.unit)


def _spread(problem: SpringProblem, cone: SpringCone, tried: SpringSet) -> Array:
    """Place the unknowns of some springs among those of all; springs of no stiffness are 0."""
    x = np.zeros(cone.starts[-1])
    x[cone.columns_of(tried.used)] = tried.x
    largest = float(np.abs(x).max(initial=0.0))
    for start, spring in zip(cone.starts, problem.springs, strict=False):
        if x[start] <= SPRING_ABSENT * largest:
            x[start : start + spring.columns] = 0.0
    return x


def _springs(
    problem: SpringProblem, cone: SpringCone, x: Array, entries: Choice
) -> Iterator[Spring]:
    """Describe the springs of unknowns, with the numbers of a catalogue if they are of one."""
    length = problem.length
    entries = entries or (None,) * len(problem.springs)
    for start, spring, entry in zip(cone.starts, problem.springs, entries, strict=False):
        stiffness = float(x[start])
        shares = x[start + 1 : start + 1 + spring.free] / (stiffness or 1.0)
        shares = np.where(np.abs(shares) < SPRING_IN_MIDDLE, 0.0, np.clip(shares, -1.0, 1.0))
        distances = [
            length * float(np.linalg.norm(first - second))
            for first, second in _end_points(problem, spring, shares)
        ]
        k = stiffness * problem.unit
        if k > 0.0:
            k = float(np.clip(k, *spring.asked.stiffness))
        ends = _attached_points(spring, shares)
        lengths = min(distances), max(distances)
        free = _free_length(spring, shares) if k > 0.0 else 0.0
        if k > 0.0 and entry is not None:
            k, free = entry
        force = k * max(abs(length - free) for length in lengths)
        yield Spring(spring.asked.text, ends, k, lengths, force, free)


def _free_length(spring: AttachedSpring, shares: Array) -> float:
    """Read the free length of a spring, metres; 0 where round-off alone is left of it."""
    low, high = spring.asked.length or (0.0, 0.0)
    if not spring.any_length:
        return low
    length = 0.5 * (low + high) + 0.5 * (high - low) * float(shares[-1])
    return length if abs(length) > SPRING_IN_MIDDLE * (high - low) else 0.0


def _end_points(
    problem: SpringProblem, spring: AttachedSpring, shares: Array
) -> Iterator[tuple[Array, Array]]:
    """Place both ends of a spring in the poses of the workspace."""
    first, second = spring.ends
    count = len(first.axes)
    for pose in problem.workspace[0]:
        second_shares = shares[count : count + len(second.axes)]
        yield point_at(pose, first, shares[:count]), point_at(pose, second, second_shares)


def _attached_points(
    spring: AttachedSpring, shares: Array
) -> tuple[AttachedPoint, AttachedPoint]:
    """Compute the points of a spring in the frames of its links."""
    points, rest = [], list(shares)
    for end in spring.asked.ends:
        x, y, z = (
            0.5 * (low + high) + 0.5 * (high - low) * float(rest.pop(0)) if low < high else low
            for low, high in end.box or ()
        )
        points.append(AttachedPoint(end.link, (x, y, z)))
    return points[0], points[1]


def _certainty(balanced: bool, settled: bool, torque: float, count: int) -> Certainty:
    """State how sure it is that torques vanish in every motion."""
    doubts = []
    if not settled:
        doubts.append("further poses may need more conditions than were found")
    if balanced and torque > SPRING_TORQUE_LEFT:
        doubts.append(f"torques of {size_text(torque)} of those of gravity are left")
    reason = "floating point decides; no torque is left at finite poses that decided nothing"
    if not balanced:
        reason = "floating point decides"
    return Certainty(
        "estimated", doubts[0] if doubts else reason, None, None, torque, count, tuple(doubts)
    )
