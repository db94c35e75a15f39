"""Platforms on legs of parallelepipeds: Pinocchio alone, freedoms, and the point masses."""

from __future__ import annotations

from itertools import product
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from balance import certify, design_space, verify
from balance.studies import ParallelepipedPlatform, parallelepiped_platform_urdf
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planar_in_pinocchio import vector_of
from tests.support.spatial_in_pinocchio import SpatialFile

SIZES = ParallelepipedPlatform()
# Farthest turn of a joint that is no rotor, radians: edges are in line with a carrier at 90°,
# in legs at random from 57° on.
FARTHEST = 0.6


def random_platform(seed, freedoms):
    """The default legs turned in space as a whole, each a little skew, all sizes other."""
    rng = np.random.default_rng([seed, freedoms])
    turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turned *= np.sign(np.linalg.det(turned))
    legs = np.array(SIZES.legs) * rng.uniform(0.8, 1.2, (3, 3, 1))
    legs += rng.uniform(-0.03, 0.03, (3, 3, 3))
    hinges = np.array(SIZES.hinges) + rng.uniform(-0.03, 0.03, (3, 3))
    return SIZES._replace(
        freedoms=freedoms,
        hinges=tuple(map(tuple, (hinges @ turned.T).tolist())),
        legs=tuple(tuple(map(tuple, leg)) for leg in (legs @ turned.T).tolist()),
        shares=tuple(rng.uniform(0.2, 1.0, 3).tolist()),
        carrier_mass=float(rng.uniform(0.02, 0.2)),
        counter=float(rng.uniform(0.6, 1.4)),
        ratio=float(rng.uniform(4.0, 12.0)),
    )


