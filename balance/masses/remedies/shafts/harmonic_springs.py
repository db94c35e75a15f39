"""Remedy: springs that take the torque of a crank at constant speed.

At a constant rate ω of the crank the kinetic energy comes and goes through its drive, which
holds the torque ``τ(u) ω²`` with ``τ = dT/du`` at the unit rate. A spring of zero free length
between the point a of the base and the point p(u) of a link, whose stiffness is ``κ ω²``, holds
``κ (p - a)·p' ω²`` of it. With ``b = κ (a - q)`` what is left for the drive,

    τ + Σ_i (κ_i (p_i - q)·p_i' - b_i·p_i'),        |b_i| ≤ κ_i R,

is linear in κ and b: for given points p the least root mean square over a turn, with all a
within R of a place q, is a convex program. (A slider that moves as ``r cos u`` needs ``κ = m``:
it swings on its spring.) Forces between links and base are inner ones, so that the shaking
stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from balance.masses.remedies.applied import AppliedRemedy, refused, with_cost
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.shafts.crank_turn import CrankTurn, turn_of_crank
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.shaking_wrench import (
    inertia_wrenches,
    mass_parameters,
    wrench_to_si,
)
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from balance.support.json_text import json_text
from balance.support.tolerances import MASSES_EQUAL
from kinematics.closure.joint_positions import input_chain
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.spatial.screws import Ad, exp
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import count_noun, number_text, vector_text

KEY = "harmonic_springs"
# Furthest place on the base from the middle of the linkage, in characteristic lengths, and the
# part of that from which it is said to be at this bound.
FURTHEST, AT_BOUND = 2.0, 0.999
# Most springs, and most points of links of which all pairs are tried.
MOST_SPRINGS, MOST_POINTS = 2, 8
# Part of the torque that springs must take at least.
WORTHWHILE = 0.01
# Way of a point below which it stands still, of the characteristic length.
STANDS = 1e-9


def apply_harmonic_springs(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Take the torque of a crank at constant speed by springs between base and links.

    Each spring has zero free length, and a stiffness that goes with the square of the speed.
    Its points on links are hinges and centres of mass; those on the base are sought.

    Yields:
        A result with the best spring, and one with the best two. The residual is the root mean
        square of the torque over a turn, over that of the file; the shaking stays.

    Source:
        B. Demeulenaere, J. De Schutter, Input torque balancing using an inverted cam mechanism,
        Journal of Mechanical Design 127(5), 2005: the energy that balances the torque.
    """
    if request.balance == "force":
        yield refused(KEY, "springs take a torque, and only the force is to be balanced")
        return
    turn = turn_of_crank(request)
    if isinstance(turn, str):
        yield refused(KEY, turn)
        return
    courses = _courses(request, turn)
    size = float(np.sqrt(np.mean(courses.torque**2)))
    weight = request.given_mass * request.space.length**2
    if not size > SHAKING_RELATIVE * weight:
        yield refused(KEY, "its crank needs no torque at constant speed")
        return
    best: tuple[int, ...] = ()
    least_residual = 1.0
    for count in range(1, MOST_SPRINGS + 1):
        tried = _sets(len(courses.points), best, count)
        solved = [_least_torque(request, courses, chosen, size) for chosen in tried]
        if not solved:
            return
        order = rank_least_first([each.residual for each in solved], relative=MASSES_EQUAL)
        springs = solved[order[0]]
        best = tried[order[0]]
        if springs.residual > least_residual - WORTHWHILE:
            if count == 1:
                yield refused(KEY, "no spring on a hinge or a centre of mass takes torque")
            return
        least_residual = springs.residual
        yield _described(request, turn, courses, springs)


class _Point(NamedTuple):
    """A point of a link.

    Attributes:
        link: name of the link.
        local: in its frame (3,), metres.
        start: at the reference pose (3,), metres.
        way: along the turn (N, 3), metres.
        rate: its velocity at the unit rate of the crank (N, 3), metres.
    """

    link: str
    local: Array
    start: Array
    way: Array
    rate: Array


class _Courses(NamedTuple):
    """The torque of the crank at its unit rate (N,), N m, and the points that move."""

    torque: Array
    points: list[_Point]


class _Springs(NamedTuple):
    """Springs at some points.

    Attributes:
        points: which points.
        stiffness: κ of each, N/m at 1 rad/s.
        anchors: their places on the base (springs, 3), metres.
        residual: root mean square of the torque that is left, over that of the file.
        at_bound: whether a place is as far away as it may be.
    """

    points: tuple[int, ...]
    stiffness: Array
    anchors: Array
    residual: float
    at_bound: bool


def _courses(request: RemedyRequest, turn: CrankTurn) -> _Courses:
    """Move the linkage through a turn: torque by the power of inertia, and points."""
    linkage, q, qd = request.linkage, turn.trajectory.q[:-1], turn.trajectory.qd[:-1]
    poses: list[Array] = []
    twists: list[Array] = []
    still = np.tile(np.eye(4), (len(q), 1, 1)), np.zeros((len(q), 6))
    for j, joint in enumerate(linkage.joints):
        H, V = (poses[joint.parent], twists[joint.parent]) if joint.parent >= 0 else still
        twists.append(V + (Ad(H) @ joint.screw) * qd[:, j, None])
        poses.append(H @ exp(joint.screw, q[:, j]))
    chain = input_chain(linkage)
    along = turn.trajectory
    motion = (x[:-1] / chain.units for x in (along.q, along.qd, along.qdd))
    wrenches = inertia_wrenches(chain, mass_parameters(linkage), *motion)
    moving = [body.link for body in linkage.bodies if body.link != GROUND]
    torque = np.zeros(len(q))
    for link, wrench in zip(moving, wrenches, strict=True):
        torque += np.einsum("ki,ki->k", twists[link], wrench_to_si(wrench, chain.frame))
    points = []
    for link, start in _candidates(linkage):
        way = poses[link][:, :3, :3] @ start + poses[link][:, :3, 3]
        if float(np.ptp(way, axis=0).max()) > STANDS * request.space.length:
            rate = twists[link][:, 3:] + np.cross(twists[link][:, :3], way)
            name, place = next(item for item in linkage.places.items() if item[1].link == link)
            local = np.linalg.solve(place.pose, [*start, 1.0])[:3]
            points.append(_Point(name, local, start, way, rate))
    return _Courses(torque, points)


