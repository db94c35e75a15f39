"""What the tests of the laws share: random screws and bodies, exact ranks, altered files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from tests.support.figures import Figure

MODELS = tuple(kinematics.gallery())
SPATIAL = (
    "bennett bennett_rational delta four_bar_spherical goldberg_five_bar hprs rusr sarrus "
    "stewart_6ups three_rsr three_rsr_rational"
).split()
PLANAR = tuple(name for name in MODELS if name not in SPATIAL)


def space(figure: Figure, path=None, max_order=None):
    """The design space that a row of the table asks for."""
    return space_of(figure, kinematics.load(path or figure.model), max_order)


def space_of(figure: Figure, linkage, max_order=None):
    """The same of a linkage that is there already."""
    motion = figure.motion or None
    return design_space(linkage, motion, figure.balance, max_order, spatial=figure.spatial)


@cache
def known(figure: Figure):
    """The certified space of a row of the table: tests share it, for it cannot be changed."""
    return certify(space(figure))


def coordinates(found, seed=3):
    """Random coordinates of a design space; shape (nullity,).

    They are those of the point nearest to random parameters, which is the same for every basis:
    which one a machine finds depends on its rounding.
    """
    z = np.random.default_rng(seed).standard_normal(len(found.basis))
    return np.linalg.lstsq(found.basis, z, rcond=None)[0]


def relative(found, expected) -> float:
    """Largest difference over the largest entry expected."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    size = np.abs(expected).max(initial=1e-300)
    return float(np.abs(found - expected).max(initial=0.0) / size)


def unit_vector(rng):
    """A direction, evenly distributed; shape (3,)."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def displacement(rng, reach=1.0):
    """A random displacement with translations of the size of ``reach``; shape (4, 4)."""
    H = np.eye(4)
    H[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    H[:3, 3] = reach * rng.standard_normal(3)
    return H


def point_masses(rng, count=12, reach=1.0):
    """Masses (n,) and positions (n, 3) of a random cloud."""
    return rng.uniform(0.1, 1.0, count), reach * rng.standard_normal((count, 3))


def sums(masses, points):
    """The ten parameters of a cloud, term by term; shape (10,)."""
    total = np.zeros(10)
    for m, (x, y, z) in zip(masses, points, strict=True):
        second = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
        total += m * np.array([1.0, x, y, z, *second])
    return total


def bounded_cloud(rng, low, high):
    """Parameters of point masses that add up to a mass between bounds."""
    points = rng.normal(size=(6, 3)) * [1.0, 1.0, 0.0]
    return sums(rng.dirichlet(np.ones(6)) * rng.uniform(max(low, 1e-3), high), points)


def off_axis(linkage, body, rng):
    """A point one characteristic length, or a little more, off every axis that carries it."""
    frame = linkage.spatial_chain.frame
    while True:
        r = frame.origin + 2.0 * frame.length * rng.standard_normal(3)
        link, gaps = body.link, []
        while link >= 0:
            n, v = linkage.joints[link].screw[:3], linkage.joints[link].screw[3:]
            gaps.append(np.linalg.norm(v - np.cross(r, n) - n * (n @ v)) / frame.length)
            link = linkage.joints[link].parent
        if 1.0 <= min(gaps) <= 1.1:
            return r


def exact_rank(matrix) -> int:
    """Rank of a matrix of integers by elimination with fractions."""
    rows = [[Fraction(int(x)) for x in row] for row in matrix]
    rank = 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for i in range(rank + 1, len(rows)):
            factor = rows[i][column] / rows[rank][column]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[rank], strict=True)]
        rank += 1
    return rank


def outside(vectors, basis) -> float:
    """Largest part of unit columns of ``vectors`` that is not in the span of ``basis``."""
    Q = np.linalg.qr(basis)[0]
    vectors = vectors / np.linalg.norm(vectors, axis=0)
    return float(np.linalg.norm(vectors - Q @ (Q.T @ vectors), axis=0).max(initial=0.0))


def altered(model: str, folder: Path, *changes: Callable[[ElementTree.Element], None]) -> Path:
    """A copy of a model of the gallery, with changes made to its ``<robot>``."""
    tree = ElementTree.parse(kinematics.gallery()[model])
    for change in changes:
        change(tree.getroot())
    path = folder / f"{model}.urdf"
    tree.write(path)
    return path


def words(numbers: Sequence[float]) -> str:
    """Numbers as an attribute holds them, to the last digit."""
    return " ".join(repr(float(x)) for x in numbers)


def rpy(R) -> str:
    """Roll, pitch and yaw of a rotation (3, 3)."""
    return words(Rotation.from_matrix(R).as_euler("xyz"))


def placed(H) -> Callable[[ElementTree.Element], None]:
    """The change that puts the whole linkage at the pose H on a new root link."""

    def change(robot):
        children = {j.find("child").get("link") for j in robot.findall("joint")}
        root = next(
            link.get("name")
            for link in robot.findall("link")
            if link.get("name") not in children
        )
        ElementTree.SubElement(robot, "link", name="new_root")
        joint = ElementTree.SubElement(robot, "joint", name="new_joint", type="fixed")
        ElementTree.SubElement(joint, "origin", xyz=words(H[:3, 3]), rpy=rpy(H[:3, :3]))
        ElementTree.SubElement(joint, "parent", link="new_root")
        ElementTree.SubElement(joint, "child", link=root)

    return change


def resized(factor: float) -> Callable[[ElementTree.Element], None]:
    """The change that multiplies all lengths, with the mass of every body kept."""

    def change(robot):
        for origin in robot.iter("origin"):
            origin.set("xyz", words(factor * np.array(origin.get("xyz").split(), float)))
        for pitch in robot.iter("screw_thread_pitch"):
            pitch.set("value", repr(factor * float(pitch.get("value"))))
        for inertia in robot.iter("inertia"):
            for key, value in inertia.attrib.items():
                inertia.set(key, repr(factor**2 * float(value)))

    return change


def renamed(robot: ElementTree.Element) -> None:
    """The change that gives every link another name."""
    for link in robot.findall("link"):
        link.set("name", f"x_{link.get('name')}_9")
    for tag in ("parent", "child", "predecessor", "successor"):
        for end in robot.iter(tag):
            end.set("link", f"x_{end.get('link')}_9")


def posed(angles: dict[str, float]) -> Callable[[ElementTree.Element], None]:
    """The change that turns tree joints by some angle about their axes, in the file."""

    def change(robot):
        for joint in robot.findall("joint"):
            if joint.get("name") in angles:
                axis = np.array(joint.find("axis").get("xyz").split(), float)
                turn = angles[joint.get("name")] * axis / np.linalg.norm(axis)
                R = Rotation.from_rotvec(turn).as_matrix()
                joint.find("origin").set("rpy", rpy(R))

    return change
