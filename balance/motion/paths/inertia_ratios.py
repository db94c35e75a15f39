"""Paths over ratios of inertia, and moments of inertia for a path through given poses.

Mass and centre of mass of each link stay, so that a balanced force stays balanced; its central
moments of inertia are multiplied by a factor f. The momentum is linear in the factors,

    A(u) = A_0(u) + Σ_j (f_j - 1) R_j I_j R_jᵀ ω_j(u),

with the rotation R_j, the central inertia I_j and the angular velocities ω_j of unit rates of
the inputs. Charts over ratios: V. van der Wijk in G. Becht, MSc thesis, TU Delft, 2020, section
2.2.3. For a path through poses at ``τ_i``, the unknowns are f and the coefficients c of

    u(τ) = interpolation + ω(τ) Σ_k c_k P_k(2τ - 1),     ω(τ) = Π_i (τ - τ_i),

which passes through all of them; ``A(u) u' = 0`` holds at Gauss points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial import Legendre
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import PATH_MOMENTUM
from balance.motion.paths.connect import ConnectionEquations
from balance.motion.paths.demand import Demand, Kept
from balance.motion.paths.path_search import LENGTH, find_paths
from balance.motion.paths.reactionless_paths import SCHEMA, ReactionlessPaths
from balance.motion.paths.tool_paths import tool_paths
from balance.motion.quiet.problem import follow_poses
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.quiet.stops import ToolLike, read_stops, read_tool
from balance.space.inertial_parameters.conversions import mass_properties, parameters
from balance.support.result_files import WithPage, WithPicture
from kinematics.closure.joint_positions import with_bodies
from kinematics.errors import BodyError, PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import (
    Iterate,
    LeastNorm,
    gauss_newton,
    never_stop,
)
from kinematics.wording import count_noun, number_text, repr_lines, size_text

# Numbers of polynomials, of which the first that meets the equations between points is taken.
POLYNOMIALS = 6, 10, 16, 24
# Momentum above which more polynomials are not tried, if the last ones did not halve it.
NO_PATH = 1e-3
# Samples at which a path is checked.
CHECKED = 201
# Largest logarithm of a factor.
MOST_LOG = float(np.log(1e4))
# Steps of least norm, the longest of them, and the part of the largest singular value below
# which directions of a step count as none.
STEPS, LONGEST, SINGULAR = 40, 0.5, 1e-9
# Displacement of unknowns in central differences; momentum at the nodes, and a step, that are
# round-off.
STEP, SOLVED, STILL = 1e-6, 1e-13, 1e-11


def with_moments(linkage: Linkage, factors: Mapping[str, float]) -> Linkage:
    """Multiply the central moments of inertia of links; masses and their centres stay.

    Raises:
        BodyError: there is no such link, or it has no moments of inertia.
        UsageError: a factor is not above 0.
    """
    numbers = {body.name: b for b, body in enumerate(linkage.bodies)}
    bodies = list(linkage.bodies)
    for name, factor in factors.items():
        if name not in numbers:
            known = ", ".join(numbers)
            raise BodyError(linkage.source, name, f"is no link with masses; these are {known}")
        if not 0.0 < factor < np.inf:
            raise UsageError(f"the factor of {name} is {factor:g}: give one above 0")
        body = bodies[numbers[name]]
        mass, com, inertia = mass_properties(body.inertia)
        if body.link == GROUND or not np.any(inertia):
            raise BodyError(linkage.source, name, "has no moments of inertia that move")
        scaled = parameters(mass, com, factor * np.asarray(inertia))
        bodies[numbers[name]] = replace(body, inertia=freeze(scaled))
    return with_bodies(linkage, bodies)


@dataclass(frozen=True, eq=False)
class InertiaChart(WithPage, WithPicture):
    """Result of `inertia_chart`.

    Attributes:
        link: name of the link whose moments of inertia are multiplied.
        factors: of them (F,).
        solutions: the paths of each.
    """

    page_maker = "path_inertia:chart_page"
    picture_maker = "path_inertia:chart_picture"

    link: str
    factors: tuple[float, ...]
    solutions: tuple[ReactionlessPaths, ...]

    def __repr__(self) -> str:
        """One line: the link, and how many paths there are."""
        count = sum(len(solution.paths) for solution in self.solutions)
        return (
            f"InertiaChart of {self.link}: {count_noun(count, 'path')} for "
            f"{count_noun(len(self.factors), 'factor')}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: for each factor what `ReactionlessPaths.to_dict` returns."""
        pairs = zip(self.factors, self.solutions, strict=True)
        charts = [{"factor": x, "solution": solution.to_dict()} for x, solution in pairs]
        return {
            "schema": SCHEMA,
            "model": self.solutions[0].linkage.name,
            "link": self.link,
            "charts": charts,
        }


