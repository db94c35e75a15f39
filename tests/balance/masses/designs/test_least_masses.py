"""The least mass: what sets the size of a design, and laws of the minimum."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance import design_space
from balance.app.answers.text.design import design_facts, unusual_matter
from tests.support.designs import design_of_any_density
from tests.support.shapes import matrix

KITES = ["four_bar_kite", "four_bar_antiparallelogram"]


def space_of(model):
    return design_space(kinematics.load(model))


def least(space, **bounds):
    return design_of_any_density(space, "mass", bounds=bounds)


@pytest.mark.parametrize("model", KITES)
def test_one_more_bound_never_makes_a_design_lighter(model):
    """Unless it leaves no design with so high a floor."""
    space, equal = space_of(model), 0
    free = least(space, coupler=(0.1, np.inf))
    heaviest = max(free.bodies, key=lambda body: body.mass)
    for part in (0.7, 0.9, 0.98, 1.5):
        most = {heaviest.name: (0.0, part * heaviest.mass)}
        bounded = least(space, coupler=(0.1, np.inf), **most)
        if bounded.value is None:
            continue
        if bounded.floor == pytest.approx(free.floor, rel=1e-9):
            assert bounded.value >= free.value * (1.0 - 1e-6)
            equal += 1
        else:
            assert bounded.floor < free.floor
    assert equal


@pytest.mark.parametrize("model", KITES)
def test_twice_the_least_mass_of_a_link_costs_at_most_twice(model):
    """Twice a design is a design; the floor makes it a little heavier than need be."""
    space = space_of(model)
    one, two = (least(space, coupler=(low, np.inf)).value for low in (0.2, 0.4))
    assert 1.85 * one < two <= 2.0 * one * (1.0 + 1e-6)


@pytest.mark.parametrize("bounds", [{}, {"coupler": (0.1, 1.0)}, {"crank": (0.0, 0.3)}])
@pytest.mark.parametrize("objective", ["mass", "inertia", "rotor"])
def test_no_body_is_below_the_floor(objective, bounds):
    """Least mass and least second moment about the centre, by the pseudo-inertia."""
    found = design_of_any_density(space_of("four_bar_kite"), objective, bounds=bounds)
    mass, moment = found.floor
    for body in found.bodies:
        P = matrix(body.z)
        central = P[:2, :2] - np.outer(P[:2, 3], P[:2, 3]) / P[3, 3]
        assert P[3, 3] >= mass * (1.0 - 1e-6)
        assert np.linalg.eigvalsh(central)[0] >= moment * (1.0 - 1e-6)


def test_the_text_says_what_sets_the_size():
    space = space_of("four_bar_kite")
    open_ = "nothing else sets the size"
    assert open_ in dict(design_facts(least(space)))["floor"]
    assert open_ in dict(design_facts(least(space, crank=(0.0, 0.3))))["floor"]
    assert open_ not in dict(design_facts(least(space, crank=(0.1, 0.3))))["floor"]
    assert "floor" not in dict(design_facts(design_of_any_density(space)))


@pytest.mark.parametrize("model", ["slider_crank", "four_bar_kite"])
def test_bounds_that_are_printed_have_a_design(model):
    """More mass for a coupler lighter than air, where a design has it: not on the kite."""
    design = balance.design(model)
    assert design.lighter_than_air == ("coupler",)
    (light,) = (body.mass for body in design.bodies if body.name == "coupler")
    heavier = balance.design(model, bounds={"coupler": (10.0 * light, 1.0)})
    printed = (
        "more mass" in repr(design),
        any("--bounds" in x for _, x in unusual_matter(design)),
    )
    assert printed == 2 * (heavier.z is not None,)
    if design.more_mass:
        again = balance.design(model, bounds=design.more_mass)
        assert again.z is not None and "bounds={'coupler': (" in repr(design)
        assert again.bodies[1].mass == pytest.approx(10.0 * light, rel=0.1)
