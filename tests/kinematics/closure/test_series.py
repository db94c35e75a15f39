"""Coefficients of the motion's power series agree with arithmetic of 70 digits.

The independent route closes the loops at points of a circle in the complex plane of the
ray's parameter, by Newton's method on the coincidence of points and axes, and reads the
coefficients off by Cauchy's integral formula. It reads the decimals of the file as they
stand: nothing is rounded to double precision on the way.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest
from mpmath import mp

import kinematics
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand
from kinematics.model.arrays import freeze
from tests.support.covering import spread
from tests.support.laws import relative

DIGITS = 70
RADIUS, SAMPLES = "0.02", 28
"""Aliasing with order k + 28 leaves ``(0.02 / ρ)²⁸``: below 1e-30 for ρ > 0.25."""


def exact(text):
    """The numbers of an attribute, as decimals."""
    return np.array([mp.mpf(word) for word in text.split()], dtype=object)


def cross_matrix(a):
    x, y, z = a
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)


class Exact:
    """A linkage read from a gallery file, and its closed motion in high precision."""

    def __init__(self, name):
        robot = ElementTree.parse(kinematics.gallery()[name]).getroot()
        self.joints, self.parents, self.axes, self.points, self.sliding = [], [], [], [], []
        links = {"base": (-1, exact("0 0 0"))}
        for joint in robot.findall("joint"):  # the gallery writes parents first
            parent, at = links[joint.find("parent").get("link")]
            at = at + exact(joint.find("origin").get("xyz"))
            links[joint.find("child").get("link")] = (len(self.joints), at)
            axis = exact(joint.find("axis").get("xyz"))
            self.joints.append(joint.get("name"))
            self.parents.append(parent)
            self.points.append(at)
            self.axes.append(axis / mp.sqrt(axis @ axis))
            self.sliding.append(joint.get("type") == "prismatic")
        self.cuts = []
        for loop in robot.findall("loop"):
            ends = [loop.find(tag) for tag in ("predecessor", "successor")]
            (i, at), (j, other) = (links[end.get("link")] for end in ends)
            at = at + exact(ends[0].find("origin").get("xyz"))
            gap = at - other - exact(ends[1].find("origin").get("xyz"))
            assert max(abs(x) for x in gap) < mp.mpf(10) ** (2 - DIGITS)
            revolute = loop.get("type") == "revolute"
            axis = exact(loop.find("axis").get("xyz")) if revolute else None
            self.cuts.append((i, j, at, axis))

    def placed(self, q):
        """Rotation and translation of every link, and of the ground last."""
        steps = [(np.eye(3, dtype=object), exact("0 0 0"))] * (len(q) + 1)
        for j, parent in enumerate(self.parents):
            (R, d), n, r = steps[parent], self.axes[j], self.points[j]
            if self.sliding[j]:
                steps[j] = R, d + R @ n * q[j]
            else:
                K = cross_matrix(n)
                turn = np.eye(3, dtype=object) + mp.sin(q[j]) * K + (1 - mp.cos(q[j])) * (K @ K)
                steps[j] = R @ turn, d + R @ (r - turn @ r)
        return steps

    def residual(self, q):
        """Gaps of the cuts, and their derivatives by every joint; (rows,), (rows, n)."""
        steps = self.placed(q)
        gaps, slopes = [], []
        for i, j, point, axis in self.cuts:
            ends = [(steps[k][0] @ point + steps[k][1], self.rates(steps, k)) for k in (i, j)]
            gaps.append(ends[0][0] - ends[1][0])
            slope = np.zeros((3, len(q)), dtype=object)
            for sign, (x, rates) in zip((1, -1), ends, strict=True):
                for k, (omega, v) in rates.items():
                    slope[:, k] += sign * (cross_matrix(omega) @ x + v)
            slopes.append(slope)
            if axis is None:
                continue
            first, second = (steps[k][0] @ axis for k in (i, j))
            gaps.append(cross_matrix(first) @ second)
            slope = np.zeros((3, len(q)), dtype=object)
            for k, (omega, _) in ends[0][1].items():
                slope[:, k] -= cross_matrix(second) @ cross_matrix(omega) @ first
            for k, (omega, _) in ends[1][1].items():
                slope[:, k] += cross_matrix(first) @ cross_matrix(omega) @ second
            slopes.append(slope)
        return np.concatenate(gaps), np.vstack(slopes)

    def rates(self, steps, link):
        """Twist (ω, v) that each joint below a link gives it, per unit rate."""
        found = {}
        while link >= 0:
            R, d = steps[self.parents[link]]
            n = R @ self.axes[link]
            if self.sliding[link]:
                found[link] = (exact("0 0 0"), n)
            else:
                found[link] = (n, cross_matrix(R @ self.points[link] + d) @ n)
            link = self.parents[link]
        return found

    def closed(self, inputs, u, start):
        """Joint positions that close the cuts at inputs u, and rates per input rate."""
        q = start.copy()
        q[inputs] = u
        others = [j for j in range(len(q)) if j not in inputs]
        for _ in range(12):
            gap, slope = self.residual(q)
            fix = solved(slope[:, others], -gap[:, None])[:, 0]
            q[others] += fix
            if max(abs(x) for x in fix) < mp.mpf(10) ** (10 - DIGITS):
                break
        gap, slope = self.residual(q)
        # Overconstrained loops close too: the geometry of the file is exact.
        assert max(abs(x) for x in gap) < mp.mpf(10) ** (12 - DIGITS)
        C = np.zeros((len(q), len(inputs)), dtype=object)
        C[inputs, range(len(inputs))] = mp.mpf(1)
        C[others] = solved(slope[:, others], -slope[:, inputs])
        return q, C

    def series(self, inputs, ray, order):
        """Coefficients of q (n, order + 2) and of C (order + 1, n, inputs) along u = t δ."""
        radius, q = mp.mpf(RADIUS), np.array([mp.mpf(0)] * len(self.joints), dtype=object)
        turns = [mp.expjpi(mp.mpf(2 * i) / SAMPLES) for i in range(SAMPLES)]
        circle = []
        # The points below the real axis are conjugate to those above it.
        for turn in turns[: SAMPLES // 2 + 1]:
            u = np.array([radius * turn * mp.mpf(x) for x in ray], dtype=object)
            q, C = self.closed(inputs, u, q)
            circle.append(np.column_stack([q, C]))
        circle += [np.conj(value) for value in circle[SAMPLES // 2 - 1 : 0 : -1]]
        found = []
        for k in range(order + 2):
            weights = [turns[-(i * k) % SAMPLES] for i in range(SAMPLES)]
            total = sum(w * value for w, value in zip(weights, circle, strict=True))
            found.append(np.vectorize(lambda x: float(x.real))(total / SAMPLES / radius**k))
        found = np.array(found)
        return found[:, :, 0], found[:-1, :, 1:]


def solved(A, B):
    """Least squares of a consistent system with full column rank, in high precision.

    The transpose, not the conjugate transpose: the solution is analytic in A.
    """
    n = A.shape[1]
    M = np.hstack([A.T @ A, A.T @ B])
    for k in range(n):
        pivot = k + int(np.argmax([float(abs(x)) for x in M[k:, k]]))
        M[[k, pivot]] = M[[pivot, k]]
        M[k] = M[k] / M[k, k]
        for i in range(n):
            if i != k:
                M[i] = M[i] - M[i, k] * M[k]
    return M[:, n:]


@cache
def exact_series(name, ray, order):
    """Coefficients of q and C for the inputs of the file, in SI units."""
    linkage = kinematics.load(name)
    with mp.workdps(DIGITS):
        model = Exact(name)
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


@pytest.mark.table(5)
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
