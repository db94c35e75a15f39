"""Verification by an independent program: Pinocchio, fed from our own model.

The linkage is opened at its welds: a loop's joint carries a massless end. Driven along a
closed motion, the opened linkage has the same momentum as the closed one, and its base the
same reaction. Pinocchio computes that reaction by the recursive Newton-Euler algorithm
without gravity, from the joints alone; it is compared with the derivative of the momentum
from our own series. Pinocchio puts forces first; they are put last here, at its border.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.inertial_parameters.conversions import mass_properties
from balance.options import Balance
from balance.verification.crank_revolution import revolve_crank
from balance.verification.joint_reactions import joint_reactions
from balance.verification.result import Run, Verification
from balance.verification.shaking_wrench import inertia_loads, mass_parameters, wrench_to_si
from balance.verification.trajectory import FIRM, Trajectory, drive, random_motions
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import LinkageError, PackageError, PoseError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Joint, Linkage
from kinematics.model.motion import Motion, motion_of
from kinematics.model_gallery import LinkageLike, as_linkage
from kinematics.spatial.inertia import displace_parameters, inertia_tensor

__all__ = ["TOLERANCE", "PinocchioModel", "verify_beside", "verify"]

Array = NDArray[np.float64]

# Masses in files are rounded: what shakes by less, relative to the inertia forces of the
# bodies, is balanced.
TOLERANCE = 1e-9
# Centres of mass that are further from their joint, in metres, are those of no mass.
FAR = 1e9


def verify(
    linkage: LinkageLike,
    z: ArrayLike | None = None,
    *,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    trajectories: int = 10,
    samples: int = 200,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    along: Sequence[Trajectory] | None = None,
    speed: float | None = None,
    crank: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """Whether a linkage shakes its base, by Pinocchio and by our own series.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        z: inertial parameters; those of the file by default. See `loads.masses`.
        motion: restriction of the inputs; free by default.
        balance: ``"force"``: the verdict is on the force alone.
        trajectories: how many random motions.
        samples: of each motion.
        seed: seed of the random motions.
        tolerance: what counts as balanced, relative to the sum of the sizes of the bodies'
            own inertia wrenches at their peak.
        along: motions to use instead of random ones.
        speed: radians per second of a crank; one revolution at this speed is the motion.
        crank: name of that crank; see `balance.verification.crank_revolution.revolve_crank`.
        progress: called with the number of motions done and of all of them.

    Raises:
        LinkageError: Pinocchio is missing, or a body cannot be given to it.
        PoseError: the linkage cannot follow the motion, or nothing moves in it.
        MotionError: a relation is wrong.
        ValueError: an option has no such value, or excludes another.
    """
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    if speed is not None and along is not None:
        raise ValueError("give either a speed or motions to move along")
    linkage, turning = as_linkage(linkage), None
    twin = PinocchioModel(linkage, mass_parameters(linkage, z))
    if speed is not None:
        way, turning = revolve_crank(linkage, speed, crank, motion_of(linkage, motion))
        along = [way]
    ways: Iterable[Trajectory] = along or ()
    if along is None:
        limits = motion_of(linkage, motion)
        ways = random_motions(linkage, trajectories, samples, seed, motion=limits)
    elif not any(way.moves for way in along):
        raise PoseError(f"{linkage.source}: nothing moves; give inputs that change with time")
    count = trajectories if along is None else len(along)
    return Verification(
        linkage=linkage, balance=balance, tolerance=tolerance,
        length=linkage.spatial_chain.frame.length, seed=seed if along is None else None,
        runs=tuple(_runs(linkage, twin, ways, progress, count)), notices=linkage.notices,
        crank=turning,
    )  # fmt: skip


def _runs(
    linkage: Linkage, twin: PinocchioModel, ways: Iterable[Trajectory],
    progress: Callable[[int, int], None] | None, count: int,
) -> Iterator[Run]:  # fmt: skip
    """The loads along each motion, one after the other."""
    chain = input_chain(linkage)
    for done, way in enumerate(ways, 1):
        yield _run(linkage, twin, chain, way)
        if progress is not None:
            progress(done, count)


def verify_beside(first: Verification, linkage: LinkageLike, **options: Any) -> Verification:
    """Another linkage verified beside a first one, driven by the same inputs.

    A crank at constant speed turns in both at that speed. If the inputs have other names, or
    the second linkage cannot follow the same motions as far from a singularity as random ones,
    random ones of its own are used.

    Args:
        first: the verification of the first linkage.
        linkage: the second linkage.
        options: as for `verify`.
    """
    linkage, along = as_linkage(linkage), None
    if first.crank is not None:
        return verify(linkage, **options)
    if linkage.inputs == first.linkage.inputs:
        with suppress(PoseError):
            ways = [run.trajectory for run in first.runs]
            along = [drive(linkage, way.time, way.u, way.ud, way.udd) for way in ways]
    if along and first.seed is not None and min(way.firmness for way in along) < FIRM:
        along = None
    found = verify(linkage, along=along, **options)
    return found if along is None else replace(found, shown=first.plotted)


def _run(linkage: Linkage, twin: PinocchioModel, chain: Chain, way: Trajectory) -> Run:
    """All loads along one motion, in SI units."""
    scale = chain.units[linkage.positions_of(linkage.inputs)]
    loads = inertia_loads(chain, twin.z, way.q / chain.units, way.ud / scale, way.udd / scale)
    held = joint_reactions(chain, loads)
    L = chain.frame.length
    own, momentum = (
        wrench_to_si(x.sum(axis=1), chain.frame) for x in (loads.rate, loads.momentum)
    )
    reaction, other = twin.reactions(way), twin.momenta(way)
    # About the middle, in characteristic lengths: moments are as large as forces.
    sizes = [L * np.linalg.norm(x, axis=2).sum(axis=1) for x in (loads.rate, loads.momentum)]
    middle = chain.frame.origin
    wrenches = np.concatenate([held.joints, held.welds], axis=1)
    forces = L * np.linalg.norm(wrenches[..., 3:], axis=2)
    return Run(
        trajectory=way, shaking=freeze(reaction), own=freeze(own), momentum=freeze(other),
        middle=freeze(_at(reaction, middle)),
        inertia=freeze(sizes[0]), impulse=freeze(sizes[1]),
        bearing=freeze(forces[:, : len(linkage.joints)]),
        rate_difference=freeze(_at(reaction - own, middle)),
        momentum_difference=freeze(_at(other - momentum, middle)), open=held.open,
    )  # fmt: skip


def _at(wrenches: Array, point: Array) -> Array:
    """Wrenches ``[moment; force]`` (..., 6) with moments about another point."""
    moment = wrenches[..., :3] - np.cross(point, wrenches[..., 3:])
    return np.concatenate([moment, wrenches[..., 3:]], axis=-1)


class PinocchioModel:
    """A linkage in Pinocchio, opened at its welds.

    Coordinates are inertial axes with the origin amid the mechanism, SI units; the frame of
    each joint is on its axis, with those axes at the reference pose.

    Attributes:
        model: ``pinocchio.Model``, without gravity.
        z: inertial parameters of the bodies (bodies, 10) about the inertial origin.
    """

    def __init__(self, linkage: Linkage, z: Array) -> None:
        """Build the model.

        Args:
            linkage: an assembled linkage.
            z: parameters of its bodies (bodies, 10).

        Raises:
            LinkageError: Pinocchio is missing, or a body has no mass, but a centre of mass.
        """
        pin = self._pin = _pinocchio()
        self.z = z
        self._origin = input_chain(linkage).frame.origin
        self._points = [_on_axis(joint, self._origin) for joint in linkage.joints]
        self.model = pin.Model()
        self.model.gravity.setZero()
        for joint, point in zip(linkage.joints, self._points, strict=True):
            before = self._points[joint.parent] if joint.parent >= 0 else np.zeros(3)
            place = pin.SE3(np.eye(3), point - before)
            self.model.addJoint(joint.parent + 1, _joint(pin, joint), place, joint.name)
        for body, own in zip(linkage.bodies, z, strict=True):
            # Pinocchio adds bodies only as long as masses are positive.
            inertia = self._inertia(linkage, body.name, own, self._points[body.link])
            self.model.inertias[body.link + 1] = inertia
        self._links = {body.link for body in linkage.bodies}
        self._data = self.model.createData()

    def _inertia(self, linkage: Linkage, name: str, z: Array, point: Array) -> Any:
        """``pinocchio.Inertia`` of a body, about the point of its joint.

        Set part by part: its constructor refuses what no body can have, and a point of the
        design space may.
        """
        shift = np.eye(4)
        shift[:3, 3] = -self._origin - point
        own = displace_parameters(z, shift)
        inertia = self._pin.Inertia.Zero()
        if np.abs(own[1:4]).max() <= FAR * abs(own[0]) and own[0] != 0.0:
            inertia.mass, inertia.lever, inertia.inertia = mass_properties(own)
            return inertia
        if own[1:4].any():
            raise LinkageError(
                f"{linkage.source}: link '{name}' has next to no mass, but its centre is not "
                "at the origin, which Pinocchio cannot be told; verify other parameters"
            )
        inertia.inertia = inertia_tensor(own)
        return inertia

    def reactions(self, way: Trajectory) -> Array:
        """Wrenches of the base ``[moment; force]`` along a motion; (N, 6).

        About the inertial origin, SI units. Pinocchio does not write ``data.f[0]``: the
        wrenches of the joints on the ground are summed.
        """
        pin, model, data = self._pin, self.model, self._data
        found = np.empty((len(way.time), 6))
        for k, (q, qd, qdd) in enumerate(zip(way.q, way.qd, way.qdd, strict=True)):
            pin.rnea(model, data, q, qd, qdd)
            total = pin.Force.Zero()
            for joint in model.children[0]:
                total += data.liMi[joint].act(data.f[joint])
            found[k] = total.vector
        return self._ours(found)

    def momenta(self, way: Trajectory) -> Array:
        """Total momenta ``[ξ; p]`` about the inertial origin (N, 6), SI units."""
        pin, model, data = self._pin, self.model, self._data
        found = np.empty((len(way.time), 6))
        bodies = [(link + 1, model.inertias[link + 1]) for link in sorted(self._links)]
        for k, (q, qd) in enumerate(zip(way.q, way.qd, strict=True)):
            pin.forwardKinematics(model, data, q, qd)
            total = pin.Force.Zero()
            for joint, inertia in bodies:
                total += data.oMi[joint].act(inertia * data.v[joint])
            found[k] = total.vector
        return self._ours(found)

    def _ours(self, forces: Array) -> Array:
        """Forces of Pinocchio (N, 6) as ``[moment; force]`` about the inertial origin."""
        return _at(np.roll(forces, 3, axis=1), -self._origin)


def _on_axis(joint: Joint, origin: Array) -> Array:
    """The point of a joint's axis nearest to the origin of the model, from there (3,)."""
    n, v = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return joint.point - origin
    return np.asarray(np.cross(n, v + np.cross(n, origin)))


def _joint(pin: Any, joint: Joint) -> Any:
    """The joint's model in Pinocchio; its axis in inertial axes."""
    n, v = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return pin.JointModelPrismaticUnaligned(v)
    if joint.kind == "helical":
        return pin.JointModelHelicalUnaligned(n, float(n @ v))
    return pin.JointModelRevoluteUnaligned(n)


def _pinocchio() -> Any:
    """The library, if it is there.

    Raises:
        PackageError: it is not, or something else goes by its name.
    """
    try:
        import pinocchio
    except ImportError:
        pinocchio = None
    if not hasattr(pinocchio, "rnea"):
        raise PackageError(
            "verify", "Pinocchio", "pip install pin",
            ", or on Windows with 'conda install -c conda-forge pinocchio'",
        )  # fmt: skip
    return pinocchio
