"""Parts of prisms that a cylinder cuts, and boxes that are turned."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import balance
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.regions import hull_region
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from kinematics.errors import UsageError

BOX = read_region("box(-1:1,-1:1,-1:1)")
CYLINDER = read_region("cylinder(0,0,0,0,0,1,1,2)")
STEEL = 7850.0


def test_a_quarter_of_a_disc_in_the_corner_of_a_box_is_that_of_the_textbook():
    """π r²/4 and 4 r/(3 π) from its sides, through a box that is 2 thick; else the rest."""
    r = 0.8
    Q = np.diag([-1.0, -1.0, 0.0, r * r - 2.0])
    Q[:2, 3] = Q[3, :2] = -1.0  # r² - (x + 1)² - (y + 1)²
    volume, at = 0.5 * np.pi * r * r, 4.0 * r / (3.0 * np.pi) - 1.0
    for sign, share in ((1.0, 0.0), (-1.0, 1.0)):
        P = sign * fill(Stock(BOX, 1.0).with_rays_inside(sign * Q), sign * Q)
        P = P + share * np.diag([8 / 3, 8 / 3, 8 / 3, 8.0])
        np.testing.assert_allclose(P[3, 3], volume, rtol=1e-6)
        np.testing.assert_allclose(P[:3, 3], [volume * at, volume * at, 0.0], atol=1e-6)
        assert P[2, 2] == pytest.approx(volume / 3.0, rel=1e-6)


def test_a_prism_is_summed_along_any_axis():
    """A circle that cuts a box along x has the moments of one along z, turned."""
    rng = np.random.default_rng(4)
    c, r = rng.uniform(-0.6, 0.6, 2), 0.9
    parts = []
    for first, second in ((0, 1), (1, 2), (2, 0)):
        Q = np.zeros((4, 4))
        Q[first, first] = Q[second, second] = -1.0
        Q[first, 3] = Q[3, first] = c[0]
        Q[second, 3] = Q[3, second] = c[1]
        Q[3, 3] = r * r - c @ c
        order = [first, second, 3 - first - second, 3]
        parts.append(fill(Stock(BOX, 1.0), Q)[np.ix_(order, order)])
    np.testing.assert_allclose(parts[1], parts[0], atol=1e-6)
    np.testing.assert_allclose(parts[2], parts[0], atol=1e-6)


def test_a_turned_box_is_the_hull_of_its_turned_corners():
    """Its middle stays, and as much matter in it balances."""
    angles, middle, half = (0.3, -0.2, 0.7), np.array([0.1, -0.3, 0.0]), [0.1, 0.15, 0.05]
    turned = read_region("box(0:0.2,-0.45:-0.15,-0.05:0.05,0.3,-0.2,0.7)")
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T * half
    corners = Rotation.from_euler("xyz", angles).apply(corners) + middle
    hull = hull_region(corners)
    points = middle + np.random.default_rng(1).uniform(-0.2, 0.2, (4000, 3))
    assert (turned.contains(points, 0.0) == hull.contains(points, 0.0)).all()
    assert turned.volume == pytest.approx(0.2 * 0.3 * 0.1, rel=1e-12)
    assert read_region(turned.text).contains(corners, 1e-9).all()
    degrees = read_region("box(-0.3:-0.1,-0.05:0.05,-20mm:20mm,0,0,90deg)")
    np.testing.assert_allclose(degrees.to_unit([-0.2, 0.1, 0.0]), [1, 0, 0], atol=1e-12)
    space = balance.design_space("four_bar_general", balance="force")
    masses = [
        balance.counterweights(space, ["crank", "rocker"], {"rocker": region}).added_mass
        for region in (turned, hull)
    ]
    assert masses[0] > 0.0 and masses[0] == pytest.approx(masses[1], rel=1e-9)
    for wrong in ("box(0:1,0:1,0:1,0.1)", "box(0:1,0:1,0,1,2,3)", "box(0:1,0:1,0:1,0:1,0,0)"):
        with pytest.raises(UsageError, match="or with ,roll,pitch,yaw"):
            read_region(wrong)


@pytest.mark.parametrize("seed", range(4))
def test_the_part_of_a_plate_that_a_quadric_cuts_off_is_in_equal_halves(seed):
    """Nothing is left of the products with the normal, although rays are not mirrored."""
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    stock = Stock(CYLINDER, STEEL, mirror)
    form = np.random.default_rng(seed).normal(size=(4, 4))
    form = form + form.T
    P, doubled = (
        fill(stock, form),
        fill(Stock(CYLINDER, STEEL), form + mirror @ form @ mirror),
    )
    assert np.abs(P[2, [0, 1, 3]]).max() <= 1e-15 * P[3, 3]
    # The same part, and the same matter in all that is even.
    even = [(0, 0), (0, 1), (1, 1), (2, 2), (0, 3), (1, 3), (3, 3)]
    for i, j in even:
        assert P[i, j] == pytest.approx(doubled[i, j], abs=1e-9 * P[3, 3])
