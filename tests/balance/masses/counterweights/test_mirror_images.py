"""Matter that is its own mirror image, sections of balls, and steps within a radius."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

import balance
from balance.masses.counterweights.added_matter import symmetric_basis
from balance.masses.counterweights.added_program import build_added_program
from balance.masses.counterweights.regions import ball_region, cylinder_region
from balance.masses.counterweights.volume.ball_sections import (
    disc_products,
    section_moments,
    section_products,
)
from balance.masses.counterweights.volume.cut_regions import (
    COARSE,
    FINE,
    Stock,
    cut_moments,
    fill,
)
from balance.masses.counterweights.volume.dual_ascent import _best_step, conditions_of
from balance.masses.counterweights.volume.fill_program import density_needed, fill_least
from balance.masses.counterweights.volume.mirror_images import halved_by_plane
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.support.clarabel_adapter import triangles

BALL = ball_region([0.0, 0.0, 0.0], 1.0)


def round_form(centre, radius, sign=1.0):
    """``sign (r² - |p - c|²)`` in x and y."""
    Q = np.diag([-1.0, -1.0, 0.0, radius**2 - np.dot(centre, centre)])
    Q[:2, 3] = Q[3, :2] = centre
    return sign * Q


def turned(Q, seed):
    """A form in a frame that is turned at random, and the turn."""
    T = np.eye(4)
    T[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    return T @ Q @ T.T, T


@pytest.mark.parametrize("a", [0.3, 0.7, 0.95])
def test_a_bored_ball_has_the_volume_of_the_textbook(a):
    """4π/3 (1 - a²)^(3/2) and its second moments, along any axis."""
    s = np.sqrt(1.0 - a * a)
    xx, zz = 2.0 * np.pi * (s**3 / 3.0 - s**5 / 5.0), 4.0 * np.pi / 15.0 * s**5
    exact = np.diag([xx, xx, zz, 4.0 / 3.0 * np.pi * s**3])
    Q, T = turned(round_form([0.0, 0.0], a, -1.0), 3)
    P = section_moments(Q, T[:3, 2], FINE)
    np.testing.assert_allclose(P, T @ exact @ T.T, atol=1e-13)


def test_a_whole_ball_has_the_moments_of_the_textbook():
    P = section_moments(np.diag([0.0, 0.0, 0.0, 1.0]), np.eye(3)[2], FINE)
    exact = 4.0 / 15.0 * np.pi * np.diag([1.0, 1.0, 1.0, 5.0])
    np.testing.assert_allclose(P, exact, atol=1e-13)


DEPTHS = [0.3, 1e-2, 1e-3, 1e-4]


@pytest.mark.parametrize("depth", DEPTHS)
def test_a_thin_cap_has_the_moments_of_exact_arithmetic(depth):
    """``(x - h) (x + 2)`` is positive in the cap beyond x = h; integrals of its discs."""
    h = 1 - Fraction(depth)
    powers = [(1 - h**k) / k for k in range(6) if k]
    mass, first = powers[0] - powers[2], powers[1] - powers[3]
    along, across = powers[2] - powers[4], (powers[0] - 2 * powers[2] + powers[4]) / 4
    exact = np.diag([float(each) for each in (along, across, across, mass)])
    exact[0, 3] = exact[3, 0] = float(first)
    Q = np.diag([1.0, 0.0, 0.0, -2.0 * float(h)])
    Q[0, 3] = Q[3, 0] = 0.5 * (2.0 - float(h))
    Q, T = turned(Q, 4)
    P = section_moments(Q, T[:3, 2], COARSE)
    np.testing.assert_allclose(
        P, np.pi * T @ exact @ T.T, atol=1e-8 * np.pi * float(mass), rtol=0.0
    )


def round_part(centre, radius, sign):
    """Moments of the part inside or outside a circle about (centre, 0), to 20 digits.

    At the distance r from the middle the circle takes the angles up to that of the law of
    cosines.
    """
    at, bound = mpmath.mpf(centre), mpmath.mpf(radius)

    def integrate(value):
        def ring(r):
            cosine = (r * r + at * at - bound * bound) / (2 * r * at)
            angle = mpmath.acos(max(-1, min(1, cosine)))
            return value(r, mpmath.sqrt(1 - r * r), angle)

        kinks = {abs(at - bound), at + bound, mpmath.mpf(0), mpmath.mpf(1)}
        return mpmath.quad(ring, sorted(r for r in kinks if 0 <= r <= 1))

    def angles(angle):
        return angle if sign > 0 else mpmath.pi - angle

    with mpmath.workdps(20):
        sums = [
            integrate(lambda r, h, a: 4 * h * r * angles(a)),
            integrate(lambda r, h, a: 4 * h * r**2 * sign * mpmath.sin(a)),
            integrate(
                lambda r, h, a: 2 * h * r**3 * (angles(a) + sign * mpmath.sin(2 * a) / 2)
            ),
            integrate(
                lambda r, h, a: 2 * h * r**3 * (angles(a) - sign * mpmath.sin(2 * a) / 2)
            ),
            integrate(lambda r, h, a: mpmath.mpf(4) / 3 * h**3 * r * angles(a)),
        ]
    mass, first, xx, yy, zz = map(float, sums)
    moments = np.diag([xx, yy, zz, mass])
    moments[0, 3] = moments[3, 0] = first
    return moments


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("radius", [0.01, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_thin_crescent_at_the_rim_has_the_moments_of_a_quadrature(depth, radius, sign):
    """Inside a circle that reaches over the rim, and outside of one; with few rays, too."""
    centre = 1.0 + radius - depth if sign > 0 else abs(radius - 1.0) + depth
    exact = round_part(centre, radius, sign)
    Q, T = turned(round_form([centre, 0.0], radius, sign), 6)
    for rays, error in ((COARSE, 3e-6), (FINE, 3e-8)):
        P = section_moments(Q, T[:3, 2], rays)
        np.testing.assert_allclose(P, T @ exact @ T.T, atol=error * exact[3, 3], rtol=0.0)


@pytest.mark.parametrize(
    ("at", "radius"), [(0.4, 0.3), (0.8, 0.5), (0.999, 0.02), (0.4, 1e-3), (0.99, 1e-4)]
)
def test_a_bore_off_the_middle_has_the_volume_of_a_quadrature(at, radius):
    """Inside, across the rim, and thin."""

    def thickness(turn):
        along = at * np.cos(turn)
        end = min(radius, -along + np.sqrt(along**2 + 1.0 - at * at))

        def height(rho):
            return rho * np.sqrt(max(1.0 - at * at - 2.0 * rho * along - rho * rho, 0.0))

        return 2.0 * quad(height, 0.0, end, epsabs=0.0)[0]

    exact = 2.0 * quad(thickness, 0.0, np.pi, epsabs=0.0, epsrel=1e-7, limit=200)[0]
    Q, T = turned(round_form([at, 0.0], radius), 5)
    stock = Stock(BALL, 1.0, T @ np.diag([1.0, 1.0, -1.0, 1.0]) @ T.T).with_rays_inside(Q)
    assert fill(stock, Q)[3, 3] == pytest.approx(exact, rel=1e-6, abs=0.0)


def test_products_over_the_surface_are_the_derivative_of_the_moments():
    """Moments of forms that differ little, by central differences."""
    Q, axis, basis = round_form([0.5, -0.3], 0.4), np.eye(3)[2], symmetric_basis()
    S = section_products(Q, axis, FINE, basis)
    for k, B in enumerate(basis):
        if np.any(B[:, 2]):
            continue  # Such a change is not constant along the axis.
        sides = [section_moments(Q + x * B, axis, FINE) for x in (1e-4, -1e-4)]
        np.testing.assert_allclose(
            S[k], triangles(sides[0] - sides[1]) / 2e-4, atol=1e-6 * np.abs(S).max()
        )


@pytest.mark.parametrize("constant", [-0.4, 0.3])
def test_products_over_a_disc_are_the_derivative_of_the_moments_of_caps(constant):
    """Closed forms of caps that differ little, by central differences; none beyond the rim."""
    normal, basis = np.array([0.3, 0.5, 0.2]), symmetric_basis()
    S = disc_products(normal, constant, basis)
    for k, B in enumerate(basis):
        if B[:3, :3].any():
            continue  # Such a change makes the plane a quadric.
        sides = [
            cut_moments(BALL, normal + 2.0 * x * B[:3, 3], constant + x * B[3, 3])
            for x in (1e-5, -1e-5)
        ]
        np.testing.assert_allclose(
            S[k], triangles(sides[0] - sides[1]) / 2e-5, atol=1e-8 * np.abs(S).max()
        )
    np.testing.assert_allclose(S, S.T, atol=1e-15)
    assert not disc_products(normal, 0.62, basis).any()


def test_a_step_is_the_best_within_its_radius():
    """None of many steps that are as long or shorter gains more."""
    rng = np.random.default_rng(2)
    for radius, flat in ((0.1, 0), (10.0, 0), (1.0, 2)):
        A, g = rng.normal(size=(6, 6)), rng.normal(size=6)
        A[:, :flat] = 0.0
        H = A.T @ A
        step = _best_step(H, g, radius)
        length = np.linalg.norm(step.change)
        assert length <= 1.06 * radius
        others = rng.normal(size=(4000, 6))
        others *= length * rng.random((4000, 1)) / np.linalg.norm(others, axis=1)[:, None]
        others = np.vstack([others, 0.99 * step.change + 0.01 * others])
        others *= np.minimum(1.0, length / np.linalg.norm(others, axis=1))[:, None]
        gains = others @ g - 0.5 * np.einsum("ni,ij,nj->n", others, H, others)
        assert gains.max() <= step.predicted + 1e-12
        assert step.predicted == pytest.approx(
            g @ step.change - 0.5 * step.change @ H @ step.change, rel=1e-9
        )


def program_of(balls, height=0.0):
    """The program of an antiparallelogram in space, and balls on its links."""
    space = recompute_spatial(balance.design_space("four_bar_antiparallelogram"))
    stocks = {
        b: Stock(ball_region([0.1 * b, 0.0, height * b], 2.0), 1.0)
        for b in range(len(space.bodies))[:balls]
    }
    regions = {b: stock.region for b, stock in stocks.items()}
    return build_added_program(space, regions, "mass"), stocks


@pytest.mark.slow
def test_matter_in_halves_fulfils_all_conditions_and_is_the_least():
    """Those that are left out too; and matter of any form, by rays in space, is no less."""
    program, stocks = program_of(3)
    halved, matter = halved_by_plane(program, stocks)
    assert halved.target.size < program.target.size
    density = 1.5 * density_needed(halved, matter).factor
    results = []
    for each, parts in ((halved, matter), (program, list(stocks.values()))):
        parts = [stock._replace(density=density) for stock in parts]
        needed = density_needed(each, parts)
        filled = fill_least(each, parts, needed)
        left = program.target - conditions_of(program, filled.moments)
        assert np.linalg.norm(left) <= 1e-10
        results.append((filled.moments[:, 3, 3].sum(), filled.bound))
    (mass, bound), (whole, whole_bound) = results
    # Rays in space are off by as much as their bound is from their mass.
    error = 2.0 * abs(whole - whole_bound)
    assert whole_bound - error <= mass <= whole + error
    assert bound == pytest.approx(mass, rel=1e-6)


def test_what_is_not_symmetric_stays_as_it_is():
    """Balls off the plane, and cylinders aslant to it: no mirror image of theirs will do."""
    program, stocks = program_of(3, height=0.1)
    assert halved_by_plane(program, stocks)[0] is program
    program, stocks = program_of(3)
    stocks[1] = Stock(cylinder_region([0.0, 0.0, 0.0], [1.0, 0.0, 1.0], 1.0, 1.0), 1.0)
    halved, matter = halved_by_plane(program, stocks)
    assert halved is program and all(stock.mirror is None for stock in matter)


@pytest.mark.slow
def test_much_denser_matter_comes_near_to_point_masses_whatever_the_last_bits():
    """To first order in one over the density; lengths and masses are changed by round-off."""
    space = balance.design_space("four_bar_antiparallelogram")

    def mass_at(density, place=0.0):
        regions = {name: ball_region([place, 0.0, 0.0], 2.0) for name in space.bodies}
        matter = balance.counterweights(space, list(space.bodies), regions, density=density)
        assert matter.verdict == "feasible"
        return matter.added_mass

    points, thin, dense = mass_at(None), mass_at(6e3), mass_at(12e3)
    assert points < dense < thin
    assert 2.0 * dense - thin == pytest.approx(points, rel=1e-3)
    for change in (1e-15, -1e-15, 3e-15):
        near = mass_at(12e3 * (1.0 + change), change)
        assert near == pytest.approx(dense, rel=1e-8)
