"""Platforms on legs of parallelepipeds: Pinocchio alone, freedoms, and the point masses."""

from __future__ import annotations

from itertools import product
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from balance import certify, design_space, verify
from balance.studies import (
    ParallelepipedPlatform,
    equivalent_points,
    parallelepiped_platform_urdf,
)
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planar_in_pinocchio import vector_of
from tests.support.spatial_in_pinocchio import SpatialFile

SIZES = ParallelepipedPlatform()
# Farthest turn of a joint that is no rotor, radians: parallelograms are flat at 90°.
FARTHEST = 0.6


FOURTH = ((0.0, 0.0, 0.25), (0.0, 0.2, 0.0), (0.15, 0.0, 0.0))
# Moments of inertia of a body, kg m², of any thickness.
BODY = np.diag([0.012, 0.015, 0.02])


def on_four_legs(freedoms):
    """A body of 1 kg on four legs."""
    hinges, masses = equivalent_points(1.0, (0.0, 0.0, 0.0), BODY)
    return SIZES._replace(
        freedoms=freedoms, hinges=hinges, shares=masses, legs=(*SIZES.legs, FOURTH)
    )


def random_platform(seed, freedoms, start=SIZES):
    """Legs turned in space as a whole, each a little skew, all sizes other."""
    rng = np.random.default_rng([seed, freedoms])
    turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turned *= np.sign(np.linalg.det(turned))
    legs = np.array(start.legs) * rng.uniform(0.8, 1.2, (len(start.legs), 3, 1))
    legs += rng.uniform(-0.03, 0.03, legs.shape)
    hinges = np.array(start.hinges)
    hinges += rng.uniform(-0.03, 0.03, hinges.shape)
    return SIZES._replace(
        freedoms=freedoms,
        hinges=tuple(map(tuple, (hinges @ turned.T).tolist())),
        legs=tuple(tuple(map(tuple, leg)) for leg in (legs @ turned.T).tolist()),
        shares=tuple(rng.uniform(0.2, 1.0, len(legs)).tolist()),
        carrier_mass=float(rng.uniform(0.02, 0.2)),
        counter=float(rng.uniform(0.6, 1.4)),
        ratio=float(rng.uniform(4.0, 12.0)),
    )


def inputs_of(freedoms, legs=3):
    """Names of the driven edges, in the order of the file."""
    by_edge = [f"edge_joint_{leg}_{k}" for k in (1, 2) for leg in range(1, legs + 1)]
    return sorted(by_edge[:freedoms])


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


@pytest.fixture(scope="module", params=product(range(number_of_cases(1, 3)), (3, 6), (3, 4)))
def case(request):
    seed, freedoms, legs = request.param
    sizes = random_platform(seed, freedoms, SIZES if legs == 3 else on_four_legs(freedoms))
    return sizes, parallelepiped_platform_urdf(sizes)


@pytest.mark.slow
def test_it_leaves_no_reactions_at_random_poses(case):
    """CRBA on a free base with the loops closed: no term between the base and the inputs."""
    sizes, urdf = case
    inputs, rng = inputs_of(sizes.freedoms, len(sizes.legs)), np.random.default_rng(1)
    model = SpatialFile(urdf, inputs)
    for turns in rng.uniform(-0.3, 0.3, (3, sizes.freedoms)):
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


