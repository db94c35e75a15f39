"""The shaking wrench of a linkage: the rate of change of its total momentum.

With the momentum regressor along the line ``u(t) = u + t u̇``
(`balance.space.momentum.regressor`)

    h = Σ_w u̇_w X_{w,0} z        ḣ = Σ_w (ü_w X_{w,0} + u̇_w X_{w,1}) z

ḣ is the wrench that the base exerts on the linkage, gravity apart; the linkage exerts the
opposite one on its base.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import RATE_RESIDUAL_RELATIVE
from balance.motion.verification.inertia_wrench_kernels import (
    fill_inertia_wrenches,
    wrench_workspace,
)
from balance.motion.verification.motion_kernels import (
    fill_load_regressors,
    fill_loads,
    load_workspace,
)
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.conversions import to_chain
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import LinkageError, PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain, Frame, read_only
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import stack_parameters
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import cross_products


class Loads(NamedTuple):
    """Momentum and its rate along a motion, in the frame and units of a spatial chain.

    Regressors have one more axis, for the parameters.

    Attributes:
        momentum: ``[ξ; p]`` of each body (N, bodies, 6), about the origin of the chain.
        rate: time derivative of the momentum, the inertia wrench of the body (N, bodies, 6).
        screws: joint screws at each sample (N, n, 6).
    """

    momentum: Array
    rate: Array
    screws: Array


def mass_parameters(linkage: Linkage, z: ArrayLike | None = None) -> Array:
    """Complete inertial parameters to ten for each body, inertial origin, SI units.

    Args:
        z: parameters; those of the file by default. A body has 10; or 4 as in a design space
            for force balance, ``[m, mcx, mcy, mcz]``. A body of a planar linkage has 10; or,
            as in its design space, 4, ``[m, mcx, mcy, Ezz]``, or 3, ``[m, mcx, mcy]``, in the
            axes of its plane. Bodies are then flat, in the plane through the inertial origin.

    Returns:
        Parameters (bodies, 10).

    Raises:
        LinkageError: the number of parameters is wrong, or one is not finite.
    """
    count = len(linkage.bodies)
    if z is None:
        return np.array([body.inertia for body in linkage.bodies]).reshape(count, 10)
    given = np.asarray(z, dtype=np.float64)
    size = given.size // max(count, 1)
    sizes = (3, 4, 10) if linkage.planar else (4, 10)
    if given.size != size * count or (count and size not in sizes):
        raise LinkageError(
            f"{linkage.source}: got {given.size} inertial parameters for {count} bodies; "
            f"give {' or '.join(map(str, sizes))} for each"
        )
    given = given.reshape(count, -1)
    if not np.isfinite(given).all():
        raise LinkageError(f"{linkage.source}: inertial parameters must be finite numbers")
    if size == 10:
        return given.copy()
    full = np.zeros((count, 10))
    if linkage.planar:
        R = linkage.chain.frame.R
        full[:, 0] = given[:, 0]
        full[:, 1:4] = given[:, 1:3] @ R[:2]
        if size == 4:
            E = 0.5 * (np.eye(3) + np.outer(R[2], R[2]))
            entries = stack_parameters(0.0, np.zeros(3), E)[4:]
            full[:, 4:] = np.outer(given[:, 3], entries)
    else:
        full[:, :4] = given
    return full


def motion_in_chain(
    linkage: Linkage, chain: Chain, trajectory: Trajectory
) -> tuple[Array, Array, Array]:
    """Convert a motion to the units of a chain: q of all joints, u̇ and ü of the inputs."""
    units = chain.units[linkage.positions_of(linkage.inputs)]
    return trajectory.q / chain.units, trajectory.ud / units, trajectory.udd / units


def inertia_loads(chain: Chain, z: Array, q: Array, ud: Array, udd: Array) -> Loads:
    """Compute the momentum of each body, and its time derivative, along a motion.

    Args:
        chain: all joints of a spatial chain, its columns the inputs; from
            `kinematics.closure.joint_positions.input_chain`.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        q: positions of all joints (N, n) that close the loops, in units of the chain.
        ud: velocities of the inputs (N, mobility), in units of the chain.
        udd: accelerations of the inputs (N, mobility), in units of the chain.

    Returns:
        Momenta and inertia wrenches, about the origin of the chain, in its units.
    """
    chain_z = to_chain(z, chain.frame, False, False)
    loads = np.zeros((2, len(q), len(chain_z), 6))
    return _filled(chain, (q, ud, udd), fill_loads, loads, chain_z)


def inertia_wrenches(chain: Chain, z: Array, q: Array, qd: Array, qdd: Array) -> Array:
    """Compute the inertia wrench of each body at all samples.

    Along the tree, with the twist ``V`` and its rate ``A`` of each link and the momentum
    ``M V`` in the coordinates that the link carries along,

        V_j = V_p + s_j q̇_j      A_j = A_p + s_j q̈_j + ad(V_p) s_j q̇_j
        ḣ = Ad(H)⁻ᵀ (M A - ad(V)ᵀ M V).

    Args:
        chain: all joints of a spatial chain; see `inertia_loads`.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        q: positions of all joints (N, n) that close the loops, in units of the chain, as for
            the next two.
        qd: their velocities (N, n).
        qdd: their accelerations (N, n).

    Returns:
        Wrenches ``[moment; force]`` (N, bodies, 6), as in `inertia_loads`; zero for bodies
        that cannot move.

    Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 5.3.
    """
    wrenches = np.empty((len(q), chain.links.size, 6))
    purpose = ("wrenches",)
    workspace = chain.borrow(purpose, lambda: wrench_workspace(chain))
    fill_inertia_wrenches(
        chain.parent,
        chain.screws,
        chain.links,
        to_chain(z, chain.frame, False, False),
        (q, qd, qdd),
        workspace,
        wrenches,
    )
    chain.give_back(purpose, workspace)
    return wrenches


def inertia_sizes(chain: Chain, z: Array, q: Array, qd: Array, qdd: Array) -> Array:
    """Compute the sum of the sizes of the inertia wrenches of the bodies, all samples at once.

    Args:
        chain: see `inertia_wrenches`, as for the other arguments.

    Returns:
        The sums (N,) of norms of ``[moment; force]``.
    """
    wrenches = inertia_wrenches(chain, z, q, qd, qdd)
    return np.asarray(np.linalg.norm(wrenches, axis=2).sum(axis=1))


def shaking_along(
    linkage: Linkage, trajectory: Trajectory, z: ArrayLike | None = None
) -> Array:
    """Compute the shaking wrench of a linkage along a motion, all samples at once.

    Args:
        z: inertial parameters of the bodies; see `mass_parameters`.

    Returns:
        The wrench about the inertial origin (N, 6), N m and N, as of `shaking`.
    """
    return np.asarray(body_wrenches_along(linkage, trajectory, z).sum(axis=1))


def body_wrenches_along(
    linkage: Linkage, trajectory: Trajectory, z: ArrayLike | None = None
) -> Array:
    """Compute what each body adds to the shaking wrench (N, bodies, 6); see `shaking_along`."""
    chain = input_chain(linkage)
    motion = (x / chain.units for x in (trajectory.q, trajectory.qd, trajectory.qdd))
    return wrench_to_si(
        inertia_wrenches(chain, mass_parameters(linkage, z), *motion), chain.frame
    )


def load_regressors(chain: Chain, q: Array, ud: Array, udd: Array) -> Loads:
    """Compute the loads as linear functions of the parameters, along a motion.

    Args:
        chain: see `inertia_loads`, as for the other arguments.
        q: positions of all joints (N, n).
        ud: velocities of the inputs (N, mobility).
        udd: accelerations of the inputs (N, mobility).

    Returns:
        Momenta and inertia wrenches per unit of each of the ten parameters of the body, all in
        the units of the chain (N, bodies, 6, 10).
    """
    loads = np.zeros((2, len(q), chain.links.size, 6, 10))
    return _filled(chain, (q, ud, udd), fill_load_regressors, loads)


def _filled(
    chain: Chain,
    motion: tuple[Array, Array, Array],
    fill: Callable[..., None],
    loads: Array,
    *masses: Array,
) -> Loads:
    """Fill loads along a motion by a kernel, with a workspace that the chain keeps."""
    q, ud, udd = (read_only(np.ascontiguousarray(x)) for x in motion)
    screws = np.empty((len(q), *chain.screws.shape))
    workspace = chain.borrow(("loads",), lambda: load_workspace(chain))
    samples = q, ud[:, None], udd[:, None]
    fill(chain.walked, chain.links, *masses, samples, workspace, screws, loads)
    chain.give_back(("loads",), workspace)
    return Loads(loads[0], loads[1], screws)


def wrench_to_si(wrenches: Array, frame: Frame) -> Array:
    """Convert wrenches or momenta of a spatial chain to SI units about the inertial origin.

    Forces scale with the length of the chain, moments with its square.

    Args:
        wrenches: ``[moment; force]`` (..., 6) in the frame and units of the chain.
        frame: frame of the chain.

    Returns:
        ``[moment; force]`` (..., 6), N m and N, or N m s and N s.
    """
    force = frame.length * wrenches[..., 3:]
    moment = frame.length**2 * wrenches[..., :3] + cross_products(frame.origin, force)
    return np.concatenate([moment, force], axis=-1)


def move_wrenches(wrenches: Array, point: Array) -> Array:
    """Move wrenches from the inertial origin to another point: ``M - r × F``.

    Args:
        wrenches: ``[moment; force]`` (..., 6) about the inertial origin, N m and N.
        point: r, metres (3,).

    Returns:
        The same wrenches with moments about the point (..., 6).
    """
    moment = wrenches[..., :3] - np.cross(point, wrenches[..., 3:])
    return np.concatenate([moment, wrenches[..., 3:]], axis=-1)


def shaking(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    qd: ArrayLike,
    qdd: ArrayLike,
    z: ArrayLike | None = None,
) -> Array:
    """Compute the shaking wrench ``ḣ = [moment; force]`` of a linkage.

    ``ḣ = Σ_w (ü_w X_{w,0} + u̇_w X_{w,1}) z`` with the momentum regressor X is the wrench of
    the base on the linkage, without gravity. A planar linkage has all six components too.

    Args:
        linkage: an assembled linkage, or an argument of `kinematics.load`.
        q: displacements from the reference pose, rad or m, of the inputs (mobility,) or of all
            joints (n,), which must close the loops; or one such row for each of N samples.
        qd: velocities of the inputs or of all joints, of the same shape, rad/s or m/s.
        qdd: accelerations of the inputs or of all joints, rad/s² or m/s².
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.

    Returns:
        The wrench about the inertial origin in inertial axes, N m and N: (6,), or (N, 6).

    Raises:
        PoseError: a pose or a velocity does not fulfil the loops, or cannot be reached.
        LinkageError: the number of parameters is wrong.

    Example:
        >>> import balance
        >>> wrench = balance.motion.shaking("robot.urdf", q=[0.0], qd=[2.0], qdd=[0.0])
        >>> (wrench.round(3) + 0.0).tolist()
        [0.0, 0.0, -0.048, -0.987, -1.198, 0.0]
    """
    linkage = as_linkage(linkage)
    chain = input_chain(linkage)
    inputs = linkage.positions_of(linkage.inputs)
    rates = [np.asarray(x, dtype=np.float64) for x in (qd, qdd)]
    single = isinstance(q, Mapping) or np.ndim(q) < 2
    poses = [q] if single else list(np.asarray(q, dtype=np.float64))
    ud, udd = (x[None] if single else x for x in rates)
    allowed = [(len(poses), linkage.mobility), (len(poses), len(linkage.joints))]
    if ud.shape not in allowed or udd.shape not in allowed:
        raise PoseError(
            f"{linkage.source}: give {linkage.mobility} (the inputs) or {len(linkage.joints)} "
            "(all joints) velocities and accelerations for each pose"
        )
    positions = np.array([joint_positions(linkage, pose) for pose in poses]) / chain.units
    if ud.shape[1] > linkage.mobility:
        _check_rates(linkage, chain, positions, ud / chain.units)
    ud, udd = (x if x.shape[1] == linkage.mobility else x[:, inputs] for x in (ud, udd))
    scale = chain.units[inputs]
    loads = inertia_loads(
        chain, mass_parameters(linkage, z), positions, ud / scale, udd / scale
    )
    wrench = wrench_to_si(loads.rate.sum(axis=1), chain.frame)
    return wrench[0] if single else wrench


def _check_rates(linkage: Linkage, chain: Chain, q: Array, qd: Array) -> None:
    """Raise PoseError for joint velocities that open the loops."""
    inputs = linkage.positions_of(linkage.inputs)
    for position, speed in zip(q, qd, strict=True):
        screws = forward_kinematics(chain, position).screws
        C = expand_from(chain, screws, np.zeros((1, chain.width)), 0).C[0, 0]
        residual = np.abs(C @ speed[inputs] - speed).max()
        if not residual <= RATE_RESIDUAL_RELATIVE * np.abs(speed).max():
            raise PoseError(
                f"{linkage.source}: these joint velocities open the loops; give those of the "
                f"inputs alone ({', '.join(linkage.inputs)})"
            )
