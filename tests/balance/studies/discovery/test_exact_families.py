"""Relations of planted families in exact arithmetic; masses against a cone program."""

from __future__ import annotations

import random
from dataclasses import replace
from math import prod

import numpy as np
import pytest

import balance
import balance.masses
from balance.space.formulas.problem import problem_of
from balance.studies.discovery.exact_families import decide_exactly
from balance.studies.discovery.families import group_members
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.related_dimensions import RelatedDimensions, condition_of
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import topology
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS
from tests.support.planted import lanes_of, mirrored, planted_corners

A, B, C = 0j, 1.3 + 0.4j, 2.1 - 0.9j
SHORT, LONG = 0.5 + 0.9j, 2.9 + 0.4j
# Joints in the order of the graph, nullity, and whether the sides are in the bound of kites.
PLANTED = {
    "kite, far": ("four-bar", [0j, SHORT, mirrored(0j, SHORT, LONG - SHORT), LONG], 5),
    "kite, near": ("four-bar", [0j, B, mirrored(0j, B, C - B), C], 5),
    "antiparallelogram": ("four-bar", [A, B, C, mirrored(A + C - B, A, C - A)], 5),
    "parallelogram": ("four-bar", [A, B, C, A + C - B], 7),
    "slider-crank": ("slider-crank", [A, B, 2.6 + 0j, 2.6 + 0j], 6),
}


def family_of(name):
    """The family of a planted geometry, with its arrays and its joints."""
    graph, corners, nullity = PLANTED[name]
    graph = topology(graph)
    structure, geometry = lanes_of(graph, np.array([corners]))
    (family,) = group_members(graph, structure, 4, [(0, geometry, nullity, 2, 0.0)])
    return structure, family, corners


def with_relations(family, relations, texts):
    """The family with other relations."""
    first = replace(family.members[0], relations=tuple(relations))
    return replace(family, relations=tuple(texts), members=(first,))


@pytest.mark.parametrize(
    "name",
    [
        each if each == "kite, far" else pytest.param(each, marks=pytest.mark.slow)
        for each in PLANTED
    ],
)
def test_relations_are_enough_and_needed(name):
    structure, family, corners = family_of(name)
    answer = decide_exactly(structure, family)
    assert (answer.enough, answer.needed, answer.reason) == (True, True, "")
    linkage = to_linkage(family.topology, structure, family.members[0].geometry)
    verdict = balance.masses.feasible(balance.design_space(linkage)).verdict
    pytest.importorskip("sympy")
    if " > 2 " not in answer.buildable:
        expected = {"feasible": "for all lengths", "infeasible": "for no lengths"}
        assert answer.buildable == expected[verdict]
        return
    # The bound in words, evaluated at the joints.
    long, short = answer.buildable.removeprefix("where ").replace(" 2 ", " ").split(" > ")
    first, second = (
        abs(corners["ABCD".index(pair[0])] - corners["ABCD".index(pair[1])])
        for pair in (long, short)
    )
    assert long.endswith("^2") and short.endswith("^2")
    assert (first**2 > 2 * second**2) == (verdict == "feasible")


@pytest.mark.slow
def test_half_of_the_relations_is_not_enough():
    structure, family, _ = family_of("kite, far")
    half = with_relations(family, family.members[0].relations[:1], family.relations[:1])
    answer = decide_exactly(structure, half)
    assert (answer.enough, answer.needed) == (False, False)


@pytest.mark.slow
def test_a_relation_too_many_is_not_needed():
    """A rhombus moves as a parallelogram, whose conditions need two equal lengths alone."""
    graph = topology("four-bar")
    corners = np.array([[0j, 1 + 0j, 1.6 + 0.8j, 0.6 + 0.8j]])
    structure, geometry = lanes_of(graph, corners)
    (family,) = group_members(graph, structure, 4, [(0, geometry, 7, 3, 0.0)])
    every = {each.text(quantities_of(graph)): each for each in family.members[0].held}
    for texts, needed in (
        (["AD = BC", "AB = CD", "AB = BC"], False),
        (["AD = BC", "AB = CD"], True),
    ):
        given = with_relations(family, [every[text] for text in texts], texts)
        answer = decide_exactly(structure, given)
        assert answer.enough and answer.needed == needed


