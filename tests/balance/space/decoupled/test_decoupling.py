"""Decoupling by order agrees with the inertia on the base at finite poses of the gallery.

The second route is that of `tests/independent/reference.py`: clouds of points on bodies.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from balance.masses import feasible
from balance.momentum import momentum_regressor
from balance.space import decoupling, locked_inertia
from balance.space.decoupled.locked_inertia import locked_parameters
from kinematics.errors import UsageError
from tests.independent.reference import (
    decoupling_rows,
    follow,
    load,
    motion_basis,
    rank_over_poses,
    ranks_by_order,
    velocities,
)
from tests.support.covering import number_of_cases, spread
from tests.support.figures import BALANCED, FIGURES
from tests.support.laws import altered, known, placed, resized, space, space_of

ROWS = [figure for figure in FIGURES if figure.balance == "dynamic"]
BY_NAME = {str(figure): figure for figure in ROWS}
# Linkages whose ranks at other sizes, places and directions are computed: of every kind.
KINDS = [
    "four_bar_kite",
    "slider_crank",
    "slider_pantograph",
    "two_rrr_bisector",
    "bennett-spatial",
    "three_rsr_rational-spatial-u2=u3",
    "hprs-spatial",
    "four_bar_general-spatial",
]
CHOSEN = KINDS[: number_of_cases(4, len(KINDS))]


@cache
def found(figure):
    """The decoupling of a row of the table."""
    return decoupling(known(figure))


def ranks(answer):
    return [order.rank for order in answer.orders]


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", spread(ROWS, 4, 0), ids=str)
def test_finite_poses_have_the_same_rank(figure):
    """Fifty poses: momentum, and the change of the inertia on the base, by parameter."""
    decision = rank_over_poses(
        load(figure.model),
        figure.motion,
        spatial=figure.spatial,
        poses=50,
        reach=figure.reach,
        rows=decoupling_rows,
    )
    answer = found(figure)
    assert decision.rank == answer.rank
    assert decision.kept > 1e-9 and decision.dropped < 1e-13
    assert answer.rank + answer.nullity == figure.parameters
    assert answer.freed.level in ("proved", "verified")


@pytest.mark.table(1)
@pytest.mark.parametrize("figure", spread(ROWS, 5, 0), ids=str)
def test_derivatives_have_the_same_rank_order_by_order(figure):
    answer = found(figure)
    decisions = ranks_by_order(
        load(figure.model),
        answer.kmax + 1,
        figure.motion,
        spatial=figure.spatial,
        radius=figure.radius,
        samples=figure.samples,
        rows=decoupling_rows,
    )
    assert [decision.rank for decision in decisions] == [*ranks(answer), answer.rank]


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", ROWS, ids=str)
def test_the_masses_of_the_file_keep_the_inertia_constant_or_not(figure):
    """Balanced masses are decoupled if and only if M is the same at fifty finite poses."""
    linkage, answer = kinematics.load(figure.model), found(figure)
    if str(figure) not in BALANCED:
        # At a symmetric pose order 0 may hold all the same.
        assert not answer.exact and answer.order in (None, 0)
        assert answer.words == "no: not balanced"
        return
    basis = np.eye(linkage.mobility) if not figure.motion else answer.space.motion.basis
    rng = np.random.default_rng(7)
    inputs = rng.uniform(-0.2, 0.2, (50, basis.shape[1])) @ basis.T
    here = locked_parameters(linkage, np.zeros(linkage.mobility))
    there = [locked_parameters(linkage, u) for u in inputs]
    kept = list(range(10)) if figure.spatial else [0, 1, 2, 6]
    change = np.abs(np.array(there) - here)[:, kept].max() / np.abs(here).max()
    assert answer.exact == (change < 1e-12)
    assert answer.exact or change > 1e-3
    assert answer.order == (answer.kmax if answer.exact else 0)


@pytest.mark.parametrize("name", CHOSEN)
def test_the_size_does_not_matter(name, tmp_path):
    figure = BY_NAME[name]
    for factor in (1e-6, 1e6):
        other = space(figure, altered(figure.model, tmp_path, resized(factor)))
        assert ranks(decoupling(other)) == ranks(found(figure))


@pytest.mark.parametrize("name", CHOSEN)
def test_place_and_direction_do_not_matter(name, tmp_path):
    figure = BY_NAME[name]
    away, *turned = np.tile(np.eye(4), (3, 1, 1))
    away[:3, 3] = 1000.0 * known(figure).length * np.array([2.0, -3.0, 6.0]) / 7.0
    for H, R in zip(turned, Rotation.random(2, random_state=51).as_matrix(), strict=True):
        H[:3, :3] = R
    for H in (away, *turned):
        other = decoupling(space(figure, altered(figure.model, tmp_path, placed(H))))
        same = found(figure)
        assert (ranks(other), other.serial_nullity) == (ranks(same), same.serial_nullity)


@pytest.mark.parametrize("name", ["four_bar_kite", "bennett-spatial", "hprs-spatial"])
def test_every_distribution_of_the_basis_is_decoupled(name):
    """No momentum, and the same inertia, at a finite pose: by the second route."""
    figure = BY_NAME[name]
    mechanism, answer = load(figure.model), found(figure)
    u = motion_basis(mechanism, figure.motion) @ np.full(answer.space.chain.width, 0.17)
    q = follow(mechanism, np.zeros(len(mechanism.joints)), u)
    rows = decoupling_rows(
        mechanism, q, velocities(mechanism, q, np.eye(len(u))), spatial=figure.spatial
    )
    assert np.abs(rows @ answer.basis).max() < 1e-11 * np.abs(answer.basis).max()
    assert np.linalg.matrix_rank(answer.basis) == answer.nullity


def test_the_locked_inertia_is_that_of_a_textbook():
    """Two point masses of 1 kg at q and -q: 2 q², and 2 kg."""
    for q in (2.0, 1.5, 1.1):
        M = locked_inertia("slider_pantograph", {"q": q - 2.0})
        assert pytest.approx(np.diag([2 * q * q, 2.0, 2.0]), abs=1e-12) == M
    M = locked_inertia("slider_pantograph", {"q": 0.0}, spatial=True)
    assert pytest.approx(np.diag([0.0, 8.0, 8.0, 2.0, 2.0, 2.0]), abs=1e-12) == M


def test_orders_stop_where_they_are_asked_to():
    answer = decoupling(design_space("slider_pantograph", max_order=1))
    assert ranks(answer) == [3, 6]
    assert answer.words.endswith("changes at order 1")


def test_a_motion_without_text_is_followed():
    given = known(BY_NAME["three_rsr_rational-spatial-u2=u3"])
    plain = kinematics.Motion(given.motion.inputs, (), given.motion.basis)
    again = design_space(given.linkage, plain)
    assert ranks(decoupling(again)) == ranks(decoupling(given))


def test_force_balance_is_refused():
    with pytest.raises(UsageError, match="dynamic balance"):
        decoupling(design_space("five_bar", balance="force"))


def test_a_decoupled_design_keeps_the_inertia(tmp_path):
    """Of a slider-crank with l1 = l2: some balanced masses are decoupled, not all."""
    balanced = certify(space_of(BY_NAME["slider_crank"], kinematics.load("slider_crank")))
    answer = decoupling(balanced)
    assert (balanced.nullity, answer.nullity) == (6, 5)
    best = feasible(answer.decoupled_space)
    assert best.verdict == "feasible"
    bodies = [
        replace(b, inertia=z) for b, z in zip(balanced.linkage.bodies, best.z, strict=True)
    ]
    linkage = replace(balanced.linkage, bodies=tuple(bodies))
    M = [locked_inertia(linkage, {"u1": u}) for u in (0.0, 0.4, -0.5)]
    assert np.abs(M[1] - M[0]).max() < 1e-12 * np.abs(M[0]).max()
    assert np.abs(M[2] - M[0]).max() < 1e-12 * np.abs(M[0]).max()
    assert decoupling(design_space(linkage)).exact


# --- [J] section 2.4 -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["four_bar_kite", "four_bar_antiparallelogram"])
def test_every_balanced_four_bar_of_two_kinds_is_decoupled(name):
    """The space of decoupled distributions is that of balanced ones; so for the files."""
    answer = found(BY_NAME[name])
    assert (answer.nullity, answer.space.nullity) == (5, 5)
    assert decoupling(design_space(f"{name}_balanced")).exact


def test_the_slider_pantograph_is_balanced_and_not_decoupled():
    answer = found(BY_NAME["slider_pantograph"])
    assert answer.space.as_given.balanced
    assert (answer.exact, answer.order) == (False, 0)
    assert answer.words == "no: balanced, but the inertia on the base changes at order 1"


def test_a_cycle_of_the_pantograph_turns_the_reaction_wheel():
    """[J] Eq. 2.52: q from 2 m to 1 m, half a turn, and both back turn the wheel by 6π/5."""
    linkage = kinematics.load("pantograph_reaction_wheel")
    z = np.array([body.inertia for body in linkage.bodies])[:, [0, 1, 2, 6]].ravel()

    def wheel_rate(q):
        """Turns of the wheel for one of the turntable, without momentum."""
        X = momentum_regressor(linkage, {"q": q - 2.0}) @ z
        h = dict(zip(linkage.inputs, X, strict=True))
        assert np.abs(h["q"]).max() < 1e-14 and np.abs(X[:, 1:]).max() < 1e-14
        return -h["turn"][0] / h["wheel_axis"][0]

    change = wheel_rate(1.0) * np.pi - wheel_rate(2.0) * np.pi
    m, gc, q, dq, dq2 = 1.0, 5.0, 2.0, -1.0, np.pi
    assert change == pytest.approx(-2 * m / gc * (2 * q + dq) * dq * dq2, abs=1e-13)
    assert change == pytest.approx(1.2 * np.pi, abs=1e-13)
