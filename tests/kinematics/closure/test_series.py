"""Coefficients of the motion's power series agree with arithmetic of 70 digits.

The independent route is `tests/independent/high_precision_motion.py`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from mpmath import mp

import kinematics
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand
from kinematics.model.arrays import freeze
from tests.independent.high_precision_motion import DIGITS, Exact
from tests.support.covering import spread
from tests.support.laws import relative


@cache
def exact_series(name, ray, order):
    """Coefficients of q and C for the inputs of the file, in SI units."""
    linkage = kinematics.load(name)
    with mp.workdps(DIGITS):
        model = Exact(kinematics.gallery()[name])
        inputs = [model.joints.index(x) for x in linkage.inputs]
        return model.joints, *model.series(inputs, ray, order)


CASES = [
    ("four_bar_general", (1.0,), 10),
    ("five_bar", (0.6, -0.8), 10),
    ("five_bar", (0.28, 0.96), 10),
    ("four_bar_antiparallelogram", (-1.0,), 10),
    ("bennett", (1.0,), 6),
    ("three_rsr", (0.6, 0.48, -0.64), 6),
]


def both_routes(name, ray, order, planar):
    """Coefficients C of the product, in SI units, beside the exact ones of C and q."""
    linkage = kinematics.load(name)
    chain = linkage.chain if planar else linkage.spatial_chain
    assert all(j.kind == "revolute" for j in linkage.joints if j.name in linkage.inputs)
    joints, q_exact, C_exact = exact_series(name, ray, order)
    at = [[linkage.joints[j].name for j in chain.joints].index(x) for x in joints]
    C = expand(chain, np.array([ray]), order).C[0][:, at] * chain.units[at][:, None]
    return C, C_exact, q_exact


@pytest.mark.table(1)
@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(("name", "ray", "order"), spread(CASES, 2))
def test_coefficients_agree_with_70_digits(name, ray, order, planar):
    """Relative to the largest coefficient of each order, and to each one in a plane."""
    C, C_exact, q_exact = both_routes(name, ray, order, planar)
    if order == 10:
        assert (np.abs(C - C_exact) <= 1e-12 * np.abs(C_exact) + 1e-30).all()
    for k in range(order + 1):
        assert relative(C[k], C_exact[k]) < 1e-12
        assert relative(C[k] @ ray, (k + 1) * q_exact[k + 1]) < 1e-12


@pytest.mark.parametrize("planar", [True, False])
def test_an_entire_motion_agrees_with_70_digits(planar):
    """The slider is at ``2 l cos u`` and all angles are linear in u.

    The coefficients of a linkage whose lengths are off by a rounding error do not fall like
    1/k!: errors are compared with the largest coefficient of all orders.
    """
    C, C_exact, q_exact = both_routes("slider_crank", (1.0,), 10, planar)
    assert relative(C, C_exact) < 1e-12
    orders = np.arange(1, 12)[:, None]
    assert relative(C[:, :, 0], orders * q_exact[1:]) < 1e-12


@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "bennett", "three_rsr"])
def test_columns_are_one_motion(name):
    """Coefficients of C along a ray scale with it: ``C_k(s δ) = s^k C_k(δ)``."""
    chain = kinematics.load(name).chain
    ray = np.random.default_rng(50).standard_normal(chain.width)
    one, other = expand(chain, np.array([ray, -1.7 * ray]), 6).C
    for k in range(7):
        assert relative(other[k], (-1.7) ** k * one[k]) < 1e-12


@pytest.mark.parametrize("name", ["five_bar", "delta", "hprs"])
def test_other_columns_are_another_motion_of_the_same_joints(name):
    """Combined columns give the rates along the combined ray; the table of the loops stays."""
    chain, rng = kinematics.load(name).spatial_chain, np.random.default_rng(53)
    mixed = rng.standard_normal((chain.width, chain.width))
    moves = chain.moves.any(axis=1, keepdims=True) & np.ones(chain.width, bool)
    other = replace(chain, moves=freeze(moves, bool)).with_columns(chain.columns @ mixed)
    assert np.array_equal(other.envelope, chain.envelope)
    ray = rng.standard_normal(chain.width)
    one, two = (expand(chain, (mixed @ ray)[None], 4).C[0], expand(other, ray[None], 4).C[0])
    for k in range(5):
        assert relative(two[k] @ ray, one[k] @ (mixed @ ray)) < 1e-11


@pytest.mark.parametrize("name", spread(list(kinematics.gallery()), 3))
def test_residuals_are_round_off(name):
    """The loops of the gallery can follow at every order, overconstrained or not."""
    linkage = kinematics.load(name)
    rays = np.random.default_rng(51).standard_normal((3, linkage.mobility))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    for chain in (linkage.chain, linkage.spatial_chain):
        series = expand(chain, rays, 10)
        assert series.order == 10 and series.residual.shape == (11,)
        sizes = np.abs(series.T).max(axis=(0, 2, 3, 4))
        assert (series.residual <= 1e-12 * np.maximum(sizes, 1.0)).all()


@pytest.mark.parametrize("name", spread(list(kinematics.gallery()), 3))
def test_twists_belong_to_the_rates(name):
    """``T_w = Σ s_j C_jw`` over the joints below a link, and ``V = Σ_w T_w δ_w``.

    Checked at a closed pose on the ray, against the sums of the series there. Order 20 at
    a hundredth of a radian leaves no truncation.
    """
    linkage = kinematics.load(name)
    for chain in (linkage.chain, linkage.spatial_chain):
        ray = np.random.default_rng(52).standard_normal(chain.width)
        ray *= 0.01 / np.linalg.norm(ray)
        C, V, T = (x[0].sum(axis=0) for x in expand(chain, ray[None], 20)[:3])
        rates = expand(chain, ray[None], 20).C[0] @ ray
        q = (rates / np.arange(1, 22)[:, None]).sum(axis=0)
        pose = forward_kinematics(chain, q)
        assert pose.error < 1e-13
        expected = np.zeros_like(T)
        for j, parent in enumerate(chain.parent):
            expected[j] = C[j][:, None] * pose.screws[j]
            if parent >= 0:
                expected[j] += expected[parent]
        assert pytest.approx(expected, abs=1e-12) == T
        assert pytest.approx(np.einsum("jwi,w->ji", expected, ray), abs=1e-12) == V
