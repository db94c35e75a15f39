"""Balanced four-bars through positions, by their lengths and by Pinocchio."""

from __future__ import annotations

import math

import numpy as np
import pytest

from balance import verify
from balance.studies.synthesis.four_bar_masses import balanced_masses, bare_space, four_bar_urdf
from balance.studies.synthesis.four_bars import FOUR_BARS, four_bars_through, place_four_bar
from balance.studies.synthesis.positions import Position, displacements
from kinematics import load
from kinematics.errors import SynthesisError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases


def space_of(four_bar):
    """Design space of the file of a four-bar."""
    return bare_space("four-bar", four_bar_urdf(four_bar))


def random_positions(rng, count):
    angles = np.cumsum(rng.uniform(0.1, 0.4, count)) * rng.choice([-1.0, 1.0])
    return tuple(Position(*rng.uniform(-0.5, 0.5, 2), float(a)) for a in angles)


@pytest.mark.parametrize("kind", FOUR_BARS)
def test_lengths_stay(kind):
    """Crank and rocker of both kinds, and that nothing is a parallelogram."""
    alpha = np.linspace(0.1, 3.0, 30)
    A, B = place_four_bar(kind, 2.5, alpha)
    lengths = [abs(A), abs(B - A), abs(B - 2.5)]
    wanted = (1.0, 1.0, 2.5) if kind == "kite" else (1.0, 2.5, 1.0)
    for length, right in zip(lengths, wanted, strict=True):
        assert np.allclose(length, right, atol=1e-14)
    assert np.ptp(np.angle(B - A)) > 0.3


@pytest.mark.table(1)
@pytest.mark.parametrize("kind", FOUR_BARS)
def test_random_positions_are_met_and_confirmed(kind):
    """The coupler by its four pivots at every position; masses by the core and Pinocchio."""
    rng = np.random.default_rng(5)
    for k in range(number_of_cases(2, 20)):
        places = random_positions(rng, 2 + k % 2)
        pivot = complex(*rng.uniform(-0.5, 0.5, 2)) if len(places) == 2 else None
        designs = four_bars_through(places, kind, moving=pivot)
        assert designs
        for one in designs[:20]:
            start = one.pivots()
            if pivot is not None:
                assert start["crank_tip"] == pytest.approx(pivot, abs=1e-12)
            for index, step in enumerate(displacements(places), 1):
                now = one.pivots(index)
                for name in ("crank_tip", "rocker_tip"):
                    assert step.move(start[name]) == pytest.approx(now[name], abs=1e-9)
                for name in ("crank", "rocker"):
                    base, tip = f"{name}_base", f"{name}_tip"
                    assert now[base] == pytest.approx(start[base], abs=1e-9)
                    assert abs(now[tip] - now[base]) == pytest.approx(
                        abs(start[tip] - start[base]), abs=1e-9
                    )
            assert one.error < 1e-9
            signs = {math.copysign(1.0, angle) for angle in one.crank_angles}
            assert len(signs) == 1 and max(map(abs, one.crank_angles)) < math.pi
        files = (
            balanced_masses(bare_space("four-bar", four_bar_urdf(one)), None)[0]
            for one in designs
        )
        written = next(filter(None, files))
        checked = verify(load(Document("four-bar", written)), trajectories=1)
        assert checked.balanced and checked.moment_residual < 1e-10


def test_short_bases_do_not_balance(monkeypatch):
    """Below √2 times the crank there are no masses."""
    from balance.studies.synthesis import four_bars

    monkeypatch.setattr(four_bars, "RATIOS", (1.3,))
    places = (Position(0, 0, 0), Position(0.2, 0.1, 0.3))
    one = four_bars_through(places, "kite", fixed=0.3j)[0]
    assert balanced_masses(space_of(one), None)[0] is None


@pytest.mark.parametrize(
    ("places", "pivot", "said"),
    [
        ([(0, 0, 0), (1, 0, 0)], 0.3j, "no pole"),
        ([(1, 0, 0), (math.cos(1), math.sin(1), 1)], 0j, "is the pole"),
        (
            [(1, 0, 0), (math.cos(1), math.sin(1), 1), (math.cos(2), math.sin(2), 2)],
            None,
            "one pole",
        ),
    ],
)
def test_positions_without_a_four_bar_are_refused(places, pivot, said):
    with pytest.raises(SynthesisError, match=said):
        four_bars_through([Position(*each) for each in places], "kite", fixed=pivot)


def test_a_coupler_that_turns_too_far_has_no_antiparallelogram():
    """Its coupler turns by less than twice the arcsine of crank over base, a right angle."""
    places = (Position(0, 0, 0), Position(0.2, 0.1, 2.0))
    assert four_bars_through(places, "antiparallelogram", fixed=0.3j) == ()
    assert four_bars_through(places, "kite", fixed=0.3j)
