"""Of equally short explanations, the first in the order of the bodies is told."""

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.interpretation.freedoms import SparseSearch, _columns
from balance.space.interpretation.terms import candidate_terms


def solutions(space, turn, noise):
    """Terms of each new dimension, for another basis of the same space with other last bits."""
    basis, serial = space.scaled_basis.copy(), space.serial_nullity
    basis[:, :serial] @= turn[0]
    basis[:, serial:] @= turn[1]
    terms = candidate_terms(space)
    columns = _columns(space, terms)
    columns = columns / np.linalg.norm(columns, axis=0)
    cost = np.array([term.cost for term in terms])
    search = SparseSearch.of(basis + noise, serial, columns, cost)
    return [np.flatnonzero(np.abs(x) > 1e-9).tolist() for x in search.independent()]


@pytest.mark.table(1)
@pytest.mark.parametrize("model", ["double_pendulum_duplicates", "four_bar_added_slider_crank"])
def test_terms_do_not_depend_on_the_basis_or_on_last_bits(model):
    space = design_space(kinematics.load(model))
    seen = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        sizes = space.serial_nullity, space.nullity - space.serial_nullity
        turn = [np.linalg.qr(rng.standard_normal((n, n)))[0] for n in sizes]
        noise = 1e-16 * rng.standard_normal(space.scaled_basis.shape)
        seen.append(solutions(space, turn, noise))
    assert len(seen[0]) == space.nullity - space.serial_nullity > 1
    assert all(one == seen[0] for one in seen[1:])