def inertia_chart(
    linkage: LinkageLike,
    link: str,
    factors: Sequence[float],
    start: ArrayLike | Mapping[str, float] | None = None,
    *,
    kept: Kept = "all",
    length: float = LENGTH,
    tool: str | None = None,
    point: ArrayLike | None = None,
) -> InertiaChart:
    """Follow the paths through a pose for several moments of inertia of a link.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        link: name of the link whose central moments of inertia are multiplied.
        factors: by what they are multiplied, above 0.
        start: displacements of the inputs; by default the reference pose.
        kept: what vanishes; see `find_paths`.
        length: arc length to either side; see `find_paths`.
        tool: link whose ways are drawn; None for the paths in the inputs.
        point: its point (3,), metres, in its frame.

    Raises:
        BodyError: there is no such link.
        UsageError: a factor is not above 0.
        PoseError: the start cannot be reached.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "upper"),
        ...      kinematics.ScrewJoint("u2", "upper", "lower", point=(1, 0, 0))],
        ...     bodies={"upper": (1, (0.5, 0, 0), 0.1 * np.eye(3)),
        ...             "lower": (1, (1.5, 0, 0), 0.1 * np.eye(3))},
        ... )
        >>> chart = balance.motion.inertia_chart(
        ...     arm, "lower", [0.5, 2.0], kept="moment", length=0.02
        ... )
        >>> [len(solution.paths) for solution in chart.solutions]
        [1, 1]
    """
    linkage = as_linkage(linkage)
    if not len(factors):
        raise UsageError("give factors of the moments of inertia")
    solutions = []
    for factor in factors:
        scaled = with_moments(linkage, {link: float(factor)})
        starts = () if start is None else (start,)
        solution = find_paths(scaled, starts, kept=kept, length=length)
        if tool is not None:
            ways = tool_paths(scaled, solution.paths, tool, point, poses=0)
            solution = replace(solution, tool=ways)
        solutions.append(solution)
    return InertiaChart(link, tuple(map(float, factors)), tuple(solutions))


@dataclass(frozen=True, eq=False)
class PathMoments(WithPage, WithPicture):
    """Result of `moments_through_poses`.

    Attributes:
        linkage: the linkage with the new moments of inertia.
        factors: by which those of links were multiplied, by name.
        u: displacements of the inputs along the path (N, mobility), from the first pose to the
            last.
        residual: momentum along it over those of the bodies, at most.
        reason: why no path passes; empty if one does.
        poses: displacements of the inputs in the poses (P, mobility).
        kept: what vanishes along the path.
    """

    page_maker = "path_inertia:moments_page"
    picture_maker = "path_inertia:moments_picture"

    linkage: Linkage
    factors: dict[str, float]
    u: Array
    residual: float
    reason: str
    poses: Array
    kept: Kept

    def __repr__(self) -> str:
        """Two lines: the factors, and the momentum."""
        texts = (f"{name} {number_text(factor)}" for name, factor in self.factors.items())
        size = size_text(self.residual, floor=PATH_MOMENTUM)
        return repr_lines(
            f"PathMoments of {self.linkage.name}: {', '.join(texts)}",
            f"momentum {size} of the bodies' own",
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "schema": SCHEMA,
            "model": self.linkage.name,
            "kept": self.kept,
            "factors": dict(self.factors),
            "inputs": list(self.linkage.inputs),
            "poses": self.poses.tolist(),
            "path": self.u.tolist(),
            "momentum": self.residual,
            "reason": self.reason or None,
        }


