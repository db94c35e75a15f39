"""Gravity as a requirement, against the potential energy by Pinocchio at finite poses."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from tests.support.potential_energies import GRAVITY, energies, poses_of
from tests.support.source_files import ROOT

# Parallelogram arms (pantographs), delta, chains, closed loops in a plane and in space.
MODELS = [
    "pantograph", "hprs", "five_bar", "delta", "four_bar_parallelogram", "fuga_i", "bennett",
    "zero_reaction_arm", "principal_vector_linkage", "slider_crank", "four_bar_spherical",
    "two_rrr", "rusr", "double_pendulum_duplicates", "three_rrr", "six_bar_watt",
    "four_bar_general", "four_bar_kite", "four_bar_antiparallelogram", "sarrus",
    "six_bar_stephenson", "slider_pantograph", "three_rsr", "goldberg_five_bar", "four_rrr",
    "double_pendulum_counter_rotary", "principal_vector_linkage_slider", "two_rrr_bisector",
    "pantograph_reaction_wheel", "four_rrr_symmetric",
]  # fmt: skip


def energy_changes(linkage, poses):
    """Change of the potential energy since the first pose, for unit parameters m, mc."""
    count, columns = len(linkage.bodies), []
    for b in range(count):
        one = np.eye(count)[b]
        at = [np.outer(one, c) for c in np.vstack([np.zeros(3), np.eye(3)])]
        first, *others = (energies(linkage, poses, one, moment) for moment in at)
        columns += [first, *(other - first for other in others)]
    rows = np.array(columns).T
    return rows[1:] - rows[0]


# Arms with parallelograms, of their makers.
MODELS += [str(ROOT / "docs" / "machines" / name) for name in ("forbal2.urdf", "forbal5.urdf")]
QUICK = ("pantograph", "slider_crank", "fuga_i")


@pytest.mark.parametrize(
    "model",
    [
        model if model in QUICK else pytest.param(model, marks=pytest.mark.slow)
        for model in MODELS
    ],
)
def test_the_potential_energy_is_constant_by_pinocchio(model):
    """For every distribution of the space to 1e-12 of its parts, and for no others."""
    linkage = kinematics.load(model)
    space = balance.require(linkage, "gravity", gravity=GRAVITY)
    changes = energy_changes(linkage, poses_of(linkage))
    if linkage.planar:
        by_body = changes.reshape(len(changes), -1, 4)
        along = by_body[..., 1:] @ space.axes[:2].T
        changes = np.concatenate([by_body[..., :1], along], axis=2).reshape(len(changes), -1)
    parts = np.abs(changes) @ np.abs(space.basis)
    assert np.abs(changes @ space.basis).max() < 1e-12 * max(1.0, parts.max())
    values = np.linalg.svd(changes, compute_uv=False)
    # Few parameters may be felt late: the gap, not a limit, tells the rank.
    kept = values[: space.rank]
    assert len(kept) == space.rank
    dropped = values[space.rank] if space.rank < values.size else 0.0
    assert dropped < 1e-5 * kept.min(initial=values[0] or 1.0)
    force = balance.design_space(linkage, balance="force")
    assert space.rank <= force.rank
    assert np.abs(space.decision.conditions.rows @ force.scaled_basis).max(initial=0) < 1e-9
