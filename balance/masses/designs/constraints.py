"""Constraints on a design: kept bodies, bounds on masses, densities, and balls for the masses.

The unit of mass is a coordinate τ of its own. Kept bodies are τ times those of the file, and
bounds are τ times the given ones, so that both constraints are linear and homogeneous. The
program stays conic, and the design is its solution divided by τ. The condition that the mass
of a body is within a ball is linear without τ; see `balance.masses.designs.mass_regions`.
Limits of density are homogeneous of degree one in the masses and τ, and not linear; see
`balance.masses.designs.density_cone`. Where τ is no coordinate, masses may be as small as they
need to be, and no density excludes a design.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from balance.masses.designs.density import DensityLimit
from balance.masses.designs.mass_regions import Ball, ball_of
from balance.masses.designs.pseudo_inertia_cone import (
    Cone,
    cone_of,
    given_parameters,
    matrices_of,
)
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import DENSITY_TIGHTENED, FIXED_RANK_RELATIVE
from kinematics.errors import BodyError, LinkageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out

# Smallest scale of a bound on a mass, in mean masses: rows of smaller bounds would be too
# large for the solver.
MIN_BOUND_SCALE = 1e-6


class Constraints(NamedTuple):
    """Constraints on the bodies of a design.

    Attributes:
        keep: positions of the bodies held as the file gives them.
        bounds: least and largest mass in kg, by position of the body.
        within: radius of the balls, in lengths of the links; infinite without balls.
        balls: ball that must contain the mass of each other body, by its position.
        densities: density that a body nowhere exceeds, by its position.
    """

    keep: tuple[int, ...] = ()
    bounds: Mapping[int, tuple[float, float]] = {}
    within: float = inf
    balls: Mapping[int, Ball] = {}
    densities: Mapping[int, DensityLimit] = {}

    def __bool__(self) -> bool:
        """Whether there is any constraint."""
        return bool(self.keep or self.bounds or self.balls or self.densities)

    @property
    def sized(self) -> bool:
        """Whether the constraints set the unit of mass, which is free otherwise."""
        return bool(self.keep or self.bounds)

    @property
    def anywhere(self) -> Constraints:
        """The same constraints without balls."""
        return self._replace(within=inf, balls={})


class Program(NamedTuple):
    """The conic program: find x with ``P_b(x) ⪰ 1`` for all free bodies and ``lines x ≥ 0``.

    Attributes:
        cone: pseudo-inertias of the free bodies as functions of x. The last coordinate is τ
            if the unit of mass is set.
        free: positions of the free bodies among all bodies.
        sized: whether the unit of mass is set.
        lines: rows of the inequalities (lines, n): τ ≥ 1 if there is a τ, then ``limits``,
            then ``balls``.
        limits: body and factor of its mass, for each row that is a mass bound.
        balls: bodies whose mass is within a ball, and the matrices G of the balls.
        densities: κ of `balance.masses.designs.density` in units of the chain and of the
            program, by position among the free bodies; a trifle larger, so that what the solver
            violates is within the limit.
        traces: sum of the traces of all bodies as a function of x (n,).
        unit: kilograms per unit of the matrices.
        whole: the cone of all bodies.
        embed: coordinates of that cone as a function of x (all coordinates, n).
        fixed: rows of the cone of all bodies that have a fixed value: those of kept bodies,
            then the fixed masses (rows, all coordinates).
        fixed_masses: bodies whose least and largest mass are equal.
        residual: least-squares residual of the fixed rows; not zero if no masses balance them.
    """

    cone: Cone
    free: tuple[int, ...]
    sized: bool
    lines: Array
    limits: tuple[tuple[int, float], ...]
    balls: tuple[tuple[int, Array], ...]
    traces: Array
    unit: float
    whole: Cone
    embed: Array
    fixed: Array
    fixed_masses: tuple[int, ...]
    residual: Array
    densities: Mapping[int, float] = {}

    @property
    def bounded_below(self) -> bool:
        """Whether kept bodies or least masses set the size of a design."""
        kept = self.sized and len(self.free) < len(self.whole.blocks)
        return kept or bool(self.fixed_masses) or any(sign > 0.0 for _, sign in self.limits)


def unknown_body(space: DesignSpace, name: str) -> BodyError:
    """Make the exception for a link that is none, or carries no parameters; to be raised."""
    place, problem = space.linkage.places.get(name), "there is no such link"
    if place is not None:
        remedy = "" if place.link < 0 else "; --bodies all (bodies='all') gives it some"
        problem = f"carries no inertial parameters{remedy}"
    return BodyError(space.source, name, problem, space.bodies)


def constraints_of(
    space: DesignSpace,
    keep: Sequence[str],
    bounds: Mapping[str, tuple[float, float]],
    within: float | None = None,
    density: float | Mapping[str, float] | None = None,
    thickness: float | None = None,
) -> Constraints:
    """Build the constraints from names of bodies.

    Args:
        keep: names of bodies held as the file gives them.
        bounds: least and largest mass of bodies, kg.
        within: radius of the balls that contain the masses of the other bodies, in lengths of
            their links; None for no limits. See `balance.masses.designs.mass_regions.ball_of`.
        density: density that the other bodies nowhere exceed, or that of some bodies by name,
            kg/m³.
        thickness: that of the bodies of a planar space, m; needed for their densities.

    Raises:
        BodyError: a body is unknown, its bounds contradict each other, or it is kept and
            limited.
        LinkageError: all bodies are kept, or there is a thickness without a density, or in
            space.
        ValueError: the radius, a density or the thickness is not positive and finite.
    """
    if within is not None and not 0.0 < within < inf:
        raise ValueError(f"within = {within}: give lengths of a link, above 0, or None")
    source, names = space.source, space.bodies
    material = density if isinstance(density, Mapping) else {}
    for name in (*keep, *bounds, *material):
        if name not in names:
            raise unknown_body(space, name)
    if not set(names) - set(keep):
        text = f"every link is kept ({', '.join(names)}): nothing is left to design; keep fewer"
        raise LinkageError(f"{source}: {text}")
    for name, (low, high) in bounds.items():
        if not (0.0 <= low <= high and high > 0.0 and low < inf):
            text = f"its mass cannot be from {low:g} to {high:g} kg: give 0 ≤ least ≤ largest"
            raise BodyError(source, name, text)
        if name in keep:
            raise BodyError(source, name, "is kept and bounded: give one of the two")
    for name in material:
        if name in keep:
            text = "is kept and has a density: give one of the two"
            raise BodyError(source, name, text)
    at = {name: b for b, name in enumerate(names)}
    constraints = Constraints(
        tuple(sorted({at[name] for name in keep})),
        {at[name]: (float(low), float(high)) for name, (low, high) in bounds.items()},
    )
    if isinstance(density, Mapping):
        limits = {at[name]: value for name, value in density.items()}
    elif density is not None:
        limits = {b: density for b in at.values() if b not in constraints.keep}
    else:
        limits = {}
    constraints = constraints._replace(densities=_density_limits(space, limits, thickness))
    if within is None:
        return constraints
    bodies = enumerate(space.linkage.bodies)
    balls = {b: ball_of(space, body, within) for b, body in bodies if b not in constraints.keep}
    return constraints._replace(within=float(within), balls=balls)


def _density_limits(
    space: DesignSpace, limits: Mapping[int, float], thickness: float | None
) -> dict[int, DensityLimit]:
    """Check densities by position of the body, and the thickness of flat bodies.

    Raises:
        LinkageError: there is a thickness without a density, or in space.
        ValueError: a density or the thickness is not positive and finite.
    """
    for what, value in (
        *(("density", value) for value in limits.values()),
        ("thickness", thickness),
    ):
        if value is not None and not (
            isinstance(value, int | float | np.number) and 0.0 < value < inf
        ):
            unit = "kg/m³" if what == "density" else "m"
            raise ValueError(f"{what} = {value}: give a number above 0, in {unit}")
    if thickness is not None and not space.planar:
        text = "the bodies of a design in space have no thickness; leave it out"
        raise LinkageError(f"{space.source}: {text}")
    assert thickness is not None or not (limits and space.planar)
    if thickness is not None and not limits:
        text = "a thickness limits nothing without a density; give one too"
        raise LinkageError(f"{space.source}: {text}")
    return {b: DensityLimit(float(value), thickness) for b, value in limits.items()}


def build_program(space: DesignSpace, constraints: Constraints) -> Program:
    """Build the conic program of a design space and constraints.

    Args:
        constraints: constraints on the bodies.
    """
    cone, count = cone_of(space), len(space.bodies)
    unit = float(sum(body.inertia[0] for body in space.linkage.bodies)) / count or 1.0
    free = tuple(b for b in range(count) if b not in constraints.keep)
    balls = tuple((b, ball.form) for b, ball in constraints.balls.items())
    tight = (1.0 + DENSITY_TIGHTENED) / space.chain.frame.length**2
    densities = {
        free.index(b): limit.least_moment * unit ** (2.0 / limit.dimensions) * tight
        for b, limit in constraints.densities.items()
    }
    if not constraints.sized:
        n = cone.blocks.shape[1]
        return Program(
            cone,
            free,
            False,
            _ball_rows(cone, free, balls),
            (),
            balls,
            _traces(cone),
            unit,
            cone,
            np.eye(n),
            np.empty((0, n)),
            (),
            np.empty(0),
            densities,
        )
    file = matrices_of(space, given_parameters(space))
    fixed_masses = tuple(b for b, (low, high) in constraints.bounds.items() if low == high)
    fixed, values = _fixed_rows(cone, file, constraints, fixed_masses)
    start, directions, residual = _solve_fixed_rows(fixed, values / unit)
    embed = np.column_stack([directions, start])
    free_cone = cone._replace(blocks=np.einsum("bnij,nm->bmij", cone.blocks[list(free)], embed))
    tau = np.eye(embed.shape[1])[-1]
    rows, limits = _bound_rows(free_cone, free, constraints, tau / unit)
    lines = np.concatenate([[tau], *rows, _ball_rows(free_cone, free, balls)])
    kept = np.trace(file[list(constraints.keep)], axis1=1, axis2=2).sum() / unit
    return Program(
        free_cone,
        free,
        True,
        lines,
        limits,
        balls,
        _traces(free_cone) + kept * tau,
        unit,
        cone,
        embed,
        fixed,
        fixed_masses,
        residual,
        densities,
    )


def _bound_rows(
    cone: Cone, free: tuple[int, ...], constraints: Constraints, tau: Array
) -> tuple[list[Array], tuple[tuple[int, float], ...]]:
    """Build the rows (1, n) of the mass bounds that are inequalities, and their bodies.

    Each row is scaled by its bound, since the solver's tolerances are absolute. ``tau`` is the
    row of the unit of mass, per kilogram.
    """
    rows, limits = [], []
    for b, (low, high) in constraints.bounds.items():
        mass = cone.blocks[free.index(b), :, -1, -1]
        for sign, value in ((1.0, low), (-1.0, high)):
            if low < high and 0.0 < value < inf:
                factor = sign / max(value * tau[-1], MIN_BOUND_SCALE)
                rows.append(factor * (mass - value * tau)[None])
                limits.append((b, factor))
    return rows, tuple(limits)


def _ball_rows(
    cone: Cone, free: tuple[int, ...], balls: tuple[tuple[int, Array], ...]
) -> Array:
    """Build the rows ``tr(G_b P_b)`` of the balls (balls, n)."""
    if not balls:
        return np.empty((0, cone.blocks.shape[1]))
    blocks = cone.blocks[[free.index(b) for b, _ in balls]]
    return np.asarray(np.einsum("bnij,bij->bn", blocks, np.array([G for _, G in balls])))


def _traces(cone: Cone) -> Array:
    return np.asarray(np.einsum("bnii->n", cone.blocks))


def _fixed_rows(
    cone: Cone, file: Array, constraints: Constraints, fixed_masses: tuple[int, ...]
) -> tuple[Array, Array]:
    """Build the rows of the cone that have a fixed value, and these values."""
    keep = list(constraints.keep)
    masses = cone.blocks[list(fixed_masses)][:, :, -1, -1]
    rows = np.concatenate([cone.stack_rows(cone.blocks[keep]), masses])
    values = np.array([constraints.bounds[b][0] for b in fixed_masses])
    return rows, np.concatenate([cone.rows(file[keep]).reshape(-1), values])


def _solve_fixed_rows(E: Array, e: Array) -> tuple[Array, Array, Array]:
    """Solve ``E y = e``: minimum-norm solution, null space of E, and residual."""
    U, values, V = np.linalg.svd(E)
    rank = int(np.sum(values > FIXED_RANK_RELATIVE * values.max(initial=0.0)))
    U = U[:, :rank]
    # Project twice: the first difference loses digits if the residual is small.
    residual = project_out(project_out(e, U), U)
    return V[:rank].T @ ((U.T @ e) / values[:rank]), V[rank:].T, residual
