"""Motion of many linkages: poses along curves, momentum there, and its derivatives.

At a pose q the loops close, and with the carried screws ``s̃_j = Ad(H_parent) s_j``

    S C = 0,  c C = 1        (S: loops and relations; c: frame of the tangent space)
    T_b = Σ_way s̃_j C_j      h = Σ_b Ad(H_b)⁻ᵀ [momentum of z_b at Ad(H_b)⁻¹ T_b]

If the geometry changes, joint j moves with a twist τ_j. Its displacement ``E_j`` then changes
by the spatial twist ``(1 - Ad(E_j)) τ_j``, and while ``c q`` is kept the closed loops give

    η_b = Σ_way Ad(H_parent) (1 - Ad(E_j)) τ_j + s̃_j q'_j,      H_b' = η̂_b H_b
    s̃_j' = ad(η_parent) s̃_j + Ad(H_parent) ad(τ_j) s_j,         S C' = -S' C,  c C' = 0
    h' = Σ_b K_b (T_b' - ad(η_b) T_b) - ad(η_b)ᵀ h_b            (K_b: inertia of the body)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from kinematics.numerics.array_types import Array, Flags, IntArray

# Newton steps at each pose; the step between poses is short.
NEWTON_STEPS = 3
# The determinant of S over its largest one, below which a pose is near a meeting of motions.
NEAR_NODE = 0.03
# Longest step of an input on the way to a given pose, radians.
PLACE_STEP = 0.05
# Newton steps of least norm, and singular values of the loops that count as zero.
CLOSING_STEPS, SMALL = 12, 1e-7


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of many linkages (lanes, poses), with loops closed.

    Attributes:
        screws: joint screws at the reference pose (lanes, joints, dim).
        q: joint positions (lanes, poses, joints).
        frames: the covectors c (lanes, poses, width, joints).
        C: joint rates, one column for each covector (lanes, poses, joints, width).
        E: displacement of each joint (lanes, poses, joints, k, k).
        H: displacement of each link, and of the ground at the end (lanes, poses, joints + 1,
            k, k).
        carried: joint screws there (lanes, poses, joints, dim).
        S: the matrix of loops, relations and covectors (lanes, poses, joints, joints).
        residual: largest component of the closure residual (lanes,).
        crossed: whether a curve comes near a meeting of motions, or crosses it: there the
            determinant of S vanishes (lanes,).
    """

    screws: Array
    q: Array
    frames: Array
    C: Array
    E: Array
    H: Array
    carried: Array
    S: Array
    residual: Array
    crossed: Flags


def _displace(structure: TopologyArrays, screws: Array, q: Array) -> tuple[Array, Array, Array]:
    """Compute E, H and the carried screws at joint positions (lanes, poses, joints)."""
    algebra = structure.algebra
    E = algebra.exp(np.broadcast_to(screws[:, None], (*q.shape, algebra.dim)), q)
    H = np.empty((*q.shape[:2], q.shape[2] + 1, *E.shape[-2:]))
    H[:, :, -1] = np.eye(E.shape[-1])
    for j, parent in enumerate(structure.parent):
        H[:, :, j] = H[:, :, parent] @ E[:, :, j]
    carried = (algebra.adjoint(H[:, :, structure.parent]) @ screws[:, None, ..., None])[..., 0]
    return E, H, carried


def _constraints(structure: TopologyArrays, carried: Array, frames: Array) -> Array:
    """Assemble the square matrix of loops, relations and covectors."""
    lanes, poses, n = carried.shape[:3]
    rows = structure.closure * len(structure.ends)
    loops = (
        structure.cycles[:, None, :]
        * np.swapaxes(carried[..., : structure.closure], -1, -2)[:, :, None]
    )
    relations = np.broadcast_to(structure.relations, (lanes, poses, *structure.relations.shape))
    return np.concatenate([loops.reshape(lanes, poses, rows, n), relations, frames], axis=2)


def _closure_residuals(structure: TopologyArrays, H: Array) -> Array:
    """Compute the closure residuals (lanes, poses, rows)."""
    first, last = H[:, :, structure.ends[:, 0]], H[:, :, structure.ends[:, 1]]
    twists = structure.algebra.gap(first @ structure.algebra.inverse(last))
    rows = structure.closure * len(structure.ends)
    return np.asarray(twists[..., : structure.closure].reshape(*H.shape[:2], rows))


