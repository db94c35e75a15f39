"""The best design within a limit of density, put to CVXPY in other coordinates.

Momentum is that of finite poses (`random_designs.rows_of`), and the limit is written as

    (∏ w_i)^{1/4} ≥ k^{3/4} m^{3/2}    or, in a plane,    (∏ w_i)^{1/3} ≥ (m⁵ / (4πρt)²)^{1/3}

with the diagonal w of a triangular W, ``[[P, W], [Wᵀ, diag w]] ⪰ 0``. Each body is measured in
axes and units of its own, those of the answer, which gives the solver more digits.
"""

from __future__ import annotations

import warnings
from math import inf, pi

import numpy as np

from tests.support.shapes import matrix, units


def chain_matrices(space):
    """Matrices T (k, 4) with ``T P Tᵀ`` the pseudo-inertia in units of the chain."""
    R, origin, length = units(space)
    G = np.eye(4)
    G[:3, :3], G[:3, 3] = R / length, -R @ origin / length
    return G[[0, 1, 3] if space.planar else range(4)]


# Violation of a limit, in units of the answer, beyond which a solution is none; its value is
# known to about ten times as much.
VIOLATED = 2e-8
# Tolerances and settings of the solver, tried one after the other: which of them reaches its
# tolerance depends on the processor.
SOLVER_SETTINGS = tuple(
    {**dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), accuracy), **settings}
    for accuracy in (1e-10, 1e-9, 1e-8)
    for settings in ({}, {"equilibrate_enable": False}, {"iterative_refinement_max_iter": 30})
)


def least(found, keep, bounds, rows, mechanism, forms, density, thickness):
    """The least mass or change of all designs, and the problem's status.

    Args:
        found: the answer, of which the objective, the space and the floor are taken.
        rows: conditions on all parameters (rows, 10 bodies).
        forms: functionals (10,) that are not negative, by body.
    """
    import cvxpy as cp

    space, T = found.space, chain_matrices(found.space)
    k, length = len(T), space.length
    _, sizes, V = np.linalg.svd(rows)
    null = V[int((sizes > 1e-11 * sizes[0]).sum()) :].T
    y = cp.Variable(null.shape[1])
    # Masses in units of those of the answer.
    unit = float(found.z[:, 0].sum()) if found.z is not None else 1.0
    z, limits, goal = null @ y, [], 0.0
    basis = np.array([T @ matrix(unit) @ T.T for unit in np.eye(10)])
    floor = found.floor[0] / unit if found.floor else 0.0
    inertias = mechanism.inertias / unit
    for b, name in enumerate(mechanism.bodies):
        own, file = z[10 * b : 10 * b + 10], T @ matrix(inertias[b]) @ T.T
        if name in keep:
            limits.append(own == inertias[b])
            goal += inertias[b][0] if found.minimise == "mass" else 0.0
            continue
        P, W = cp.Variable((k, k), symmetric=True), cp.Variable((k, k))
        m, X = own[0], np.eye(k)
        if found.z is not None:
            X = np.linalg.inv(np.linalg.cholesky(T @ matrix(found.z[b] / unit) @ T.T))
        limits += [P == sum(own[i] * (X @ basis[i] @ X.T) for i in range(10))]
        limits += [P >> floor * X @ X.T]
        limits += [cp.upper_tri(W) == 0]
        limits += [cp.bmat([[P, W], [W.T, cp.diag(cp.diag(W))]]) >> 0]
        root = cp.geo_mean(cp.diag(W)) * np.linalg.det(X) ** (-2.0 / k)
        if thickness is None:
            kappa = 0.2 * (3.0 / (4.0 * pi * density)) ** (2.0 / 3.0) / length**2
            limits.append(root >= kappa**0.75 * unit**0.5 * cp.power(m, 1.5))
        else:
            sheet = (4.0 * pi * density * thickness * length**2) ** (-2.0 / 3.0)
            limits.append(root >= sheet * unit ** (2.0 / 3.0) * cp.power(m, 5.0 / 3.0))
        if name in forms:
            limits.append(forms[name] @ own >= 0)
        low, high = bounds.get(name, (0.0, inf))
        limits += [m >= low / unit] + [m <= high / unit] * (high < inf)
        if found.minimise == "mass":
            goal += m
        else:
            there = X @ file @ X.T
            logarithm = np.linalg.slogdet(there)[1] - k
            goal += 2.0 * (cp.trace(np.linalg.inv(there) @ P) - cp.log_det(P) + logarithm)
    problem = cp.Problem(cp.Minimize(goal), limits)
    value, status = solve_in_turn(problem, limits)
    return value * (unit if found.minimise == "mass" else 1.0), status


def solve_in_turn(problem, limits):
    """Solve a problem by the first settings that reach their tolerance: value and status."""
    import cvxpy as cp

    value, status = None, "failed"
    for settings in SOLVER_SETTINGS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                value = problem.solve(solver=cp.CLARABEL, **settings)
            except cp.SolverError:
                continue
        status = problem.status
        # Now and then the solver calls optimal what is not even allowed.
        if status == "optimal" and max(np.max(x.violation()) for x in limits) > VIOLATED:
            status = "optimal_inaccurate"
        if status in ("optimal", "infeasible"):
            break
    if value is None:
        raise cp.SolverError("no settings of the solver end with an answer")
    return value, status
