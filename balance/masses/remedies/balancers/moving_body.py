"""One body on the base whose own motion takes the momentum of a planar linkage.

It slides along two axes of the plane and turns about its normal n, on a ring of mass m and
inertia J. With the momentum ``[ξ; p]`` of the linkage about the origin, and its own place r,

    ṙ = -p / m        ω = -n·(ξ - r × p) / J

so that neither force nor moment is left; r moves as the common centre of mass does, reversed
and m over the mass of the linkage times as little. Its place at the start is free in the plane:
the one where it turns least along the motions that are tried, by least squares. Along the
normal it stands in the plane of the centres of mass, without which a moment across is left.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.balancers.balancing_wheels import with_motors
from balance.masses.remedies.balancers.crank_sweep import (
    crank_rates,
    sweep_crank,
)
from balance.masses.remedies.balancers.on_base import (
    SEED,
    BalancerDrive,
    Course,
    ForceBalanced,
    NoBalancer,
    build_or_refuse,
    fine_motion_of,
    motion_columns,
    ring_inertia,
    verify_with_balancers,
    with_input_inertia,
)
from balance.masses.remedies.balancers.varying_ratio import CsvFiles, integrate
from balance.masses.remedies.momentum_along import MovedMasses, move_masses
from balance.masses.remedies.request import MOTIONS, RemedyRequest
from balance.masses.remedies.variant import free_name, names_taken
from balance.motion.motion_tolerances import CONDITIONING_NOTICE, SHAKING_RELATIVE
from balance.motion.verification.trajectory import drive, random_motions
from kinematics.loading.model_gallery import load
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.motion import motion_of
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import round_decimals
from kinematics.wording import number_text, vector_text

# Furthest place from the middle of the linkage, in characteristic lengths.
FURTHEST = 2.0
# Part of that from which a place is as far away as it may be, beside its rounding.
AT_BOUND = 0.99
# Digits of places, of the characteristic length: in the plane, where they are free, and along
# the normal, where fewer would leave a moment.
DIGITS, EXACT = 3, 12
# Momenta below it, of the largest in the plane, have no direction.
PLACED = 1e-6


def apply_moving_mass(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by one body on the base that motors move along and around.

    Two motors slide it, a third turns it; the links keep their masses. For the force alone it
    does not turn. Its mass is the budget of the request, by default the mass of the linkage;
    a lighter one moves further.

    Yields:
        One result; a file has time, inputs, and position, speed, force or torque, and power of
        each motor at the greatest power, and one a motion for ``balance verify --csv``.
    """
    yield build_or_refuse("moving_mass", _move_by_motors, request)


