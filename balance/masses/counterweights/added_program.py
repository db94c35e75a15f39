"""The conic program of counterweights: least cost of added matter that balances a linkage.

Added matter of link b is a measure μ_b in its region. The linkage is balanced if

    Σ_b ∫ A_b(x) dμ_b = r,

where r is what the given masses leave and A_b are quadratic polynomials, one for each
condition. The least ``Σ_b ∫ c_b dμ_b`` has the dual

    maximise y·r    so that    c_b - y·A_b ≥ 0 on the region of b,

so that y proves a lower bound. If no measures balance, some y with ``y·r > 0`` has
``-y·A_b ≥ 0`` on all regions, which is a certificate. In both cases the polynomials are
quadratic, and `minimise_in_region` checks them without a solver.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import (
    MomentCone,
    first_moment_cone,
    lump_cone,
    moment_cone,
    parameters_per_moment,
    symmetric_basis,
)
from balance.masses.counterweights.regions import Region
from balance.masses.designs.objectives import rotor_weights
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.space.inertial_parameters.conversions import pseudo_inertia, to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import (
    TRIANGLES,
    ConstraintBlock,
    solve_conic,
    triangles,
)
from balance.support.tolerances import CONDITION_WITHOUT_MATTER
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out

# Price of mass for the objectives inertia and rotor, in squares of the characteristic length,
# so that no mass is added that serves nothing.
IDLE_MASS_PRICE = 1e-2
AddedObjective = Literal["mass", "inertia", "rotor"]


class AddedProgram(NamedTuple):
    """The program, with lengths in the unit coordinates of the regions.

    Attributes:
        space: the design space.
        regions: region by position of the body, ascending.
        unit: kilograms per unit of mass.
        rows: conditions (links, ρ, 10) on the coordinates `triangles` of each ΔP. Stacked side
            by side their rows are orthonormal.
        target: r (ρ,).
        lift: functionals on the counted parameters of all bodies, in the units of the chain
            (parameters, ρ), of which the conditions are made.
        unmatched: functional (parameters,) in which no added matter has a part and that the
            given masses do not fulfil; zero if there is none.
        given: counted parameters of the given masses (parameters,), in units of mass.
        cost: polynomials c_b of the objective, likewise (links, 10).
        inertia: for ``inertia``, moments of inertia about the link's origin: of ΔP
            (links, 6, 10) and of the given masses (links, 6); otherwise empty.
        scale: SI units per unit of the objective.
        constant: objective of the given masses alone, SI units.
        idle: part of ``cost`` that is a price on mass besides the objective.
    """

    space: DesignSpace
    regions: Mapping[int, Region]
    unit: float
    rows: Array
    target: Array
    lift: Array
    unmatched: Array
    given: Array
    cost: Array
    inertia: tuple[Array, Array]
    scale: float
    constant: float
    idle: float


class AddedSolution(NamedTuple):
    """An answer of the solver.

    Attributes:
        infeasible: whether the solver found that no matter balances.
        moments: ΔP of each link, in unit coordinates and units of mass (links, 4, 4); without
            second moments if they do not count.
        dual: y (ρ,).
        forms: polynomials ``c_b - y·A_b``, matrices (links, 4, 4) in unit coordinates; for an
            infeasible program without c_b.
        bound: value of the dual, in units of the objective.
        cones: the cones of the links; those of cylinders hold the points that were found.
    """

    infeasible: bool
    moments: Array
    dual: Array
    forms: Array
    bound: float
    cones: tuple[MomentCone, ...]


def build_added_program(
    space: DesignSpace,
    regions: Mapping[int, Region],
    minimise: AddedObjective,
    price: float = IDLE_MASS_PRICE,
) -> AddedProgram:
    """Build the program of counterweights.

    Args:
        regions: region by position of the body.
        price: price of mass for the objectives inertia and rotor, in squares of
            ``space.length``.
    """
    file = given_parameters(space)
    unit = float(file[:, 0].sum()) / len(file) or 1.0
    frame, force = space.chain.frame, space.balance == "force"
    given = to_chain(file, frame, space.planar, force).reshape(-1) / unit
    conditions = orthonormal_conditions(space.scaled_basis)
    width = conditions.shape[1] // len(file)
    by_body = conditions.reshape(len(conditions), len(file), width).transpose(1, 0, 2)
    raw = by_body[list(regions)] @ parameters_per_moment(space, regions)
    U, values, V = np.linalg.svd(np.concatenate(raw, axis=1), full_matrices=False)
    rank = int(np.sum(values > CONDITION_WITHOUT_MATTER * values.max(initial=0.0)))
    r, kept = -conditions @ given, U[:, :rank] / values[:rank]
    rows = V[:rank].reshape(rank, len(regions), 10).transpose(1, 0, 2)
    # Moments that no condition has, second ones for forces, have no round-off in its rows.
    rows = rows * (raw != 0.0).any(axis=1)[:, None, :]
    cost, inertia, scale, constant = objective_of(space, regions, minimise, price, file, unit)
    # Twice, because what is left may be much smaller than r.
    remainder = conditions.T @ project_out(project_out(r, U[:, :rank]), U[:, :rank])
    return AddedProgram(
        space,
        regions,
        unit,
        rows,
        r @ kept,
        conditions.T @ kept,
        remainder,
        given,
        cost,
        inertia,
        scale,
        constant,
        0.0 if minimise == "mass" else price,
    )


def solve_added(program: AddedProgram) -> AddedSolution:
    """Solve the program; points of cylinders are added until none has a negative price."""
    return _with_points(program, _solve)


def certificate_dual(program: AddedProgram) -> Array:
    """Compute a certificate y (ρ,) with entries of at most 1, for programs near the border.

    It is the dual of the least sum of absolute errors of the conditions, which has a solution
    whether or not matter balances; with ``y·r`` zero if some does.
    """
    empty = np.empty(0)
    free = program._replace(cost=np.zeros_like(program.cost), inertia=(empty, empty))
    return _with_points(free, _least_errors).dual


def _least_errors(program: AddedProgram, cones: tuple[MomentCone, ...]) -> AddedSolution:
    """Minimise the sum of absolute errors of the conditions."""
    q, rows, offset, parts = conic_arguments(program, cones)
    rank, count = program.target.size, q.size
    more = np.zeros((len(rows) + 2 * rank, count + 2 * rank))
    more[: len(rows), :count] = rows
    more[:rank, count:] = np.hstack([np.eye(rank), -np.eye(rank)])
    more[len(rows) :, count:] = np.eye(2 * rank)
    solution = solve_conic(
        np.append(q, np.ones(2 * rank)),
        more,
        np.append(offset, np.zeros(2 * rank)),
        [*parts, ConstraintBlock("nonnegative", 2 * rank)],
    )
    dual = solution.dual[:rank]
    forms = -np.einsum("r,lrj->lj", dual, program.rows) @ TRIANGLES[4].T
    none = np.zeros((len(cones), 4, 4))
    return AddedSolution(True, none, dual, forms.reshape(-1, 4, 4), 0.0, cones)


def _with_points(
    program: AddedProgram,
    solve: Callable[[AddedProgram, tuple[MomentCone, ...]], AddedSolution],
) -> AddedSolution:
    """Solve with more and more points of cylinders, until none has a negative price."""
    from balance.masses.counterweights.cylinder_points import first_points, missing_points

    kinds = list(program.regions.values())
    if program.space.balance == "force" and program.idle == 0.0:
        # Neither the conditions nor the mass feel second moments.
        return solve(program, tuple(first_moment_cone(region) for region in kinds))
    points = {k: first_points() for k, shape in enumerate(kinds) if shape.kind == "cylinder"}
    exact = {k: moment_cone(shape) for k, shape in enumerate(kinds) if k not in points}
    while True:
        cones = exact | {k: lump_cone(p) for k, p in points.items()}
        solution = solve(program, tuple(cones[k] for k in range(len(cones))))
        more = missing_points(program.regions, solution.forms, points)
        if not more:
            return solution
        points = {
            k: np.concatenate([p, more[k]]) if k in more else p for k, p in points.items()
        }


def added_objective(program: AddedProgram, moments: Sequence[Array]) -> tuple[float, float]:
    """Compute the objective of added matter.

    Args:
        moments: ΔP of each link (4, 4), in unit coordinates and units of mass.

    Returns:
        Its value in SI units, and its value in the program: in the program's units, without
        the given masses and with the price on mass.
    """
    vectors = triangles(np.array(moments))
    priced = float(np.sum(program.cost * vectors))
    idle = program.idle * float(np.sum([P[3, 3] for P in moments]))
    if not program.inertia[0].size:
        return (priced - idle) * program.scale + program.constant, priced
    tensors = np.einsum("lij,lj->li", program.inertia[0], vectors) + program.inertia[1]
    largest = float(np.linalg.eigvalsh((tensors @ TRIANGLES[3].T).reshape(-1, 3, 3)).max())
    return largest * program.scale, largest + priced


def conic_arguments(
    program: AddedProgram, cones: Sequence[MomentCone]
) -> tuple[Array, Array, Array, list[ConstraintBlock]]:
    """Build arguments of `solve_conic`: the conditions, then the cones of the links.

    Args:
        cones: cone of each link. For ``inertia``, the last variable is the upper bound.

    Returns:
        Objective, rows, offset and cones.
    """
    at = np.cumsum([0, *(len(cone.matrices) for cone in cones)])
    rank, n, heavy = program.target.size, int(at[-1]), program.inertia[0].size > 0
    height = rank + sum(len(cone.rows) + 6 * heavy for cone in cones)
    rows, offset, q = np.zeros((height, n + heavy)), np.zeros(height), np.zeros(n + heavy)
    parts, row = [ConstraintBlock("zero", rank)], rank
    offset[:rank] = -program.target
    for k, cone in enumerate(cones):
        columns, moments = slice(at[k], at[k + 1]), triangles(cone.matrices).T
        rows[:rank, columns], q[columns] = program.rows[k] @ moments, program.cost[k] @ moments
        rows[row : row + len(cone.rows), columns] = cone.rows
        parts += cone.parts
        row += len(cone.rows)
        if heavy:
            inertia_rows = slice(row, row + 6)
            rows[inertia_rows, columns] = -program.inertia[0][k] @ moments
            rows[inertia_rows, n], offset[inertia_rows] = (
                triangles(np.eye(3)),
                -program.inertia[1][k],
            )
            parts.append(ConstraintBlock("psd_triangle", 3))
            row += 6
    q[n:] = 1.0
    return q, rows, offset, parts


def _solve(program: AddedProgram, cones: tuple[MomentCone, ...]) -> AddedSolution:
    """Solve the program with these cones."""
    q, rows, offset, parts = conic_arguments(program, cones)
    solution = solve_conic(q, rows, offset, parts)
    at, rank = np.cumsum([0, *(len(cone.matrices) for cone in cones)]), program.target.size
    moments = np.array(
        [cone.matrices.T @ solution.x[at[k] : at[k + 1]] for k, cone in enumerate(cones)]
    )
    dual = solution.dual[:rank]
    flat = -np.einsum("r,lrj->lj", dual, program.rows)
    if not solution.infeasible:
        flat = flat + program.cost + _inertia_prices(program, solution.dual, cones)
    forms = (flat @ TRIANGLES[4].T).reshape(-1, 4, 4)
    bound = -float(offset @ solution.dual)
    return AddedSolution(solution.infeasible, moments, dual, forms, bound, cones)


def _inertia_prices(program: AddedProgram, dual: Array, cones: tuple[MomentCone, ...]) -> Array:
    """Compute the polynomials (links, 10) that weigh the moments of inertia in the dual."""
    prices = np.zeros_like(program.cost)
    at = program.target.size
    for k, cone in enumerate(cones if program.inertia[0].size else ()):
        at += len(cone.rows)
        prices[k] = dual[at : at + 6] @ program.inertia[0][k]
        at += 6
    return prices


def orthonormal_conditions(basis: Array) -> Array:
    """Compute orthonormal rows (rank, parameters) that vanish on a space (parameters, n)."""
    if basis.shape[1] == 0:
        return np.eye(len(basis))
    Q = np.linalg.qr(basis, mode="complete")[0]
    return np.asarray(Q[:, basis.shape[1] :].T)


def objective_of(
    space: DesignSpace,
    regions: Mapping[int, Region],
    minimise: AddedObjective,
    price: float,
    file: Array,
    unit: float,
) -> tuple[Array, tuple[Array, Array], float, float]:
    """Compute ``cost``, ``inertia``, ``scale`` and ``constant`` of the program.

    Args:
        file: parameters of the given masses (bodies, 10), kg.
        unit: kilograms per unit of mass.
    """
    empty, S = np.empty(0), symmetric_basis()
    cost = np.zeros((len(regions), 10))
    if minimise == "mass":
        cost[:] = S[:, 3, 3]
        return cost, (empty, empty), unit, 0.0
    area = space.length**2
    cost += price * S[:, 3, 3]
    if minimise == "inertia":
        added, given = np.zeros((len(regions), 6, 10)), np.zeros((len(regions), 6))
        for k, (b, region) in enumerate(regions.items()):
            added[k] = _inertia_triangles(region.place @ S @ region.place.T).T / area
            F = np.linalg.inv(space.frames[b])
            given[k] = _inertia_triangles(F @ pseudo_inertia(file[b]) @ F.T) / (area * unit)
        return cost, (added, given), unit * area, 0.0
    frame, flat = space.chain.frame, [0, 1, 3] if space.planar else [0, 1, 2, 3]
    to_frame = np.eye(4)
    to_frame[:3, :3] = frame.R / frame.length
    to_frame[:3, 3] = -to_frame[:3, :3] @ frame.origin
    weights = rotor_weights(space)
    for k, (b, region) in enumerate(regions.items()):
        H = (to_frame @ space.frames[b] @ region.place)[flat]
        cost[k] += np.einsum("nij,ij->n", S, H.T @ weights[b] @ H)
    P = (to_frame @ pseudo_inertia(file) @ to_frame.T)[:, flat][:, :, flat]
    return cost, (empty, empty), unit * area, float(np.sum(weights * P)) * area


def _inertia_triangles(P: Array) -> Array:
    """Compute the vectors (..., 6) of inertia tensors from pseudo-inertias (..., 4, 4)."""
    second = P[..., :3, :3]
    trace = np.trace(second, axis1=-2, axis2=-1)
    return triangles(trace[..., None, None] * np.eye(3) - second)
