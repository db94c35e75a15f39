"""Mixed partials of the momentum: 110 digits, finite poses, and restricted motions.

The reference takes the positions of point masses from closed poses on a grid, as polynomials
in the inputs; their derivatives are velocities, and sums of those are the momentum.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

import balance
import kinematics
from balance.momentum import momentum_regressor, momentum_taylor
from kinematics import taylor_motion
from kinematics.errors import MotionError
from tests.support.laws import point_masses, relative, sums
from tests.support.partials import DIGITS, Grid, factorials, multi_indices


def bodies_of_points(linkage, seed=0):
    """Point masses for each body: (mass, place) by link, and all inertial parameters."""
    rng = np.random.default_rng(seed)
    clouds, z = [], []
    for body in linkage.bodies:
        masses, places = point_masses(rng, 2)
        clouds += [(body.link, m, p) for m, p in zip(masses, places, strict=True)]
        z.append(sums(masses, places))
    return clouds, np.array(z)


def momentum_of_points(grid, clouds, order):
    """Coefficients of the momentum (w, 6) by multi-index, for unit rates of the inputs."""
    names = [joint.name for joint in grid.linkage.joints]
    width = len(grid.linkage.inputs)
    total = {alpha: np.zeros((width, 6)) for alpha in multi_indices(width, order)}
    units, placed = np.eye(width, dtype=int), grid.placed()
    for link, mass, place in clouds:
        at = grid.joints.index(names[link])
        with mp.workdps(DIGITS):
            values = {beta: H[at][0] @ place + H[at][1] for beta, H in placed.items()}
        x = {
            alpha: grid.derivatives(values, alpha) / factorials(alpha)
            for alpha in multi_indices(width, order + 1)
        }
        for w in range(width):
            speed = {alpha: (alpha[w] + 1) * x[tuple(alpha + units[w])] for alpha in total}
            for alpha in total:
                total[alpha][w, 3:] += mass * speed[alpha]
                for beta in multi_indices(width, sum(alpha)):
                    rest = tuple(np.subtract(alpha, beta))
                    if min(rest) >= 0:
                        total[alpha][w, :3] += mass * np.cross(x[beta], speed[rest])
    return total


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("name", "order"),
    [("four_bar_general", 5), ("bennett", 5), ("five_bar", 5), ("three_rsr", 2)],
)
def test_mixed_partials_agree_with_110_digits(name, order):
    """Relative to the largest derivative of the order, to 1e-12."""
    linkage = kinematics.load(name)
    grid = Grid(name, order + 1)
    clouds, z = bodies_of_points(linkage)
    expected = momentum_of_points(grid, clouds, order)
    expansion = momentum_taylor(linkage, order, spatial=True)
    found = expansion.momentum(z.ravel())
    assert found.shape == (len(expected), len(linkage.inputs), 6)
    for k in range(order + 1):
        rows = [i for i, a in enumerate(expansion.exponents) if a.sum() == k]
        right = [expected[tuple(a)] for a in expansion.exponents[rows].tolist()]
        assert relative(found[rows], right) < 1e-12
        scale = [factorials(a) for a in expansion.exponents[rows].tolist()]
        both = expansion.derivatives[rows] @ z.ravel(), found[rows]
        assert relative(both[0], np.array(scale)[:, None, None] * both[1]) < 1e-14


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("name", "motion", "order"),
    [
        ("three_rsr", "u2=u3", 10),
        ("three_rsr", None, 8),
        ("five_bar", None, 10),
        ("slider_crank", None, 12),
        ("hprs", None, 6),
    ],
)
def test_the_regressor_at_finite_poses(name, motion, order):
    """What high orders leave out at small displacements is below 1e-11."""
    linkage = kinematics.load(name)
    expansion = momentum_taylor(linkage, order, motion)
    basis = expansion.motion.basis
    y = np.random.default_rng(5).uniform(-0.02, 0.02, (3, basis.shape[1]))
    found = expansion.evaluate(y)
    for at, X in zip(y, found, strict=True):
        whole = momentum_regressor(linkage, basis @ at)
        assert relative(X, np.einsum("urp,uw->wrp", whole, basis)) < 1e-11


def test_a_balanced_linkage_has_no_derivative():
    """Momentum of the kite with reactionless masses, beside that of one heavier body."""
    linkage = kinematics.load("four_bar_kite_balanced")
    expansion = momentum_taylor(linkage, 6)
    z = np.array([body.inertia[[0, 1, 2, 6]] for body in linkage.bodies])
    sizes = np.abs(expansion.momentum(z.ravel())).max(axis=(1, 2))
    z[1] *= 1.01
    heavier = np.abs(expansion.momentum(z.ravel())).max(axis=(1, 2))
    assert (sizes < 1e-11 * heavier.max()).all() and (heavier > 1e-3 * heavier[0]).any()


def test_momentum_is_the_mass_times_the_derivative_of_the_motion():
    """A point mass alone: its momentum follows from the Taylor motion of its joints."""
    linkage = kinematics.load("slider_crank")
    motion, expansion = taylor_motion(linkage, 6), momentum_taylor(linkage, 5)
    slider = motion.joints.index("q4")
    z = np.zeros((len(linkage.bodies), 4))
    z[[body.link for body in linkage.bodies].index(slider), 0] = 2.0
    along = expansion.momentum(z.ravel())[:, 0, 1]
    for k in range(6):
        expected = 2.0 * motion.derivatives([k + 1])[slider]
        assert expansion.derivatives[k, 0, 1] @ z.ravel() == pytest.approx(expected, abs=1e-11)
        assert along[k] * factorials([k]) == pytest.approx(expected, abs=1e-11)


def test_it_is_public_and_refuses_unknown_motions():
    linkage = kinematics.load("five_bar")
    with pytest.raises(MotionError, match="is not an input"):
        momentum_taylor(linkage, 3, "q2=0")
    found = balance.momentum.momentum_taylor(linkage, 0)
    assert (
        isinstance(found, balance.momentum.MomentumTaylor)
        and not found.coefficients.flags.writeable
    )
    assert relative(found.coefficients[0], momentum_regressor(linkage, [0.0, 0.0])) < 1e-14
