"""Sizes of dyads that a search finds, against restarts and a grid."""

from __future__ import annotations

import numpy as np

from balance.masses.remedies.dyads.dyad_sizes import best_size

TURN = 2.0 * np.pi


def check_least_size(seed, mass_of, least, random):
    """Check that 20 random starts agree within 5 %, and nothing on a grid is much lighter."""
    starts = np.random.default_rng(random).uniform(0.0, TURN, 20)
    masses = [best_size(seed, mass_of, start).mass for start in starts]
    np.testing.assert_allclose(masses, least, rtol=0.05)
    grid = [
        mass_of(seed.resized(size, angle))
        for size in (0.5, 0.8, 1.0)
        for angle in np.linspace(0.0, TURN, 12, endpoint=False)
    ]
    assert min(grid) > 0.99 * least
