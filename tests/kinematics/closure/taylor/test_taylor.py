"""Taylor motions: every mixed partial derivative, the radius, the error, Newton's method."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import kinematics
from kinematics import ScrewJoint, from_screws, taylor_motion, taylor_motion_many
from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.joint_positions import joint_positions
from kinematics.closure.series import expand
from kinematics.closure.taylor.expansion_kernels import polynomials
from kinematics.closure.taylor.layout import packed_layout
from kinematics.closure.taylor.monomials import (
    monomial_powers,
    monomial_table,
    multiply_polynomials,
)
from kinematics.errors import LinkageError, MobilityError, MotionError, PoseError
from kinematics.model.linkage import Mimic
from kinematics.numerics.compiled.simd import VECTOR_WIDTH
from tests.support.laws import altered, relative, resized
from tests.support.partials import Grid, multi_indices

SIX = ["four_bar_general", "bennett", "five_bar", "three_rrr", "three_rsr", "delta"]


@cache
def motion_of(name, order=6):
    return taylor_motion(kinematics.load(name), order)


def points(motion, count, seed, share=1.0):
    """Random points evenly within a share of the radius, at most 3."""
    rng = np.random.default_rng(seed)
    v = rng.standard_normal((count, motion.scales.size))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    far = share * min(motion.radius, 3.0)
    return far * rng.uniform(0.0, 1.0, (count, 1)) * v * motion.scales


# --- polynomials ---------------------------------------------------------------------------


@pytest.mark.parametrize(("width", "order"), [(1, 7), (2, 6), (3, 4), (5, 3)])
def test_products_are_those_of_fractions(width, order):
    """Products without constants, by whole numbers, against a dictionary of exponents."""
    table = monomial_table(width, order)
    assert [sum(a) for a in table.exponents] == sorted(sum(a) for a in table.exponents)
    assert sorted(map(tuple, table.exponents.tolist())) == multi_indices(width, order)
    rng = np.random.default_rng(width)
    count = len(table.exponents)
    A, B = rng.integers(-9, 9, (2, count, 2 * VECTOR_WIDTH)).astype(float)
    A[0] = B[0] = 0.0
    out = np.full((count, 2 * VECTOR_WIDTH), np.nan)
    flat = (A.ravel(), B.ravel(), out.ravel())
    multiply_polynomials(
        1, count, VECTOR_WIDTH + 1, 2 * VECTOR_WIDTH, table.places, table.pairs, *flat
    )
    expected = np.zeros((count, 2 * VECTOR_WIDTH))
    index = {tuple(a): i for i, a in enumerate(table.exponents.tolist())}
    for i in range(1, count):
        for j in range(1, count):
            t = index.get(tuple((table.exponents[i] + table.exponents[j]).tolist()))
            if t is not None:
                expected[t] += A[i] * B[j]
    assert np.array_equal(out[1:], expected[1:])


def test_powers_are_those_of_fractions():
    table = monomial_table(3, 5)
    u = [Fraction(1, 2), Fraction(-3, 4), Fraction(5, 8)]
    x, y, z = u
    expected = [float(x**a * y**b * z**c) for a, b, c in table.exponents.tolist()]
    assert relative(monomial_powers(table.exponents, np.array(u, float)), expected) < 1e-15


def test_too_many_products_are_refused():
    with pytest.raises(LinkageError, match="give a lower order, or restrict the motion"):
        taylor_motion(kinematics.load("stewart_6ups"), 15)
    with pytest.raises(ValueError, match="at least 1"):
        taylor_motion(kinematics.load("five_bar"), 0)


# --- derivatives ---------------------------------------------------------------------------


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "name", ["four_bar_general", "bennett", "five_bar", "fuga_i", "three_rsr"]
)
def test_mixed_partials_agree_with_110_digits(name, order=6):
    """Every derivative of every joint, relative to the largest of its order, to 1e-12."""
    linkage, grid = kinematics.load(name), Grid(name, order)
    motion = taylor_motion(linkage, order)
    at = linkage.positions_of(grid.joints)
    by_order = [[] for _ in range(order + 1)]
    for alpha in multi_indices(len(linkage.inputs), order):
        expected = grid.derivatives(grid.q, alpha)
        by_order[sum(alpha)].append((motion.derivatives(alpha)[at], expected))
    for pairs in by_order[1:]:
        found, expected = np.moveaxis(np.array(pairs), 1, 0)
        assert relative(found, expected) < 1e-12


@pytest.mark.parametrize("name", [*SIX, "rusr", "sarrus", "stewart_6ups"])
@pytest.mark.parametrize("planar", [True, False])
def test_polynomials_are_the_series_along_rays(name, planar):
    """Homogeneous parts at a direction are the coefficients of the ray kernel.

    Compared with the largest of the order along all rays: along one they may cancel.
    """
    linkage = kinematics.load(name)
    chain = linkage.chain if planar else linkage.spatial_chain
    order = 6 if chain.width < 4 else 3
    table = monomial_table(chain.width, order)
    found, condition = polynomials(chain.screws, packed_layout(chain, order))
    assert 1.0 <= condition < 1e4
    rays = np.random.default_rng(8).standard_normal((5, chain.width))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    series = expand(chain, rays, order - 1)
    for k in range(1, order + 1):
        part = slice(table.starts[k], table.starts[k + 1])
        values = monomial_powers(table.exponents[part], rays) @ found[part]
        expected = np.einsum("rjw,rw->rj", series.C[:, k - 1], rays) / k
        assert relative(values, expected) < 1e-11


def test_the_order_of_inputs_does_not_matter():
    """Symmetry of mixed partials: swapping the inputs swaps their indices."""
    linkage = kinematics.load("three_rsr")
    swapped = kinematics.load("three_rsr", inputs=linkage.inputs[::-1])
    one, other = taylor_motion(linkage, 4), taylor_motion(swapped, 4)
    for alpha in one.exponents:
        assert one.derivatives(alpha) == pytest.approx(
            other.derivatives(alpha[::-1]), rel=1e-11, abs=1e-11
        )


@pytest.mark.parametrize("name", ["five_bar", "three_rsr", "slider_crank"])
def test_derivatives_at_a_point_are_slopes(name):
    """Central differences of the polynomial itself; step 1e-4 leaves 1e-7 of the scale."""
    motion = motion_of(name)
    (u,) = points(motion, 1, 5, 0.3)
    unit = np.eye(motion.scales.size, dtype=int)
    for direction in unit:
        h = 1e-4 * motion.scales * direction
        for alpha in (np.zeros_like(direction), direction, unit[0] + unit[-1]):
            below, above = (motion.derivatives(alpha, u + s * h) for s in (-1, 1))
            slope = (above - below) / (2 * h.sum())
            assert relative(motion.derivatives(alpha + direction, u), slope) < 1e-6
    assert np.array_equal(motion.derivatives(0 * unit[0], u), motion.evaluate(u))
    assert not motion.derivatives(7 * unit[0], u).any()


def test_a_restricted_motion_is_the_whole_one_along_its_basis():
    linkage = kinematics.load("three_rsr")
    whole, part = taylor_motion(linkage, 5), taylor_motion(linkage, 5, "u2=-2*u3")
    assert part.exponents.shape[1] == 2
    y = np.random.default_rng(6).uniform(-0.2, 0.2, (7, 2))
    u = y @ part.motion.basis.T
    assert relative(part.evaluate(y), whole.evaluate(u)) < 1e-12
    assert part.distance(y) == pytest.approx(whole.distance(u), rel=1e-12)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_slider_crank_driven_by_its_slider(unit, tmp_path):
    """Two links of 0.5 m: the crank is at ``acos x`` where the slider is at x = 0.6 m.

    It is stretched at x = 1 m. Also a thousand times smaller.
    """
    path = altered("slider_crank", tmp_path, resized(unit))
    linkage = kinematics.load(path, inputs=["q4"])
    motion = taylor_motion(linkage, 12)
    s = np.array([[0.05], [-0.1]])
    crank = motion.evaluate(unit * s)[:, motion.joints.index("u1")]
    assert crank == pytest.approx(np.arccos(0.6 + s[:, 0]) - np.arccos(0.6), abs=3e-9)
    edge = motion.distance([0.4 * unit])
    assert 0.8 * edge < motion.radius < edge
    first = -1.0 / np.sqrt(1.0 - 0.6**2) / unit
    assert motion.derivatives([1])[motion.joints.index("u1")] == pytest.approx(first, rel=1e-14)


def test_an_open_chain_is_linear_and_has_no_radius():
    motion = taylor_motion(kinematics.load("hprs"), 3)
    assert motion.radius == np.inf and motion.condition == 1.0
    assert not motion.coefficients[motion.exponents.sum(axis=1) != 1].any()
    u = np.full(motion.scales.size, 0.7)
    assert motion.polish(u) == pytest.approx(motion.evaluate(u), abs=1e-15)
    assert motion.error(u) < 1e-15


# --- radius, error and Newton's method -----------------------------------------------------


@pytest.mark.table(1)
@pytest.mark.parametrize("name", SIX)
def test_newton_closes_and_the_error_is_honest(name):
    """Order 6, 170 points within the radius on each of six linkages.

    The true pose is the one that is reached in small steps from the reference pose. The
    estimate may be smaller than the error by a factor of 10 at most, and is not useless.
    """
    motion, linkage = motion_of(name), kinematics.load(name)
    u = points(motion, 170, 1)
    predicted, estimated = motion.evaluate(u), motion.error(u)
    units = linkage.spatial_chain.units
    moving = linkage.spatial_chain.joints
    ratios = []
    for i, at in enumerate(u):
        true = joint_positions(linkage, at)
        assert relative(motion.polish(at), true) < 1e-9
        error = np.abs((predicted[i] - true)[moving] / units).max()
        assert error <= 10.0 * estimated[i]
        ratios.append(estimated[i] / max(error, 1e-14))
    assert np.median(ratios) < 3.0


@pytest.mark.parametrize("order", [1, 2, 3])
def test_low_orders_know_their_error_too(order):
    linkage = kinematics.load("five_bar")
    motion = taylor_motion(linkage, order)
    assert motion.radius == pytest.approx(motion_of("five_bar").radius, rel=1e-12)
    for at in points(motion, 40, 2, 0.7):
        error = np.abs(motion.evaluate(at) - joint_positions(linkage, at)).max()
        assert 0.3 * error < motion.error(at) < 3.0 * error + 1e-13


@pytest.mark.parametrize(("name", "order"), [("four_bar_general", 60), ("bennett", 60)])
def test_the_radius_is_where_the_series_stops_converging(name, order):
    """Terms of a much higher order shrink inside it, and grow 30 % beyond it."""
    chain, motion = kinematics.load(name).chain, motion_of(name)
    rates = np.abs(expand(chain, np.ones((1, 1)), order).C[0, :, :, 0]).max(axis=1)
    early, late = rates[20:30], rates[-10:]
    for factor, grows in ((1.0, False), (1.3, True)):
        reach = factor * motion.radius
        growth = late.max() / early.max() * reach ** (order - 29)
        assert (growth > 1.0) == grows


@pytest.mark.parametrize("name", ["four_bar_general", "three_rsr"])
def test_poses_are_closed_where_a_low_order_is_far_off(name):
    """Also where Newton's method would not end near the prediction."""
    linkage = kinematics.load(name)
    motion = taylor_motion(linkage, 1)
    off = []
    for u in points(motion, 60, 9):
        true = joint_positions(linkage, u)
        off.append(np.linalg.norm(motion.evaluate(u) - true))
        assert relative(motion.polish(u), true) < 1e-9
    assert max(off) > 0.25


