"""Conditions at finite poses: enough of them, and no more than a limit of work allows."""

from __future__ import annotations

import numpy as np
import pytest

from balance.space.conditions import collect
from balance.space.conditions.collect import add_pose_conditions
from balance.space.conditions.rank import Conditions
from kinematics import ScrewJoint, from_screws

JOINTS = 3
# A body that turns about an axis has seven parameters that shake what it is jointed to, five
# if the axis rests.
RANK = 7 * JOINTS - 2


@pytest.fixture(scope="module")
def chain():
    """A serial chain of turning joints whose axes have no special relation."""
    rng = np.random.default_rng(5)
    links = ["base", *(f"link{k}" for k in range(JOINTS))]
    joints = [
        ScrewJoint(
            f"u{k}",
            links[k],
            links[k + 1],
            axis=tuple(rng.uniform(-1, 1, 3)),
            point=tuple(rng.uniform(-1, 1, 3)),
        )
        for k in range(JOINTS)
    ]
    return from_screws(joints, name="arm").chain


@pytest.mark.slow
@pytest.mark.parametrize(("most", "poses"), [(1, 4 + 8), (20, 4 + 8 + 16)])
def test_the_work_of_a_batch_is_limited(chain, monkeypatch, most, poses):
    """Ill-conditioned rows are added up to the limit, and have the rank of the theory."""
    rows, unknowns = 6 * JOINTS, 10 * JOINTS
    monkeypatch.setattr(collect, "MAX_WORK_PER_BATCH", most * rows * unknowns**2)
    # With this tolerance, pivots count that are ill-conditioned: more poses are asked for.
    none = Conditions.given(np.empty((0, unknowns)), tolerance=1e-4)
    conditions, used, settled = add_pose_conditions(chain, False, none)
    assert conditions.ill_conditioned and not settled
    assert (used, conditions.rank) == (poses, RANK)


def test_a_small_chain_settles_far_below_the_limit(chain):
    none = Conditions.given(np.empty((0, 10 * JOINTS)))
    conditions, used, settled = add_pose_conditions(chain, False, none)
    assert settled and (used, conditions.rank) == (4 + 8, RANK)
