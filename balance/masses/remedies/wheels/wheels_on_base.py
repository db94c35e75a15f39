"""Wheels on the base that take the angular momentum of a force-balanced linkage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.partial.motion_loads import input_inertia
from balance.masses.remedies.applied import AppliedRemedy, RemedyVerdict, with_cost
from balance.masses.remedies.judge import POSES
from balance.masses.remedies.least_matter import least_matter
from balance.masses.remedies.momentum_along import Momentum, MovedMasses, move_masses
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import append_elements, free_name, names_taken
from balance.masses.remedies.wheels.varying_ratio import integrate
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.trajectory import Trajectory, random_motions
from balance.motion.verification.verify_motions import verify
from balance.space.spaces.compute_space import design_space
from kinematics.loading.model_gallery import load
from kinematics.model.arrays import freeze
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import Linkage, names_of
from kinematics.model.motion import motion_of
from kinematics.numerics.array_types import Array
from kinematics.wording import size_text

# Samples of a motion in a file: a spline through them has the velocities and accelerations.
FILE_SAMPLES = 1001
# The attributes of a motion that have a row for each sample.
SAMPLED = ("time", "u", "ud", "udd", "q", "qd", "qdd")


class NoWheel(Exception):
    """No wheel is built: verdict, reason, and the proof if it is infeasible, as plain data."""

    def __init__(
        self, verdict: RemedyVerdict, reason: str, proof: dict[str, object] | None = None
    ) -> None:
        """Keep the facts."""
        self.verdict, self.reason, self.proof = verdict, reason, proof
        super().__init__(reason)


class ForceBalanced(NamedTuple):
    """A linkage without shaking force.

    Attributes:
        document: its file.
        linkage: the linkage, with the inputs of the request.
        added: mass of counterweights, kg.
    """

    document: Document
    linkage: Linkage
    added: float


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
    def mass(self) -> float:
        """Mass of the ring, kg."""
        return self.inertia / self.radius**2

    def elements(self, root: str) -> tuple[Element, Element]:
        """Make the link and the joint on the root: ``J/2 (1 + n nᵀ)`` is its inertia."""
        inertia = 0.5 * self.inertia * (np.eye(3) + np.outer(self.axis, self.axis))
        at, pose = make_elements.origin(np.eye(4)), np.eye(4)
        pose[:3, 3] = self.point
        return (
            make_elements.link(self.name, make_elements.inertial(self.mass, inertia, at)),
            make_elements.joint(
                self.joint,
                "continuous",
                root,
                self.name,
                make_elements.origin(pose),
                (number_words(self.axis), ""),
            ),
        )

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

    def peaks(self, speed: Array, change: Array) -> dict[str, float]:
        """Compute the peaks of speed (rad/s), torque (N m) and power (W) along a motion.

        Args:
            speed: of the wheel (N,), rad/s.
            change: its acceleration (N,), rad/s².
        """
        torque = self.inertia * change
        values = {"speed": speed, "torque": torque, "power": torque * speed}
        return {name: float(np.abs(x).max()) for name, x in values.items()}


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


@lru_cache(maxsize=1)
def balance_force(request: RemedyRequest) -> ForceBalanced:
    """Balance the force of a linkage by the least counterweights, once for all wheels.

    Default regions that are too small are widened; see `balance.masses.remedies.least_matter`.

    Args:
        request: the request; its balance does not count.

    Raises:
        NoWheel: no matter in the regions does.
        LinkageError: the linkage cannot be read again.
    """
    inputs, angles = request.linkage.inputs, request.angles
    linkage = load(
        request.base, None, inputs, bodies="all", massless=request.massless, angles=angles
    )
    space = design_space(linkage, request.motion or None, "force")
    data = request.base.data
    if not space.as_given.balanced:
        least = least_matter(
            space, request.links, request.regions, request.density, request.thickness
        )
        verdict = least.matter.verdict
        if verdict != "feasible":
            raise NoWheel(verdict, f"a wheel takes no force, and {least.reason}", least.proof)
        data = with_counterweights(least.matter)
    document = Document(request.base.name, data)
    made = load(document, None, inputs, angles=angles)
    mass = sum(float(body.inertia[0]) for body in made.bodies)
    return ForceBalanced(document, made, mass - request.given_mass)


def _turn_wheels(
    balanced: ForceBalanced, whole: Linkage, run: MovedMasses, wheels: Sequence[Wheel]
) -> Trajectory:
    """Compute the motion in which wheels take the angular momentum of a linkage.

    A wheel about n has the speed ``-n·ξ / J`` and the acceleration ``-n·ξ̇ / J``. It is on the
    base, so that all other joints move as they do without it.

    Args:
        balanced: the linkage without wheels.
        whole: the linkage with them; their joints are inputs.
        run: a motion of the linkage without them.
    """
    moved, momentum = run
    turns = {}
    for wheel in wheels:
        speed, change = (
            -(x[:, :3] @ wheel.axis) / wheel.inertia for x in (momentum.total, momentum.rate)
        )
        turns[wheel.joint] = integrate(moved.time, speed, change), speed, change

    def join(names: Sequence[str], order: Sequence[str], parts: Sequence[Array]) -> list[Array]:
        columns = {name: tuple(x[:, k] for x in parts) for k, name in enumerate(names)}
        columns |= turns
        return [freeze(np.stack([columns[n][k] for n in order], axis=1)) for k in range(3)]

    linkage = balanced.linkage
    u, ud, udd = join(linkage.inputs, whole.inputs, (moved.u, moved.ud, moved.udd))
    q, qd, qdd = join(
        names_of(linkage.joints), names_of(whole.joints), (moved.q, moved.qd, moved.qdd)
    )
    return replace(moved, u=u, ud=ud, udd=udd, q=q, qd=qd, qdd=qdd, path=None)


@lru_cache(maxsize=1)
def fine_motion(request: RemedyRequest) -> MovedMasses:
    """Make a random motion of as many samples as its file needs, once for all wheels.

    Args:
        request: the request, whose force can be balanced.
    """
    linkage = balance_force(request).linkage
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


def verify_with_wheels(
    request: RemedyRequest,
    blank: AppliedRemedy,
    balanced: ForceBalanced,
    wheels: Sequence[Wheel],
    runs: Sequence[MovedMasses],
) -> tuple[AppliedRemedy, tuple[Trajectory, ...]]:
    """Write wheels into the file, verify it along motions, and add up the cost.

    The wheels are inputs of their own in the file, so that their motions are given.

    Args:
        blank: the result so far.
        balanced: the linkage without wheels.
        runs: motions of the linkage without wheels.

    Returns:
        The result, with the inertia that the inputs of the file feel while the wheels stand,
        and the motions with the wheels, the last inputs.
    """
    root = next(name for name, place in balanced.linkage.places.items() if place.link < 0)
    elements = [item for wheel in wheels for item in wheel.elements(root)]
    document = append_elements(balanced.document, elements)
    inputs = (*balanced.linkage.inputs, *(wheel.joint for wheel in wheels))
    whole = load(document, None, inputs, angles=request.angles)
    moved = tuple(_turn_wheels(balanced, whole, run, wheels) for run in runs)
    checked = verify(whole, motions=[_thin_out(trajectory) for trajectory in moved])
    residual = max(checked.force_residual, checked.moment_residual)
    blank = replace(
        blank,
        residual=residual,
        new_links=tuple(wheel.name for wheel in wheels),
        new_joints=tuple(wheel.joint for wheel in wheels),
    )
    if not (residual <= SHAKING_RELATIVE and checked.agreed):
        reason = f"its file shakes by {size_text(residual)} of the bodies' own inertia"
        return replace(blank, reason=reason), moved
    felt = {
        name: value
        for name, value in input_inertia(whole).items()
        if name in balanced.linkage.inputs
    }
    added = balanced.added + sum(wheel.mass for wheel in wheels)
    done = replace(blank, verdict="feasible", urdf=document.data)
    return with_cost(request, done, added, felt), moved