def inputs_of(freedoms):
    """Names of the driven edges."""
    return [f"edge_joint_{leg}_{k}" for leg in (1, 2, 3) for k in range(1, freedoms // 3 + 1)]


def scaled_mass_matrix(model, turns):
    """Mass matrix over the geometric means of its diagonal, where no edge turns far."""
    for halvings in range(6):
        closed = model.turn_to(0.5**halvings * np.array(turns), steps=20) < np.inf
        turned = pin.difference(model.model, pin.neutral(model.model), model.q)
        if closed and np.abs(turned[[*model.free, *model.others]]).max() < FARTHEST:
            break
    else:
        pytest.fail("no edge turns so little")
    M = model.mass_matrix()
    own = np.sqrt(np.diagonal(M))
    return M / np.outer(own, own)


@pytest.fixture(scope="module", params=product(range(number_of_cases(1, 3)), (3, 6)))
def case(request):
    sizes = random_platform(*request.param)
    return sizes, parallelepiped_platform_urdf(sizes)


@pytest.mark.slow
def test_it_leaves_no_reactions_at_random_poses(case):
    """CRBA on a free base with the loops closed: no term between the base and the inputs."""
    sizes, urdf = case
    model, rng = SpatialFile(urdf, inputs_of(sizes.freedoms)), np.random.default_rng(1)
    for turns in rng.uniform(-0.3, 0.3, (4, sizes.freedoms)):
        scaled = scaled_mass_matrix(model, turns)
        assert np.abs(scaled[:6, 6:]).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("link", ["rotor_2_3", "edge_1_2", "carrier_3_1", "twin_3_3"])
def test_a_heavier_link_is_seen(link):
    """By 1 %, at a random pose."""
    urdf = scaled_link(parallelepiped_platform_urdf(), link, 1.01)
    scaled = scaled_mass_matrix(SpatialFile(urdf, inputs_of(6)), [0.1, -0.05, 0.02] * 2)
    assert np.abs(scaled[:6, 6:]).max() > 1e-6


def scaled_link(urdf, link, by, tag="mass"):
    """The file with the masses and moments of inertia of a link scaled, or the latter alone."""
    root = ElementTree.fromstring(urdf)
    inertial = root.find(f"link[@name='{link}']/inertial")
    for element in inertial.iter():
        if element.tag in (tag, "inertia"):
            for key in element.attrib:
                element.set(key, repr(by * float(element.get(key))))
    return ElementTree.tostring(root)


@pytest.mark.slow
def test_the_tensor_of_the_platform_matters_if_it_turns():
    """Of ten times the moments of inertia: shakes with six freedoms, not with three."""
    for freedoms in (3, 6):
        urdf = parallelepiped_platform_urdf(SIZES._replace(freedoms=freedoms))
        heavy = scaled_link(urdf, "platform", 10.0, tag="inertia")
        model = SpatialFile(heavy, inputs_of(freedoms))
        scaled = scaled_mass_matrix(model, np.resize([0.1, -0.05, 0.07], freedoms))
        shaking = np.abs(scaled[:6, 6:]).max()
        assert shaking < 1e-9 if freedoms == 3 else shaking > 1e-5


@pytest.mark.parametrize("freedoms", [3, 6])
def test_the_platform_is_three_point_masses_at_its_hinges(freedoms):
    """Its mass, first and second moments, from the file."""
    sizes = random_platform(5, freedoms)
    root = ElementTree.fromstring(parallelepiped_platform_urdf(sizes))
    inertial = root.find("link[@name='platform']/inertial")
    centre = vector_of(inertial.find("origin"))
    entry = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
    tensor = np.array([[entry["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    points, masses = np.array(sizes.hinges) - sizes.hinges[0], np.array(sizes.shares)
    assert float(inertial.find("mass").get("value")) == pytest.approx(masses.sum(), rel=1e-14)
    assert centre == pytest.approx(masses @ points / masses.sum(), abs=1e-11)
    # Second moments Σ m r rᵀ about the centre: half the trace less the tensor.
    second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    arms = points - centre
    assert second == pytest.approx(np.einsum("i,ij,ik", masses, arms, arms), abs=1e-11)


@pytest.mark.parametrize("freedoms", [3, 6])
def test_the_platform_moves_in_all_its_freedoms(freedoms):
    """Its twists by Pinocchio: as many as inputs, and no turn with three."""
    urdf = parallelepiped_platform_urdf(SIZES._replace(freedoms=freedoms))
    model, names = SpatialFile(urdf, inputs_of(freedoms)), inputs_of(freedoms)
    twists = []
    for k in range(freedoms):
        model.turn_to(1e-4 * np.eye(freedoms)[k], steps=1)
        frame = model.frame("platform")
        twists.append(pin.log6(still_frame(urdf, names).actInv(frame)).vector / 1e-4)
    twists = np.array(twists)
    assert np.linalg.matrix_rank(twists, tol=1e-2) == freedoms
    if freedoms == 3:
        assert np.abs(twists[:, 3:]).max() < 1e-9


def still_frame(urdf, names):
    """The frame of the platform at the pose of the file."""
    model = SpatialFile(urdf, names)
    model.turn_to(np.zeros(len(names)), steps=1)
    return model.frame("platform").copy()


@pytest.mark.slow
@pytest.mark.parametrize("freedoms", [3, 6])
def test_the_product_agrees(freedoms):
    """Design space with exact arithmetic, and random motions of all inputs."""
    urdf = parallelepiped_platform_urdf(SIZES._replace(freedoms=freedoms))
    linkage = load(Document("platform", urdf))
    assert linkage.mobility == freedoms and list(linkage.inputs) == inputs_of(freedoms)
    space = certify(design_space(linkage))
    assert space.as_given.balanced and space.certainty.level == "verified"
    checked = verify(linkage, trajectories=2)
    assert checked.balanced and checked.moment_residual < 1e-9


FLAT_LEG = ((0.0, 0.0, 0.25), (0.2, 0.0, 0.0), (0.1, 0.0, 0.1))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"freedoms": 4}, "give 3 or 6"),
        ({"hinges": SIZES.hinges[:2]}, "three hinges, three shares and three legs"),
        ({"legs": (SIZES.legs[0][:2], *SIZES.legs[1:])}, "three legs of edges"),
        ({"shares": (0.3, 0.0, 0.3)}, r"shares\[1\] = 0 must be positive"),
        ({"ratio": float("inf")}, "ratio = inf must be positive"),
        ({"legs": (*SIZES.legs[:2], FLAT_LEG)}, "leg 3 is flat"),
        ({"legs": (((0.0, 0.0, 0.0),) * 3, *SIZES.legs[1:])}, "leg 1 is flat, or not finite"),
        ({"hinges": ((0, 0, 0), (1, 0, 0), (2, 0, 0.01))}, "in line, or not finite"),
        ({"hinges": ((0, 0, 0), (1, 0, 0), (0, float("nan"), 0))}, "in line, or not finite"),
        ({"legs": SIZES.legs[:1] * 3, "freedoms": 3}, "do not move it in all freedoms"),
        ({"legs": SIZES.legs[:1] * 3}, "do not move it in all freedoms"),
    ],
)
def test_platforms_that_cannot_be_are_refused(change, said):
    with pytest.raises(UsageError, match=said):
        parallelepiped_platform_urdf(SIZES._replace(**change))
