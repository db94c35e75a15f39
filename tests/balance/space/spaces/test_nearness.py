"""The distance to a geometry of lower rank, against singular values at moved geometries."""

from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.momentum.regressor import RegressorSeries
from balance.space.spaces import distance_to_rank_drop as nearness
from kinematics.closure.newton import radius_of_convergence
from kinematics.closure.series import expand
from kinematics.model.arrays import freeze
from tests.support.laws import altered

STEP = 2e-7
CASES = {
    "four_bar_general": {},
    "four_bar_chain": {},
    "eight_bar": {},
    "four_rrr_parallel": {},
    "scissor_three_stage": {},
    "hprs": {},
    "rusr": {},
    "bennett": {},
    "sarrus": {},
    "three_rsr": {"motion": "u2=u3"},
    "four_rrr": {"balance": "force"},
    "six_bar_watt": {"spatial": True},
    "pantograph": {},
    "goldberg_five_bar": {},
    "four_bar_spherical": {"balance": "force"},
}


def by_differences(space):
    """σ / |∂σ/∂g|, with the singular value itself at geometries moved both ways.

    Changes that open the loops, by more than a thousandth of the step, do not count.
    """
    chain, force, order = space.chain, space.balance == "force", space.kmax
    columns, rows = space.rank + space.nullity, chain.width * (3 if chain.planar else 6)
    rows = rows * 2 // 3 if force and chain.planar else rows // 2 if force else rows
    rays = nearness.spanning_rays(chain.width, order, 2 - (-columns // rows))
    lengths = radius_of_convergence(expand(chain, rays, 0).C[0] @ rays[0]) ** np.arange(
        order + 1.0
    )

    def sized(change, step):
        moved = replace(chain, screws=freeze(chain.screws + step * change))
        series = expand(moved, rays, order)
        X = RegressorSeries(moved, series, force).rows(order)
        values = np.linalg.svd(
            (X * lengths.reshape(-1, 1, 1, 1, 1)).reshape(-1, columns), compute_uv=False
        )
        return values[space.rank - 1], (series.residual * lengths).max(initial=0.0)

    slopes = []
    for change in nearness.rates_of_changes(space.linkage, chain):
        (up, one), (down, other) = sized(change, STEP), sized(change, -STEP)
        if max(one, other) <= 1e-3 * STEP:
            slopes.append((up - down) / (2 * STEP))
    steepest = np.linalg.norm(slopes) if slopes else 0.0
    value, _ = sized(np.zeros_like(chain.screws), 0.0)
    return value / steepest if steepest else np.inf, len(slopes)


@pytest.mark.table
@pytest.mark.parametrize("model", CASES)
def test_a_slope_is_that_of_the_singular_value(model, monkeypatch):
    monkeypatch.setattr(nearness, "FIRST_ORDER_CHANGE", np.inf)
    space = design_space(kinematics.load(model), **CASES[model])
    expected, _ = by_differences(space)
    assert nearness.distance_to_rank_drop(space) == pytest.approx(expected, rel=1e-5)


def test_overconstrained_loops_open_under_some_changes_only():
    """Points of a Sarrus linkage stay on their lines; each joint of a Bennett one is needed."""
    kept = {}
    for model in ("bennett", "sarrus", "rusr"):
        space = design_space(kinematics.load(model))
        changes = nearness.rates_of_changes(space.linkage, space.chain)
        kept[model] = by_differences(space)[1] / len(changes)
    assert kept == {"bennett": 0.0, "sarrus": 0.6, "rusr": 1.0}


@pytest.mark.parametrize("off", [1e-3, 1e-4])
def test_an_antiparallelogram_made_general_is_as_near_as_it_was_moved(off, tmp_path):
    """Both ends of the base, moved back by half of what it is longer, make it special again."""

    def lengthened(robot):
        origin = robot.find("joint[@name='q4']/origin")
        origin.set("xyz", f"{1 + off} 0 0")
        origin = robot.find("loop/successor/origin")
        origin.set("xyz", " ".join([f"{-0.488 - off}", *origin.get("xyz").split()[1:]]))

    linkage = kinematics.load(altered("four_bar_antiparallelogram", tmp_path, lengthened))
    found = nearness.distance_to_rank_drop(design_space(linkage)) * linkage.chain.frame.length
    assert 0.1 * off < found < off / 2**0.5