def _candidates(linkage: Linkage) -> Iterator[tuple[int, Array]]:
    """Yield hinges and centres of mass of moving links, each point once, by its link."""
    listed: list[Array] = []
    places = [
        (link, joint.point)
        for j, joint in enumerate(linkage.joints)
        for link in (joint.parent, j)
    ]
    places += [
        (body.link, body.inertia[1:4] / body.inertia[0])
        for body in linkage.bodies
        if body.inertia[0] > 0.0
    ]
    linked = {place.link for place in linkage.places.values()}
    close = STANDS * linkage.spatial_chain.frame.length
    for link, point in places:
        twice = any(float(np.abs(point - other).max()) < close for other in listed)
        if link == GROUND or link not in linked or twice:
            continue
        listed.append(point)
        yield link, np.asarray(point)


def _sets(points: int, best: Sequence[int], count: int) -> list[tuple[int, ...]]:
    """List the sets of points that are tried: all, or of many points those with the best."""
    if points <= MOST_POINTS or count == 1:
        return list(combinations(range(points), count))
    return [(*best, k) for k in range(points) if k not in best]


def _least_torque(
    request: RemedyRequest, courses: _Courses, chosen: tuple[int, ...], size: float
) -> _Springs:
    """Find the springs at some points that leave the least torque, root mean square.

    Unknowns are κ and b of each spring, in units of ``size`` and of the characteristic length.
    """
    linkage, length = request.linkage, request.space.length
    axes = linkage.chain.frame.R[:2] if linkage.planar else np.eye(3)
    middle, count = linkage.chain.frame.origin, len(axes)
    columns = []
    for k in chosen:
        way, rate = ((x @ axes.T) / length for x in courses.points[k][3:])
        way = way - axes @ middle / length
        columns += [np.einsum("ki,ki->k", way, rate)[:, None], -rate]
    C, torque = np.hstack(columns), courses.torque / size
    block: Array = np.diag([FURTHEST, *[1.0] * count])
    rows = np.asarray(np.kron(np.eye(len(chosen)), block), dtype=np.float64)
    parts = [ConstraintBlock("second_order", count + 1)] * len(chosen)
    H, q = C.T @ C / len(C), C.T @ torque / len(C)
    x = solve_conic(q, rows, np.zeros(len(rows)), parts, H).x.reshape(len(chosen), count + 1)
    kappa, pull = np.maximum(x[:, 0], 0.0), x[:, 1:]
    reach = pull / np.where(kappa > 0.0, kappa, 1.0)[:, None]
    starts = np.array([courses.points[k].start for k in chosen])
    # In the plane of its point, where a spring of a planar linkage has its place.
    level = starts - (starts - middle) @ axes.T @ axes
    return _Springs(
        chosen,
        kappa * size / length**2,
        level + length * reach @ axes,
        float(np.sqrt(np.mean((torque + C @ x.ravel()) ** 2))),
        bool((np.linalg.norm(reach, axis=1) > AT_BOUND * FURTHEST).any()),
    )


def _described(
    request: RemedyRequest, turn: CrankTurn, courses: _Courses, springs: _Springs
) -> AppliedRemedy:
    """Describe springs in words and as data."""
    residual = springs.residual if springs.residual > SHAKING_RELATIVE else 0.0
    points = [courses.points[k] for k in springs.points]
    listed = [
        {
            "link": point.link,
            "point": point.local.tolist(),
            "at": point.start.tolist(),
            "base": anchor.tolist(),
            "stiffness": stiffness,
        }
        for point, anchor, stiffness in zip(
            points, springs.anchors, springs.stiffness.tolist(), strict=True
        )
    ]
    each = ", ".join(
        f"{number_text(stiffness, '.3g')} N/m on {point.link} from "
        f"{vector_text(np.round(anchor, 3))} m"
        for point, anchor, stiffness in zip(
            points, springs.anchors, springs.stiffness.tolist(), strict=True
        )
    )
    bound = " (a place two characteristic lengths away is a bound)" * springs.at_bound
    words = (
        f"{count_noun(len(points), 'spring')} of zero free length against the torque of "
        f"{turn.joint.name} at constant speed: at 1 rad/s, and with its square, {each}{bound}"
    )
    reason = (
        f"at constant speed they leave {number_text(residual, '.3g')} of the torque of "
        f"{turn.joint.name} in the file (root mean square); the shaking stays"
    )
    blank = AppliedRemedy(
        KEY,
        words,
        "partial",
        reason,
        residual=residual,
        urdf=request.base.data,
        files={"springs.json": json_text({"springs": listed}, 1).encode()},
        details={"crank": turn.joint.name, "springs": listed},
    )
    # Bearings carry the springs besides, which the file does not have.
    costed = with_cost(request, blank, 0.0, request.linkage, request.motion)
    return replace(costed, built=None)
