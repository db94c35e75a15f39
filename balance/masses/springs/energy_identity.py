"""Proof in rational numbers that the energies of springs and gravity add up to a constant.

The numbers of the linkage, to 14 digits, are taken as rational. A hinge turns by ``c`` and
``s`` with ``c² + n·n s² = 1`` for an axis n of any length; at t = 0, 1 and infinity in
``c = (1 - n·n t²)/(1 + n·n t²)``, ``s = 2 t/(1 + n·n t²)`` these are rational. Differences of
positions, and their products with directions on the way from one to the other, have one factor
of each hinge at most: such a function is ``α + β c + γ s`` in each of them, and of second
degree in a sliding coordinate. It is therefore constant if it is so on the grid of three values
of each joint. So are all energies here: a polynomial identity is checked at a finite number of
poses, without round-off (N. Alon, Combinatorics, Probability and Computing 8, 1999, on grids).

Loops are opened; ``e_p = H_end p - H_successor p`` vanishes where they are closed, for all
points p. The energies of closed poses are constant if multiples of ``e_p·(R_F a)`` and of
``e_p·e_p`` make the sum constant on the opened linkage, identically. That is sufficient, and
linear in the multipliers. A parallelogram closes as an antiparallelogram, too, where other
springs balance. If all hinges are parallel, links that turn alike are therefore given one
angle; where the loops then close identically, with as many angles as the linkage is mobile,
these are coordinates of its mode of motion, and the grid is one of them.

Where digits leave centres of mass off the lines that balance asks for, they may be shifted by
1e-11 of the size.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import NamedTuple

from balance.masses.springs.distance_equations import distance_equations
from balance.masses.springs.rational_solution import (
    inconsistency,
    rational,
    solve_rational,
)
from balance.masses.springs.rational_vectors import (
    NO_TURN,
    ONE,
    ZERO,
    Rotation,
    Vector3,
    add,
    compose,
    rotations,
    scale,
    subtract,
    turn,
)
from balance.masses.springs.spring import Spring
from balance.masses.springs.spring_term import SpringTerm
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import dot

# Most joints of the opened linkage: the grid has three poses to the power of their number.
MAX_JOINTS = 7
# How near rational springs are to those of floating point, and centres of mass to the file.
FOUND, NEAR = Fraction(1, 10**8), Fraction(1, 10**11)


class FreeEnd(NamedTuple):
    """What of a spring may be shifted to make an identity exact.

    Attributes:
        end: one of its ends, 0 or 1.
        axes: coordinates of it that are within their range, 0 to 2.
        stiffness: whether the stiffness is within its range too.
    """

    end: int
    axes: tuple[int, ...]
    stiffness: bool


class EnergyProof(NamedTuple):
    """Rational springs whose energy and that of gravity add up to a constant.

    Attributes:
        stiffnesses: N/m, of the springs that are needed, in their order.
        shifts: of their free ends along each free coordinate, metres: from the points that
            floating point gave.
        poses: poses of the grid at which the sum is the same.
        multipliers: number of closure functions with a multiplier that is not zero.
        points: both ends of the springs with the shifts, inertial frame at the reference pose,
            metres.
        masses: link, mass, and mass times centre of mass of each body, inertial frame at the
            reference pose, kg and kg m; within 1e-11 of those of the file.
        gravity: m/s².
    """

    stiffnesses: tuple[Fraction, ...]
    shifts: tuple[tuple[Fraction, ...], ...]
    poses: int
    multipliers: int
    points: tuple[tuple[Vector3, Vector3], ...]
    masses: tuple[tuple[int, Fraction, Vector3], ...]
    gravity: Vector3


def prove_constant(
    linkage: Linkage,
    springs: Sequence[Spring],
    free: Sequence[FreeEnd],
    gravity: Sequence[float],
    turns: Sequence[int],
) -> EnergyProof | str:
    """Prove that the energies of springs and of gravity add up to a constant.

    Args:
        linkage: the linkage.
        springs: springs that balance by floating point; those without stiffness are left out.
        free: what of each spring may be shifted.
        gravity: acceleration of gravity (3,), m/s².
        turns: number of the angle of each link, 0 for one that does not turn: links that turn
            alike at generic poses have one.

    Returns:
        The proof, or the reason why there is none.
    """
    reason = _refusal(linkage)
    if reason:
        return reason
    used = [k for k, spring in enumerate(springs) if spring.stiffness > 0.0]
    terms = [_term(linkage, springs[k], free[k]) for k in used]
    weights, g = _weights(linkage), _vector(gravity)
    closures = list(_closures(linkage))
    poses = _mode_grid(linkage, turns, closures)
    if poses is None:
        poses = list(_grid(linkage))
    else:
        closures = []
    table = [_energies(linkage, pose, closures, terms, weights, g) for pose in poses]
    first, base = table[0]
    rows = [[x - y for x, y in zip(row, first, strict=True)] for row, _ in table[1:]]
    right = [base - value for _, value in table[1:]]
    start = [ZERO] * len(closures)
    for term in terms:
        start += [] if term.given else [term.stiffness]
        start += [ZERO] * len(term.axes)
    count = len(start)
    start += [ZERO] * (3 * len(weights))
    equations = distance_equations(terms, len(closures), len(start))
    if equations is None:
        return "free lengths leave distances in the energy, which have no identity of this kind"
    rows, right = rows + [row for row, _ in equations], right + [x for _, x in equations]
    solution = solve_rational(rows, right, start, count)
    if solution is None:
        return "no rational numbers near those of the file make the sum constant identically"
    shifts = [_take(solution, count + 3 * k) for k in range(len(weights))]
    size = sum(mass for _, mass, _ in weights) * rational(linkage.chain.frame.length)
    if any(abs(x) > size * NEAR for shift in shifts for x in shift):
        return "centres of mass would be others than those of the file"
    return _read_proof(terms, solution, len(closures), len(poses), weights, shifts, g)


def _take(solution: Sequence[Fraction], at: int) -> Vector3:
    """Take three unknowns."""
    return solution[at], solution[at + 1], solution[at + 2]


def _energies(
    linkage: Linkage,
    pose: _GridPose,
    closures: Sequence[tuple[int, Vector3, tuple[int, int] | None]],
    terms: Sequence[SpringTerm],
    weights: Sequence[tuple[int, Fraction, Vector3]],
    g: Vector3,
) -> tuple[list[Fraction], Fraction]:
    """Compute all functions with an unknown factor in a pose, and the energy without."""
    row = [_closure_value(linkage, pose, *item) for item in closures]
    energy = _gravity_energy(pose, weights, g)
    for term in terms:
        half, *more = _spring_values(pose, term)
        energy += half * term.stiffness if term.given else 0
        row += more if term.given else [half, *more]
    for link, _, _ in weights:
        R = pose.R[link]
        row += [-sum((g[i] * R[i][k] for i in range(3)), ZERO) for k in range(3)]
    return row, energy


def _read_proof(
    terms: Sequence[SpringTerm],
    solution: Sequence[Fraction],
    at: int,
    poses: int,
    weights: Sequence[tuple[int, Fraction, Vector3]],
    moved: Sequence[Vector3],
    g: Vector3,
) -> EnergyProof | str:
    """Read the springs of a solution; those of the springs begin at a place."""
    multipliers = sum(x != 0 for x in solution[:at])
    stiffnesses, shifts, points = [], [], []
    for term in terms:
        k = term.stiffness if term.given else solution[at]
        at += not term.given
        products = solution[at : at + len(term.axes)]
        at += len(term.axes)
        if not abs(k - term.stiffness) <= term.stiffness * FOUND:
            return "the rational stiffnesses are others than those of floating point"
        if any(abs(x / k) > FOUND for x in products):
            return "the rational points are others than those of floating point"
        stiffnesses.append(k)
        shifts.append(tuple(x / k for x in products))
        points.append(_shifted(term, shifts[-1]))
    return EnergyProof(
        tuple(stiffnesses),
        tuple(shifts),
        poses,
        multipliers,
        tuple(points),
        tuple(
            (link, mass, add(moment, shift))
            for (link, mass, moment), shift in zip(weights, moved, strict=True)
        ),
        g,
    )


def prove_none(
    linkage: Linkage,
    springs: Sequence[tuple[tuple[int, Vector3, tuple[Vector3, ...]], ...]],
    gravity: Sequence[float],
) -> bool:
    """Prove that no springs make the energies of a linkage without loops constant.

    Stiffnesses of either sign count, and all points along the free coordinates.

    Args:
        linkage: the linkage.
        springs: for both ends of each, its link, a point and free directions at the reference
            pose, inertial frame.
        gravity: acceleration of gravity (3,), m/s².

    Returns:
        Whether a combination of poses was found in which all springs have no part, and gravity
        has one.
    """
    if _refusal(linkage) or linkage.loops:
        return False
    weights, g, table = _weights(linkage), _vector(gravity), []
    for pose in _grid(linkage):
        row: list[Fraction] = []
        for first, second in springs:
            row += _pair_values(pose, first, second)
        table.append((row, _gravity_energy(pose, weights, g)))
    start, base = table[0]
    rows = [[x - y for x, y in zip(row, start, strict=True)] for row, _ in table[1:]]
    return inconsistency(rows, [base - value for _, value in table[1:]])


def _refusal(linkage: Linkage) -> str:
    """Say why the energies of a linkage are not functions of the kind that is known here."""
    if linkage.mimics:
        return "joints coupled by a ratio have no identity of this kind"
    if any(joint.kind == "helical" for joint in linkage.joints):
        return "screws have no identity of this kind"
    if len(linkage.joints) > MAX_JOINTS:
        return f"exact identities are sought for up to {MAX_JOINTS} joints"
    return ""


def _vector(values: Sequence[float] | Array) -> Vector3:
    """Read three numbers as rational ones."""
    x, y, z = map(rational, values)
    return x, y, z


def place(linkage: Linkage, link: str, point: Sequence[float]) -> tuple[int, Vector3]:
    """Find a link, and a point of it at the reference pose in rational numbers."""
    number, pose = linkage.places[link]
    R, origin = [_vector(row) for row in pose[:3, :3]], _vector(pose[:3, 3])
    local = _vector(point)
    x, y, z = (o + dot(row, local) for row, o in zip(R, origin, strict=True))
    return number, (x, y, z)


def direction(linkage: Linkage, link: str, axis: int) -> Vector3:
    """Find the direction of an axis of a link frame at the reference pose."""
    return _vector(linkage.places[link].pose[:3, axis])


def _term(linkage: Linkage, spring: Spring, free: FreeEnd) -> SpringTerm:
    """Write a spring in rational numbers."""
    (a, p), (b, q) = (place(linkage, x.link, x.point) for x in spring.ends)
    axes = tuple(direction(linkage, spring.ends[free.end].link, axis) for axis in free.axes)
    k = rational(spring.stiffness)
    length = rational(spring.free_length)
    return SpringTerm((a, b), (p, q), axes, free.end, k, not free.stiffness, length)


def _weights(linkage: Linkage) -> list[tuple[int, Fraction, Vector3]]:
    """Read link, mass, and mass times centre of mass of each body that moves."""
    return [
        (body.link, rational(body.inertia[0]), _vector(body.inertia[1:4]))
        for body in linkage.bodies
        if body.link != GROUND
    ]


def _shifted(term: SpringTerm, shifts: Sequence[Fraction]) -> tuple[Vector3, Vector3]:
    """Shift the free end of a spring: ``½ |a + s e - b|²`` is linear in s up to a constant."""
    points = list(term.points)
    for shift, axis in zip(shifts, term.axes, strict=True):
        points[term.end] = add(points[term.end], scale(shift, axis))
    return points[0], points[1]


class _GridPose(NamedTuple):
    """Displacements of all links from the reference pose.

    Attributes:
        R: rotations; the ground last.
        r: where the origin goes, likewise.
    """

    R: tuple[Rotation, ...]
    r: tuple[Vector3, ...]

    def point(self, link: int, p: Vector3) -> Vector3:
        """Displace a point of a link."""
        return add(turn(self.R[link], p), self.r[link])


def _grid(linkage: Linkage) -> Iterator[_GridPose]:
    """Move every joint to three values, in all combinations."""
    choices = [_displacements(linkage, j) for j in range(len(linkage.joints))]
    for chosen in product(*choices):
        R: list[Rotation] = []
        r: list[Vector3] = []
        for joint, (turned, shift) in zip(linkage.joints, chosen, strict=True):
            if joint.parent == GROUND:
                R.append(turned)
                r.append(shift)
                continue
            before, origin = R[joint.parent], r[joint.parent]
            R.append(compose(before, turned))
            r.append(add(turn(before, shift), origin))
        yield _GridPose((*R, NO_TURN), (*r, (ZERO, ZERO, ZERO)))


def _mode_grid(
    linkage: Linkage,
    turns: Sequence[int],
    closures: Sequence[tuple[int, Vector3, tuple[int, int] | None]],
) -> list[_GridPose] | None:
    """Move the angles of links that turn alike, if these are coordinates of the motion.

    Args:
        linkage: the linkage.
        turns: number of the angle of each link.
        closures: the functions that vanish where the loops are closed.

    Returns:
        The poses of the grid; None if hinges are not parallel, or the angles are no
        coordinates.
    """
    if not linkage.loops or max(turns, default=0) != linkage.mobility:
        return None
    if any(joint.kind != "revolute" for joint in linkage.joints):
        return None
    n = _vector(linkage.joints[0].direction)
    if any(_vector(joint.direction) not in (n, scale(-ONE, n)) for joint in linkage.joints):
        return None
    poses = []
    for chosen in product(rotations(n), repeat=linkage.mobility):
        angles = (NO_TURN, *chosen)
        R = [angles[number] for number in turns]
        r: list[Vector3] = []
        for j, joint in enumerate(linkage.joints):
            p = _vector(joint.point)
            at = p if joint.parent == GROUND else add(turn(R[joint.parent], p), r[joint.parent])
            r.append(subtract(at, turn(R[j], p)))
        poses.append(_GridPose((*R, NO_TURN), (*r, (ZERO, ZERO, ZERO))))
    closed = all(
        _closure_value(linkage, pose, *item) == 0
        for pose in poses
        for item in closures
        if item[2] is None
    )
    return poses if closed else None


def _displacements(linkage: Linkage, j: int) -> list[tuple[Rotation, Vector3]]:
    """List the three displacements of a joint in the inertial frame at the reference pose."""
    joint = linkage.joints[j]
    n = _vector(joint.direction)
    if joint.kind == "prismatic":
        return [(NO_TURN, scale(Fraction(k), n)) for k in (0, 1, -1)]
    p = _vector(joint.point)
    return [(R, subtract(p, turn(R, p))) for R in rotations(n)]


def _gravity_energy(
    pose: _GridPose, weights: Sequence[tuple[int, Fraction, Vector3]], g: Vector3
) -> Fraction:
    """Compute ``-g·Σ (m r + R mc)``."""
    total = ZERO
    for link, mass, moment in weights:
        at = add(scale(mass, pose.r[link]), turn(pose.R[link], moment))
        total -= dot(g, at)
    return total


def _spring_values(pose: _GridPose, term: SpringTerm) -> list[Fraction]:
    """Compute half the squared length, and what a shift of the free end changes of it."""
    first, second = (
        pose.point(link, p) for link, p in zip(term.links, term.points, strict=True)
    )
    apart = subtract(first, second)
    sign = 1 if term.end == 0 else -1
    R = pose.R[term.links[term.end]]
    return [dot(apart, apart) / 2, *(sign * dot(apart, turn(R, axis)) for axis in term.axes)]


def _pair_values(
    pose: _GridPose,
    first: tuple[int, Vector3, tuple[Vector3, ...]],
    second: tuple[int, Vector3, tuple[Vector3, ...]],
) -> list[Fraction]:
    """Compute the functions of k, k s, k t and k s t; see `gradient_rows`."""
    apart = subtract(pose.point(*first[:2]), pose.point(*second[:2]))
    a, b = ([turn(pose.R[end[0]], axis) for axis in end[2]] for end in (first, second))
    return [
        dot(apart, apart) / 2,
        *(dot(apart, axis) for axis in a),
        *(-dot(apart, axis) for axis in b),
        *(-dot(x, y) for x in a for y in b),
    ]


def _closures(linkage: Linkage) -> Iterator[tuple[int, Vector3, tuple[int, int] | None]]:
    """List functions that vanish where the loops are closed.

    Each is a loop, a point p, and a link and axis of ``e_p·(R a)``, or None for ``e_p·e_p``.
    """
    for k, loop in enumerate(linkage.loops):
        o = _vector(linkage.joints[loop.end].point)
        steps = [(ZERO, ZERO, ZERO), (ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE)]
        links = {GROUND}
        for link in (loop.end, loop.successor):
            while link != GROUND:
                links.add(link)
                link = linkage.joints[link].parent
        for step in steps:
            p = add(o, step)
            yield k, p, None
            yield from ((k, p, (link, axis)) for link in sorted(links) for axis in range(3))


def _closure_value(
    linkage: Linkage, pose: _GridPose, k: int, p: Vector3, along: tuple[int, int] | None
) -> Fraction:
    """Compute a function of `_closures` in a pose of the opened linkage."""
    loop = linkage.loops[k]
    e = subtract(pose.point(loop.end, p), pose.point(loop.successor, p))
    if along is None:
        return dot(e, e)
    link, axis = along
    return sum((e[i] * pose.R[link][i][axis] for i in range(3)), ZERO)
