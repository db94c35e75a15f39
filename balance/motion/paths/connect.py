"""Paths without reaction between two given poses.

Unknown is the whole path x(τ), 0 ≤ τ ≤ 1, of the inputs, and of the attitude of a base that
turns:

    x' = x₁ - x₀ + Σ_k c_k P_k(2τ - 1),   k ≥ 1

with Legendre polynomials P, so that both ends are given. The equations ``A(x) x' = 0`` hold at
Gauss points. Newton steps of least norm, ``Σ_k |c_k|² w_k``, change a first path as little as
they may; further ones shorten it. Between the points the error falls with the number of
polynomials faster than any power of it, for A is analytic. Where ``A x' = 0`` is not
integrable, the paths reach every pose nearby (A. W. Divelbiss, J. T. Wen, Nonholonomic path
planning with inequality constraints, 1993, for the least-norm steps; E. Papadopoulos, S.
Dubowsky, 1991, for arms in space).

The momentum of a base that floats with the rotation R = exp θ vanishes, if in its own axes

    S_u u' + S_ω J(θ) θ' = 0,     S = H_ξ - M_ξv H_p / m

where H has the momenta ``[ξ; p]`` of unit rates, of the inputs and of turns of the locked
linkage with its base, M_ξv is the angular momentum of unit velocities, and J takes θ' to the
angular velocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from balance.motion.floating_base.base import FloatingBase
from balance.motion.motion_tolerances import PATH_CONNECTED
from balance.motion.paths.demand import Demand
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import spatial_inertias
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array

# Numbers of polynomials, of which the first that meets the equations between the points is
# taken.
POLYNOMIALS = 32, 64, 128, 192, 256, 384, 512, 768
# Momentum between the points, over what the rates could make, up to which a path is exact.
EXACT_BETWEEN_POINTS = 1e-10
# Least-norm steps from a first path, steps that shorten a path, and the first of their lengths.
STEPS, SHORTENED, LONGEST = 40, 12, 0.5
# Least part of a step that is tried.
LEAST_PART = 1.0 / 64.0
# Displacement of coordinates in central differences.
DIFFERENCE = 1e-5
# Part of the largest singular value below which directions of a step count as none.
SINGULAR = 1e-8
# First paths: how many of their polynomials move, and the size of their loops.
LOOP_TERMS, LOOPS = 4, (0.5, 4.0)
SEED = 5


class PoseRows(NamedTuple):
    """The equations at poses of a path.

    Attributes:
        poses: closed poses (P).
        rows: A (P, rows, coordinates), by coordinates in units.
    """

    poses: SampledPoses
    rows: Array


@dataclass(frozen=True, eq=False)
class ConnectionEquations:
    """The equations of a path from pose to pose.

    Attributes:
        model: the linkage with its masses.
        demand: what vanishes; of a base that turns, its mass and inertia count.
        units: of the coordinates: of the inputs 1 rad or the characteristic length, of turns 1.
        axes: directions of turns of the base in its own axes (turns, 3); none if it does not
            turn.
    """

    model: SampledLinkage
    demand: Demand
    units: Array
    axes: Array

    @classmethod
    def of(cls, linkage: Linkage, demand: Demand) -> ConnectionEquations:
        """Prepare a linkage."""
        frame = linkage.spatial_chain.frame
        kinds = [linkage.joints[j].kind for j in linkage.positions_of(linkage.inputs)]
        units = np.array([frame.length if kind == "prismatic" else 1.0 for kind in kinds])
        axes = np.empty((0, 3))
        if demand.kept == "turned":
            axes = linkage.chain.frame.R[2:] if linkage.planar else np.eye(3)
        model = SampledLinkage.of(linkage, np.zeros(3))
        return cls(model, demand, np.append(units, np.ones(len(axes))), axes)

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return len(self.units) - len(self.axes)

    def at(self, poses: SampledPoses, x: Array) -> PoseRows:
        """Compute the equations at closed poses with the coordinates x (P, coordinates)."""
        model, length = self.model, self.model.linkage.spatial_chain.frame.length
        h = model.momenta(poses)
        kept, base = self.demand.kept, self.demand.base
        if kept == "turned":
            assert base is not None
            rows = self._turning_rows(poses, h, base, x[:, self.inputs :])
        elif kept == "force":
            rows = length * h[:, 3:]
        else:
            centre = np.broadcast_to(
                np.array(self.demand.about or (0.0, 0.0, 0.0)), (len(h), 3)
            )
            if kept == "attitude" and base is not None:
                centre = model.mass * model.com(poses) + base.mass * np.array(base.com)
                centre = centre / (model.mass + base.mass)
            moment = h[:, :3] - np.cross(centre[:, :, None], h[:, 3:], axis=1)
            rows = moment if kept != "all" else np.concatenate([moment, length * h[:, 3:]], 1)
        return PoseRows(poses, rows * self.units)

    def _turning_rows(
        self, poses: SampledPoses, h: Array, base: FloatingBase, turns: Array
    ) -> Array:
        """Compute ``[S_u, S_ω J(θ)]`` (P, turns, coordinates)."""
        M = poses.inertias.sum(axis=1) + spatial_inertias(base.parameters[None])[0]
        coupling = M[:, :3, 3:] / M[:, 3:4, 3:4]
        by_u = h[:, :3] - coupling @ h[:, 3:]
        by_turn = (M[:, :3, :3] - coupling @ M[:, 3:, :3]) @ _turning_rates(turns @ self.axes)
        rows = np.concatenate([by_u, by_turn @ self.axes.T], axis=2)
        return np.asarray(self.axes @ rows)

    def near(self, poses: SampledPoses, x: Array) -> PoseRows | None:
        """Compute the equations at coordinates near those of closed poses; None if beyond."""
        beside = self.model.near(poses, x[:, : self.inputs])
        return None if beside is None else self.at(beside, x)

    def slopes(self, poses: SampledPoses, x: Array, rates: Array) -> Array | None:
        """Compute ``∂(A x')/∂x`` (P, rows, coordinates) by central differences.

        Args:
            x: coordinates (P, coordinates).
            rates: x' over units (P, coordinates).
        """
        m = x.shape[1]
        steps = DIFFERENCE * np.concatenate([np.diag(self.units), -np.diag(self.units)])
        around = (x[None] + steps[:, None]).reshape(-1, m)
        several = SampledPoses(
            *(np.tile(part, (2 * m, *[1] * (part.ndim - 1))) for part in poses)
        )
        beside = self.near(several, around)
        if beside is None:
            return None
        values = np.einsum("prm,pm->pr", beside.rows, np.tile(rates, (2 * m, 1)))
        up, down = values.reshape(2, m, len(x), -1)
        return np.asarray(((up - down) / (2.0 * DIFFERENCE)).transpose(1, 2, 0))


def _turning_rates(turns: Array) -> Array:
    """Compute J (P, 3, 3): the angular velocity in the axes of the base is ``J(θ) θ'``."""
    angle = np.linalg.norm(turns, axis=1)[:, None, None]
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    second = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    K = skew(turns)
    return np.asarray(np.eye(3) - first * K + second * (K @ K))


@dataclass(frozen=True, eq=False)
class LegendrePath:
    """A path between two points.

    Attributes:
        start: x₀ (coordinates,), in units.
        way: x₁ - x₀.
        coefficients: c (polynomials, coordinates).
    """

    start: Array
    way: Array
    coefficients: Array

    def at(self, tau: Array) -> tuple[Array, Array]:
        """Compute the coordinates and their derivatives (N, coordinates), in units."""
        values, rates = legendre_basis(tau, len(self.coefficients))
        x = self.start + tau[:, None] * self.way + values @ self.coefficients
        return x, self.way + rates @ self.coefficients

    @property
    def weights(self) -> Array:
        """Prices of the coefficients (polynomials, 1): rapid changes cost more."""
        k = np.arange(1, len(self.coefficients) + 1)[:, None]
        return (1.0 + (k / 4.0) ** 4) / (2.0 * k + 1.0)

    @property
    def size(self) -> float:
        """``∫ |x'|² dτ`` with the prices of rapid changes."""
        return float(self.way @ self.way + (self.weights * self.coefficients**2).sum())


def legendre_basis(tau: Array, count: int) -> tuple[Array, Array]:
    """Compute integrals from 0 of P_1 … P_count at 2τ - 1, and these (N, count)."""
    P: Array = np.polynomial.legendre.legvander(2.0 * tau - 1.0, count + 1).astype(np.float64)
    k = np.arange(1, count + 1)
    return (P[:, k + 1] - P[:, k - 1]) / (2.0 * (2.0 * k + 1.0)), P[:, k]


class Connection(NamedTuple):
    """A path between two poses.

    Attributes:
        path: the path, in units.
        tau: Gauss points (N,).
        poses: closed poses there.
        residual: largest momentum there, or between them if that is more than round-off, over
            what the rates could make.
    """

    path: LegendrePath
    tau: Array
    poses: SampledPoses
    residual: float

    @property
    def meets(self) -> bool:
        """Whether the equations are met."""
        return self.residual <= PATH_CONNECTED


def connect(
    equations: ConnectionEquations,
    start: Array,
    way: Array,
    follow: Callable[[Array], SampledPoses],
    accept: Callable[[Connection], bool],
    starts: int,
) -> Connection | None:
    """Find a path between two poses along which the equations hold.

    Args:
        start: coordinates (coordinates,), in units.
        way: to the end.
        follow: computes closed poses along inputs (N, inputs), the first from the start.
        accept: whether a path that meets the equations is taken.
        starts: number of first paths: the straight line, and loops of growing size.

    Returns:
        The path; of those that meet the equations at no or beyond limits, the best one. None if
        the loops cannot be closed along any first path.
    """
    rng = np.random.default_rng(SEED)
    best: Connection | None = None
    for trial in range(starts):
        loops = np.zeros((POLYNOMIALS[0], way.size))
        size = LOOPS[0] + (LOOPS[1] - LOOPS[0]) * trial / starts
        if trial:
            loops[:LOOP_TERMS] = size * rng.standard_normal((LOOP_TERMS, way.size))
        solution = _solve(equations, LegendrePath(start, way, loops), follow)
        if solution is None:
            continue
        if best is None or solution.residual < best.residual:
            best = solution
        if solution.meets and accept(solution):
            return solution
    return best


def _solve(
    equations: ConnectionEquations,
    path: LegendrePath,
    follow: Callable[[Array], SampledPoses],
) -> Connection | None:
    """Solve from one first path, with ever more polynomials until the path is exact."""
    solution: Connection | None = None
    apart = np.inf
    for count in POLYNOMIALS:
        extra = count - len(path.coefficients)
        path = replace(path, coefficients=np.pad(path.coefficients, ((0, extra), (0, 0))))
        tau = 0.5 * (1.0 + np.polynomial.legendre.leggauss(count)[0])
        try:
            poses = _follow(equations, path, tau, follow)
        except PoseError:
            return solution
        solution = _newton(equations, Connection(path, tau, poses, np.inf), path)
        if solution is None or not solution.meets:
            return solution
        if not extra:
            solution = _shorten(equations, solution)
        path = solution.path
        before, apart = apart, _momentum_between(equations, solution, follow)
        if apart <= EXACT_BETWEEN_POINTS:
            return solution
        solution = solution._replace(residual=apart)
        if _polynomials_needed(count, count - extra, apart, before) > POLYNOMIALS[-1]:
            return solution
    return solution


def _momentum_between(
    equations: ConnectionEquations,
    solution: Connection,
    follow: Callable[[Array], SampledPoses],
) -> float:
    """Compute the largest momentum half way between Gauss points."""
    between = 0.5 * (solution.tau[1:] + solution.tau[:-1])
    x, rates = solution.path.at(between)
    poses = _follow(equations, solution.path, between, follow)
    return float(np.abs(_momenta(equations.at(poses, x * equations.units), rates)).max())


def _polynomials_needed(count: int, before: int, apart: float, apart_before: float) -> float:
    """Estimate the polynomials of an exact path: the momentum falls by a share for each.

    Args:
        count: their number.
        before: that of the path before.
        apart: momentum between the points.
        apart_before: that of the path before; infinite if there was none.
    """
    if not np.isfinite(apart_before):
        return count
    share = np.log(apart_before / apart) / (count - before)
    return count + np.log(apart / EXACT_BETWEEN_POINTS) / share if share > 0.0 else np.inf


def _follow(
    equations: ConnectionEquations,
    path: LegendrePath,
    tau: Array,
    follow: Callable[[Array], SampledPoses],
) -> SampledPoses:
    """Compute closed poses of a path."""
    count = equations.inputs
    return follow(path.at(tau)[0][:, :count] * equations.units[:count])


def _momenta(here: PoseRows, rates: Array) -> Array:
    """Compute ``A x'`` (P, rows) over the largest momentum of unit rates."""
    size = np.abs(here.rows).max() or 1.0
    return np.asarray(np.einsum("prm,pm->pr", here.rows, rates) / size)


def _newton(
    equations: ConnectionEquations, start: Connection, path: LegendrePath
) -> Connection | None:
    """Meet the equations at Gauss points by least-norm steps.

    Args:
        start: another path with as many polynomials, near which closed poses are known.
        path: the path to begin with.

    Returns:
        The last path; None if the loops cannot be closed along the first one.
    """
    tau, basis = start.tau, legendre_basis(start.tau, len(path.coefficients))
    x, rates = path.at(tau)
    here = equations.near(start.poses, x * equations.units)
    if here is None:
        return None
    F = _momenta(here, rates)
    for _ in range(STEPS):
        if np.abs(F).max() <= PATH_CONNECTED:
            break
        step = _least_norm_step(equations, path, here, x, rates, F, basis, shorten=False)
        part, moved = 1.0, None
        while step is not None and moved is None and part >= LEAST_PART:
            moved = _moved(equations, path, part * step, here, tau)
            if moved is not None and not _falls(F, moved[2], part):
                moved = None
            part *= 0.5
        if moved is None:
            break
        path, here, F = moved
        x, rates = path.at(tau)
    return Connection(path, tau, here.poses, float(np.abs(F).max()))


def _falls(before: Array, after: Array, part: float) -> bool:
    """Whether a part of a step lets the residual fall by a share of what it promises."""
    return bool(np.linalg.norm(after) < (1.0 - 0.1 * part) * np.linalg.norm(before))


def _shorten(equations: ConnectionEquations, solution: Connection) -> Connection:
    """Shorten a path by steps along which the equations hold to first order, then met again."""
    trust, basis = LONGEST, legendre_basis(solution.tau, len(solution.path.coefficients))
    for _ in range(SHORTENED):
        x, rates = solution.path.at(solution.tau)
        here = equations.at(solution.poses, x * equations.units)
        F = _momenta(here, rates)
        step = _least_norm_step(
            equations, solution.path, here, x, rates, F, basis, shorten=True
        )
        if step is None or trust < 0.05 * LONGEST:
            break
        step *= min(1.0, trust / (np.abs(basis[0] @ step).max() or 1.0))
        changed = replace(solution.path, coefficients=solution.path.coefficients + step)
        trial = _newton(equations, solution, changed)
        if trial is None or not trial.meets or trial.path.size > 0.995 * solution.path.size:
            trust *= 0.4
            continue
        solution, trust = trial, 1.5 * trust
    return solution


def _moved(
    equations: ConnectionEquations,
    path: LegendrePath,
    step: Array,
    here: PoseRows,
    tau: Array,
) -> tuple[LegendrePath, PoseRows, Array] | None:
    """Change a path; None if its loops cannot be closed."""
    changed = LegendrePath(path.start, path.way, path.coefficients + step)
    x, rates = changed.at(tau)
    there = equations.near(here.poses, x * equations.units)
    return None if there is None else (changed, there, _momenta(there, rates))


def _least_norm_step(
    equations: ConnectionEquations,
    path: LegendrePath,
    here: PoseRows,
    x: Array,
    rates: Array,
    F: Array,
    basis: tuple[Array, Array],
    shorten: bool,
) -> Array | None:
    """Compute the step of least norm that meets the equations to first order.

    Args:
        shorten: whether the path after the step is to have the least norm, not the step.
    """
    slopes = equations.slopes(here.poses, x * equations.units, rates)
    if slopes is None:
        return None
    size = np.abs(here.rows).max() or 1.0
    values, polynomials = basis
    J = np.einsum("nrm,nk->nrkm", here.rows / size, polynomials)
    J += np.einsum("nrm,nk->nrkm", slopes / size, values)
    J = J.reshape(F.size, -1)
    root = np.sqrt(1.0 / path.weights).repeat(x.shape[1], axis=1).ravel()
    residual, c = F.ravel(), path.coefficients.ravel()
    target = -residual + (J @ c if shorten else 0.0)
    J *= root
    gram = J @ J.T
    gram[np.diag_indices_from(gram)] += SINGULAR**2 * np.trace(gram)
    solution = (J.T @ np.linalg.solve(gram, target)) * root
    step = solution - (c if shorten else 0.0)
    return np.asarray(step.reshape(path.coefficients.shape))
