"""Questions about designs put to two solvers of CVXPY, where the product settles nothing."""

from __future__ import annotations

import warnings
from math import inf

import numpy as np

from tests.support.shapes import matrix

# The margin with which another solver settles what was left undecided.
SETTLED = 1e-9


def second_opinion(one, rows, mechanism, forms) -> str:
    """The verdict of two other solvers on the same question, put in other coordinates.

    Args:
        one: a `random_designs.Question`.
        rows: conditions on all parameters (rows, 10 bodies).
        mechanism: the linkage by the second reading.
        forms: functionals (10,) that are not negative, by body.
    """
    import cvxpy as cp

    count = len(mechanism.bodies)
    _, sizes, V = np.linalg.svd(rows)
    null = V[int((sizes > 1e-11 * sizes[0]).sum()) :].T
    y, t, tau = cp.Variable(null.shape[1]), cp.Variable(), cp.Variable()
    z, limits, total = null @ y, [tau >= t], 0.0
    free = [b for b, name in enumerate(mechanism.bodies) if name not in one.keep]

    def margin() -> float:
        """Of the solver's masses themselves; their traces add up to 1."""
        P = [matrix(part) for part in (null @ y.value).reshape(count, 10)]
        return min(np.linalg.eigvalsh(P[b])[0] for b in free) / sum(map(np.trace, P))

    units = np.array([matrix(unit) for unit in np.eye(10)])
    for b, name in enumerate(mechanism.bodies):
        own = z[10 * b : 10 * b + 10]
        if name in one.keep:
            limits.append(own == tau * mechanism.inertias[b])
            total += tau * float(np.trace(matrix(mechanism.inertias[b])))
            continue
        P = cp.Variable((4, 4), symmetric=True)
        limits += [P == sum(own[k] * units[k] for k in range(10)), P >> t * np.eye(4)]
        if name in forms:
            limits.append(forms[name] @ own >= 0)
        low, high = one.bounds.get(name, (0.0, inf))
        limits += [own[0] >= low * tau] + [own[0] <= high * tau] * (high < inf)
        total += cp.trace(P)
    problems = (
        cp.Problem(cp.Maximize(t), [*limits, total <= 1.0]),
        cp.Problem(cp.Minimize(total), [*limits, t == 1.0]),
    )
    said = [
        _settled(problem, margin, solver)
        for problem in problems
        for solver in ("CLARABEL", "SCS")
    ]
    return min(said)


def _settled(problem, margin, solver: str) -> str:
    """What one solver says of one problem: that there is a margin, or can be none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            problem.solve(solver=solver, **({"eps": 1e-9} if solver == "SCS" else {}))
    except Exception as error:
        if type(error).__name__ != "SolverError":
            raise
        return "undecided"
    if problem.status == "infeasible":
        return "infeasible"
    return "feasible" if problem.status == "optimal" and margin() > SETTLED else "undecided"
