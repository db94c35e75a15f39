"""Formulas beside those in print, in rational numbers and in other geometries."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import balance
import kinematics
from balance.space.formulas.file_values import file_values
from tests.support.formula_rows import matrix, violation
from tests.support.four_bar_spaces import space_of

A, B, C, D = Fraction(3, 7), Fraction(11, 5), Fraction(13, 4), Fraction(17, 6)


def same(formulas, values, published):
    """Whether printed rows equal published ones exactly, whatever their order."""
    rows = {tuple(row) for row in matrix(formulas, values).tolist()}
    return rows == {tuple(row) for row in published}


def test_four_bar_of_berkof_and_lowen():
    """R. S. Berkof, G. G. Lowen, 1969: columns s1 s2 s3 m1 m2 m3; any four-bar."""
    formulas = balance.formulas("four_bar_general", "force")
    values = {"l_crank": A, "l_coupler": B, "l_rocker": C, "l_ground": D}
    published = [[1, 0, A / C, 0, A, 0], [0, 1, B / C, 0, 0, 0]]
    assert formulas.confirmed and same(formulas, values, published)
    assert not same(formulas, values | {"l_rocker": D}, published)


def test_slider_crank_in_line():
    """s1 + a (m2 + m3) = 0 and s2 + b m3 = 0; the slider does not turn."""
    formulas = balance.formulas("slider_crank", "force")
    values = {"l_crank": A, "l_coupler": B}
    assert same(formulas, values, [[1, 0, 0, 0, A, A], [0, 1, 0, 0, 0, B]])


@pytest.mark.slow
def test_berkof_and_lowen_in_symbols():
    sympy = pytest.importorskip("sympy")
    a, b, c, m2 = sympy.symbols("l_crank l_coupler l_rocker m_coupler", real=True)
    s1, s2, s3 = sympy.symbols("s_crank s_coupler s_rocker")
    published = [s1 + a / c * s3 + a * m2, s2 + b / c * s3]
    ours = balance.formulas("four_bar_general", "force").sympy()
    assert [sympy.simplify(x - y) for x, y in zip(ours, published, strict=True)] == [0, 0]


@pytest.mark.slow
def test_masses_of_a_thesis_fulfil_the_formulas_of_its_mechanism():
    """J. J. de Jong, chapter 6, table 6.2: all sums vanish; some do not for lighter arms.

    General lengths of its arms have as many conditions, but others.
    """
    formulas = balance.formulas("two_rrr_bisector")
    assert formulas.confirmed and len(formulas.relations) == 10
    assert not any(file_values(formulas).sums)
    changed = kinematics.load("two_rrr_bisector")
    arm = next(body for body in changed.bodies if body.name == "arm1")
    place = changed.bodies.index(arm)
    lighter = replace(arm, inertia=0.99 * arm.inertia)
    bodies = (*changed.bodies[:place], lighter, *changed.bodies[place + 1 :])
    other = replace(formulas, linkage=replace(changed, bodies=bodies))
    assert any(file_values(other).sums)


SPECIAL = {
    "four_bar_kite": ([(0.4, 0.4, 0.9, 0.9, 0.7, True), (0.5, 0.5, 1.3, 1.3, 1.1, True)], 7),
    "four_bar_antiparallelogram": ([(0.4, 0.9, 0.4, 0.9, 0.7, True)], 7),
    "four_bar_parallelogram": ([(0.4, 0.9, 0.4, 0.9, 0.7, False)], 5),
}


@pytest.mark.parametrize("model", SPECIAL)
def test_special_four_bars_in_other_lengths(model):
    """Formulas of one file hold in linkages of the same kind with other lengths.

    B. Ricard, C. M. Gosselin, 2000, found that these can be balanced dynamically.
    """
    formulas = balance.formulas(model)
    geometries, rank = SPECIAL[model]
    assert formulas.confirmed and formulas.rank == rank == len(formulas.conditions)
    for a, b, c, d, turn, mirrored in geometries:
        values = {"l_crank": a, "l_coupler": b, "l_rocker": c, "l_ground": d}
        space = space_of(a, b, c, d, turn, mirrored)
        if space.rank != rank:
            space = space_of(a, b, c, d, turn, not mirrored)
        assert space.rank == rank
        assert violation(formulas, space, values) < 1e-9  # lengths are rounded to doubles
        assert violation(formulas, space, values | {"l_ground": 1.01 * d}) > 1e-4


def test_kite_has_the_bound_of_its_length():
    """Ricard and Gosselin: J of the rocker is positive only where the ground is the longer."""
    text = balance.formulas("four_bar_kite").text()
    assert "J_rocker - ((l_ground^2 - l_crank^2)/l_ground) sx_rocker + J_coupler = 0" in text
