"""Added dyads: known geometries, walks to related angles, and what is judged and refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.remedies.dyads.added_dyad import (
    apply_added_dyad,
    buildable_space,
    walks_from_random,
)
from balance.masses.remedies.dyads.dyad_geometry import Dyad, convert_numbers, dyad_document
from balance.masses.remedies.dyads.dyad_search import AngleRelations, walk
from balance.masses.remedies.dyads.known_dyads import dyad_seeds, hinges_of, sides_of
from balance.masses.remedies.request import RemedyRequest
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.general_four_bars import general_four_bars
from balance.studies.synthesis.positions import Position
from kinematics import ScrewJoint, from_screws
from kinematics.model.arrays import Frame
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document

# Hinges on the crank, the rocker and the ground, in metres; that at the origin is the first.
GAINS = 0.1 + 0.43j, -0.5 + 0.75j, 1.0 + 0.0j
# Far from a dead centre, where series of the angles converge slowly.
WELL_PLACED = 0.2 + 0.5j, 0.8 + 0.9j, 1.0 + 0.0j
NO_GAIN = 0.1 + 0.35j, 1.5 + 1.9j, 1.0 + 0.0j


def four_bar(a: complex, b: complex, d: complex):
    """A four-bar with hinges at 0 and d on the ground, and rods of 1 kg."""
    points = [(point.real, point.imag, 0.0) for point in (a, b, d)]
    joints = [
        ScrewJoint("u1", "base", "crank"),
        ScrewJoint("q2", "crank", "coupler", point=points[0]),
        ScrewJoint("q4", "base", "rocker", point=points[2]),
    ]
    loop = ScrewJoint("q3", "coupler", "rocker", point=points[1])
    ends = {"crank": (0, a), "coupler": (a, b), "rocker": (b, d)}
    E = np.diag([1e-3, 1e-3, 1e-2])
    bodies = {
        name: (1.0, [((p + q) / 2).real, ((p + q) / 2).imag, 0.0], E)
        for name, (p, q) in ends.items()
    }
    return from_screws(joints, [loop], bodies, ["u1"], name="four_bar")


def with_dyad(linkage, dyad, numbers):
    request = RemedyRequest(linkage)
    document, _, _ = dyad_document(request.base, dyad, numbers, linkage.chain.frame)
    return kinematics.load(document, None, linkage.inputs, bodies="all")


def relations_of(linkage, dyad, numbers):
    """The angular rates of a linkage with a dyad, and the numbers in its frame."""
    whole = with_dyad(linkage, dyad, numbers)
    names = [whole.joints[j].name for j in whole.chain.joints]
    new = [k for k, name in enumerate(names) if name.startswith("dyad")]
    own = convert_numbers(dyad, numbers, linkage.chain.frame, whole.chain.frame)
    assert whole.bodies[-1].name == "dyad_2"
    turning = np.arange(len(whole.bodies) - dyad.slides)
    return AngleRelations(whole.chain, dyad, np.array(new), turning).at_scale(own), own


@pytest.mark.parametrize(
    "words", ["the loop repeated, reflected", "a crank-slider of equal lengths"]
)
def test_the_gradient_is_that_of_the_smallest_singular_value(words):
    """The chain rule against central differences of σ², away from its zeros."""
    linkage = four_bar(*GAINS)
    seed = next(one for one in dyad_seeds(linkage) if one.words == words)
    rng = np.random.default_rng(0)
    moved = seed.numbers + 0.3 * rng.standard_normal(seed.numbers.size)
    relations, numbers = relations_of(linkage, seed.dyad, moved)
    sigma, J = relations.smallest(numbers)
    step = 1e-5
    slopes = [
        (relations.smallest(numbers + h)[0] ** 2 - relations.smallest(numbers - h)[0] ** 2)
        / (2 * step)
        for h in step * np.eye(numbers.size)
    ]
    assert sigma > 1e-6
    found = relations.gradient(numbers, J)
    np.testing.assert_allclose(found, slopes, atol=1e-4 * np.abs(slopes).max())


def rates_of(linkage) -> dict[str, float]:
    """Angular rates of the links for a unit rate of the input."""
    X = balance.momentum.momentum_regressor(linkage, {"u1": 0.2}).reshape(3, -1)
    return {body.name: X[0, 4 * k + 3] for k, body in enumerate(linkage.bodies)}


@pytest.mark.parametrize("linkage", [GAINS, NO_GAIN])
def test_a_repeated_loop_has_two_relations_between_angles(linkage):
    """Against the ground, the crank turns by the sum of a link and the link that repeats it."""
    linkage = four_bar(*linkage)
    seeds = [one for one in dyad_seeds(linkage) if "repeated" in one.words]
    seed = next(one for one in seeds if {s.name for s in one.dyad.sides} == {"base", "crank"})
    rate = rates_of(with_dyad(linkage, seed.dyad, seed.numbers))
    # The first link of the dyad repeats the coupler if it is hinged to the ground.
    on_ground = seed.dyad.sides[0].name == "base"
    coupler, rocker = ("dyad_1", "dyad_2") if on_ground else ("dyad_2", "dyad_1")
    assert abs(rate["coupler"] + rate[coupler] - rate["crank"]) < 1e-12
    assert abs(rate["rocker"] + rate[rocker] - rate["crank"]) < 1e-12
    space = balance.design_space(with_dyad(linkage, seed.dyad, seed.numbers))
    assert (space.nullity, space.parallel.shape[1]) == (9, 2)


@pytest.mark.slow
def test_a_four_bar_without_a_balanced_loop_gains_by_a_dyad():
    """The file is read again, and Pinocchio and exact arithmetic confirm it."""
    linkage = four_bar(*GAINS)
    assert balance.masses.feasible(balance.design_space(linkage)).verdict == "infeasible"
    found = next(iter(apply_added_dyad(RemedyRequest(linkage))))
    assert found.verdict == "feasible" and found.residual < 1e-9
    again = kinematics.load(Document("gain.urdf", found.urdf))
    assert (len(again.bodies), again.mobility, len(again.loops)) == (5, 1, 2)
    checked = balance.verify(again, trajectories=2, seed=7)
    assert max(checked.force_residual, checked.moment_residual) < 1e-9
    space = balance.certify(balance.design_space(again))
    assert space.certainty.level in ("proved", "verified") and space.as_given.balanced


def test_a_walk_returns_to_related_angles():
    """From 0.01 of the size beside a repeated loop, walks end on geometries of lower rank."""
    linkage = four_bar(*WELL_PLACED)
    seed = next(iter(dyad_seeds(linkage)))
    rng = np.random.default_rng(1)
    ended = []
    for _ in range(4):
        moved = seed.numbers + 0.01 * rng.standard_normal(6)
        relations, numbers = relations_of(linkage, seed.dyad, moved)
        ended.append((walk(relations, numbers), relations))
    related = [(one, relations) for one, relations in ended if one.related]
    assert len(related) >= 3
    for one, relations in related:
        assert relations.smallest(one.numbers)[0] < 1e-10
        back = convert_numbers(
            seed.dyad, one.numbers, relations.chain.frame, linkage.chain.frame
        )
        whole = with_dyad(linkage, seed.dyad, back)
        assert balance.design_space(whole).nullity > 7


@pytest.mark.slow
def test_walks_from_random_dyads_are_the_same_each_time():
    request = RemedyRequest(four_bar(*GAINS))
    first, second = (
        [one.numbers for one, _ in walks_from_random(request, True, 2)] for _ in "ab"
    )
    np.testing.assert_array_equal(first, second)


def test_a_dyad_that_is_no_part_of_the_solution_is_not_buildable():
    request = RemedyRequest(four_bar(*GAINS))
    sides = sides_of(request.linkage)
    rocker = next(one for one in sides.values() if one.name == "rocker")
    moved = np.random.default_rng(3).standard_normal(6)
    seed = next(iter(dyad_seeds(request.linkage)))
    other = replace(seed, dyad=Dyad((sides[-1], rocker), False), numbers=moved)
    assert buildable_space(request, other) is None


def test_numbers_are_converted_between_frames():
    """There and back, with a turned frame of another size."""
    c, s = np.cos(0.4), np.sin(0.4)
    given = Frame(np.eye(3), np.array([0.1, 0.2, 0.0]), 0.7)
    wanted = Frame(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), np.array([1.0, 0, 0]), 2.0)
    sides = tuple(sides_of(four_bar(*GAINS)).values())[:2]
    for slides in (False, True):
        dyad = Dyad(sides, slides)
        numbers = np.array([0.3, -0.2, 0.5, 0.9, 1.1, 0.4])[: dyad.size]
        there = convert_numbers(dyad, numbers, given, wanted)
        assert np.abs(there - numbers).max() > 0.1
        np.testing.assert_allclose(convert_numbers(dyad, there, wanted, given), numbers)
    assert there[4] == pytest.approx(numbers[4] - 0.4)


def test_hinges_know_their_links():
    linkage = four_bar(*GAINS)
    pairs = sorted(tuple(sorted(hinge.links)) for hinge in hinges_of(linkage))
    assert len(pairs) == 4 and [pair[0] for pair in pairs].count(-1) == 2


def test_linkages_for_which_no_dyad_is_searched_are_refused():
    spatial = RemedyRequest(kinematics.load("bennett"))
    (one,) = apply_added_dyad(spatial)
    assert one.verdict == "refused" and "planar" in one.reason
    (one,) = apply_added_dyad(RemedyRequest(four_bar(*GAINS), balance="force"))
    assert one.verdict == "refused" and "force" in one.reason


@pytest.mark.slow
def test_digits_of_a_dyad_exclude_no_masses():
    """With lengths of 15 digits no relation is exact, but masses balance to the last of them.

    So a proof that no masses balance it would speak of the last digits alone.
    """
    places = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22)]
    design = general_four_bars([Position(*place) for place in places])[0]
    inertial = make_elements.inertial(0.3, 2e-3 * np.eye(3), make_elements.origin(np.eye(4)))
    urdf = four_bar_urdf(design, dict.fromkeys(("crank", "coupler", "rocker"), inertial))
    linkage = kinematics.load(Document("four_bar", urdf))
    of_points, of_steel = (
        balance.compare_remedies(linkage, only=["added_dyad"], density=density).results
        for density in (None, "steel")
    )
    assert [result.verdict for result in of_points].count("feasible") == 2
    assert {result.verdict for result in of_steel} <= {"feasible", "undecided"}
    assert not any("no masses whatever" in result.reason for result in of_steel)
