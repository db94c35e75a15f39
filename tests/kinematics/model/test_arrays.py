"""Chains that are pickled, as processes that share work get them."""

from __future__ import annotations

import pickle
from dataclasses import fields

import numpy as np
import pytest

import balance
import kinematics


@pytest.mark.parametrize("model", ["four_bar_general", "bennett"])
def test_a_pickled_chain_is_read_only_and_keeps_no_results(model):
    """Kernels of a chain that was used are not pickled, and the same kernels take its copy."""
    linkage = kinematics.load(model)
    space = balance.design_space(linkage)
    chain = linkage.chain
    copy = pickle.loads(pickle.dumps(chain))
    for part in fields(chain):
        array = getattr(chain, part.name)
        if isinstance(array, np.ndarray):
            again = getattr(copy, part.name)
            np.testing.assert_array_equal(again, array)
            assert again.dtype == array.dtype and not again.flags.writeable, part.name
            assert again.flags.c_contiguous == array.flags.c_contiguous
    assert copy.frame.length == chain.frame.length and not copy.frame.R.flags.writeable
    assert chain.structure.made and not copy.structure.made
    again = balance.design_space(pickle.loads(pickle.dumps(kinematics.load(model))))
    assert (again.rank, again.nullity) == (space.rank, space.nullity)
