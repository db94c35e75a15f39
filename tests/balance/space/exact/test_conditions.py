"""Ranks modulo a prime with fewer rows than there are: the same as with all of them."""

import numpy as np
import pytest

from balance.space.exact.chain import exact_chain
from balance.space.exact.conditions import ExactConditions
from balance.space.exact.modular import PRIMES, Echelon
from balance.space.exact.modular_series import SAMPLES, Momenta, chain_modulo
from kinematics import load
from kinematics.files.urdf.rational_screws import exact_geometry
from tests.support.modular_rows import conditions as all_conditions

MODELS = ("hprs", "four_rrr", "rusr", "five_bar")
ORDERS = 4


def chain_of(name):
    linkage = load(name)
    return exact_chain(linkage, exact_geometry(linkage))


def ranks_of_all_rows(chain, p, rays):
    """Ranks by order of all rows along rays, by an elimination of their own."""
    rows, _ = all_conditions(chain, rays, ORDERS - 1, p)
    ranks, echelon = [], Echelon(rows.shape[-1], p)
    for order in rows:
        echelon.absorb(order.reshape(-1, rows.shape[-1]))
        ranks.append(echelon.rank)
    return ranks


def extended(chain, p, likely=()):
    run = ExactConditions(chain_modulo(chain, p))
    for _ in range(ORDERS):
        run.extend(likely)
    return run


@pytest.mark.parametrize("name", MODELS)
def test_likely_rows_leave_the_ranks_as_they_are(name):
    """Those of another prime, half of them, rows that depend on each other, or of orders."""
    chain = chain_of(name)
    plain, other = extended(chain, PRIMES[0]), extended(chain, PRIMES[1])
    rays = np.random.default_rng(8).integers(1, 2**20, (12, chain.width))
    assert plain.ranks == ranks_of_all_rows(chain, PRIMES[0], rays)
    bad = [(0, 0, row, 0) for row in (1, 0)] + [(1, 0, 0, 0), (9, 9, 0, 0)]
    for likely in (other.pivots, other.pivots[::2], bad):
        again = extended(chain, PRIMES[0], likely)
        assert again.ranks == plain.ranks
        assert len(again.pivots) == len(plain.pivots) == plain.ranks[-1]


@pytest.mark.parametrize("name", MODELS[:2])
def test_pivots_of_likely_rows_are_a_minor_that_does_not_vanish(name):
    chain, p = chain_of(name), PRIMES[0]
    run = extended(chain, p, extended(chain, PRIMES[1]).pivots)
    rows = []
    for order, ray, row, _ in run.pivots:
        momenta = Momenta(chain_modulo(chain, p), run.rays[ray])
        rows.append(momenta.rows(order)[row])
    minor = Echelon(len(run.pivots), p)
    minor.absorb(np.array(rows)[:, [column for *_, column in run.pivots]])
    assert minor.rank == len(run.pivots)


def test_of_all_rows_only_the_likely_ones_are_eliminated(monkeypatch):
    """The second prime needs a row for each condition, and few combinations for each ray."""
    chain, counts = chain_of("hprs"), []
    first = extended(chain, PRIMES[0])
    absorb = Echelon.absorb

    def count(echelon, rows):
        counts.append(len(rows))
        return absorb(echelon, rows)

    monkeypatch.setattr(Echelon, "absorb", count)
    second = extended(chain, PRIMES[1], first.pivots)
    assert second.ranks == first.ranks and sum(counts) == first.ranks[-1]


def test_samples_miss_no_row():
    """One row of many that is not implied shows in the combinations of all."""
    remainders = chain_modulo(chain_of("hprs"), PRIMES[0])
    momenta = Momenta(remainders, np.arange(1, 7))
    rows, samples = momenta.rows(1), momenta.samples(1)
    assert samples.shape == (SAMPLES, rows.shape[1])
    for missing in range(0, len(rows), 7):
        echelon = Echelon(rows.shape[1], PRIMES[0])
        echelon.absorb(np.delete(rows, missing, axis=0))
        implied = echelon.implies(rows)
        assert echelon.implies(samples) == implied
    assert not Echelon(rows.shape[1], PRIMES[0]).implies(samples)
