"""Dyads at constant speed: momenta at finite poses, Pinocchio, and where there are none.

Poses and momenta come from the independent route (``tests/independent/reference.py``).
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import balance
from balance.masses.remedies.dyads.constant_speed_dyad import (
    KEY,
    apply_constant_speed_dyad,
    space_at_constant_speed,
)
from balance.masses.remedies.dyads.dyad_geometry import dyad_document
from balance.masses.remedies.dyads.dyad_sizes import LARGEST, LEAST, best_size, size_words
from balance.masses.remedies.dyads.known_dyads import DyadSeed, dyad_seeds
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.size_search import lightest_between
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.trajectory import random_motions
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.loading.model_gallery import as_linkage, load
from kinematics.model.document.element import Document
from tests.independent import reference
from tests.support.dyad_sizes import check_least_size
from tests.support.remedy_files import momentum

MODEL = "four_bar_general"
TURN = 2.0 * np.pi


def regressors(mechanism, count=24):
    """Momenta of unit parameters at a unit rate of the crank, over a turn (count, 6, n)."""
    q, rows = np.zeros(len(mechanism.joints)), []
    for u in np.arange(count) * TURN / count:
        q = reference.follow(mechanism, q, np.array([u]))
        rates = reference.velocities(mechanism, q, np.ones((1, 1)))
        rows.append(reference.regressor(mechanism, q, rates)[:6])
    return np.array(rows)


def test_one_dimension_more_than_balance_at_any_speed():
    """The null space of the momenta over a turn with an unknown constant moment."""
    linkage = as_linkage(MODEL)
    space = balance.design_space(linkage, spatial=True)
    steady = space_at_constant_speed(space, linkage.positions_of(["u1"])[0])
    X = regressors(reference.load(MODEL))
    constant = np.zeros((*X.shape[:2], 1))
    constant[:, 2] = -1.0
    rows = np.concatenate([X, constant], axis=2).reshape(-1, X.shape[2] + 1)
    sizes = np.linalg.svd(rows, compute_uv=False)
    assert rows.shape[1] - (sizes > 1e-9 * sizes[0]).sum() == steady.nullity
    assert steady.nullity == space.nullity + 1
    moments = X @ steady.basis
    assert np.ptp(moments[:, 2], axis=0).max() < 1e-9 * np.abs(X).max()
    assert np.abs(np.delete(moments, 2, axis=1)).max() < 1e-9 * np.abs(X).max()


@pytest.mark.parametrize(
    "words", ["the loop repeated, reflected", "its parallelogram, reflected"]
)
def test_equal_inertias_of_links_that_repeat_the_loop_have_a_constant_moment(words):
    """B_4 = B_2 and B_5 = B_3: the moment is that of B_1 + B_2 + B_3 on the crank."""
    request = RemedyRequest(as_linkage(MODEL))
    seed = next(
        seed
        for seed in dyad_seeds(request.linkage)
        if seed.words == words and {side.name for side in seed.dyad.sides} == {"base", "crank"}
    ).resized(0.7, 0.9)
    frame = request.linkage.chain.frame
    document, _, _ = dyad_document(request.base, seed.dyad, seed.numbers, frame)
    linkage = load(document, bodies="all")
    names = [body.name for body in linkage.bodies]
    ezz = 4 * np.arange(len(names)) + 3
    rates = np.array(
        [
            balance.momentum.momentum_regressor(linkage, {"u1": u}).reshape(3, -1)[0, ezz]
            for u in np.linspace(0.0, TURN, 12, endpoint=False)
        ]
    )
    turn = dict(zip(names, rates.T, strict=True))
    # The first link repeats the coupler if it is hinged to the ground; a parallelogram has its
    # sides in the other order.
    on_ground = seed.dyad.sides[0].name == "base"
    order = ("dyad_1", "dyad_2") if on_ground == ("loop" in words) else ("dyad_2", "dyad_1")
    B = {"crank": 0.3, "coupler": 0.7, "rocker": 1.9, order[0]: 0.7, order[1]: 1.9}
    total = sum(B[name] * turn[name] for name in names)
    np.testing.assert_allclose(total / turn["crank"], 0.3 + 0.7 + 1.9, rtol=1e-9)


def test_dyads_balance_a_four_bar_at_constant_speed():
    """No force at any pose of the file, and a moment that is the stated inertia's."""
    request = RemedyRequest(as_linkage(MODEL))
    results = list(apply_constant_speed_dyad(request))
    assert [applied.details["kind"] for applied in results] == ["RRR", "RRP"]
    for applied in results:
        assert (applied.verdict, applied.residual) == ("partial", 0.0)
        J = applied.details["inertia_left"]
        linkage = load(Document("dyad.urdf", applied.urdf), None, request.linkage.inputs)
        # Where the speed changes, the base holds the crank's moment, and no force.
        (motion,) = random_motions(linkage, 1, 12, seed=3)
        masses = np.array([body.inertia for body in linkage.bodies])
        wrench = PinocchioModel(linkage, masses).reactions(motion)
        np.testing.assert_allclose(
            np.abs(wrench[:, 2]), np.abs(J * motion.udd[:, 0]), atol=1e-7
        )
        assert np.abs(np.delete(wrench, 2, axis=1)).max() < 1e-7 * np.abs(wrench).max()
        # At constant speed: momenta by matrix exponentials, no force, and the moment of J.
        steady, _ = revolve_crank(linkage, 1.0, "u1", None, 12)
        parts = np.array(
            [momentum(linkage, q, qd) for q, qd in zip(steady.q, steady.qd, strict=True)]
        )
        size, total = np.abs(parts).sum(axis=1).max(), parts.sum(axis=1)
        assert np.abs(np.delete(total, 2, axis=1)).max() < 1e-9 * size
        np.testing.assert_allclose(total[:, 2], J, rtol=1e-9)
        # No dead point between the samples of the search.
        fine, _ = revolve_crank(linkage, 1.0, "u1", None, 500)
        assert fine.conditioning > 0.1
        mass = sum(body.inertia[0] for body in linkage.bodies)
        assert mass == pytest.approx(request.given_mass + applied.added_mass, rel=1e-9)


