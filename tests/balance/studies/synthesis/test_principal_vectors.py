"""Principal-vector linkages: finite poses by the offsets in the file, momentum by Pinocchio."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from balance import design_space, verify
from balance.studies import PrincipalVectors, principal_vector_urdf
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases

TURNS = (1.0, -0.4, -1.3, 0.7, -0.9)


def random_chain(n, seed=0):
    """Elements of about 1 m in a row, with principal points beside them."""
    rng = np.random.default_rng([n, seed])
    joints = np.arange(1, n) + rng.normal(0, 0.1, n - 1) + 1j * rng.normal(0, 0.3, n - 1)
    points = np.arange(n) + 0.5 + rng.normal(0, 0.2, n) + 1j * rng.uniform(0.2, 0.6, n)
    return PrincipalVectors(tuple(joints.tolist()), tuple(points.tolist()))


def read(urdf):
    return load(Document("principal vectors", urdf))


def point(element):
    return complex(*map(float, element.find("origin").get("xyz").split()[:2]))


class Poses:
    """Places of the bodies of a file for any angles of its elements, by its offsets alone."""

    def __init__(self, urdf):
        self.root = ElementTree.fromstring(urdf)
        self.masses, self.centres, self.moments, self.element = {}, {}, {}, {}
        for link in self.root.iter("link"):
            name, inertial = link.get("name"), link.find("inertial")
            if inertial is not None:
                self.masses[name] = float(inertial.find("mass").get("value"))
                self.centres[name] = point(inertial)
                self.moments[name] = float(inertial.find("inertia").get("izz"))
                self.element[name] = int(name.removeprefix("element").split("_")[-1]) - 1

    def place(self, angles):
        """Frames of all bodies; how far the ends of loops are apart."""
        ways = {name: np.exp(1j * angles[i]) for name, i in self.element.items()}
        at, ways["base"] = {"base": 0j}, 1.0
        joints = list(self.root.iter("joint"))
        while joints:
            joint = joints.pop(0)
            parent, child = (joint.find(side).get("link") for side in ("parent", "child"))
            if parent in at:
                at[child] = at[parent] + ways[parent] * point(joint)
            else:
                joints.append(joint)
        ends = [
            [at[side.get("link")] + ways[side.get("link")] * point(side) for side in loop[:2]]
            for loop in self.root.iter("loop")
        ]
        return at, ways, max(abs(first - second) for first, second in ends)

    def centres_at(self, angles):
        """Centres of mass (bodies,)."""
        at, ways, _ = self.place(angles)
        return np.array([at[name] + ways[name] * c for name, c in self.centres.items()])

    def momenta(self, angles, step=1e-4):
        """Angular momentum for each turn of one element alone (n,), by central differences."""
        m = np.array(list(self.masses.values()))
        here, momenta = self.centres_at(angles), np.zeros(len(angles))
        for i, turn in enumerate(step * np.eye(len(angles))):
            ahead, behind = self.centres_at(angles + turn), self.centres_at(angles - turn)
            momenta[i] = m @ (here.conj() * (ahead - behind)).imag / (2.0 * step)
            momenta[i] += sum(self.moments[b] for b, e in self.element.items() if e == i)
        return momenta


@pytest.mark.parametrize("n", [2, 3, 5])
def test_forces_are_balanced_and_turns_decoupled_in_all_freedoms(n):
    """The common centre rests, and each turn has the same momentum at all poses."""
    for seed in range(number_of_cases(2, 20)):
        chain = random_chain(n, seed)
        poses, rng = Poses(principal_vector_urdf(chain)), np.random.default_rng(seed)
        m = np.array(list(poses.masses.values()))
        momenta = []
        for angles in rng.uniform(-np.pi, np.pi, (4, n)):
            assert poses.place(angles)[2] < 1e-10
            centre = m @ poses.centres_at(angles) / m.sum()
            assert abs(centre - chain.pivot) < 1e-10
            momenta.append(poses.momenta(angles))
        assert np.ptp(momenta, axis=0).max() < 1e-6 * np.min(momenta)
        heavy = poses.masses | {"element1": 1.05}
        m = np.array(list(heavy.values()))
        centres = [m @ poses.centres_at(angles) for angles in (np.zeros(n), np.arange(n) + 1.0)]
        assert abs(np.subtract(*centres)) > 1e-3


@pytest.mark.parametrize(
    "n", [2, pytest.param(3, marks=pytest.mark.slow), pytest.param(4, marks=pytest.mark.slow)]
)
def test_a_drive_leaves_one_freedom_without_momentum(n):
    """By Pinocchio along random motions; without the drive forces alone are balanced."""
    chain = random_chain(n)._replace(turns=TURNS[:n])
    linkage = read(principal_vector_urdf(chain))
    assert linkage.mobility == 1 and linkage.inputs == ("turn1",)
    checked = verify(linkage, trajectories=1, samples=20)
    assert checked.balanced and checked.moment_residual < 1e-9
    free = read(principal_vector_urdf(chain._replace(turns=None)))
    assert free.mobility == n
    checked = verify(free, trajectories=1, samples=20)
    assert checked.force_residual < 1e-9 and checked.moment_residual > 1e-3


def test_the_design_space_agrees():
    urdf = principal_vector_urdf(random_chain(3)._replace(turns=(1.0, 0.0, -1.0)))
    assert design_space(read(urdf)).as_given.balanced
    # 0.1 % more of one counter-mass is seen.
    heavier = urdf.replace(b'<mass value="0.5"/>', b'<mass value="0.5005"/>', 1)
    assert not design_space(read(heavier)).as_given.balanced


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"points": (0j,), "joints": ()}, "give 2 to 8"),
        ({"joints": (0j,)}, "1 joint between 3 elements"),
        ({"points": (0j, 1j, complex("nan"))}, "finite"),
        ({"joints": (0j, 1 + 0j), "points": (0j, 1j, 2j)}, "at a joint"),
        ({"rod_mass": 0.0}, "rod_mass"),
        ({"turns": (1.0, -1.0)}, "give 3 turns"),
        ({"turns": (0.0, 1.0, -1.0)}, "first is not 0"),
        ({"turns": (1.0, 0.0, 2.0)}, "one way"),
    ],
)
def test_linkages_that_do_not_exist_are_refused(change, said):
    with pytest.raises(UsageError, match=said):
        principal_vector_urdf(random_chain(3)._replace(**change))
