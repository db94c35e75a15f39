"""Relations of planted families in exact arithmetic; masses against a cone program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import balance
import balance.masses
from balance.studies.discovery.exact_families import decide_exactly
from balance.studies.discovery.families import group_members
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import topology
from tests.support.planted import lanes_of, mirrored, similar_ternaries

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


def test_what_formulas_do_not_know_has_a_reason():
    graph = topology("stephenson3")
    corners = similar_ternaries(np.random.default_rng(2), parallel=True)
    structure, geometry = lanes_of(graph, corners[None])
    (family,) = group_members(graph, structure, 7, [(0, geometry, 10, 4, 0.0)])
    answer = decide_exactly(structure, family)
    assert not answer.enough and "no relations of the kind" in answer.reason
