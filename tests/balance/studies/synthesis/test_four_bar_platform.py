"""Platforms on three legs of four-bars: Pinocchio alone, and the condition on the platform."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from balance import verify
from balance.studies import FourBarPlatform, StackedFourBar, four_bar_platform_urdf
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planar_in_pinocchio import PlanarFile

INPUTS = [f"crank_joint_{leg}_1" for leg in (1, 2, 3)]

# Farthest turn of a joint, radians: cranks start 69° from a change point or more.
FARTHEST = 0.5


def random_platform(seed):
    """Hinges of a triangle of about 0.3 m, and legs of antiparallelograms of all sizes."""
    rng = np.random.default_rng(seed)
    corners = 0.2 * np.exp(1j * (np.array([-2.6, -0.4, 1.6]) + rng.uniform(-0.3, 0.3, 3)))

    def four_bar(crank, angle):
        side = float(rng.choice([-1.0, 1.0]))
        return StackedFourBar(
            crank=crank * float(rng.uniform(0.8, 1.2)),
            ratio=float(rng.uniform(2.2, 3.5)),
            crank_angle=side * float(rng.uniform(1.2, 1.9)),
            base_angle=angle + float(rng.uniform(-0.3, 0.3)),
        )

    legs = tuple((four_bar(0.2, way), four_bar(0.12, 1.5)) for way in (0.3, 2.4, -1.6))
    return FourBarPlatform(tuple(corners.tolist()), legs)


def shares(model, turns):
    """Mass matrix over the geometric means of its diagonal, where no joint turns far.

    Otherwise a four-bar may pass a change point, and be a parallelogram beyond it.
    """
    turns = np.array(turns)
    while model.turn_to(turns) > FARTHEST:
        turns = 0.5 * turns
    M = model.mass_matrix()
    own = np.sqrt(np.diagonal(M))
    return M, M / np.outer(own, own)


def platform_of(urdf):
    """Mass, centre and moment of inertia of the platform, its frame at the first hinge."""
    link = ElementTree.fromstring(urdf).find("link[@name='platform']/inertial")
    x, y, _ = map(float, link.find("origin").get("xyz").split())
    turned = [float(a) for a in link.find("origin").get("rpy", "0 0 0").split()]
    assert turned[:2] == [0.0, 0.0]
    return (
        float(link.find("mass").get("value")),
        complex(x, y),
        float(link.find("inertia").get("izz")),
    )


@pytest.fixture(scope="module", params=range(number_of_cases(1, 6)))
def case(request):
    sizes = random_platform(request.param)
    return sizes, four_bar_platform_urdf(sizes, density=None)


@pytest.mark.slow
def test_it_leaves_no_reactions_at_random_poses(case):
    """CRBA on a free base, loops closed: no term between base and drives; a constant base."""
    _, urdf = case
    model, rng, bases = PlanarFile(urdf, INPUTS), np.random.default_rng(1), []
    for turns in rng.uniform(-0.05, 0.05, (5, 3)):
        M, scaled = shares(model, turns)
        assert np.abs(scaled[:3, 3:]).max() < 1e-9
        # The platform joins the legs: the drives are not decoupled.
        assert np.abs(scaled[3:, 3:] - np.eye(3)).max() > 1e-3
        bases.append(M[:3, :3])
    assert np.ptp(bases, axis=0).max() < 1e-9 * np.abs(bases).max()


@pytest.mark.slow
def test_the_platform_is_three_point_masses_at_its_hinges(case):
    """Shares by mass and centre, and the moment of inertia from them."""
    sizes, urdf = case
    mass, centre, moment = platform_of(urdf)
    at = np.array(sizes.hinges) - sizes.hinges[0]
    points = np.linalg.solve(
        [np.ones(3), at.real, at.imag], [mass, mass * centre.real, mass * centre.imag]
    )
    assert moment == pytest.approx(points @ np.abs(at - centre) ** 2, rel=1e-7)
    assert moment > 0.0


@pytest.mark.slow
def test_another_moment_of_inertia_of_the_platform_shakes(case):
    _, urdf = case
    text = urdf.decode()
    start = text.index("izz=", text.index('<link name="platform">'))
    first, value, rest = text[start:].split('"', 2)
    heavy = f'{text[:start]}{first}"{1.01 * float(value)!r}"{rest}'
    scaled = shares(PlanarFile(heavy.encode(), INPUTS), [0.04, -0.02, 0.05])[1]
    assert np.abs(scaled[:3, 3:]).max() > 1e-7


@pytest.mark.slow
def test_the_product_agrees():
    """Steel by default; random motions of all three inputs do not shake."""
    linkage = load(Document("platform", four_bar_platform_urdf()))
    assert linkage.mobility == 3 and list(linkage.inputs) == INPUTS
    checked = verify(linkage, trajectories=2)
    assert checked.balanced and checked.moment_residual < 1e-9


SIZES = FourBarPlatform()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"hinges": SIZES.hinges[:2]}, "three hinges and three legs"),
        ({"legs": SIZES.legs[:2]}, "three hinges and three legs"),
        ({"hinges": (0j, 1 + 0j, 2 + 0.01j)}, "in line"),
        ({"hinges": (0j, 1 + 0j, complex("nan"))}, "in line, or not finite"),
        ({"platform_mass": 0.0}, "must be positive"),
        ({"legs": (SIZES.legs[0][:1], *SIZES.legs[1:])}, "leg 1 .* lower and an upper"),
        (
            {"legs": (*SIZES.legs[:2], (StackedFourBar(), StackedFourBar(ratio=1.3)))},
            "leg 3 of the platform: four-bar 2 .* no masses",
        ),
    ],
)
def test_platforms_that_cannot_be_are_refused(change, said):
    with pytest.raises(UsageError, match=said):
        four_bar_platform_urdf(SIZES._replace(**change))


@pytest.mark.slow
def test_matter_that_is_too_thin_is_said():
    with pytest.raises(UsageError, match="no matter of at most 7850"):
        four_bar_platform_urdf(thickness=1e-4)