def test_what_is_almost_a_kite_does_not_pass_through_its_fold(tmp_path):
    """Its base is 0.1 mm too short; its series is nearly that of the kite, which folds flat.

    Beyond, within the estimated radius, the loops close on another branch only. Where the
    crank stops, the coupler lies along the rocker: a triangle with two sides in line.
    """
    d = 0.9999

    def shorter(robot):
        robot.find("joint[@name='q4']/origin").set("xyz", f"{d} 0 0")
        robot.find("loop/successor/origin").set("xyz", f"{0.72 - d} 0.96 0")

    motion = taylor_motion(kinematics.load(altered("four_bar_kite", tmp_path, shorter)), 7)
    crank, coupler, rocker = np.hypot([0.6, 0.12, 0.72 - d], [0.3, 0.66, 0.96])
    cosine = (crank**2 + d**2 - (rocker - coupler) ** 2) / (2.0 * crank * d)
    edge = np.arccos(cosine) - np.arctan2(0.3, 0.6)
    assert -motion.radius < 1.05 * edge
    for share in (0.5, 0.9, 0.99):
        assert motion.polish([share * edge])[motion.joints.index("u1")] == share * edge
    for share in (1.01, 1.05):
        with pytest.raises(PoseError, match="give a nearer pose"):
            motion.polish([share * edge])


