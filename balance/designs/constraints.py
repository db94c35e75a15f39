"""What is asked of a design beside balance: bodies held as they are, bounds on masses, limits.

The first two are linear once the unit of mass is a coordinate τ of its own: bodies that are
kept are τ times those of the file, and bounds are τ times those asked for. So the question
stays one about a cone, and a design is what is found over τ. That the mass of a body is
within a ball is linear as it is; see `balance.designs.mass_regions`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.designs.mass_regions import Ball, ball_of
from balance.designs.pseudo_inertia_cone import Cone, cone_of, given_parameters, matrices_of
from balance.spaces.design_space_result import DesignSpace
from kinematics.errors import BodyError, LinkageError
from kinematics.linalg.vectors import project_out

__all__ = ["MASS_EQUAL", "Program", "Constraints", "program", "constraints_of"]

Array = NDArray[np.float64]

# Singular values of the conditions that kept bodies impose, relative to the largest.
MASS_EQUAL = 1e-10
# The smallest unit, in mean masses, in which a bound on a mass is counted.
SMALLEST = 1e-6


class Constraints(NamedTuple):
    """What is asked of the bodies.

    Attributes:
        keep: positions of the bodies held as the file gives them.
        bounds: least and largest mass in kg, by position of the body.
        within: radius of the balls, in lengths of the links; infinite without limits.
        balls: where the mass of each other body is to be, by its position.
    """

    keep: tuple[int, ...] = ()
    bounds: Mapping[int, tuple[float, float]] = {}
    within: float = inf
    balls: Mapping[int, Ball] = {}

    def __bool__(self) -> bool:
        """Whether anything is asked."""
        return bool(self.keep or self.bounds or self.balls)

    @property
    def sized(self) -> bool:
        """Whether it sets the size of masses, which is free otherwise."""
        return bool(self.keep or self.bounds)

    @property
    def anywhere(self) -> Constraints:
        """The same without balls."""
        return Constraints(self.keep, self.bounds)


class Program(NamedTuple):
    """A question about a cone: x with ``P_b(x) ⪰ 1`` for all free bodies, and ``lines x ≥ 0``.

    Attributes:
        cone: of the free bodies, in the coordinates x, the last of which is τ if the size of
            masses is set.
        free: their positions among all bodies.
        sized: whether it is.
        lines: rows that must not be negative (lines, n): that of τ, which is to be at least
            1, if there is one; then those of ``limits``; then those of ``balls``.
        limits: body and factor of the mass in it, for each row that is a bound.
        balls: bodies whose mass is in a ball, and the forms G of these.
        traces: of all bodies together (n,).
        unit: kilograms per unit of the matrices.
        whole: the cone of all bodies.
        embed: its coordinates for each of x (all coordinates, n).
        fixed: rows of the whole cone that have a value: those of kept bodies, and then the
            masses that are told exactly (rows, all coordinates).
        told: bodies of the latter.
        left: what these miss of their values at best; not zero if nothing can balance them.
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
    told: tuple[int, ...]
    left: Array


def constraints_of(
    space: DesignSpace, keep: Sequence[str], bounds: Mapping[str, tuple[float, float]],
    within: float | None = None,
) -> Constraints:  # fmt: skip
    """The restriction of that name.

    Args:
        space: the design space.
        keep: names of bodies held as the file gives them.
        bounds: least and largest mass of bodies, kg.
        within: radius of the balls that hold the masses of the other bodies, in lengths of
            their links; None for no limits. See `balance.designs.mass_regions.ball_of`.

    Raises:
        BodyError: a body is unknown, its bounds contradict each other, or it is kept and
            bounded.
        LinkageError: all bodies are kept.
        ValueError: the radius is not positive and finite.
    """
    if within is not None and not 0.0 < within < inf:
        raise ValueError(f"within = {within}: give lengths of a link, above 0, or None")
    source, names = space.source, space.bodies
    for name in (*keep, *bounds):
        if name not in names:
            raise BodyError(source, name, "carries no inertial parameters", names)
    if not set(names) - set(keep):
        text = f"every link is kept ({', '.join(names)}): nothing is left to design; keep fewer"
        raise LinkageError(f"{source}: {text}")
    for name, (low, high) in bounds.items():
        if not (0.0 <= low <= high and high > 0.0 and low < inf):
            text = f"its mass cannot be from {low:g} to {high:g} kg: give 0 ≤ least ≤ largest"
            raise BodyError(source, name, text)
        if name in keep:
            raise BodyError(source, name, "is kept and bounded: give one of the two")
    at = {name: b for b, name in enumerate(names)}
    asked = Constraints(
        tuple(sorted({at[name] for name in keep})),
        {at[name]: (float(low), float(high)) for name, (low, high) in bounds.items()},
    )
    if within is None:
        return asked
    balls = {b: ball_of(space, body, within)
             for b, body in enumerate(space.linkage.bodies) if b not in asked.keep}  # fmt: skip
    return asked._replace(within=float(within), balls=balls)


