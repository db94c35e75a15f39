"""Verification of balance by an independent program, Pinocchio, on the same linkage.

The linkage is opened at its welds: a loop joint carries a massless end. Along a motion that
closes the loops, the opened linkage has the momentum and the base reaction of the closed one.
Pinocchio computes this reaction from the joint motions by the recursive Newton-Euler algorithm
without gravity. It is compared with the derivative of the momentum from our own series.
Pinocchio orders wrenches as ``[force; moment]``; this module converts them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import CONDITIONING_LEAST, SHAKING_RELATIVE
from balance.motion.verification.crank_revolution import Crank, revolve_crank
from balance.motion.verification.given_motions import Motions, read_motions
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.load_errors import load_errors
from balance.motion.verification.run import Run
from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    inertia_sizes,
    mass_parameters,
    motion_in_chain,
    move_wrenches,
    wrench_to_si,
)
from balance.motion.verification.trajectory import Trajectory, drive, random_motions
from balance.motion.verification.verification import Verification
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.options import Balance, point_of
from kinematics.closure.joint_positions import input_chain
from kinematics.error_text import clean
from kinematics.errors import FileError, LinkageError, PackageError, PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Joint, Linkage
from kinematics.model.motion import Motion, motion_of
from kinematics.model.spatial.inertia import displace_parameters, inertia_tensor
from kinematics.numerics.array_types import Array

# Largest distance of a centre of mass from its joint, metres; the mass counts as zero beyond.
MAX_CENTRE_DISTANCE = 1e9
# Bytes that ``pinocchio.Data`` takes per cube of the number of joints: second derivatives of
# the inverse dynamics, eight arrays of that size.
CUBE_BYTES = 64
# Joints of a model with several branches, and most joints of a branch: 4 MB and 8 GB.
PART_JOINTS, MOST_JOINTS = 40, 500


def verify(
    linkage: LinkageLike,
    z: ArrayLike | None = None,
    *,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    trajectories: int = 10,
    samples: int = 200,
    seed: int = 0,
    tolerance: float = SHAKING_RELATIVE,
    motions: Motions | None = None,
    speed: float | str | None = None,
    crank: str | None = None,
    about: ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """Verify the balance of a linkage along motions, by Pinocchio and by our own series.

    The linkage is balanced if the peak of the base reaction ``ḣ = [moment; force]`` is at most
    ``tolerance`` times the peak sum of the inertia wrenches of the bodies.

    Args:
        linkage: an assembled linkage, or an argument of `kinematics.load`.
        z: inertial parameters as in `shaking`; those of the file by default.
        motion: restriction of the inputs; free by default.
        balance: ``"dynamic"``, or ``"force"`` for a verdict on the force alone.
        trajectories: number of random motions.
        samples: samples of each motion.
        seed: seed of the random motions.
        tolerance: largest relative residual of a balanced linkage.
        motions: motions to use instead of random ones, one or several: a `Trajectory`, or the
            path of a table; see `balance.motion.from_csv`.
        speed: speed of a crank, rad/s, or ``"300rpm"``; one revolution at this speed is the
            motion.
        crank: name of that crank; see
            `balance.motion.verification.crank_revolution.revolve_crank`.
        about: point in the inertial frame for moments that are reported, metres; the middle of
            the mechanism by default. The verdict is that for moments about the middle.
        progress: called with the number of motions done and the number of all motions.

    Returns:
        The verdict, with the loads along each motion.

    Raises:
        PackageError: Pinocchio is missing.
        LinkageError: a body without mass has a first moment of mass, or none has a mass.
        PoseError: the linkage cannot follow the motion, or nothing moves in it.
        MotionError: a relation is wrong.
        ValueError: an option has no such value, or excludes another.

    Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5 (Newton-Euler).

    Example:
        >>> import balance
        >>> balance.verify("robot.urdf", trajectories=1).verdict
        'not balanced'
    """
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    linkage = as_linkage(linkage)
    masses = mass_parameters(linkage, z)
    if z is None and not masses.any():
        problem, remedy = "no moving link has a mass", "give the links that move an <inertial>"
        raise FileError(clean(linkage.source, 1000), "", problem, remedy)
    model = PinocchioModel(linkage, masses)
    given, rotation = given_or_turned(linkage, motions, speed, crank, motion)
    followed: Iterable[Trajectory] = given or ()
    if given is None:
        limits = motion_of(linkage, motion)
        followed = random_motions(linkage, trajectories, samples, seed, motion=limits)
    count = trajectories if given is None else len(given)
    point = linkage.spatial_chain.frame.origin if about is None else point_of(about)
    return Verification(
        linkage,
        balance,
        tolerance,
        linkage.spatial_chain.frame.length,
        seed if given is None else None,
        tuple(_runs(linkage, model, followed, point, progress, count)),
        linkage.notices,
        freeze(point),
        rotation,
        motion=motion,
    )


def given_or_turned(
    linkage: Linkage,
    motions: Motions | None,
    speed: float | str | None,
    crank: str | None,
    motion: Motion | str | Sequence[str] | None = None,
) -> tuple[Sequence[Trajectory] | None, Crank | None]:
    """Return the given motions, or the revolution of a crank; None for random motions.

    Raises:
        PoseError: nothing moves, or the crank cannot turn fully.
        ValueError: there are motions and a speed.
    """
    if speed is not None:
        if motions is not None:
            raise ValueError("give either a speed or motions to move along")
        revolution, rotation = revolve_crank(linkage, speed, crank, motion_of(linkage, motion))
        return [revolution], rotation
    given = read_motions(linkage, motions, motion_of(linkage, motion))
    if given is not None and not any(trajectory.moves for trajectory in given):
        raise PoseError(f"{linkage.source}: nothing moves; give inputs that change with time")
    return given, None


def _runs(
    linkage: Linkage,
    model: PinocchioModel,
    motions: Iterable[Trajectory],
    point: Array,
    progress: Callable[[int, int], None] | None,
    count: int,
) -> Iterator[Run]:
    """Compute the loads along each motion, one after the other."""
    chain = input_chain(linkage)
    for done, trajectory in enumerate(motions, 1):
        yield _run(linkage, model, chain, trajectory, point)
        if progress is not None:
            progress(done, count)


def verify_second(first: Verification, linkage: LinkageLike, **options: Any) -> Verification:
    """Verify a second linkage along the motions of a first one.

    Moments are about the same point. A crank turns at the same constant speed in both. The
    second linkage gets random motions of its own if its inputs have other names, or if it
    cannot follow the motions of the first one, or is near-singular there.

    Args:
        first: the verification of the first linkage.
        linkage: the second linkage.
        options: keyword arguments of `verify`.

    Returns:
        The verification of the second linkage.
    """
    linkage, motions = as_linkage(linkage), None
    options = {**options, "about": first.point}
    if first.crank is not None:
        return verify(linkage, **{"speed": first.crank.speed, **options})
    if linkage.inputs == first.linkage.inputs:
        with suppress(PoseError):
            given = first.motions
            motions = [
                replace(
                    drive(
                        linkage, trajectory.time, trajectory.u, trajectory.ud, trajectory.udd
                    ),
                    errors=trajectory.errors,
                )
                for trajectory in given
            ]
    if motions and first.seed is not None:
        conditioning = min(trajectory.conditioning for trajectory in motions)
        motions = motions if conditioning >= CONDITIONING_LEAST else None
    verification = verify(linkage, motions=motions, **options)
    return verification if motions is None else replace(verification, shown=first.plotted)


def _run(
    linkage: Linkage, model: PinocchioModel, chain: Chain, trajectory: Trajectory, point: Array
) -> Run:
    """Compute all loads along one motion, in SI units."""
    driven = linkage.positions_of(linkage.inputs)
    scale = chain.units[driven]
    loads = inertia_loads(chain, model.z, *motion_in_chain(linkage, chain, trajectory))
    reactions = joint_reactions(chain, loads)
    L = chain.frame.length
    rate, momentum = (
        wrench_to_si(x.sum(axis=1), chain.frame) for x in (loads.rate, loads.momentum)
    )
    reaction, other = model.reactions(trajectory), model.momenta(trajectory)
    # Divide moments about the middle by the length, to compare them with forces.
    sizes = [L * np.linalg.norm(x, axis=2).sum(axis=1) for x in (loads.rate, loads.momentum)]
    middle = chain.frame.origin
    errors = None
    if trajectory.errors is not None:
        errors = freeze(load_errors(linkage, chain, model.z, trajectory, point))
    forces = L * np.linalg.norm(reactions.joints[..., 3:], axis=2)
    return Run(
        trajectory=trajectory,
        shaking=freeze(reaction),
        series_shaking=freeze(rate),
        momentum=freeze(other),
        middle=freeze(move_wrenches(reaction, middle)),
        about=freeze(move_wrenches(reaction, point)),
        inertia=freeze(sizes[0]),
        impulse=freeze(sizes[1]),
        bearing=freeze(forces),
        least_bearing=freeze(L * reactions.least),
        preloaded=freeze(reactions.preloaded, np.bool_),
        rate_difference=freeze(move_wrenches(reaction - rate, middle)),
        momentum_difference=freeze(move_wrenches(other - momentum, middle)),
        drive=freeze(L**2 * reactions.motors[:, driven] / scale),
        open=reactions.open,
        errors=errors,
    )


class RelativeShaking(NamedTuple):
    """Largest shaking along motions, relative to the peak sum of the own inertia wrenches.

    Attributes:
        force: that of the force.
        moment: that of the moment about the middle, over the characteristic length.
    """

    force: float
    moment: float


def measure_shaking(linkage: Linkage, motions: Iterable[Trajectory]) -> RelativeShaking:
    """Measure how much the masses of a file shake its base, by Pinocchio.

    These are `Verification.force_residual` and `Verification.moment_residual` of `verify`,
    without the loads of joints and motors and without our own series of the total momentum.
    Sizes of the wrenches of the bodies need no series: see `inertia_sizes`.

    Raises:
        PackageError: Pinocchio is missing.
        LinkageError: a body without mass has a first moment of mass.
    """
    masses, chain = mass_parameters(linkage), input_chain(linkage)
    model, length = PinocchioModel(linkage, masses), linkage.spatial_chain.frame.length
    listed = list(motions)
    reactions = np.concatenate([model.reactions(trajectory) for trajectory in listed])
    moved = move_wrenches(reactions, chain.frame.origin).reshape(-1, 2, 3)
    moment, force = np.linalg.norm(moved, axis=2).max(axis=0, initial=0.0).tolist()
    # All samples of all motions at once: they have no order.
    together = zip(*((each.q, each.qd, each.qdd) for each in listed), strict=True)
    joints = (np.concatenate(parts) / chain.units for parts in together)
    sizes = inertia_sizes(chain, masses, *joints)
    inertia = chain.frame.length * float(sizes.max(initial=0.0))
    if inertia == 0.0:
        return RelativeShaking(0.0, 0.0)
    return RelativeShaking(force / inertia, moment / length / inertia)


class _Part(NamedTuple):
    """Branches of an opened linkage, in Pinocchio.

    Attributes:
        joints: their joints in the linkage, in the order of the model.
        model: ``pinocchio.Model``.
        data: its ``pinocchio.Data``.
        bodies: joints of the model that carry bodies.
    """

    joints: list[int]
    model: Any
    data: Any
    bodies: list[int]


class PinocchioModel:
    """A linkage in Pinocchio, opened at its welds.

    Coordinates are inertial axes with the origin in the middle of the mechanism, SI units. The
    frame of each joint is on the joint axis, parallel to the inertial axes at the reference
    pose. Branches that stand on the base apart from each other are computed one after the
    other: the memory of Pinocchio grows with the cube of the number of joints of a model.

    Attributes:
        model: ``pinocchio.Model``, without gravity.
        z: inertial parameters of the bodies (bodies, 10) about the inertial origin.
    """

    def __init__(self, linkage: Linkage, z: Array) -> None:
        """Build the Pinocchio model.

        Args:
            z: inertial parameters of its bodies (bodies, 10), inertial origin, SI units.

        Raises:
            PackageError: Pinocchio is missing.
            LinkageError: a body without mass has a first moment of mass, or a branch has so
                many joints that Pinocchio would need more than a few gigabytes.
        """
        self._pin = _import_pinocchio()
        self.z = z
        self._origin = input_chain(linkage).frame.origin
        self._points = [_axis_point(joint, self._origin) for joint in linkage.joints]
        self._inertias = {
            body.link: self._inertia(linkage, body.name, body_z, self._points[body.link])
            for body, body_z in zip(linkage.bodies, z, strict=True)
        }
        self.model = self._model_of(linkage, range(len(linkage.joints)))
        self._parts = []
        for joints in _independent_parts(linkage):
            whole = len(joints) == len(linkage.joints)
            model = self.model if whole else self._model_of(linkage, joints)
            bodies = [k + 1 for k, joint in enumerate(joints) if joint in self._inertias]
            self._parts.append(_Part(joints, model, model.createData(), bodies))

    def _model_of(self, linkage: Linkage, joints: Sequence[int]) -> Any:
        """Build the ``pinocchio.Model`` of some joints, whose parents are among them."""
        pin = self._pin
        model, position = pin.Model(), {joint: k for k, joint in enumerate(joints, 1)}
        model.gravity.setZero()
        for j in joints:
            joint, point = linkage.joints[j], self._points[j]
            before = self._points[joint.parent] if joint.parent >= 0 else np.zeros(3)
            place = pin.SE3(np.eye(3), point - before)
            parent = position.get(joint.parent, 0)
            model.addJoint(parent, _joint_model(pin, joint), place, joint.name)
            if j in self._inertias:
                # Set the inertia itself: Pinocchio adds only bodies of positive mass.
                model.inertias[position[j]] = self._inertias[j]
        return model

    def _inertia(self, linkage: Linkage, name: str, z: Array, point: Array) -> Any:
        """Build the ``pinocchio.Inertia`` of a body about the point of its joint.

        Its parts are set one by one, because the constructor refuses values that are not
        physical, and points of the design space may have such values.
        """
        shift = np.eye(4)
        shift[:3, 3] = -self._origin - point
        local_z = displace_parameters(z, shift)
        inertia = self._pin.Inertia.Zero()
        if (
            np.abs(local_z[1:4]).max() <= MAX_CENTRE_DISTANCE * abs(local_z[0])
            and local_z[0] != 0.0
        ):
            inertia.mass, inertia.lever, inertia.inertia = mass_properties(local_z)
            return inertia
        if local_z[1:4].any():
            raise LinkageError(
                f"{linkage.source}: link '{name}' has next to no mass, but its centre is not "
                "at the origin, which Pinocchio cannot represent; verify other parameters"
            )
        inertia.inertia = inertia_tensor(local_z)
        return inertia

    def reactions(self, trajectory: Trajectory) -> Array:
        """Compute the wrench of the base on the linkage along a motion (N, 6).

        ``[moment; force]`` about the inertial origin, SI units. Pinocchio does not compute
        ``data.f[0]``, so the wrenches of the joints on the ground are summed.
        """
        pin, wrenches = self._pin, np.zeros((len(trajectory.time), 6))
        for joints, model, data, _ in self._parts:
            motion = (x[:, joints] for x in (trajectory.q, trajectory.qd, trajectory.qdd))
            places, forces, grounded = data.liMi, data.f, list(model.children[0])
            for k, (q, qd, qdd) in enumerate(zip(*motion, strict=True)):
                pin.rnea(model, data, q, qd, qdd)
                for joint in grounded:
                    wrenches[k] += places[joint].act(forces[joint]).vector
        return self._to_inertial(wrenches)

    def momenta(self, trajectory: Trajectory) -> Array:
        """Compute the total momentum ``[ξ; p]`` about the inertial origin (N, 6), SI units."""
        pin, momenta = self._pin, np.zeros((len(trajectory.time), 6))
        for joints, model, data, bodies in self._parts:
            inertias = [(joint, model.inertias[joint]) for joint in bodies]
            motion = (x[:, joints] for x in (trajectory.q, trajectory.qd))
            for k, (q, qd) in enumerate(zip(*motion, strict=True)):
                pin.forwardKinematics(model, data, q, qd)
                total = pin.Force.Zero()
                for joint, inertia in inertias:
                    total += data.oMi[joint].act(inertia * data.v[joint])
                momenta[k] += total.vector
        return self._to_inertial(momenta)

    def _to_inertial(self, forces: Array) -> Array:
        """Convert wrenches of Pinocchio (N, 6) to ours about the inertial origin."""
        return move_wrenches(np.roll(forces, 3, axis=1), -self._origin)


def _independent_parts(linkage: Linkage) -> list[list[int]]:
    """Divide the joints of an opened linkage into parts that have no joint in common.

    Returns:
        Joints of each part, ascending: branches on the base that together have at most
        `PART_JOINTS`, or one branch of more.

    Raises:
        LinkageError: a branch has more than `MOST_JOINTS`.
    """
    root: list[int] = []
    for j, joint in enumerate(linkage.joints):
        root.append(root[joint.parent] if joint.parent >= 0 else j)
    branches: dict[int, list[int]] = {}
    for j, first in enumerate(root):
        branches.setdefault(first, []).append(j)
    parts: list[list[int]] = []
    for branch in branches.values():
        if len(branch) > MOST_JOINTS:
            size = CUBE_BYTES * len(branch) ** 3 / 1e9
            raise LinkageError(
                f"{linkage.source}: {len(branch)} joints stand on one another: Pinocchio, "
                f"which verifies, needs {size:.0f} GB; verify a shorter part of the linkage"
            )
        if not parts or len(parts[-1]) + len(branch) > PART_JOINTS:
            parts.append([])
        parts[-1] += branch
    return [sorted(part) for part in parts]


def _axis_point(joint: Joint, origin: Array) -> Array:
    """Compute the point of a joint axis nearest to the origin, relative to it (3,)."""
    n, v = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return joint.point - origin
    return np.asarray(np.cross(n, v + np.cross(n, origin)))


def _joint_model(pin: Any, joint: Joint) -> Any:
    """Build the Pinocchio model of a joint, its axis in inertial axes."""
    n, v = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return pin.JointModelPrismaticUnaligned(v)
    if joint.kind == "helical":
        return pin.JointModelHelicalUnaligned(n, float(n @ v))
    return pin.JointModelRevoluteUnaligned(n)


def _import_pinocchio() -> Any:
    """Import Pinocchio.

    Raises:
        PackageError: it is not installed, or another package has its name.
    """
    try:
        import pinocchio
    except ImportError:
        pinocchio = None
    if not hasattr(pinocchio, "rnea"):
        raise PackageError(
            "verify",
            "Pinocchio",
            "pip install pin",
            ", or on Windows with 'conda install -c conda-forge pinocchio'",
        )
    return pinocchio