@pytest.mark.lanes
def test_no_condition_is_below_one():
    """Loops of one equation have condition 1, which round-off may not lower."""
    for angle in np.linspace(0.1, 3.0, 40):
        screw = [0.0, 0.0, 0.0, np.cos(angle), np.sin(angle), 0.0]
        slides = [ScrewJoint(name, "base", "slider", screw=screw) for name in ("u", "q")]
        linkage = from_screws(slides[:1], slides[1:], inputs=["u"])
        one = taylor_motion(linkage, order=2).condition
        (many,) = taylor_motion_many(linkage, [[0.0, 0.0]], order=2).condition
        assert one >= 1.0 and many >= 1.0 and max(one, many) < 1.0 + 1e-12


def test_points_are_checked():
    motion = motion_of("five_bar")
    for wrong in ([0.1], [0.1, np.nan], 0.3, [[0.1, 0.2, 0.3]]):
        with pytest.raises(PoseError, match="are 2 finite numbers"):
            motion.evaluate(wrong)
    for alpha in ((1,), (1, -1), (0.5, 1)):
        with pytest.raises(ValueError, match="a multi-index is 2 whole numbers"):
            motion.derivatives(alpha)
    assert motion.evaluate(np.zeros((4, 3, 2))).shape == (4, 3, 5)
    assert motion.error(np.zeros((4, 3, 2))).shape == (4, 3)
    assert motion.error(np.zeros((0, 2))).shape == (0,)
    with pytest.raises(PoseError, match="closed at one point at a time"):
        motion.polish(np.zeros((3, 2)))
    assert not motion.coefficients.flags.writeable