def program(space: DesignSpace, asked: Constraints) -> Program:
    """The question whether a space has a design that fulfils a restriction."""
    cone, count = cone_of(space), len(space.bodies)
    unit = float(sum(body.inertia[0] for body in space.linkage.bodies)) / count or 1.0
    free = tuple(b for b in range(count) if b not in asked.keep)
    balls = tuple((b, ball.form) for b, ball in asked.balls.items())
    if not asked.sized:
        n = cone.blocks.shape[1]
        return Program(
            cone, free, False, _inside(cone, free, balls), (), balls, _traces(cone), unit,
            cone, np.eye(n), np.empty((0, n)), (), np.empty(0),
        )  # fmt: skip
    file = matrices_of(space, given_parameters(space))
    told = tuple(b for b, (low, high) in asked.bounds.items() if low == high)
    fixed, values = _fixed(cone, file, asked, told)
    start, motions, left = _solutions(fixed, values / unit)
    embed = np.column_stack([motions, start])
    own = cone._replace(blocks=np.einsum("bnij,nm->bmij", cone.blocks[list(free)], embed))
    tau = np.eye(embed.shape[1])[-1]
    rows, limits = _bounding(own, free, asked, tau / unit)
    lines = np.concatenate([[tau], *rows, _inside(own, free, balls)])
    kept = np.trace(file[list(asked.keep)], axis1=1, axis2=2).sum() / unit
    return Program(
        own, free, True, lines, limits, balls, _traces(own) + kept * tau, unit, cone, embed,
        fixed, told, left,
    )  # fmt: skip


def _bounding(
    cone: Cone, free: tuple[int, ...], asked: Constraints, tau: Array
) -> tuple[list[Array], tuple[tuple[int, float], ...]]:
    """Rows (1, n) of the bounds that are not equations, and what they limit; tau is per kg.

    They are in units of the bound, which the solver would miss if it is far from the others.
    """
    rows, limits = [], []
    for b, (low, high) in asked.bounds.items():
        mass = cone.blocks[free.index(b), :, -1, -1]
        for sign, value in ((1.0, low), (-1.0, high)):
            if low < high and 0.0 < value < inf:
                factor = sign / max(value * tau[-1], SMALLEST)
                rows.append(factor * (mass - value * tau)[None])
                limits.append((b, factor))
    return rows, tuple(limits)


def _inside(cone: Cone, free: tuple[int, ...], balls: tuple[tuple[int, Array], ...]) -> Array:
    """Rows ``tr(G_b P_b)`` (balls, n)."""
    if not balls:
        return np.empty((0, cone.blocks.shape[1]))
    own = cone.blocks[[free.index(b) for b, _ in balls]]
    return np.asarray(np.einsum("bnij,bij->bn", own, np.array([G for _, G in balls])))


def _traces(cone: Cone) -> Array:
    return np.asarray(np.einsum("bnii->n", cone.blocks))


def _fixed(
    cone: Cone, file: Array, asked: Constraints, told: tuple[int, ...]
) -> tuple[Array, Array]:
    """Rows of the cone that have a value, and these values."""
    keep = list(asked.keep)
    masses = cone.blocks[list(told)][:, :, -1, -1]
    rows = np.concatenate([cone.stacked(cone.blocks[keep]), masses])
    values = np.array([asked.bounds[b][0] for b in told])
    return rows, np.concatenate([cone.rows(file[keep]).reshape(-1), values])


def _solutions(E: Array, e: Array) -> tuple[Array, Array, Array]:
    """Least solution of ``E y = e``, basis of the null space of E, and what is left of e."""
    U, values, V = np.linalg.svd(E)
    rank = int(np.sum(values > MASS_EQUAL * values.max(initial=0.0)))
    U = U[:, :rank]
    # Twice, since the first difference loses digits where little is left.
    left = project_out(project_out(e, U), U)
    return V[:rank].T @ ((U.T @ e) / values[:rank]), V[rank:].T, left