def _close(
    structure: TopologyArrays, screws: Array, q: Array, frames: Array, steps: int = NEWTON_STEPS
) -> Array:
    """Close the loops by Newton's method, keeping ``c q``."""
    for _ in range(steps):
        _, H, carried = _displace(structure, screws, q)
        errors = np.zeros((*q.shape, 1))
        residuals = _closure_residuals(structure, H)
        errors[..., : residuals.shape[-1], 0] = residuals
        q = q - _solve(_constraints(structure, carried, frames), errors)[..., 0]
    return q


def _solve(S: Array, right_side: Array) -> Array:
    """Solve linear systems; NaN where any of them is singular in its lane."""
    try:
        return np.asarray(np.linalg.solve(S, right_side))
    except np.linalg.LinAlgError:
        usable = np.abs(np.linalg.det(S)) > 0.0
        safe = np.where(usable[..., None, None], S, np.eye(S.shape[-1]))
        solution = np.asarray(np.linalg.solve(safe, right_side))
        return np.where(usable[..., None, None], solution, np.nan)


def _rates(structure: TopologyArrays, S: Array) -> Array:
    """Solve for the columns of C."""
    right_side = np.zeros((*S.shape[:-1], structure.width))
    right_side[..., -structure.width :, :] = np.eye(structure.width)
    return _solve(S, right_side)


def _orthonormal(C: Array) -> Array:
    """Compute covectors (…, width, joints) that span the columns of C, near to them."""
    if C.shape[-1] == 1:
        return np.swapaxes(C / np.sqrt(np.sum(C**2, axis=-2, keepdims=True)), -1, -2)
    # The polar factor changes smoothly along a curve.
    values, Q = np.linalg.eigh(np.swapaxes(C, -1, -2) @ C)
    root = (Q / np.sqrt(values)[..., None, :]) @ np.swapaxes(Q, -1, -2)
    return np.swapaxes(C @ root, -1, -2)


def _first_frames(structure: TopologyArrays, screws: Array) -> Array:
    """Compute covectors of the tangent space at the reference pose (lanes, 1, width, n)."""
    lanes, n = screws.shape[:2]
    none = np.zeros((lanes, 1, 0, n))
    S = _constraints(structure, screws[:, None], none)
    return np.asarray(np.linalg.svd(np.nan_to_num(S))[2][:, :, -structure.width :])


def _directions(width: int) -> Array:
    """Choose the directions of the curves (curves, width), the same in every run."""
    if width == 1:
        return np.array([[1.0], [-1.0]])
    rays = np.random.default_rng(7).standard_normal((2 * width + 2, width))
    return np.asarray(rays / np.sqrt(np.sum(rays**2, axis=1, keepdims=True)))


def follow_curves(
    structure: TopologyArrays, geometry: LaneGeometry, reach: float, steps: int
) -> Poses:
    """Follow the motion from the reference pose, both ways or in several directions.

    At each step the fastest joint moves by ``reach / steps``.

    Args:
        reach: way of the fastest joint, radians (or units of length).
        steps: number of poses on each curve.

    Returns:
        The poses, without the reference pose. A lane whose residual is infinite has
        lost its way.
    """
    screws = structure.screws(geometry)
    rays = _directions(structure.width)
    frames = np.repeat(_first_frames(structure, screws), len(rays), axis=1)
    C = np.swapaxes(frames, -1, -2)
    q = np.zeros((len(screws), len(rays), screws.shape[1]))
    poses = []
    with np.errstate(all="ignore"):
        for _ in range(steps):
            move = np.einsum("lrjw,rw->lrj", C, rays)
            fastest = np.max(np.abs(move), axis=-1, keepdims=True)
            q = _close(structure, screws, q + reach / steps / fastest * move, frames)
            carried = _displace(structure, screws, q)[2]
            C = _rates(structure, _constraints(structure, carried, frames))
            frames = _orthonormal(np.where(np.isfinite(C), C, 1.0))
            C = np.swapaxes(frames, -1, -2)
            poses.append((q, frames))
    return _poses(
        structure,
        screws,
        np.concatenate([q for q, _ in poses], axis=1),
        np.concatenate([c for _, c in poses], axis=1),
        len(rays),
    )


