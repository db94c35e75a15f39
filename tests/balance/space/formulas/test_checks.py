"""The checks of formulas notice wrong ones, and what cannot be derived is refused."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from fractions import Fraction
from itertools import count

import pytest

import balance
import kinematics
from balance.space.formulas import derive, geometry_samples
from balance.space.formulas.assembly_order import assembly_order
from balance.space.formulas.derive import file_residual, fresh_geometries
from balance.space.formulas.geometry_samples import GeometrySamples
from balance.space.formulas.modular_conditions import ConditionSource
from balance.space.formulas.planar_parts import planar_parts
from balance.space.formulas.polynomials import Quotient
from balance.space.formulas.relations import FreeDimensions, relations_in
from kinematics.errors import ExactError, UsageError
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS


def with_twice_a_term(formulas):
    """The same formulas with one coefficient doubled."""
    first, *rest = formulas.conditions
    term = first.terms[0]
    content, monomial, factors = term.coefficient
    wrong = term._replace(coefficient=Quotient(2 * content, monomial, factors))
    return replace(
        formulas, conditions=(first._replace(terms=(wrong, *first.terms[1:])), *rest)
    )


def test_both_checks_notice_a_wrong_coefficient():
    space = balance.design_space("four_bar_general", balance="force")
    parts = planar_parts(space)
    source = ConditionSource(parts, *assembly_order(parts), force=True)
    free = FreeDimensions(parts, [], cartesian=False)
    samples = GeometrySamples(source, free, space.rank)
    right = balance.formulas("four_bar_general", "force")
    for formulas, holds in ((right, True), (with_twice_a_term(right), False)):
        conditions = formulas.conditions
        count = fresh_geometries(samples, formulas.parameters, conditions)
        residual = file_residual(space, parts, free, conditions, complete=True)
        assert (count == 20) == holds == (residual < 1e-12)


def test_every_pose_closes_whatever_the_dimensions():
    """Loops vanish at poses drawn modulo a prime, and two poses differ."""
    p, rng = PRIMES_OF_61_BITS[2], random.Random(3)
    for model in ("slider_crank", "six_bar_stephenson", "three_rrr"):
        parts = planar_parts(balance.design_space(model, balance="force"))
        source = ConditionSource(parts, *assembly_order(parts), force=True)
        free = FreeDimensions(parts, [], cartesian=False)
        values = free.pairs(free.draw(p, rng), p)
        starts = []
        for _ in range(2):
            motion, _ = source.motion_at(values, p, rng)
            for loop in motion.loops:
                for side in (0, 1):
                    total = sum(a[side] * motion.start[i][side] for i, a in loop.items())
                    assert total % p == 0
            starts.append(motion.start)
        assert starts[0] != starts[1] and motion.loops


def test_links_that_do_not_turn_are_found():
    """Relations that leave the sum of the turns of a leg zero; other relations do not."""
    for motion, turns in (("c1=-a1-b1", False), ("c1=-2*a1-b1", True), ("b1=-a1", True)):
        linkage = kinematics.load("four_rrr", inputs=["a1", "b1", "c1"])
        parts = planar_parts(balance.design_space(linkage, motion, balance="force"))
        still = {parts.parts[k].name for k in parts.unturned}
        assert ("platform" not in still) == turns
    assert still == {"upper1"}


def test_relations_of_a_pantograph_are_found():
    parts = planar_parts(balance.design_space("pantograph", balance="force"))
    words = {relation.words for relation in relations_in(parts)}
    assert "BC = DE" in words
    free = FreeDimensions(parts, relations_in(parts), cartesian=False)
    assert len(free.free) == 2 and free.equals(free.free[0]) == ""
    assert sum(free.equals(i) != "" for i in range(len(parts.dimensions))) == 3


def test_solved_parameters_are_those_asked_for():
    formulas = balance.formulas("four_bar_general", "force", solve=["s_rocker", "s_coupler"])
    assert [each.solved.name for each in formulas.conditions] == ["s_rocker", "s_coupler"]
    assert formulas.confirmed
    coefficient = formulas.conditions[0].terms[0].coefficient
    assert coefficient.content == Fraction(1)


@pytest.mark.parametrize(
    ("words", "options", "problem"),
    [
        ("goldberg_five_bar", {}, "special dimensions alone"),
        ("delta", {}, "single loops"),
        ("hprs", {}, "no screws"),
        ("double_pendulum_duplicates", {}, "follows another"),
        ("four_bar_general", {"solve": ["s_crank", "m_coupler", "s_rocker"]}, "as well"),
        ("four_bar_general", {"solve": ["ghost"]}, "no parameter"),
        ("four_bar_general", {"where": "AB=BD"}, "does not hold"),
        ("four_bar_general", {"where": "AB=XY"}, "no distance"),
    ],
)
def test_refusals(words, options, problem):
    with pytest.raises(ExactError, match=problem):
        balance.formulas(words, "force", **options)


def test_a_relation_is_written_with_an_equals_sign():
    with pytest.raises(UsageError, match="write AB=CD"):
        balance.formulas("four_bar_general", "force", where="AB")


def test_given_relations_are_used():
    formulas = balance.formulas("slider_crank", "force", where="AB=BD")
    assert formulas.relations == ("AB=BD",) and formulas.confirmed
    assert "l_coupler" not in formulas.text()


def derived_until(monkeypatch, step):
    """Formulas of a six-bar, with a clock that counts its readings; and their number."""
    clock = count()
    for module in (derive, geometry_samples):
        monkeypatch.setattr(module, "monotonic", lambda: float(next(clock)))
    return balance.formulas("six_bar_watt", "force", seconds=step), next(clock)


@pytest.mark.slow
def test_time_returns_the_conditions_that_are_known(monkeypatch):
    """A condition that is known is the same as with more time, and none is half known."""
    whole, last = derived_until(monkeypatch, 1e9)
    lines = whole.text().splitlines()
    assert whole.confirmed and len(lines) == 3
    numbers = set()
    for step in range(last - 8, last):
        part, _ = derived_until(monkeypatch, step)
        known = part.text().splitlines()
        assert set(known) <= set(lines) and len(known) + part.unknown == len(lines)
        assert part.confirmed == (not part.unknown)
        numbers.add(len(known))
    assert {1, 2} <= numbers


def test_too_large_formulas_are_refused_with_their_size(monkeypatch):
    monkeypatch.setattr(derive, "MAX_UNKNOWNS", 5)
    with pytest.raises(ExactError, match=r"degree \d over \d has up to (\d+) terms") as raised:
        balance.formulas("six_bar_watt", "force")
    terms, remaining = map(int, re.findall(r"(\d+) (?:terms|are left)", str(raised.value)))
    assert 5 < remaining <= terms and "more than the 5" in str(raised.value)


def test_time_that_is_over_leaves_conditions_open():
    formulas = balance.formulas("four_bar_general", "force", seconds=1e-9)
    assert formulas.unknown == formulas.rank == 4 and not formulas.confirmed
    assert formulas.conditions == ()
