"""Densities by material or with a unit, in all functions that take one."""

from __future__ import annotations

import pytest

import balance
from kinematics.errors import UsageError

MODEL, LINKS = "four_bar_general", ["crank", "rocker"]

FUNCTIONS = {
    "counterweights": lambda density: (
        balance.counterweights(MODEL, LINKS, balance="force", density=density).added_mass
    ),
    "design": lambda density: (
        balance.design("four_bar_antiparallelogram", density=density).density
    ),
    "partial": lambda density: (
        balance.partial(
            MODEL, LINKS, 0.5, balance="force", density=density, speed=10.0
        ).shaking.objective
    ),
    "remedies": lambda density: (
        balance.compare_remedies(MODEL, only=["own_masses"], balance="force", density=density)
        .results[0]
        .added_mass
    ),
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_a_density_is_a_number_a_material_or_a_text_with_a_unit(function):
    tungsten = function(19250.0)
    assert function("tungsten") == tungsten == function(" 19.25 g/cm3")
    assert function("aluminium") != tungsten


def test_densities_by_link_may_be_materials():
    by_name = balance.counterweights(
        MODEL, LINKS, balance="force", density={"crank": "lead", "rocker": "steel"}
    )
    assert [weight.density for weight in by_name.weights] == [11340.0, 7850.0]


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_an_unknown_material_is_named(function):
    with pytest.raises(UsageError, match="'stel' is no material that is known.*steel"):
        function("stel")