def reach_places(
    structure: TopologyArrays, geometry: LaneGeometry, inputs: tuple[int, ...], places: Array
) -> Poses:
    """Turn some joints from the reference pose by given angles, and close the loops there.

    Args:
        inputs: as many joints as there are freedoms; their rates are the columns of C.
        places: displacements of the inputs at each pose (poses, inputs).

    Returns:
        The poses. A lane is lost where an input meets a dead point on the way.
    """
    screws = structure.screws(geometry)
    lanes, n = screws.shape[:2]
    shape = (lanes, len(places), len(inputs), n)
    frames = np.broadcast_to(np.eye(n)[list(inputs)], shape).copy()
    q = np.zeros((lanes, len(places), n))
    steps = max(1, ceil(float(np.abs(places).max(initial=0.0)) / PLACE_STEP))

    def side(S: Array) -> Array:
        return np.sign(np.linalg.det(np.nan_to_num(S)))

    start = side(_constraints(structure, _displace(structure, screws, q)[2], frames))
    with np.errstate(all="ignore"):
        for _ in range(steps):
            carried = _displace(structure, screws, q)[2]
            C = _rates(structure, _constraints(structure, carried, frames))
            move = np.einsum("lpjw,pw->lpj", C, places / steps)
            q = _close(structure, screws, q + move, frames)
        poses = _poses(structure, screws, q, frames, len(places))
    same = np.all(side(poses.S) == start, axis=1)
    residual = np.where(same, poses.residual, np.inf)
    return replace(poses, residual=residual, crossed=np.zeros(lanes, bool))


def _poses(
    structure: TopologyArrays, screws: Array, q: Array, frames: Array, curves: int
) -> Poses:
    """Compute all quantities at poses whose loops are closed."""
    with np.errstate(all="ignore"):
        q = _close(structure, screws, q, frames, 2)
        E, H, carried = _displace(structure, screws, q)
        S = _constraints(structure, carried, frames)
        C = _rates(structure, S)
        residual = np.abs(_closure_residuals(structure, H)).max(axis=(1, 2))
        good = np.isfinite(C).all(axis=(1, 2, 3)) & np.isfinite(residual)
        good &= np.max(np.abs(C), axis=(1, 2, 3), initial=0.0) < 1e3
        side = np.linalg.det(np.nan_to_num(S)).reshape(len(S), -1, curves)
    side *= np.sign(side[:, :1])
    crossed = np.any(side < NEAR_NODE * side.max(axis=(1, 2), keepdims=True), axis=(1, 2))
    residual = np.where(good, residual, np.inf)
    return Poses(screws, q, frames, C, E, H, carried, S, residual, crossed)


def _body_twists(structure: TopologyArrays, poses: Poses) -> tuple[Array, Array]:
    """Compute spatial twists of the bodies (…, bodies, dim, width), and ``Ad(H_b)⁻¹``."""
    terms = poses.carried[..., None] * poses.C[..., None, :]
    T = np.einsum("bj,lpjdw->lpbdw", structure.paths[structure.bodies], terms)
    algebra = structure.algebra
    return T, algebra.adjoint(algebra.inverse(poses.H[:, :, structure.bodies]))


def lane_momentum_rows(structure: TopologyArrays, poses: Poses) -> Array:
    """Compute the matrix M (lanes, poses · width · components, unknowns) of ``h = M z``.

    Args:
        poses: poses of the linkages.
    """
    T, back = _body_twists(structure, poses)
    body_twists = back @ T
    tensor = structure.algebra.tensors.momentum
    rows = np.einsum("lpbdw,diq->lpbwiq", body_twists, tensor)
    rows = (np.swapaxes(back, -1, -2)[:, :, :, None] @ rows)[..., structure.components, :]
    lanes = len(rows)
    return np.moveaxis(rows, 2, 4).reshape(lanes, -1, structure.unknowns)


def momentum_rates(
    structure: TopologyArrays, geometry: LaneGeometry, poses: Poses, z: Array
) -> Array:
    """Differentiate the momentum of given masses with respect to all changes.

    Args:
        poses: poses of the linkages.
        z: parameters of all bodies, several sets for each lane (lanes, sets, unknowns).

    Returns:
        Shape (lanes, sets, poses · width · components, changes).
    """
    algebra = structure.algebra
    eta, twists = _link_rates(structure, geometry, poses)
    dT = _twist_rates(structure, poses, eta, twists)
    eta = eta[:, :, structure.bodies]
    T, back = _body_twists(structure, poses)
    # T' - ad(η) T = T' + ad(T) η
    bracket = algebra.bracket(np.swapaxes(T, -1, -2))
    moved = dT + np.einsum("lpbwij,lpbjc->lpbwic", bracket, eta)
    sets = z.reshape(*z.shape[:2], len(structure.bodies), -1)
    inertia = np.einsum("lsbq,diq->lsbid", sets, algebra.tensors.momentum)
    turn = np.swapaxes(back, -1, -2)
    K = turn[:, None] @ inertia[:, :, None] @ back[:, None]
    h = K @ T[:, None]
    out = np.einsum("lspbij,lpbwjc->lspwic", K, moved)
    # ad(η)ᵀ h is linear in both: -Σ η_a bracket[a]ᵀ h.
    force = np.einsum("aij,lspbiw->lspbwja", algebra.tensors.bracket, h)
    out -= np.einsum("lspbwja,lpbac->lspwjc", force, eta)
    out = out[..., structure.components, :]
    return out.reshape(*z.shape[:2], -1, eta.shape[-1])


