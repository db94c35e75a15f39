"""Balance at one pose alone: no momentum there, and momentum elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance import design, design_space, momentum_regressor

CASES = ["four_bar_general", "five_bar", "three_rsr"]


@pytest.mark.parametrize("minimise", [None, "mass", "change"])
@pytest.mark.parametrize("model", CASES)
def test_no_momentum_at_the_pose_and_some_elsewhere(model, minimise):
    linkage = kinematics.load(model)
    at = dict.fromkeys(linkage.inputs, 0.1)
    linkage = kinematics.load(model, at=at)
    space = design_space(linkage, max_order=0)
    found = design(space, minimise, one_pose=True)
    assert found.verdict == "feasible" and found.words.endswith("at the reference pose alone")
    z, size = found.z.reshape(-1), np.abs(found.z).sum()
    here = momentum_regressor(linkage, np.zeros(linkage.mobility), spatial=True) @ z
    there = momentum_regressor(linkage, np.full(linkage.mobility, 0.1), spatial=True) @ z
    assert np.abs(here).max() < 1e-11 * size < 1e-4 * size < np.abs(there).max()


def test_conditions_of_more_than_one_pose_are_refused():
    with pytest.raises(ValueError, match="max_order=0"):
        design(design_space("four_bar_kite"), one_pose=True)
