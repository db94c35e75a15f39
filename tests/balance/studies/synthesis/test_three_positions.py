"""Nonlinear pantographs through three positions, beside numerical integration."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from balance.studies.synthesis.balanced_pantograph import pantograph_urdf
from balance.studies.synthesis.confirm import confirm_along
from balance.studies.synthesis.constrained_motion import constrained_motion, list_defects
from balance.studies.synthesis.pantograph import default_masses
from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.synthesize import through_three_positions
from balance.studies.synthesis.three_positions import circle_centres, default_window
from tests.support.covering import number_of_cases
from tests.support.pantographs import integrated, random_triple


@pytest.mark.slow
def test_random_triples_are_met():
    """Twenty solvable triples: a design that is found meets them to 1e-9, by integration."""
    good = 0
    for seed in range(20):
        places, masses, fixed, moving = random_triple(seed)
        designs, found = through_three_positions(places, masses, default_window(places))
        nearest = min(designs, key=lambda each: abs(each.chain.moving - moving))
        assert abs(nearest.chain.moving - moving) < 1e-9
        assert abs(nearest.chain.fixed - fixed) < 1e-8
        for design in designs:
            chain = design.chain
            assert chain.error < 1e-9
            if any(defect.kind == "reversal" for defect in list_defects(design)):
                continue
            good += 1
            for beta, turn in zip(chain.link_turns[1:], chain.tool_turns[1:], strict=True):
                other = integrated(design.inertias, design.opening, beta)
                assert other == pytest.approx(turn, abs=1e-9)
    assert good >= 20


@pytest.mark.slow
def test_random_triples_are_confirmed_by_the_core():
    """The written file follows its motion without momentum, by Pinocchio."""
    confirmed = 0
    for seed in range(number_of_cases(2, 50)):
        places, masses, _, _ = random_triple(seed)
        for design in through_three_positions(places, masses, default_window(places))[0]:
            if not list_defects(design):
                found = confirm_along(pantograph_urdf(design), constrained_motion(design))
                assert found.confirmed and found.momentum < 1e-10, (seed, found)
                confirmed += 1
    assert confirmed >= number_of_cases(2, 50)


def test_triples_without_a_design_say_so():
    """The tool turns back and forth: a motion without momentum turns it one way only."""
    masses = replace(default_masses(1.0, 0.5), m6=0.1)
    for turn in (0.3, 0.6):
        places = [Position(0, 0, 0), Position(0.2, 0.1, turn), Position(0.3, 0.4, 1e-3)]
        designs, found = through_three_positions(places, masses, default_window(places))
        assert designs == () and not len(found.moving)


def test_centres_are_as_far_from_three_points():
    places = [Position(0, 0, 0), Position(0.2, 0.1, 0.4), Position(0.3, 0.4, 1.0)]
    steps = displacements(places)
    W = np.array([0.3 + 0.1j, -0.2j])
    G = circle_centres(W, steps)
    for step in steps:
        assert np.allclose(abs(step.move(W) - G), abs(W - G), atol=1e-13)
    assert math.isfinite(abs(G).max())