def platform_of(urdf):
    """Mass, centre and tensor of the platform, its frame at the first hinge."""
    inertial = ElementTree.fromstring(urdf).find("link[@name='platform']/inertial")
    entry = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
    tensor = np.array([[entry["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    mass = float(inertial.find("mass").get("value"))
    return mass, vector_of(inertial.find("origin")), tensor


@pytest.mark.parametrize("freedoms", [3, 6])
def test_the_platform_is_point_masses_at_its_hinges(freedoms):
    """Its mass, first and second moments, from the file."""
    sizes = random_platform(5, freedoms)
    mass, centre, tensor = platform_of(parallelepiped_platform_urdf(sizes))
    points, masses = np.array(sizes.hinges) - sizes.hinges[0], np.array(sizes.shares)
    assert mass == pytest.approx(masses.sum(), rel=1e-14)
    assert centre == pytest.approx(masses @ points / masses.sum(), abs=1e-11)
    # Second moments Σ m r rᵀ about the centre: half the trace less the tensor.
    second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    arms = points - centre
    assert second == pytest.approx(np.einsum("i,ij,ik", masses, arms, arms), abs=1e-11)


def test_on_four_legs_the_platform_is_the_body():
    mass, centre, tensor = platform_of(parallelepiped_platform_urdf(on_four_legs(6)))
    assert mass == pytest.approx(1.0, rel=1e-14)
    assert centre == pytest.approx(-np.array(on_four_legs(6).hinges[0]), abs=1e-11)
    assert tensor == pytest.approx(BODY, abs=1e-11)


@pytest.mark.parametrize("body", [BODY, np.diag([0.01, 0.02, 0.03])], ids=["body", "plate"])
def test_points_of_a_turned_body_are_equivalent_to_it(body):
    """Mass, centre and tensor about it of four point masses."""
    rng = np.random.default_rng(4)
    turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    tensor, centre = turned @ body @ turned.T, rng.normal(size=3)
    points, masses = map(np.array, equivalent_points(0.7, centre, tensor))
    arms = points - centre
    assert masses.sum() == pytest.approx(0.7, rel=1e-14)
    assert np.abs(masses @ arms).max() < 1e-14
    squares = np.einsum("ij,ij->i", arms, arms)
    about = (masses @ squares) * np.eye(3) - np.einsum("i,ij,ik", masses, arms, arms)
    assert about == pytest.approx(tensor, abs=1e-15)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ((1.0, (0, 0, 0), np.diag([1.0, 1.0, 2.1])), "no body has this mass and this tensor"),
        ((-1.0, (0, 0, 0), np.eye(3)), "no body has this mass"),
        ((float("nan"), (0, 0, 0), np.eye(3)), "give finite numbers"),
        ((1.0, (1e308, 0, 0), 1e308 * np.eye(3)), "give finite numbers"),
        ((1.0, (0, 0, 0), np.eye(3) + 0.1 * np.eye(3, k=1)), "the tensor is not symmetric"),
        ((1.0, (0, 0), np.eye(3)), r"a centre \(3,\) and a tensor \(3, 3\)"),
    ],
)
def test_no_points_are_equivalent_to_what_is_no_body(body, said):
    with pytest.raises(UsageError, match=said):
        equivalent_points(*body)


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
@pytest.mark.parametrize(
    "sizes", [SIZES._replace(freedoms=3), SIZES, on_four_legs(6)], ids=["3", "6", "four legs"]
)
def test_the_product_agrees(sizes):
    """Design space with exact arithmetic, and random motions of all inputs."""
    linkage = load(Document("platform", parallelepiped_platform_urdf(sizes)))
    assert linkage.mobility == sizes.freedoms
    assert list(linkage.inputs) == inputs_of(sizes.freedoms, len(sizes.legs))
    space = certify(design_space(linkage))
    assert space.as_given.balanced and space.certainty.level == "verified"
    checked = verify(linkage, trajectories=2)
    assert checked.balanced and checked.moment_residual < 1e-9


FLAT_LEG = ((0.0, 0.0, 0.25), (0.2, 0.0, 0.0), (0.1, 0.0, 0.1))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"freedoms": 4}, "give 3 or 6"),
        ({"hinges": SIZES.hinges[:2]}, "hinges, shares and legs of three edges"),
        ({"legs": (SIZES.legs[0][:2], *SIZES.legs[1:])}, "legs of three edges"),
        ({"shares": (0.3, 0.0, 0.3)}, r"shares\[1\] = 0 must be positive"),
        ({"ratio": float("inf")}, "ratio = inf must be positive"),
        ({"rotor_radius": 1e-200}, "sizes of rotors: 0.0001 to 10000 m"),
        (
            {"hinges": tuple((1e-13 * x, 0, 1e-13 * z) for x, _, z in SIZES.hinges)},
            "sizes of hinges",
        ),
        ({"legs": ((*SIZES.legs[0][:2], (0, 1e90, 0)), *SIZES.legs[1:])}, "sizes of edges"),
        ({"legs": (((1.0, 0.0),) * 3, *SIZES.legs[1:])}, "three coordinates"),
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
