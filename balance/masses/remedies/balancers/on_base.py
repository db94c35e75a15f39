"""Balancers on the base, whose motion takes the momentum that a linkage leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.remedies.applied import (
    AppliedRemedy,
    RemedyVerdict,
    describe_residual,
    inertia_ratio,
    refused,
    with_cost,
)
from balance.masses.remedies.as_built import InputSteps, input_steps
from balance.masses.remedies.balancers.varying_ratio import integrate
from balance.masses.remedies.least_matter import least_matter
from balance.masses.remedies.momentum_along import Momentum, MovedMasses, move_masses
from balance.masses.remedies.request import MOTIONS, POSES, RemedyRequest
from balance.masses.remedies.variant import append_elements, free_name, names_taken
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.trajectory import Trajectory, drive, random_motions
from balance.motion.verification.verify_motions import verify
from balance.space.spaces.compute_space import design_space
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.arrays import freeze
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import Linkage, names_of
from kinematics.model.motion import motion_of
from kinematics.numerics.array_types import Array

# Samples of a motion in a file: a spline through them has the velocities and accelerations.
FILE_SAMPLES = 1001
# Seed of the other random motions.
SEED = 3
# Why nothing is built where nothing is left to take.
NO_MOMENT = "no moment is left once counterweights balance the force"
# The attributes of a motion that have a row for each sample.
SAMPLED = ("time", "u", "ud", "udd", "q", "qd", "qdd")


class NoBalancer(Exception):
    """No balancer is built: its verdict and reason, and the proof if it is infeasible."""

    def __init__(
        self, verdict: RemedyVerdict, reason: str, proof: dict[str, object] | None = None
    ) -> None:
        """Keep the facts."""
        self.verdict, self.reason, self.proof = verdict, reason, proof
        super().__init__(reason)

    def applied(self, remedy: str, words: str = "") -> AppliedRemedy:
        """Return the result of the remedy, for which nothing is built."""
        blank = refused(remedy, self.reason, words)
        return replace(blank, verdict=self.verdict, proof=self.proof)


def build_or_refuse(
    remedy: str, build: Callable[[RemedyRequest], AppliedRemedy], request: RemedyRequest
) -> AppliedRemedy:
    """Build balancers, or say why there are none."""
    try:
        return build(request)
    except NoBalancer as no:
        return no.applied(remedy)
    except LinkageError as error:
        return refused(remedy, str(error))


class ForceBalanced(NamedTuple):
    """A linkage without shaking force.

    Attributes:
        document: its file.
        linkage: the linkage, with the inputs of the request.
        added: mass of counterweights, kg.
        rim: which of them are at the rim of their regions, in words; empty for none.
        places: how much matter is where, in words; empty for none.
    """

    document: Document
    linkage: Linkage
    added: float
    rim: str = ""
    places: str = ""


class BalancerDrive(NamedTuple):
    """A joint that moves a balancer, with a motor, a gear or a cam.

    Attributes:
        name: of what it moves.
        joint: name of the joint.
        inertia: what it moves: kg m², or kg if it slides.
        slides: whether it slides.
    """

    name: str
    joint: str
    inertia: float
    slides: bool = False

    @property
    def effort(self) -> str:
        """What it takes: ``"force"`` (N) if it slides, else ``"torque"`` (N m)."""
        return "force" if self.slides else "torque"

    def columns(self, position: Array, speed: Array, change: Array) -> dict[str, Array]:
        """List position, speed, force or torque, and power along a motion (N,), SI units.

        Args:
            change: the acceleration.
        """
        effort = self.inertia * change
        names = "position" if self.slides else "angle", "speed", self.effort, "power"
        values = (position, speed, effort, effort * speed)
        return {f"{self.name} {name}": x for name, x in zip(names, values, strict=True)}

    def peaks(self, speed: Array, change: Array) -> dict[str, float]:
        """Compute the peaks of speed, torque or force, and power along a motion, SI units.

        Args:
            speed: (N,), rad/s or m/s.
            change: its rate (N,).
        """
        effort = self.inertia * change
        values = {"speed": speed, self.effort: effort, "power": effort * speed}
        return {name: float(np.abs(x).max()) for name, x in values.items()}


# Position, speed and acceleration of a joint (N,).
Course = tuple[Array, Array, Array]


class Balancer(Protocol):
    """Links on the base whose motion takes a momentum of a linkage."""

    @property
    def links(self) -> tuple[str, ...]:
        """Names of its links."""

    @property
    def drives(self) -> tuple[BalancerDrive, ...]:
        """Its joints, from the base on."""

    @property
    def mass(self) -> float:
        """Its mass, kg."""

    def elements(self, root: str) -> tuple[Element, ...]:
        """Make its links and joints on the root."""

    def courses(self, run: MovedMasses) -> tuple[Course, ...]:
        """Compute how its joints move while the linkage moves."""


class Wheel(NamedTuple):
    """A thin ring that turns on the base about a fixed axis through its centre.

    Attributes:
        name: of its link.
        joint: name of its joint.
        axis: unit vector (3,), inertial.
        point: its centre (3,), metres.
        inertia: about its axis, J, kg m².
        radius: metres; its mass is ``J / radius²``.
    """

    name: str
    joint: str
    axis: Array
    point: Array
    inertia: float
    radius: float

    @property
    def links(self) -> tuple[str, ...]:
        """Its link."""
        return (self.name,)

    @property
    def drives(self) -> tuple[BalancerDrive, ...]:
        """Its joint."""
        return (BalancerDrive(self.name, self.joint, self.inertia),)

    @property
    def mass(self) -> float:
        """Mass of the ring, kg."""
        return self.inertia / self.radius**2

    def elements(self, root: str) -> tuple[Element, ...]:
        """Make the link and the joint on the root."""
        at, pose = make_elements.origin(np.eye(4)), np.eye(4)
        pose[:3, 3] = self.point
        tensor = ring_inertia(self.inertia, self.axis)
        return (
            make_elements.link(self.name, make_elements.inertial(self.mass, tensor, at)),
            make_elements.joint(
                self.joint,
                "continuous",
                root,
                self.name,
                make_elements.origin(pose),
                (number_words(self.axis), ""),
            ),
        )

    def courses(self, run: MovedMasses) -> tuple[Course, ...]:
        """Take the angular momentum: speed ``-n·ξ / J``, acceleration ``-n·ξ̇ / J``."""
        momentum = run.momentum
        speed, change = (
            -(x[:, :3] @ self.axis) / self.inertia for x in (momentum.total, momentum.rate)
        )
        return ((integrate(run.trajectory.time, speed, change), speed, change),)

    def details(self) -> dict[str, object]:
        """Describe the wheel as plain data."""
        return {
            "link": self.name,
            "joint": self.joint,
            "axis": self.axis.tolist(),
            "point": self.point.tolist(),
            "inertia": self.inertia,
            "mass": self.mass,
            "radius": self.radius,
        }


def ring_inertia(inertia: float, axis: Array) -> Array:
    """Compute the tensor ``J/2 (1 + n nᵀ)`` (3, 3) of a thin ring of inertia J about n."""
    return np.asarray(0.5 * inertia * (np.eye(3) + np.outer(axis, axis)))


def make_wheel(
    document: Document,
    axis: Array,
    point: Array,
    inertia: float,
    radius: float,
    suffix: str = "",
) -> Wheel:
    """Make a wheel, with names that a file has not taken.

    Args:
        axis: unit vector (3,), inertial.
        point: its centre (3,), metres.
        inertia: about its axis, kg m².
        radius: metres.
        suffix: end of its name.
    """
    taken = names_taken(document)
    name = free_name(f"balancing_wheel{suffix}", taken)
    joint = free_name(f"{name}_joint", taken)
    return Wheel(name, joint, axis, point, inertia, radius)


def has_momentum(linkage: Linkage, momenta: Sequence[Momentum], axes: Array) -> bool:
    """Return whether there is angular momentum along axes, beside round-off.

    Args:
        linkage: a linkage without shaking force.
        momenta: along motions of it.
        axes: unit vectors (k, 3).
    """
    length = linkage.spatial_chain.frame.length
    most = max(
        float(np.abs(momentum.total[:, :3] @ axes.T).max(initial=0.0)) for momentum in momenta
    )
    return most > SHAKING_RELATIVE * length * max(
        float(momentum.size.max()) for momentum in momenta
    )


def refuse_other_moments(linkage: Linkage, momenta: Sequence[Momentum], lost: str) -> None:
    """Refuse a planar linkage that leaves no moment along its normal, or one across it.

    Args:
        linkage: a linkage without shaking force.
        momenta: along motions of it.
        lost: what becomes of a moment across the normal.

    Raises:
        NoBalancer: there is such a moment, or none at all.
    """
    axes = linkage.chain.frame.R
    if has_momentum(linkage, momenta, axes[:2]):
        raise NoBalancer(
            "undecided",
            "centres of mass are in different planes, so that a moment across the normal is "
            f"left, which {lost}",
        )
    if not has_momentum(linkage, momenta, axes[2:]):
        raise NoBalancer("refused", NO_MOMENT)


@lru_cache(maxsize=1)
def balance_force(request: RemedyRequest) -> ForceBalanced:
    """Balance the force of a linkage by the least counterweights, once for all wheels.

    Default regions that are too small are widened; see `balance.masses.remedies.least_matter`.

    Args:
        request: the request; its balance does not count.

    Raises:
        NoBalancer: no matter in the regions does.
        LinkageError: the linkage cannot be read again.
    """
    inputs, angles = request.linkage.inputs, request.angles
    space = design_space(request.load_base(), request.motion or None, "force")
    data, rim, places = request.base.data, "", ""
    if not space.as_given.balanced:
        least = least_matter(
            space, request.links, request.regions, request.density, request.thickness
        )
        verdict = least.matter.verdict
        if verdict != "feasible":
            raise NoBalancer(
                verdict, f"a wheel takes no force, and {least.reason}", least.proof
            )
        data, rim = with_counterweights(least.matter), least.rim_text(request.links)
        places = least.places_text
    document = Document(request.base.name, data)
    made = load(document, None, inputs, angles=angles)
    mass = sum(float(body.inertia[0]) for body in made.bodies)
    return ForceBalanced(document, made, mass - request.given_mass, rim, places)


def _join_motions(
    balanced: ForceBalanced, whole: Linkage, run: MovedMasses, balancers: Sequence[Balancer]
) -> Trajectory:
    """Compute the motion in which balancers take the momentum of a linkage.

    They are on the base, so that all other joints move as they do without them.

    Args:
        balanced: the linkage without balancers.
        whole: the linkage with them; their joints are inputs.
        run: a motion of the linkage without them.
    """
    moved, added = run.trajectory, dict[str, Course]()
    for balancer in balancers:
        joints = [drive.joint for drive in balancer.drives]
        added |= dict(zip(joints, balancer.courses(run), strict=True))

    def join(names: Sequence[str], order: Sequence[str], parts: Sequence[Array]) -> list[Array]:
        columns = {name: tuple(x[:, k] for x in parts) for k, name in enumerate(names)}
        columns |= added
        return [freeze(np.stack([columns[n][k] for n in order], axis=1)) for k in range(3)]

    linkage = balanced.linkage
    u, ud, udd = join(linkage.inputs, whole.inputs, (moved.u, moved.ud, moved.udd))
    q, qd, qdd = join(
        names_of(linkage.joints), names_of(whole.joints), (moved.q, moved.qd, moved.qdd)
    )
    return replace(moved, u=u, ud=ud, udd=udd, q=q, qd=qd, qdd=qdd, path=None)


def _joined_steps(
    request: RemedyRequest,
    balanced: ForceBalanced,
    whole: Linkage,
    balancers: Sequence[Balancer],
) -> InputSteps:
    """Move each input of a linkage alone at the reference pose, and the balancers with it."""
    alone = input_steps(request, balanced.linkage, request.motion)
    at_start = np.zeros(len(alone.ud))
    moved = drive(balanced.linkage, at_start, 0.0 * alone.ud, alone.ud, alone.udd)
    joined = _join_motions(balanced, whole, move_masses(balanced.linkage, moved), balancers)
    return InputSteps(joined.ud, joined.udd)


@lru_cache(maxsize=1)
def fine_motion(request: RemedyRequest) -> MovedMasses:
    """Make a random motion of as many samples as its file needs, once for all wheels.

    Args:
        request: the request, whose force can be balanced.
    """
    return fine_motion_of(request, balance_force(request).linkage)


@lru_cache(maxsize=1)
def random_force_balanced_motions(request: RemedyRequest) -> list[MovedMasses]:
    """Make random motions of a linkage without shaking force, once for what has no ratio.

    Args:
        request: the request, whose force can be balanced.
    """
    linkage = balance_force(request).linkage
    limits = motion_of(linkage, request.motion or None)
    motions = random_motions(linkage, MOTIONS, seed=SEED, motion=limits)
    return [move_masses(linkage, motion) for motion in motions]


def fine_motion_of(request: RemedyRequest, linkage: Linkage) -> MovedMasses:
    """Make a random motion of a linkage of as many samples as its file needs."""
    limits = motion_of(linkage, request.motion or None)
    return move_masses(linkage, next(random_motions(linkage, 1, FILE_SAMPLES, motion=limits)))


def motion_columns(inputs: Sequence[str], motion: Trajectory) -> dict[str, Array]:
    """List the columns of a motion as ``balance verify --csv`` reads them.

    Args:
        inputs: names of all inputs, in the order of the motion.
    """
    columns = {"time": motion.time}
    for rate, values in ("", motion.u), ("velocity ", motion.ud), ("acceleration ", motion.udd):
        columns |= {f"{rate}{name}": values[:, k] for k, name in enumerate(inputs)}
    return columns


def _thin_out(trajectory: Trajectory) -> Trajectory:
    """Keep as many samples of a motion as its verification needs."""
    step = max(1, len(trajectory.time) // POSES)
    kept = {name: getattr(trajectory, name)[::step] for name in SAMPLED}
    return replace(trajectory, **kept)


def verify_with_balancers(
    request: RemedyRequest,
    blank: AppliedRemedy,
    balanced: ForceBalanced,
    balancers: Sequence[Balancer],
    runs: Sequence[MovedMasses],
) -> tuple[AppliedRemedy, tuple[Trajectory, ...]]:
    """Write balancers into the file, verify it along motions, and add up the cost.

    Their joints are inputs of their own in the file, so that their motions are given.

    Args:
        blank: the result so far.
        balanced: the linkage without balancers.
        runs: motions of the linkage without them.

    Returns:
        The result, with the inertia that the inputs of the file feel while the balancers
        stand, and the motions with the balancers, the last inputs.
    """
    root = next(name for name, place in balanced.linkage.places.items() if place.link < 0)
    elements = [item for balancer in balancers for item in balancer.elements(root)]
    joints = tuple(drive.joint for balancer in balancers for drive in balancer.drives)
    document = append_elements(balanced.document, elements)
    inputs = (*balanced.linkage.inputs, *joints)
    whole = load(document, None, inputs, angles=request.angles)
    moved = tuple(_join_motions(balanced, whole, run, balancers) for run in runs)
    checked = verify(whole, motions=[_thin_out(trajectory) for trajectory in moved])
    residual = checked.force_residual
    if request.balance == "dynamic":
        residual = max(residual, checked.moment_residual)
    blank = replace(
        blank,
        residual=residual,
        new_links=tuple(link for balancer in balancers for link in balancer.links),
        new_joints=joints,
    )
    if not (residual <= SHAKING_RELATIVE and checked.agreed):
        reason = describe_residual(residual)
        return replace(blank, reason=reason), moved
    added = balanced.added + sum(balancer.mass for balancer in balancers)
    done = replace(blank, verdict="feasible", urdf=document.data)
    steps = _joined_steps(request, balanced, whole, balancers)
    done = with_cost(request, done, added, whole, steps=steps)
    return replace(done, reason=done.reason + balanced.rim), moved


def with_input_inertia(
    request: RemedyRequest, done: AppliedRemedy, felt: Mapping[str, float]
) -> AppliedRemedy:
    """Add what inputs feel of balancers that move with them to a result that has costs."""
    if done.input_inertia is None:
        return done
    inertia = {name: x + felt.get(name, 0.0) for name, x in done.input_inertia.items()}
    return replace(done, input_inertia=inertia, inertia_ratio=inertia_ratio(request, inertia))
