"""The least violation of requirements, against a second solver and its own multipliers."""

from __future__ import annotations

import cvxpy
import numpy as np
import pytest

import balance
import kinematics
from balance.masses import least_violation
from kinematics.errors import UsageError
from kinematics.model.spatial.inertia import from_pseudo_inertia
from tests.support.points import point_counterweights

LINKS, RADIUS = ("crank", "rocker"), 0.2
REGIONS = {name: f"ball(0,0,0,{RADIUS})" for name in LINKS}
LISTS = ["force; moment at u1=0.2", "gravity; dynamic at u1=0; force up to order 1", "dynamic"]


def in_si(space, rows):
    """Conditions on the parameters (bodies, 10) in SI units, from those of the chain."""
    L, o, size = space.length, space.chain.frame.origin, len(space.labels)
    unit = np.zeros((10, 10))
    for k in range(10):
        z = np.eye(10)[k]
        shift = np.eye(4)
        shift[:3, :3], shift[:3, 3] = np.eye(3) / L, -o / L
        E = np.array([[z[4], z[7], z[8]], [z[7], z[5], z[9]], [z[8], z[9], z[6]]])
        P = np.block([[0.5 * np.trace(E) * np.eye(3) - E, z[1:4, None]], [z[None, 1:4], z[0]]])
        unit[:, k] = from_pseudo_inertia(shift @ P @ shift.T)
    return rows.reshape(len(rows), -1, size) @ unit[:size]


@pytest.mark.parametrize("listed", LISTS)
def test_a_second_solver_leaves_as_much(listed):
    """Pseudo-inertias in balls as matrix inequalities, by cvxpy."""
    linkage, budget = kinematics.load("four_bar_general"), 1.5
    space = balance.require(linkage, listed, gravity=(0.3, -1.0, 0.2), spatial=True)
    weights = [1.0 + k for k in range(len(space.regions))]
    answer = least_violation(space, LINKS, budget, regions=REGIONS, weights=weights)
    given = np.array([body.inertia for body in linkage.bodies])
    P = {name: cvxpy.Variable((4, 4), PSD=True) for name in LINKS}
    limits = [sum(part[3, 3] for part in P.values()) <= budget]
    limits += [RADIUS**2 * p[3, 3] >= cvxpy.trace(p[:3, :3]) for p in P.values()]
    terms = []
    for weight, region in zip(weights, space.regions, strict=True):
        rows = in_si(space, region.rows)
        alone = np.linalg.norm(np.einsum("rbp,bp->rb", rows, given), axis=0).sum()
        left = np.einsum("rbp,bp->r", rows, given)
        for name, p in P.items():
            b = space.bodies.index(name)
            units = []
            for i in range(4):
                for j in range(4):
                    unit = np.zeros((4, 4))
                    unit[i, j] = unit[j, i] = 1.0 if i == j else 0.5
                    moved = space.frames[b] @ unit @ space.frames[b].T
                    units.append(rows[:, b] @ from_pseudo_inertia(moved))
            left = left + np.array(units).T @ cvxpy.reshape(p, 16, order="C")
        terms.append(weight * cvxpy.sum_squares(left / alone))
    problem = cvxpy.Problem(cvxpy.Minimize(sum(terms)), limits)
    problem.solve(solver="CLARABEL")
    assert answer.verdict == "optimal"
    assert answer.total**2 == pytest.approx(problem.value, rel=1e-5, abs=1e-9)
    assert answer.bound <= answer.total * (1.0 + 1e-9)
    added = answer.z[:, 0].sum() - given[:, 0].sum()
    assert added <= budget * (1.0 + 1e-6)


def test_the_multiplier_is_the_derivative_by_the_weight():
    space = balance.require("four_bar_general", "force; dynamic at u1=0.3")
    step = 1e-3
    totals = [
        least_violation(space, LINKS, 0.5, weights=(1.0, w)).total ** 2
        for w in (1.0 - step, 1.0 + step)
    ]
    item = least_violation(space, LINKS, 0.5).violations[1]
    assert item.text == "force"
    assert (totals[1] - totals[0]) / (2 * step) == pytest.approx(item.after**2, rel=1e-3)


def test_what_can_be_met_is_met_by_the_least_matter():
    space = balance.require("four_bar_general", "force")
    answer = least_violation(space, LINKS, 5.0)
    assert answer.dearest is None
    assert "meet all requirements" in answer.words
    least = point_counterweights(space, LINKS)
    assert sum(weight.mass for weight in answer.weights) == pytest.approx(
        least.added_mass, rel=1e-4
    )


def test_the_dearest_requirement_is_named():
    space = balance.require("four_bar_general", "force; dynamic")
    answer = least_violation(space, LINKS, 3.0)
    assert "'dynamic' costs most" in answer.words
    costs = {item.text: item.cost for item in answer.violations}
    assert max(costs, key=costs.get) == "dynamic"


@pytest.mark.parametrize(
    ("budget", "weights", "words"),
    [
        (0.0, None, "adds nothing"),
        (-1.0, None, "give a mass"),
        (1.0, (1.0,), "give 2 weights"),
        (1.0, (1.0, -2.0), "above 0"),
    ],
)
def test_wrong_numbers_are_refused(budget, weights, words):
    space = balance.require("four_bar_general", "force; gravity")
    with pytest.raises(UsageError, match=words):
        least_violation(space, LINKS, budget, weights=weights)


def test_requirements_of_a_linkage_are_those_of_its_space():
    """Weights are those of the texts as written; a space has them in its own order."""
    texts = "gravity; dynamic at u1=0; force"
    space = balance.require("four_bar_general", texts, gravity=(0, -9.81, 0))
    assert space.texts == ("dynamic at u1=0", "force", "gravity")
    first = least_violation(space, LINKS, 2.0, weights=[2.0, 3.0, 1.0])
    second = least_violation(
        "four_bar_general",
        LINKS,
        2.0,
        require=texts,
        gravity=(0, -9.81, 0),
        weights=[1.0, 2.0, 3.0],
    )
    assert first.violations == second.violations and np.array_equal(first.z, second.z)


@pytest.mark.parametrize(
    ("given", "more", "told"),
    [
        ("four_bar_general", {}, "or a linkage and require"),
        (balance.design_space, {"require": "force"}, "or a linkage and require"),
        (balance.require, {"require": "force"}, "leave out require"),
    ],
)
def test_what_has_no_requirements_is_refused(given, more, told):
    if not isinstance(given, str):
        given = given("four_bar_general", *(["force"] if given is balance.require else []))
    with pytest.raises(UsageError, match=told):
        least_violation(given, LINKS, 1.0, **more)


@pytest.mark.slow
def test_of_matter_that_meets_all_requirements_the_least_is_added():
    """As much as the least counterweights, which another program finds."""
    links = ["left_upper", "left_lower", "right_upper", "right_lower"]
    space = balance.require("fuga_i", "force; dynamic at u1=0")
    answer = least_violation(space, links, 1.0)
    assert answer.verdict == "optimal" and answer.total < 1e-12
    least = balance.counterweights(space, links, density=None)
    assert answer.mass == pytest.approx(least.added_mass, rel=1e-6)