@pytest.mark.slow
def test_matter_alone_is_judged_where_it_is_enough():
    """A slider-crank whose masses suffice at constant speed has no dyad that is heavier."""
    (alone, *lighter) = apply_constant_speed_dyad(RemedyRequest(as_linkage("slider_crank")))
    assert alone.verdict == "partial" and "no dyad" in alone.words and not alone.new_links
    assert all(applied.added_mass < alone.added_mass for applied in lighter)


@pytest.mark.parametrize(
    ("model", "options", "why"),
    [
        ("five_bar", {}, "2 degrees of freedom"),
        ("bennett", {}, "planar"),
        (MODEL, {"balance": "force"}, "forces"),
        ("four_bar_antiparallelogram_balanced", {}, "shakes nothing"),
    ],
)
def test_where_a_dyad_at_constant_speed_is_no_remedy(model, options, why):
    (applied,) = apply_constant_speed_dyad(RemedyRequest(as_linkage(model), **options))
    assert applied.verdict == "refused" and why in applied.reason, applied


def seed_of_size_one() -> DyadSeed:
    return next(dyad_seeds(as_linkage(MODEL)))


@pytest.mark.parametrize(
    ("least", "direction", "size", "bound"),
    [(2.0, 1.0, LARGEST, "larger"), (0.1, -2.5, LEAST, "smaller"), (0.6, 3.0, 0.6, "")],
)
def test_a_size_is_found_wherever_it_is_least(least, direction, size, bound):
    """A mass of one least size and direction, behind a bound or between the bounds."""
    first = seed_of_size_one()
    base = first.numbers[:2] @ [1.0, 1j] - first.centre

    def mass_of(seed):
        c = (seed.numbers[:2] @ [1.0, 1j] - seed.centre) / base
        return 2.0 + np.log(abs(c) / least) ** 2 - np.cos(np.angle(c) - direction)

    sized = best_size(first, mass_of, first=0.3)
    assert sized.seed.size == pytest.approx(size, abs=0.02)
    assert np.cos(sized.turn - direction) > np.cos(np.radians(1.0))
    words = size_words(sized.seed, sized.beyond)
    assert (
        (f"(a bound: {bound} ones take less mass)" in words)
        == ("bound" in words)
        == bool(bound)
    )
    assert best_size(first, lambda _: np.inf) is None


@pytest.mark.slow
def test_sizes_of_twenty_random_starts_agree():
    """Within 5 %, and no size and direction of a grid is lighter than the best by more."""
    from balance.masses.remedies.dyads.constant_speed_dyad import _matter_with
    from balance.masses.remedies.shafts.crank_turn import turn_of_crank

    request = RemedyRequest(as_linkage(MODEL), only=(KEY,))
    turn = turn_of_crank(request)

    def mass_of(seed):
        matter = _matter_with(request, turn, seed)
        return np.inf if matter is None else matter.added_mass

    *_, applied = apply_constant_speed_dyad(request)
    assert applied.details["kind"] == "RRP"
    pair = tuple(applied.words.split(" between ")[1].split(":")[0].split(" and "))
    seed = next(
        seed
        for seed in dyad_seeds(request.linkage)
        if seed.dyad.slides and tuple(side.name for side in seed.dyad.sides) == pair
    )
    check_least_size(seed, mass_of, applied.added_mass, 4)


@pytest.mark.parametrize("least", [0.1, 0.3, 0.617, 0.9, 2.0])
def test_a_least_mass_is_found_between_its_bounds(least):
    """Also beside sizes without matter, and at a bound."""

    def mass_of(size):
        return np.log(size / least) ** 2 if size > 0.27 else np.inf

    size = lightest_between(mass_of, 0.25, 1.0)
    assert size == pytest.approx(min(max(least, 0.28), 1.0), abs=0.011)


@pytest.mark.slow
def test_the_last_bits_of_masses_and_places_decide_on_no_dyad_of_steel():
    """Two files that differ by round-off have the same dyads, of the same mass."""
    base, rng = RemedyRequest(as_linkage(MODEL)).base, np.random.default_rng(1)

    def near(number):
        return repr(float(number[0]) * (1.0 + 1e-15 * int(rng.integers(-2, 3))))

    def changed(attribute):
        return attribute[1] + re.sub(r"-?\d+(\.\d*)?(e[-+]?\d+)?", near, attribute[2])

    urdf = base.data.decode()
    text = re.sub(r'(\b(?:xyz|value|i[xyz]{2})=)("[^"]*")', changed, urdf)
    assert text != urdf
    results = []
    for each in (urdf, text):
        request = RemedyRequest(load(Document(base.name, each.encode())), density=7850.0)
        request.check()
        results.append(list(apply_constant_speed_dyad(request)))
    plain, bits = results
    assert [row.verdict for row in plain] == ["partial", "partial"]
    for row, near_row in zip(plain, bits, strict=True):
        assert (near_row.verdict, near_row.words) == (row.verdict, row.words)
        assert near_row.added_mass == pytest.approx(row.added_mass, rel=1e-6)