def ternaries(name, nullity):
    """A family of Stephenson III linkages: equal angles, and products of lengths."""
    graph = topology("stephenson3")
    structure, geometry = lanes_of(graph, planted_corners(name, 1, 5))
    (family,) = group_members(graph, structure, 7, [(0, geometry, nullity, 4, 0.0)])
    assert {each.kind for each in family.members[0].relations} == {"same angle", "product"}
    return structure, family


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "nullity"), [("similar ternaries", 8), ("parallel ternaries", 10)]
)
def test_angles_and_products_are_enough_and_needed(name, nullity):
    structure, family = ternaries(name, nullity)
    answer = decide_exactly(structure, family)
    assert (answer.enough, answer.needed, answer.reason) == (True, True, "")


@pytest.mark.slow
def test_one_angle_of_two_is_not_enough():
    structure, family = ternaries("similar ternaries", 8)
    _, *others = family.members[0].relations
    short = with_relations(family, others, family.relations[1:])
    answer = decide_exactly(structure, short)
    assert (answer.enough, answer.needed) == (False, False)


def test_drawn_dimensions_fulfil_the_relations():
    """By tangents of angles and squares of lengths, written again for x and y of the joints."""
    structure, family = ternaries("similar ternaries", 8)
    linkage = to_linkage(family.topology, structure, family.members[0].geometry)
    parts = problem_of(balance.design_space(linkage), force=False).parts
    quantities = quantities_of(family.topology)
    relations = family.members[0].relations
    conditions = [condition_of(each, quantities, parts) for each in relations]
    related, p = RelatedDimensions(parts, conditions), PRIMES_OF_61_BITS[1]
    values = related.pairs(related.draw(p, random.Random(3)), p)
    spot = {}
    for number, part in enumerate(parts.parts):
        for joint, dimension in part.points.items():
            x, y = (0, 0) if dimension is None else values[dimension]
            # x + i y and x - i y are independent in the field.
            half = pow(2, -1, p)
            spot[parts.joints[joint].name, number] = (x + y) * half % p, (x - y) * half % p

    def way(a, b):
        part = next(n for n in range(len(parts.parts)) if {(a, n), (b, n)} <= set(spot))
        (x, u), (y, v) = spot[a, part], spot[b, part]
        return y - x, v - u

    def length(pair):
        x, u = way(*pair)
        return x * x - u * u

    def tangent(at, first, second):
        (x, u), (y, v) = way(at, first), way(at, second)
        return (x * v - u * y) * pow(x * y - u * v, -1, p)

    assert (tangent("A", "D", "G") - tangent("B", "C", "E")) % p == 0
    assert (tangent("A", "D", "G") - tangent("C", "B", "E")) % p != 0
    assert (tangent("D", "A", "G") - tangent("C", "B", "E")) % p == 0
    texts = [text for text in family.relations if "·" in text]
    assert len(texts) == 2
    for text in texts:
        left, right = (side.strip().split("·") for side in text.split("="))
        products = [prod(map(length, side)) for side in (left, right)]
        assert (products[0] - products[1]) % p == 0


def test_what_formulas_do_not_know_has_a_reason():
    """Equal slopes and constants of two loops bind the same dimensions."""
    graph = topology("watt2")
    structure, geometry = lanes_of(graph, watt_with_equal_corners()[None])
    (family,) = group_members(graph, structure, 7, [(0, geometry, 8, 3, 0.0)])
    assert family.complete
    answer = decide_exactly(structure, family)
    assert not answer.enough and "one after the other" in answer.reason


def watt_with_equal_corners():
    """Two four-bars at D, of which the opposite corners B and F turn alike."""
    A, B, C, D = 0.0, 0.4 + 1.1j, 2.2 + 1.5j, 2.6 + 0j
    a, b, c, d = abs(B - A), abs(C - B), abs(D - C), abs(A - D)
    g, h, turn = 0.9, 1.9, np.exp(0.8j)
    # e f = P and e² + f² = S have the slope and the constant of the other loop.
    P = g * h * a * b / (c * d)
    S = g * g + h * h + P * (a * a + b * b - c * c - d * d) / (a * b)
    e, f = (np.sqrt(S + 2 * P) + sign * np.sqrt(S - 2 * P) for sign in (1, -1))
    E, G = D + g * (C - D) / c * turn, D + h * (A - D) / d * turn
    r = abs(G - E)
    x = (r * r + (e * e - f * f) / 4) / (2 * r)
    F = E + (x + 1j * np.sqrt(e * e / 4 - x * x)) * (G - E) / r
    return np.array([A, B, C, D, E, F, G])
