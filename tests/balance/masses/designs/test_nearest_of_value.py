"""Designs of about the least value of an objective: the value, and that no other is nearer."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from balance import design_space
from balance.masses.designs.best_design import maximise_margin
from balance.masses.designs.constraints import build_program
from balance.masses.designs.objectives import minimise_objective
from tests.fuzz.random_designs import rows_of
from tests.independent.second_densities import chain_matrices
from tests.support.designs import design_of_any_density
from tests.support.gallery_run import changed_commands, changed_lines, run_commands
from tests.support.shapes import matrix

EXCESS = 1e-5
ACCURACY = ("tol_feas", "tol_gap_abs", "tol_gap_rel")
# Objectives that leave bodies free, in space and in a plane.
FREE = [
    ("bennett", "mass"),
    ("bennett", "inertia"),
    ("four_bar_spherical", "inertia"),
    ("rusr", "mass"),
]
COMMANDS = (
    "design bennett --balance force --minimise rotor",
    "design bennett_rational --balance force --minimise inertia",
    "design rusr --balance force --minimise inertia",
    "design sarrus --balance force --minimise mass",
    "design two_rrr --balance force --minimise inertia",
    "design three_rrr --balance force --minimise inertia",
    "design fuga_i --balance force --minimise inertia",
    "design four_bar_kite --minimise mass",
)


@pytest.mark.parametrize("wanted", ["mass", "inertia", "rotor"])
@pytest.mark.parametrize("model", ["bennett", "five_bar", "four_bar_kite"])
def test_the_value_is_the_least_one_but_for_an_excess(model, wanted):
    """With limits of density, the nearest design and the one without a second objective."""
    space = design_space(model, balance="force")
    answer = maximise_margin(space, thickness=None)
    program = build_program(space, answer.constraints)
    optima = minimise_objective(space, program, wanted, answer.z, answer.margin)
    nearest, least = (optimum.value for optimum in optima)
    assert least * (1.0 - 1e-9) <= nearest <= least * (1.0 + EXCESS) * (1.0 + 1e-9)


def squared_distance(P, file):
    """``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``."""
    steps = np.linalg.solve(file, P - file)
    return float(np.einsum("bij,bji->", steps, steps))


def reference_of(file, floor):
    """Bodies of the file, of which no eigenvalue is below a fifth of their mean."""
    values, axes = np.linalg.eigh(file)
    least = np.maximum(floor, 0.2 * values.mean(axis=1, keepdims=True))
    return (axes * np.maximum(values, least)[:, None]) @ axes.mT


@pytest.mark.parametrize(("model", "wanted"), FREE)
def test_no_design_of_the_value_is_nearer(model, wanted):
    """CVXPY, in coordinates of the momentum of finite poses."""
    cp = pytest.importorskip("cvxpy")
    space = design_space(model, balance="force")
    found = design_of_any_density(space, wanted, within=None)
    T, given = chain_matrices(space), [body.inertia for body in space.linkage.bodies]
    unit = float(np.mean([z[0] for z in given]))
    basis = np.array([T @ matrix(e) @ T.T for e in np.eye(10)]) / unit
    file = np.einsum("bi,ijk->bjk", np.array(given), basis)
    floor = found.floor[0] / unit
    reference = reference_of(file, floor)
    _, sizes, V = np.linalg.svd(rows_of(model, "force", space.inputs, space.bodies))
    null = V[int((sizes > 1e-11 * sizes[0]).sum()) :].T
    y = cp.Variable(null.shape[1])
    limits, goal, mass, trace = [], 0.0, 0.0, 0.0
    for b, frame in enumerate(space.frames):
        z = null[10 * b : 10 * b + 10] @ y
        P = sum(z[i] * basis[i] for i in range(10))
        X = np.linalg.inv(np.linalg.cholesky(reference[b]))
        goal += cp.sum_squares(X @ P @ X.T - np.eye(4))
        limits.append(P / floor >> np.eye(4))
        mass += z[0]
        trace += cp.trace(P)
        if wanted == "inertia":
            shift = np.eye(4)
            shift[:3, 3] = -frame[:3, 3]
            moved = [shift @ matrix(e) @ shift.T for e in np.eye(10)]
            S = sum(z[i] * moved[i][:3, :3] for i in range(10))
            limits.append((cp.trace(S) * np.eye(3) - S) / found.value << np.eye(3))
    if wanted == "mass":
        limits.append(mass / found.value <= 1.0)
    largest = maximise_margin(space, within=None, density=None).margin
    limits.append(trace <= 10.0 * 0.01 / largest)
    problem = cp.Problem(cp.Minimize(goal), limits)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem.solve(solver=cp.CLARABEL, **dict.fromkeys(ACCURACY, 1e-10))
    assert problem.status in ("optimal", "optimal_inaccurate")
    P = np.einsum("bi,ijk->bjk", found.z, basis)
    other = np.einsum("bi,ijk->bjk", (null @ y.value).reshape(-1, 10), basis)
    distance = squared_distance(P, reference)
    assert distance == pytest.approx(problem.value, rel=1e-4)
    assert np.abs(P - other).max() < 3e-3 * np.abs(P).max()
    # The first steps to the other one lead no nearer.
    for step in (1e-3, 0.1, 1.0):
        assert squared_distance(P + step * (other - P), reference) > distance * (1.0 - 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_printed_digit_depends_on_rounding(seed):
    changed = changed_commands(run_commands(COMMANDS), run_commands(COMMANDS, seed))
    assert not changed, changed_lines(changed)