def _link_rates(
    structure: TopologyArrays, geometry: LaneGeometry, poses: Poses
) -> tuple[Array, Array]:
    """Compute η of all links (…, joints, dim, changes), and the twists τ of the joints."""
    algebra = structure.algebra
    twists = np.moveaxis(structure.twists(geometry), 1, -1)
    local = twists[:, None] - algebra.adjoint(poses.E) @ twists[:, None]
    carried = algebra.adjoint(poses.H[:, :, structure.parent]) @ local
    open_by = np.einsum("mj,lpjdc->lpmdc", structure.cycles, carried)
    open_by = open_by[..., : structure.closure, :]
    right = np.zeros((*poses.S.shape[:-1], twists.shape[-1]))
    rows = open_by.shape[2] * open_by.shape[3]
    right[..., :rows, :] = -open_by.reshape(*open_by.shape[:2], rows, -1)
    dq = _solve(poses.S, right)
    terms = carried + poses.carried[..., None] * dq[..., None, :]
    return np.einsum("kj,lpjdc->lpkdc", structure.paths, terms), twists


def _twist_rates(structure: TopologyArrays, poses: Poses, eta: Array, twists: Array) -> Array:
    """Differentiate the twists of the bodies (…, bodies, width, dim, changes)."""
    algebra = structure.algebra
    ground = np.zeros_like(eta[:, :, :1])
    above = np.concatenate([eta, ground], axis=2)[:, :, structure.parent]
    # ad(η) s = -ad(s) η
    ds = -algebra.bracket(poses.carried) @ above
    local_rates = -algebra.bracket(poses.screws)[..., :, :] @ twists
    ds += algebra.adjoint(poses.H[:, :, structure.parent]) @ local_rates[:, None]
    loops = np.einsum("mj,lpjdc,lpjw->lpmdwc", structure.cycles, ds, poses.C)
    loops = loops[..., : structure.closure, :, :]
    shape = loops.shape
    right = np.zeros((*poses.S.shape[:-1], shape[-2] * shape[-1]))
    rows = shape[2] * shape[3]
    right[..., :rows, :] = -loops.reshape(*shape[:2], rows, -1)
    dC = _solve(poses.S, right).reshape(*poses.C.shape, -1)
    paths = structure.paths[structure.bodies]
    return np.einsum("bj,lpjdc,lpjw->lpbwdc", paths, ds, poses.C) + np.einsum(
        "bj,lpjd,lpjwc->lpbwdc", paths, poses.carried, dC
    )


def freedoms(
    structure: TopologyArrays, screws: Array, q: Array, step: Array
) -> tuple[Array, IntArray]:
    """Step along the part of a direction in which the loops can move, and count freedoms there.

    Args:
        screws: joint screws at the reference pose (lanes, joints, dim).
        q: joint positions of closed loops (lanes, joints).
        step: change of the joint positions (joints,).

    Returns:
        Positions with loops closed again by steps of least norm, and the number of freedoms;
        0 where the loops cannot be closed.
    """
    lanes, n = q.shape
    none = np.zeros((lanes, 1, 0, n))

    def loops(q: Array) -> tuple[Array, Array]:
        _, H, carried = _displace(structure, screws, q[:, None])
        S = _constraints(structure, carried, none)[:, 0]
        errors = np.zeros((lanes, S.shape[1]))
        residuals = _closure_residuals(structure, H)[:, 0]
        errors[:, : residuals.shape[1]] = residuals
        return S, errors

    S, errors = loops(q)
    inverse = np.linalg.pinv(S, rcond=SMALL)
    q = q + step - (inverse @ (S @ step)[..., None])[..., 0]
    for _ in range(CLOSING_STEPS):
        S, errors = loops(q)
        q = q - (np.linalg.pinv(S, rcond=SMALL) @ errors[..., None])[..., 0]
    S, errors = loops(q)
    values = np.linalg.svd(S, compute_uv=False)
    rank = np.sum(values > SMALL * values[:, :1], axis=1)
    return q, np.where(np.abs(errors).max(axis=1) < 1e-10, n - rank, 0)