def apply_cam_mass(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage of one freedom by a body that cams on its crank move.

    The body is that of `apply_moving_mass`. Position and turn are functions of the crank
    angle, so that cams balance at any speed of the crank.

    Yields:
        One result; a file has the lifts and their slopes over the motion of the crank.
    """
    yield build_or_refuse("cam_mass", _move_by_cams, request)


class MovingBody(NamedTuple):
    """A ring on two slides and a hinge, one upon another on the base.

    Attributes:
        links: names of its links: of a slide, of the next, of the ring.
        joints: names of its joints.
        axes: unit vectors of two slides in the plane, and the normal (3, 3), inertial.
        place: of its centre at the reference pose (3,), metres.
        mass: m, kg.
        radius: ρ, metres: J = m ρ².
        turns: whether it turns; otherwise it is on two slides alone.
    """

    links: tuple[str, ...]
    joints: tuple[str, ...]
    axes: Array
    place: Array
    mass: float
    radius: float
    turns: bool

    @property
    def drives(self) -> tuple[BalancerDrive, ...]:
        """Its joints: two slides, which move all of it, and the hinge."""
        slides = [BalancerDrive(name, name, self.mass, slides=True) for name in self.joints[:2]]
        turn = [
            BalancerDrive(name, name, self.mass * self.radius**2) for name in self.joints[2:]
        ]
        return (*slides, *turn)

    def elements(self, root: str) -> tuple[Element, ...]:
        """Make its links and joints; only the last link has mass."""
        parents, pose = (root, *self.links[:-1]), np.eye(4)
        pose[:3, 3] = self.place
        places = make_elements.origin(pose), *[make_elements.origin(np.eye(4))] * 2
        tensor = ring_inertia(self.mass * self.radius**2, self.axes[2])
        mass = make_elements.inertial(self.mass, tensor, make_elements.origin(np.eye(4)))
        parts: list[Element] = []
        for k, (parent, link) in enumerate(zip(parents, self.links, strict=True)):
            last, kind = link == self.links[-1], "prismatic" if k < 2 else "continuous"
            axis = (number_words(self.axes[k]), "")
            parts += [
                make_elements.link(link, mass if last else None),
                make_elements.joint(self.joints[k], kind, parent, link, places[k], axis),
            ]
        return tuple(parts)

    def courses(self, run: MovedMasses) -> tuple[Course, ...]:
        """Compute how it moves while the linkage moves."""
        time, (total, rate, _) = run.trajectory.time, run.momentum
        slides = []
        for axis in self.axes[:2]:
            speed, change = (-(x[:, 3:] @ axis) / self.mass for x in (total, rate))
            slides.append((integrate(time, speed, change), speed, change))
        if not self.turns:
            return tuple(slides)
        shifts = np.stack([position for position, _, _ in slides], axis=1)
        r = self.place + shifts @ self.axes[:2]
        # The place moves along p, so that its rate has no part in that of r × p.
        speed, change = (
            -((x[:, :3] - np.cross(r, x[:, 3:])) @ self.axes[2]) / (self.mass * self.radius**2)
            for x in (total, rate)
        )
        return (*slides, (integrate(time, speed, change), speed, change))


class _Prepared(NamedTuple):
    """A linkage with its own masses, random motions of it, and the body for them.

    Its strokes are the ranges of both slides along these motions, metres.
    """

    given: ForceBalanced
    runs: list[MovedMasses]
    fine: MovedMasses
    body: MovingBody
    strokes: list[float]

    @property
    def words(self) -> str:
        """What is built in where, and how far it moves."""
        body, at = self.body, vector_text(self.body.place)
        carried = "two slides and a hinge" if body.turns else "two slides"
        return (
            f"a body of {number_text(body.mass)} kg (--budget sets it) on {carried} at {at} m, "
            f"moved on the base by up to {number_text(max(self.strokes), '.3g')} m{self._bound}"
        )

    @property
    def _bound(self) -> str:
        """Whether the place is as far away as it may be, in words."""
        frame = self.given.linkage.spatial_chain.frame
        away = self.body.axes[:2] @ (self.body.place - frame.origin)
        at_bound = float(np.linalg.norm(away)) > AT_BOUND * FURTHEST * frame.length
        return " (two characteristic lengths away, a bound: it turns less further)" * at_bound


@lru_cache(maxsize=1)
def _prepare(request: RemedyRequest) -> _Prepared:
    """Move the linkage, and place the body, once for motors and for cams.

    Raises:
        NoBalancer: the linkage is spatial, there is no budget, no force, or a moment across
            the normal.
        LinkageError: the linkage cannot be moved.
    """
    if not request.linkage.planar:
        raise NoBalancer("refused", "a spatial linkage: the body moves in a plane")
    mass = request.given_mass if request.budget is None else request.budget
    if not mass > 0.0:
        raise NoBalancer("refused", "a budget of 0 kg, and the body needs a mass")
    linkage = load(request.base, None, request.linkage.inputs, angles=request.angles)
    limits = motion_of(linkage, request.motion or None)
    motions = random_motions(linkage, MOTIONS, seed=SEED, motion=limits)
    runs = [move_masses(linkage, motion) for motion in motions]
    axes, taken = linkage.chain.frame.R, names_taken(request.base)
    turns = request.balance == "dynamic"
    kinds = ["slide", "slide", "body"] if turns else ["slide", "body"]
    links, joints = [], []
    for kind in kinds:
        links.append(free_name(f"balancing_{kind}", taken))
        taken.add(links[-1])
        joints.append(free_name(f"{links[-1]}_joint", taken))
        taken.add(joints[-1])
    place = _place(request, runs, axes, mass)
    body = MovingBody(
        tuple(links), tuple(joints), axes, place, mass, request.rotor_radius, turns
    )
    given = ForceBalanced(request.base, linkage, 0.0)
    fine = fine_motion_of(request, linkage)
    courses = [body.courses(run) for run in (*runs, fine)]
    strokes = [max(float(np.ptp(each[k][0])) for each in courses) for k in range(2)]
    return _Prepared(given, runs, fine, body, strokes)


def _place(
    request: RemedyRequest, runs: Sequence[MovedMasses], axes: Array, mass: float
) -> Array:
    """Choose the place at which a body turns least, in the plane of the centres of mass.

    With its displacement s from there, least squares of ``ξ - (place + s) × p`` over all
    samples.

    Raises:
        NoBalancer: there is no force, or the centres of mass are in different planes.
    """
    frame = request.linkage.spatial_chain.frame
    momenta = [run.momentum for run in runs]
    p = np.concatenate([momentum.total[:, 3:] for momentum in momenta])
    size = max(float(momentum.size.max()) for momentum in momenta)
    if not float(np.abs(p).max()) > SHAKING_RELATIVE * size:
        raise NoBalancer("refused", "the links have no force: a wheel takes the moment")
    moved = np.concatenate([_shifts(run, mass) for run in runs])
    moment = np.concatenate([momentum.total[:, :3] for momentum in momenta])
    moment = moment - np.cross(frame.origin + moved, p)
    rows = -skew(p).reshape(-1, 3)
    offset = np.linalg.lstsq(rows, moment.ravel(), rcond=PLACED)[0]
    along = axes @ offset
    if request.balance == "dynamic":
        across = (moment - np.cross(along[2] * axes[2], p)) @ axes[:2].T
        if float(np.abs(across).max()) > SHAKING_RELATIVE * size * frame.length:
            raise NoBalancer(
                "refused",
                "centres of mass are in different planes, so that a moment across the normal "
                "is left, which this body does not take; active wheels do",
            )
    reach = float(np.hypot(*along[:2])) / (FURTHEST * frame.length)
    along[:2] /= max(1.0, reach)
    start = axes @ frame.origin + along
    decimals = -int(np.floor(np.log10(frame.length)))
    flat = round_decimals(start[:2], decimals + DIGITS)
    normal = round_decimals(start[2:], decimals + EXACT)
    return np.asarray(np.concatenate([flat, normal]) @ axes)


def _shifts(run: MovedMasses, mass: float) -> Array:
    """Integrate ``-p / m`` along a motion (N, 3)."""
    total, rate, _ = run.momentum
    parts = [
        integrate(run.trajectory.time, -total[:, k] / mass, -rate[:, k] / mass)
        for k in range(3, 6)
    ]
    return np.stack(parts, axis=1)


def _move_by_motors(request: RemedyRequest) -> AppliedRemedy:
    """Move the body by motors."""
    ready = _prepare(request)
    words = f"{ready.words} by motors"
    blank = AppliedRemedy("moving_mass", words, "undecided", "")
    runs = [*ready.runs, ready.fine]
    done = with_motors(request, blank, ready.given, [ready.body], runs)
    return replace(done, details={"body": _details(ready), **done.details})


def _move_by_cams(request: RemedyRequest) -> AppliedRemedy:
    """Move the body by cams on the crank, which feels it."""
    if request.linkage.planar and request.freedoms != 1:
        count = f"{request.freedoms} degrees of freedom"
        raise NoBalancer("refused", f"{count}, but a lift is a function of one")
    ready = _prepare(request)
    linkage, body = ready.given.linkage, ready.body
    limits = motion_of(linkage, request.motion or None)
    crank, rates = crank_rates(linkage, limits)
    way, turns = sweep_crank(linkage, limits, crank, rates)
    sweep = move_masses(linkage, way)
    runs = [ready.fine, *ready.runs]
    if regular := way.conditioning > CONDITIONING_NOTICE:
        runs.append(sweep)
    words = f"{ready.words} by cams on {crank}"
    blank = AppliedRemedy("cam_mass", words, "undecided", "")
    done, moved = verify_with_balancers(request, blank, ready.given, [body], runs)
    joints = (*linkage.inputs, *(driven.joint for driven in body.drives))
    courses = body.courses(sweep)
    lifts = {"u": way.u[:, linkage.inputs.index(crank)]}
    for driven, (position, slope, _) in zip(body.drives, courses, strict=True):
        lifts |= {f"{driven.name} lift": position, f"{driven.name} slope": slope}
    done = replace(
        done,
        files=CsvFiles({"motion.csv": motion_columns(joints, moved[0]), "cams.csv": lifts}),
        details={
            "body": _details(ready),
            "crank": crank,
            "full_turn": turns,
            "singular": not regular,
            # What the hinge turns on in each turn, beside what a cam gives back.
            "cycle": [float(position[-1] - position[0]) for position, _, _ in courses],
            "peaks": [
                {"at": "unit rate of the crank", **driven.peaks(slope, change)}
                for driven, (_, slope, change) in zip(body.drives, courses, strict=True)
            ],
        },
    )
    start = drive(linkage, [0.0], [0.0 * rates], [rates], [0.0 * rates])
    at_start = body.courses(move_masses(linkage, start))
    felt = sum(
        driven.inertia * float(speed[0]) ** 2
        for driven, (_, speed, _) in zip(body.drives, at_start, strict=True)
    )
    return with_input_inertia(request, done, {crank: felt})


def _details(ready: _Prepared) -> dict[str, object]:
    """Describe the body as plain data, and how far it moves along the random motions."""
    body = ready.body
    return {
        "links": list(body.links),
        "joints": list(body.joints),
        "place": body.place.tolist(),
        "axes": body.axes.tolist(),
        "mass": body.mass,
        "inertia": body.mass * body.radius**2 if body.turns else 0.0,
        "strokes": ready.strokes,
    }