def moments_through_poses(
    linkage: LinkageLike,
    links: Sequence[str],
    poses: Sequence[ArrayLike | Mapping[str, float]],
    *,
    kept: Kept = "all",
    tool: ToolLike = None,
) -> PathMoments:
    """Find moments of inertia of links with which a reactionless path passes through poses.

    A path of a linkage with two inputs, of which one is free, passes through one pose more for
    each link that is named.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        links: names of links whose central moments of inertia may be multiplied.
        poses: two or more, in order: displacements of the inputs from the reference pose, or
            by name coordinates ``x``, ``y``, ``z``, ``rx``, ``ry``, ``rz`` of a tool, whose
            inputs are then those next to the pose before.
        kept: what vanishes: ``"all"`` or ``"moment"``.
        tool: link whose poses are given; or the link and its point (3,), metres, in its frame.

    Returns:
        The factors and the path, or the reason why none was found.

    Raises:
        BodyError: there is no such link, or no such tool.
        PoseError: a pose cannot be reached, or two that follow are one.
        UsageError: fewer than two poses, or no link, are given.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "upper"),
        ...      kinematics.ScrewJoint("u2", "upper", "lower", point=(1, 0, 0))],
        ...     bodies={"upper": (1, (0.5, 0, 0), 0.1 * np.eye(3)),
        ...             "lower": (1, (1.5, 0, 0), 0.1 * np.eye(3))},
        ... )
        >>> answer = balance.motion.moments_through_poses(
        ...     arm, ["lower"], [[0.0, 1.0], [-0.2, 1.6]], kept="moment"
        ... )
        >>> answer.reason, answer.residual < 1e-9
        ('', True)
    """
    linkage = as_linkage(linkage)
    if kept not in ("all", "moment"):
        raise UsageError(f"kept is 'all' or 'moment', since {kept!r} has no moments of inertia")
    if not len(links) or len(poses) < 2:
        raise UsageError("give links whose moments may change, and two poses or more")
    with_moments(linkage, dict.fromkeys(links, 1.0))
    equations = ConnectionEquations.of(linkage, Demand(kept))
    point = read_tool(linkage, tool)
    stops = read_stops(equations.model, equations.units, poses, point, cycle=False)
    u = np.array(stops.inputs)
    problem = _PathProblem(equations, tuple(links), u)
    best: tuple[float, Array, Array] | None = None
    for count in POLYNOMIALS:
        before, attempt = best, problem.solve(count)
        if attempt is not None and (best is None or attempt[0] < best[0]):
            best = attempt
        if best is None or before is None:
            continue
        if best[0] <= PATH_MOMENTUM or best[0] > max(NO_PATH, 0.5 * before[0]):
            break
    if best is None:
        raise PoseError(f"{linkage.source}: the loops cannot be closed between the poses")
    residual, logs, way = best
    factors = dict(zip(links, np.exp(logs).tolist(), strict=True))
    reason = ""
    if not residual <= PATH_MOMENTUM:
        least = number_text(residual, ".2g")
        reason = f"no such path was found: the least momentum is {least} of the bodies' own"
    changed = with_moments(linkage, factors)
    return PathMoments(changed, factors, freeze(way), residual, reason, freeze(u), kept)