def test_a_pose_out_of_reach_is_refused():
    motion = motion_of("five_bar")
    with pytest.raises(PoseError, match="give a nearer pose"):
        motion.polish([2.5, -2.5])


def test_equations_and_motions_are_checked():
    linkage = kinematics.load("bennett")
    with pytest.raises(MobilityError, match="choose other inputs or equations"):
        taylor_motion(linkage, 3, equations=[0, 1])
    with pytest.raises(MobilityError, match="choose other inputs or equations"):
        taylor_motion(linkage, 3, equations=[0, 1, 1])
    with pytest.raises(MotionError, match="is not an input"):
        taylor_motion(linkage, 3, "nothing=0")
    few = taylor_motion(linkage, 8, equations=[0, 1, 5])
    assert relative(few.coefficients, taylor_motion(linkage, 8).coefficients) < 1e-10


def test_mimic_joints_follow():
    """A relation of positions adds a row to the equations."""
    free = kinematics.load("hprs")
    places = free.positions_of(["revolute", "wrist_x"]).tolist()
    tied = assemble(replace(free, mimics=(Mimic(*places, -2.0),), named_inputs=()))
    motion = taylor_motion(tied, 3)
    q = motion.evaluate(np.full((5, motion.scales.size), 0.3))
    assert q[:, places[0]] == pytest.approx(-2.0 * q[:, places[1]], abs=1e-13)
    assert np.abs(q[:, places]).min() > 0.1
