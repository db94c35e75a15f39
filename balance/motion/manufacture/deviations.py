"""What deviates in a linkage that is made, and what each deviation does to its shaking.

Three kinds, each of every link or joint by itself and within a bound:

- the mass of a link, as by its density: ``z → (1 + ε) z``, ``|ε| ≤ μ``;
- its centre of mass, along each axis of the link frame: all of its matter is displaced by d,
  ``mc → mc + m d``, ``E → E + m (2 (c·d) 1 - c dᵀ - d cᵀ) + m (d·d 1 - d dᵀ)``;
- the axis of a joint, along two directions at right angles to it, so that lengths of links
  change; loops close by the other joints, and the inputs move as before.

Loads are linear in z. So they are affine in ε, and in ``(1 + ε) d`` but for the square of d,
whose bound is kept: with masses and centres alone nothing is neglected. Axes count to first
order, by central differences of loads along the motion with a displaced axis.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import AXIS_SHIFT, AXIS_SHIFT_CLOSED
from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    load_regressors,
    mass_parameters,
    motion_in_chain,
    move_wrenches,
    wrench_to_si,
)
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.conversions import to_chain
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.newton import solve_positions
from kinematics.errors import LinkageError, UsageError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage
from kinematics.model.plane import plane_axes
from kinematics.model.spatial.inertia import displace_parameters, stack_parameters
from kinematics.numerics.array_types import Array


class Tolerances(NamedTuple):
    """Largest deviations.

    Attributes:
        mass: of the mass of each link, relative to it.
        length: of the axis of each joint, along each of two directions, metres.
        com: of the centre of mass of each link, along each axis of its frame, metres.
    """

    mass: float = 0.0
    length: float = 0.0
    com: float = 0.0

    def __repr__(self) -> str:
        """One line: the three bounds."""
        return (
            f"Tolerances: mass {100.0 * self.mass:g} %, length {self.length:g} m, com "
            f"{self.com:g} m"
        )


class Deviation(NamedTuple):
    """One quantity that deviates.

    Attributes:
        kind: ``"mass"``, ``"com"`` or ``"length"``.
        name: of the link, or of the joint.
    """

    kind: str
    name: str

    @property
    def words(self) -> str:
        """The quantity in words."""
        what = {"mass": "mass of", "com": "centre of mass of", "length": "axis of"}
        return f"{what[self.kind]} {self.name}"


class DeviatingLoads(NamedTuple):
    """Shaking along a motion as an affine function of deviations.

    Attributes:
        nominal: shaking without deviations (N, 6), ``[moment; force]``, N m and N.
        columns: what each deviation adds at its bound (N, 6, columns): the wrench is
            ``nominal + columns v`` with ``|v_k| ≤ 1``.
        owners: deviation that each column is part of (columns,), as index.
        neglected: bound on what the squares of displacements of centres add (N, 2): moment
            and force.
    """

    nominal: Array
    columns: Array
    owners: tuple[int, ...]
    neglected: Array


def deviations_of(linkage: Linkage, tolerances: Tolerances) -> tuple[Deviation, ...]:
    """List what deviates: masses, centres of mass, axes.

    Raises:
        UsageError: a bound is negative or too large, or all are 0.
    """
    if not (0.0 <= tolerances.mass < 1.0):
        raise UsageError(f"mass: {tolerances.mass:g} is not a part from 0 up to 1")
    for name in ("length", "com"):
        if not (0.0 <= getattr(tolerances, name) < np.inf):
            raise UsageError(f"{name}: {getattr(tolerances, name):g} m is not 0 or more")
    if not any(tolerances):
        raise UsageError("give a tolerance above 0: of masses, lengths or centres of mass")
    deviations = []
    for kind in ("mass", "com"):
        if getattr(tolerances, kind) > 0.0:
            deviations += [Deviation(kind, body.name) for body in linkage.bodies]
    if tolerances.length > 0.0:
        deviations += [
            Deviation("length", joint.name)
            for joint in linkage.joints
            if joint.kind != "prismatic"
        ]
    return tuple(deviations)


def deviating_loads(
    linkage: Linkage,
    trajectory: Trajectory,
    tolerances: Tolerances,
    deviations: tuple[Deviation, ...],
    about: Array,
    z: Array | None = None,
) -> DeviatingLoads:
    """Compute shaking as an affine function of deviations.

    Args:
        trajectory: a motion.
        tolerances: bounds of the deviations.
        deviations: from `deviations_of`.
        about: point of moments (3,), metres.
        z: parameters (bodies, 10); those of the file by default.

    Raises:
        LinkageError: loops do not close with a displaced axis.
    """
    chain = input_chain(linkage)
    masses = mass_parameters(linkage, z)
    q, ud, udd = motion_in_chain(linkage, chain, trajectory)
    rate = load_regressors(chain, q, ud, udd).rate
    parameters = to_chain(masses, chain.frame, False, False)

    def si(wrenches: Array) -> Array:
        return move_wrenches(wrench_to_si(wrenches, chain.frame), about)

    nominal = si(np.einsum("kbip,bp->ki", rate, parameters))
    columns, owners = [], []
    neglected = np.zeros((len(q), 2))
    at = {(item.kind, item.name): k for k, item in enumerate(deviations)}
    for b, body in enumerate(linkage.bodies):
        R = body.frame[:3, :3]
        if ("mass", body.name) in at:
            columns.append(si(tolerances.mass * rate[:, b] @ parameters[b]))
            owners.append(at["mass", body.name])
        if ("com", body.name) in at:
            grown = (1.0 + tolerances.mass) * tolerances.com
            for axis in R.T:
                change = _displaced(masses[b], axis)
                change = to_chain(change[None], chain.frame, False, False)[0]
                columns.append(si(grown * rate[:, b] @ change))
                owners.append(at["com", body.name])
            square = (
                _bound_shifted_inertia(tolerances.com)
                * (1.0 + tolerances.mass)
                * abs(masses[b, 0])
            )
            sizes = np.linalg.norm(rate[:, b, :3, 4:], axis=1)
            neglected[:, 0] += sizes @ square
    for j, joint in enumerate(linkage.joints):
        if ("length", joint.name) in at:
            for shift in plane_axes(joint.screw[:3])[:2]:
                slope = _shifted_loads(chain, j, shift, masses, (q, ud, udd), linkage.source)
                columns.append(si(tolerances.length * slope))
                owners.append(at["length", joint.name])
    return DeviatingLoads(
        freeze(nominal), freeze(np.stack(columns, axis=2)), tuple(owners), freeze(neglected)
    )


def deviated_masses(
    linkage: Linkage,
    tolerances: Tolerances,
    loads: DeviatingLoads,
    deviations: tuple[Deviation, ...],
    vertex: Array,
    z: Array | None = None,
) -> Array:
    """Compute the parameters (bodies, 10) of a linkage with given deviations, exactly.

    Args:
        tolerances: bounds of the deviations.
        loads: what the deviations do.
        deviations: from `deviations_of`.
        vertex: deviations over their bounds (columns,), from -1 to 1.
        z: parameters without deviations; those of the file by default.
    """
    masses = mass_parameters(linkage, z)
    for b, body in enumerate(linkage.bodies):
        parts: dict[str, list[float]] = {"mass": [], "com": []}
        for owner, share in zip(loads.owners, vertex.tolist(), strict=True):
            if deviations[owner].name == body.name and deviations[owner].kind in parts:
                parts[deviations[owner].kind].append(share)
        if parts["com"]:
            H = np.eye(4)
            H[:3, 3] = body.frame[:3, :3] @ (tolerances.com * np.array(parts["com"]))
            masses[b] = displace_parameters(masses[b], H)
        masses[b] *= 1.0 + tolerances.mass * sum(parts["mass"])
    return masses


def exact_peaks(
    linkage: Linkage,
    trajectory: Trajectory,
    masses: Array,
    loads: DeviatingLoads,
    deviations: tuple[Deviation, ...],
    vertex: Array,
    about: Array,
) -> tuple[float, float]:
    """Compute the peak moment, N m, and force, N, with deviations: exactly in the masses.

    Args:
        trajectory: a motion.
        masses: parameters with these deviations (bodies, 10).
        loads: what the deviations do along the motion.
        deviations: from `deviations_of`.
        vertex: deviations over their bounds (columns,).
        about: point of moments (3,), metres.
    """
    chain = input_chain(linkage)
    motion = motion_in_chain(linkage, chain, trajectory)
    rate = inertia_loads(chain, masses, *motion).rate.sum(axis=1)
    wrench = move_wrenches(wrench_to_si(rate, chain.frame), about)
    lengths = [k for k, owner in enumerate(loads.owners) if deviations[owner].kind == "length"]
    wrench = wrench + loads.columns[:, :, lengths] @ vertex[lengths]
    moment, force = np.linalg.norm(wrench.reshape(-1, 2, 3), axis=2).max(axis=0).tolist()
    return moment, force


def _displaced(z: Array, d: Array) -> Array:
    """Compute how parameters (10,) change with a displacement of the matter, per metre."""
    m, mc = z[0], z[1:4]
    E = 2.0 * (mc @ d) * np.eye(3) - np.outer(mc, d) - np.outer(d, mc)
    return stack_parameters(0.0, m * d, E)


def _bound_shifted_inertia(size: float) -> Array:
    """Bound the entries of ``d·d 1 - d dᵀ`` (6,), per kilogram, for ``|d_i| ≤ size``.

    In other axes the length of d is at most ``√3 size``.
    """
    return 3.0 * size**2 * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])


def _shifted_loads(
    chain: Chain, j: int, shift: Array, z: Array, motion: tuple[Array, ...], source: str
) -> Array:
    """Compute the derivative of the total load (N, 6) by a displacement of an axis, per metre.

    Args:
        chain: the linkage.
        j: the joint.
        shift: direction (3,).
        z: parameters of the bodies (bodies, 10), SI units.
        motion: positions of all joints, velocities and accelerations of the inputs.
        source: file of the linkage, for the error.

    Raises:
        LinkageError: the loops do not close.
    """
    ends = []
    for sign in (1.0, -1.0):
        screws = chain.screws.copy()
        n = screws[j, :3]
        screws[j, 3:] += np.cross(sign * AXIS_SHIFT * shift, n)
        moved = replace(chain, screws=freeze(screws))
        poses = np.empty_like(motion[0])
        for k, q in enumerate(motion[0]):
            poses[k], error = solve_positions(moved, q)
            if not error <= AXIS_SHIFT_CLOSED:
                raise LinkageError(
                    f"{source}: the loops do not close with other lengths: the linkage is "
                    "overconstrained; give tolerances of mass and com alone"
                )
        ends.append(inertia_loads(moved, z, poses, *motion[1:]).rate.sum(axis=1))
    return np.asarray((ends[0] - ends[1]) / (2.0 * AXIS_SHIFT * chain.frame.length))