class _PathProblem:
    """The equations of factors and a path through poses."""

    def __init__(self, equations: ConnectionEquations, links: Sequence[str], u: Array) -> None:
        """Prepare the poses; see `moments_through_poses`."""
        self.equations = equations
        self.units, self.u = equations.units, u
        steps = np.linalg.norm(np.diff(u, axis=0) / self.units, axis=1)
        self.places = np.append(0.0, np.cumsum(steps)) / steps.sum()
        self.links = []
        for body in equations.model.linkage.bodies:
            if body.name in links:
                self.links.append(
                    (links.index(body.name), body.link, mass_properties(body.inertia)[2])
                )
        self.count = len(links)

    def _curves(self, count: int, tau: Array) -> tuple[Array, Array]:
        """Compute values (1 + count, N) of the interpolation and the bubbles, and slopes."""
        x, places = 2.0 * tau - 1.0, 2.0 * self.places - 1.0
        degree = len(places) - 1
        lines = [
            Legendre.fit(places, column, degree, domain=[-1, 1])
            for column in (self.u / self.units).T
        ]
        bubble = Legendre.fromroots(places)
        bubble = bubble / np.abs(bubble(np.linspace(-1.0, 1.0, 101))).max()
        bubbles = [bubble * Legendre.basis(k) for k in range(count)]
        values = np.array([curve(x) for curve in (*lines, *bubbles)])
        slopes = np.array([2.0 * curve.deriv()(x) for curve in (*lines, *bubbles)])
        return values, slopes

    def solve(self, count: int) -> tuple[float, Array, Array] | None:
        """Solve with so many polynomials: momentum, logarithms of factors, path; or None.

        Steps are of least norm, with small weights for high polynomials.
        """
        width, nodes = len(self.units), 2 * (count + len(self.places)) + 8
        points = 0.5 * (1.0 + np.polynomial.legendre.leggauss(nodes)[0])
        curves = self._curves(count, points)
        weights = np.ones(self.count + count * width)
        weights[self.count :] = np.repeat(1.0 / (1.0 + np.arange(count)) ** 2, width)

        def equations(z: Array) -> tuple[Array, Array]:
            steps = STEP * np.eye(z.size)
            value = self._at(curves, known, z * weights)
            sides = [
                [self._at(curves, known, (z + side * step) * weights) for step in steps]
                for side in (1.0, -1.0)
            ]
            return value, (np.array(sides[0]) - np.array(sides[1])).T / (2.0 * STEP)

        def solved(path: Sequence[Iterate]) -> bool:
            return path[-1].error <= SOLVED or path[-1].size <= STILL

        try:
            start = curves[0][:width].T * self.units
            known = follow_poses(self.equations.model, start)
            rule = LeastNorm(SINGULAR, LONGEST)
            solution = gauss_newton(
                equations, np.zeros(weights.size), rule, solved, never_stop, STEPS
            )
            z = solution.last.x * weights
            curves = self._curves(count, np.linspace(0.0, 1.0, CHECKED))
            x, rates = self._path(curves, z)
            poses = follow_poses(self.equations.model, x * self.units)
        except PoseError:
            return None
        momentum = self._momentum(poses, x, rates, z[: self.count])
        return float(np.linalg.norm(momentum, axis=1).max()), z[: self.count], x * self.units

    def _path(self, curves: tuple[Array, Array], z: Array) -> tuple[Array, Array]:
        """Compute coordinates (N, w) and their derivatives for unknowns."""
        width = len(self.units)
        c = z[self.count :].reshape(-1, width)
        x, rates = (part[:width].T + part[width:].T @ c for part in curves)
        return x, rates

    def _at(self, curves: tuple[Array, Array], known: SampledPoses, z: Array) -> Array:
        """Compute the equations for unknowns: momentum over those of the bodies, at all nodes.

        The path is moved across the interpolation alone, which decides the speed along it.
        """
        x, rates = self._path(curves, z)
        poses = self.equations.model.near(known, x * self.units)
        if poses is None:
            raise PoseError(
                f"{self.equations.model.linkage.source}: the loops cannot be closed"
            )
        logs = np.clip(z[: self.count], -MOST_LOG, MOST_LOG)
        momentum = self._momentum(poses, x, rates, logs)
        line, way = (part[: len(self.units)].T for part in curves)
        aside = np.einsum("pw,pw->p", x - line, way) / (way**2).sum(axis=1)
        return np.append(momentum.ravel(), aside)

    def _momentum(self, poses: SampledPoses, x: Array, rates: Array, logs: Array) -> Array:
        """Compute ``A u'`` over the momenta of the bodies (P, 6); 0 where nothing counts."""
        model = self.equations.model
        length = model.linkage.spatial_chain.frame.length
        units = self.units
        rows = self.equations.at(poses, x * units).rows
        momentum = np.zeros((len(x), 6))
        momentum[:, : rows.shape[1]] = np.einsum("prw,pw->pr", rows, rates)
        H, si = model.displacements(poses.q), rates * units
        bodies = np.einsum("pnij,pnjw,pw->pni", poses.inertias, poses.twists, si)
        body_sizes = np.linalg.norm(bodies[..., :3], axis=2) + length * np.linalg.norm(
            bodies[..., 3:], axis=2
        )
        total = body_sizes.sum(axis=1)
        for place, link, inertia in self.links:
            R = H[:, link, :3, :3]
            omega = np.einsum("pjw,pw->pj", poses.twists[:, link, :3], si)
            turning = np.einsum("pij,jk,plk,pl->pi", R, inertia, R, omega)
            extra = np.expm1(logs[place])
            momentum[:, :3] += extra * turning
            total = total + max(0.0, extra) * np.linalg.norm(turning, axis=1)
        return momentum / total[:, None]
