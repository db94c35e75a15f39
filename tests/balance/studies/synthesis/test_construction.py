"""The construction with ruler and compass, beside the equations."""

from __future__ import annotations

import numpy as np
import pytest

from balance.studies.synthesis.construction import construct_chain
from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.rr_chain import chain_from_fixed_pivot, chain_from_moving_pivot


@pytest.mark.parametrize("seed", range(10))
def test_the_construction_finds_the_pivots(seed):
    """[B] G. Becht, MSc thesis, TU Delft, 2020, section 3.2: for a chosen moving pivot the line
    is at β/2 to the bisector, not at π/2 - β.
    """
    rng = np.random.default_rng(seed)
    places = [Position(*rng.uniform(-1, 1, 2), rng.uniform(-1.4, 1.4)) for _ in range(2)]
    pivot, ratio = complex(*rng.uniform(-1, 1, 2)), -float(rng.uniform(0.2, 1.5))
    (step,) = displacements(places)
    for make, chosen in (
        (chain_from_fixed_pivot, "fixed"),
        (chain_from_moving_pivot, "moving"),
    ):
        chain = make(places, ratio, pivot)
        drawn = construct_chain(chain, chosen)
        size = 1.0 + abs(chain.fixed) + abs(chain.moving)
        assert abs(drawn.points["W1"] - chain.moving) < 1e-11 * size
        assert abs(drawn.points["W2"] - step.move(chain.moving)) < 1e-11 * size
        assert abs(drawn.points["G"] - chain.fixed) < 1e-11 * size
        for _, centre, radius in drawn.circles:
            assert abs(drawn.points["W2"] - centre) == pytest.approx(radius, rel=1e-9)
        if chosen == "fixed":
            assert abs(drawn.points["P12"] - step.pole) < 1e-11 * (1 + abs(step.pole))
        else:
            (_, _, bisector), (_, _, line) = drawn.lines
            half = abs(np.angle((line / bisector) ** 2)) / 2
            beta = abs(np.angle(np.exp(1j * chain.link_turns[1])))
            assert half == pytest.approx(beta / 2, abs=1e-12)
