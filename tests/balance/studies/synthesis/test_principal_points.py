"""Principal points of random masses: centres of the file, and momentum by Pinocchio alone."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from balance import verify
from balance.studies import PrincipalVectors, principal_points, principal_vector_urdf
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planar_in_pinocchio import PlanarFile

ROD = 0.3


def random_elements(n, seed=0):
    """Joints, masses and centres of elements in a ring, and a hinge that could close it.

    The first draw of which no parallelogram is nearly flat.
    """
    rng = np.random.default_rng([n, seed, 7])
    while True:
        joints, masses, centres, closing = draw(n, rng)
        P = np.array(principal_points(joints, masses, centres, ROD))
        a, b = P[:-1] - joints, P[1:] - joints
        flat = np.sin(np.angle(a[:, None] / b))[np.triu_indices(n - 1)]
        if np.abs(flat).min() > 0.1:
            return joints, masses, centres, closing


def draw(n, rng):
    ring = np.exp(2j * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n)
    masses, centres = (
        rng.uniform(0.5, 3.0, n),
        rng.normal(0, 0.3, n) + 1j * rng.normal(0, 0.3, n),
    )
    ends = np.roll(ring, 1)
    centres += 0.5 * (ring + ends)
    return ring[:-1].tolist(), masses.tolist(), centres.tolist(), complex(ring[-1])


def linkage_of(n, seed=0, closed=False):
    """Elements with given masses and centres, on the points that follow from them."""
    joints, masses, centres, closing = random_elements(n, seed)
    return PrincipalVectors(
        joints=tuple(joints),
        points=principal_points(joints, masses, centres, ROD),
        element_mass=tuple(masses),
        rod_mass=ROD,
        decoupled=False,
        closing=closing if closed else None,
    )


def rods_are_parallel(model):
    """Whether each rod turned as its element; flat parallelograms may fold on the way."""
    for link in model.links:
        turned = model.frame(link).rotation - model.frame(f"element{link[-1]}").rotation
        if np.abs(turned).max() > 1e-6:
            return False
    return True


def momenta(model, turns):
    """Momentum for unit rates of the inputs, over the sum of that of the bodies in size.

    The velocities of the bodies are taken with √(M_ii m): the largest momentum there can be.
    """
    turns = np.array(turns)
    while model.turn_to(turns, 4) > 3.0 or not rods_are_parallel(model):
        turns = 0.5 * turns
        assert np.abs(turns).max() > 1e-3
    M = model.mass_matrix()
    most = np.sqrt(np.diagonal(M)[3:] * M[0, 0])
    return M[:3, 3:] / most


@pytest.mark.parametrize("n", [2, 3, pytest.param(6, marks=pytest.mark.slow)])
def test_elements_keep_their_masses_and_centres(n):
    """The file has the given elements, although its rods have mass."""
    for seed in range(number_of_cases(1, 10)):
        _, masses, centres, _ = random_elements(n, seed)
        vectors = linkage_of(n, seed)
        root = ElementTree.fromstring(principal_vector_urdf(vectors))
        for i, (mass, centre) in enumerate(zip(masses, centres, strict=True)):
            inertial = root.find(f"link[@name='element{i + 1}']/inertial")
            x, y, _ = map(float, inertial.find("origin").get("xyz").split())
            assert float(inertial.find("mass").get("value")) == pytest.approx(mass, rel=1e-12)
            assert abs(vectors.points[i] + complex(x, y) - centre) < 1e-9


@pytest.mark.parametrize(
    "n", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, 4, 5, 6))]
)
def test_open_chains_have_no_linear_momentum(n):
    """By Pinocchio on a free base, in random poses; a rod that is heavier is seen."""
    urdf = principal_vector_urdf(linkage_of(n))
    model = PlanarFile(urdf, load(Document("open", urdf)).inputs)
    poses = np.random.default_rng(n).uniform(-0.1, 0.1, (3, n))
    for turns in poses:
        shares = momenta(model, turns)
        assert np.abs(shares[:2]).max() < 1e-9
    assert np.abs(shares[2]).max() > 1e-3
    heavy = urdf.replace(f'<mass value="{ROD}"/>'.encode(), b'<mass value="0.31"/>', 1)
    assert heavy != urdf
    model = PlanarFile(heavy, load(Document("heavy", heavy)).inputs)
    assert np.abs(momenta(model, poses[0])[:2]).max() > 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("n", [4, 5, 6])
def test_closed_chains_have_no_linear_momentum(n):
    for seed in range(number_of_cases(1, 5)):
        urdf = principal_vector_urdf(linkage_of(n, seed, closed=True))
        linkage = load(Document("closed", urdf))
        assert linkage.mobility == n - 2
        model, rng = PlanarFile(urdf, linkage.inputs), np.random.default_rng(seed)
        for turns in rng.uniform(-0.1, 0.1, (3, n - 2)):
            assert np.abs(momenta(model, turns)[:2]).max() < 1e-9


@pytest.mark.slow
def test_the_product_agrees():
    linkage = load(Document("closed", principal_vector_urdf(linkage_of(4, closed=True))))
    checked = verify(linkage, balance="force", trajectories=1)
    assert checked.balanced and checked.force_residual < 1e-9


CHAIN = linkage_of(4, closed=True)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"element_mass": (1.0, 2.0)}, "2 masses of 4 elements"),
        ({"element_mass": (1.0, 2.0, -1.0, 1.0)}, "element_mass = -1"),
        ({"turns": (1.0, -1.0, 1.0, -1.0)}, "take decoupled"),
        ({"turns": (1.0, -1.0, 1.0, -1.0), "decoupled": True}, "are not constant"),
        ({"closing": CHAIN.joints[0]}, "closing hinge is at a joint"),
        ({"closing": complex("nan")}, "closing hinge is at a joint"),
        (
            {"points": CHAIN.points[:3], "joints": CHAIN.joints[:2], "element_mass": 1.0},
            "4 elements",
        ),
    ],
)
def test_linkages_that_do_not_exist_are_refused(change, said):
    with pytest.raises(UsageError, match=said):
        principal_vector_urdf(CHAIN._replace(**change))


@pytest.mark.parametrize(
    ("masses", "centres", "said"),
    [
        ([1.0], [0j], "give 2 to 8 masses"),
        ([1.0, 2.0], [0j], "give 2 to 8 masses"),
        ([1.0, 0.0], [0j, 1j], "positive masses"),
        ([1.0, 2.0], [0j, complex("inf")], "finite numbers"),
    ],
)
def test_points_of_nothing_are_refused(masses, centres, said):
    with pytest.raises(UsageError, match=said):
        principal_points([1.0], masses, centres)
