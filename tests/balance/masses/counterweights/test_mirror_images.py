"""Matter that is its own mirror image, sections of balls, and steps within a radius."""

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
from balance.masses.counterweights.volume.cut_regions import FINE, Stock, cut_moments, fill
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
    """4π/3 (1 - a²)^(3/2) and its second moments, along any axis and from any place."""
    s = np.sqrt(1.0 - a * a)
    xx, zz = 2.0 * np.pi * (s**3 / 3.0 - s**5 / 5.0), 4.0 * np.pi / 15.0 * s**5
    exact = np.diag([xx, xx, zz, 4.0 / 3.0 * np.pi * s**3])
    Q, T = turned(round_form([0.0, 0.0], a, -1.0), 3)
    axis = np.ascontiguousarray(T[:3, 2])
    # Rays from beside a thin bore touch it, which costs accuracy.
    places = ((0.0, 0.0, 0.9), 1e-11), ((0.05, 0.1, 0.9), 1e-11), ((0.6, -0.3, 0.5), 1e-4)
    for origin, error in places:
        at = tuple((T[:3, :3] @ origin).tolist())
        P = section_moments(Q, axis, FINE, at)
        np.testing.assert_allclose(P, T @ exact @ T.T, atol=error)


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (0.6, 0.6, 0.1), (0.97, 0.0, 0.0)])
def test_a_whole_ball_has_the_moments_of_the_textbook_from_any_place(origin):
    """To round-off: parts far thinner than the ball are no smaller than its error."""
    P = section_moments(np.diag([0.0, 0.0, 0.0, 1.0]), np.eye(3)[2], FINE, origin)
    exact = 4.0 / 15.0 * np.pi * np.diag([1.0, 1.0, 1.0, 5.0])
    np.testing.assert_allclose(P, exact, atol=1e-13)


@pytest.mark.parametrize(
    ("at", "radius"), [(0.4, 0.3), (0.8, 0.5), (0.999, 0.02), (0.4, 1e-3), (0.99, 1e-4)]
)
def test_a_bore_off_the_middle_has_the_volume_of_a_quadrature(at, radius):
    """Inside, across the rim, and so thin that rays from afar would miss it."""

    def thickness(turn):
        along = at * np.cos(turn)
        end = min(radius, -along + np.sqrt(along**2 + 1.0 - at * at))

        def height(rho):
            return rho * np.sqrt(max(1.0 - at * at - 2.0 * rho * along - rho * rho, 0.0))

        return 2.0 * quad(height, 0.0, end, epsabs=0.0)[0]

    exact = 2.0 * quad(thickness, 0.0, np.pi, epsabs=0.0, epsrel=1e-7, limit=200)[0]
    Q, T = turned(round_form([at, 0.0], radius), 5)
    stock = Stock(BALL, 1.0, T @ np.diag([1.0, 1.0, -1.0, 1.0]) @ T.T).with_rays_inside(Q)
    assert fill(stock, Q)[3, 3] == pytest.approx(exact, rel=2e-5, abs=0.0)


def test_products_over_the_surface_are_the_derivative_of_the_moments():
    """Moments of forms that differ little, by central differences."""
    Q, axis, basis = round_form([0.5, -0.3], 0.4), np.eye(3)[2], symmetric_basis()
    inside = (0.5, -0.3, 0.1)
    S = section_products(Q, axis, FINE, inside, basis)
    for k, B in enumerate(basis):
        if np.any(B[:, 2]):
            continue  # Such a change is not constant along the axis.
        sides = [section_moments(Q + x * B, axis, FINE, inside) for x in (1e-4, -1e-4)]
        np.testing.assert_allclose(
            S[k], triangles(sides[0] - sides[1]) / 2e-4, atol=1e-4 * np.abs(S).max()
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
