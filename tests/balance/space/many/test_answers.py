"""Random geometries of eight topologies, with special ones sown in: every integer is right.

Each is compared with `design_space` of that linkage alone, and the ranks of those families that
have a model in the gallery with exact arithmetic: no special one is missed, none is invented.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

import balance
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.inputs.geometry import resized, variants
from kinematics import load
from kinematics.model.linkage import Linkage
from tests.support.covering import number_of_cases
from tests.support.one_by_one import integers, one_by_one

pytestmark = pytest.mark.lanes

# Geometries of each topology, and the part of them that is special.
COUNT, SPECIAL = number_of_cases(50, 2500), 0.02
Points = dict[str, np.ndarray]


class Topology(NamedTuple):
    """A linkage, and special geometries of it.

    Attributes:
        model: name in the gallery; None if a random geometry has no exact rank.
        draw: makes the joint screws of a random geometry.
        special: name in the gallery, or None, of a special kind; and what makes its screws.
    """

    model: str
    exact: bool
    draw: Callable[[Linkage, np.random.Generator], np.ndarray]
    special: tuple[tuple[str | None, Callable[[Linkage, np.random.Generator], np.ndarray]], ...]


def drawn_points(linkage: Linkage, rng: np.random.Generator) -> Points:
    """The joints of a planar linkage, each moved at random by about a fifth of its size."""
    size = linkage.chain.frame.length / 5.0
    return {
        joint.name: joint.point[:2] + size * rng.standard_normal(2) for joint in linkage.joints
    }


def planar_screws(linkage: Linkage, points: Points, rng: np.random.Generator) -> np.ndarray:
    """Joint screws of a planar linkage, turned, resized and placed at random."""
    turn, size, shift = rng.uniform(0.0, 6.28), rng.uniform(0.2, 5.0), rng.standard_normal(2)
    R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    screws = np.zeros((len(linkage.joints), 6))
    for j, joint in enumerate(linkage.joints):
        x, y = size * (R @ points[joint.name] + shift)
        if joint.kind == "prismatic":
            screws[j, 3:5] = R @ points["axis"]
        else:
            screws[j] = [0.0, 0.0, 1.0, y, -x, 0.0]
    return screws


def any_planar(linkage: Linkage, rng: np.random.Generator) -> np.ndarray:
    """Joints at random places."""
    points = drawn_points(linkage, rng)
    points["axis"] = np.array([np.cos(turn := rng.uniform(0.0, 6.28)), np.sin(turn)])
    return planar_screws(linkage, points, rng)


def mirrored(point: np.ndarray, line: np.ndarray) -> np.ndarray:
    """A point mirrored at a line through the origin."""
    along = line / np.linalg.norm(line)
    return 2.0 * (point @ along) * along - point


def kite(points: Points, ring: tuple[str, str, str, str]) -> None:
    """Move the last corner: two pairs of neighbours are equal."""
    a, b, c, d = ring
    points[d] = points[a] + mirrored(points[b] - points[a], points[c] - points[a])


def parallelogram(points: Points, ring: tuple[str, str, str, str]) -> None:
    """Move the third corner."""
    a, b, c, d = ring
    points[c] = points[b] + points[d] - points[a]


def antiparallelogram(points: Points, ring: tuple[str, str, str, str]) -> None:
    """Move the third corner: a parallelogram folded at the diagonal across."""
    a, b, c, d = ring
    opposite = points[b] + points[d] - points[a]
    points[c] = points[b] + mirrored(opposite - points[b], points[d] - points[b])


def with_rings(*changes: tuple[Callable, tuple[str, str, str, str]]) -> Callable:
    """Make a function that draws a planar linkage with special loops."""

    def draw(linkage: Linkage, rng: np.random.Generator) -> np.ndarray:
        points = drawn_points(linkage, rng)
        for change, ring in changes:
            change(points, ring)
        return planar_screws(linkage, points, rng)

    return draw


def in_line_slider_crank(linkage: Linkage, rng: np.random.Generator) -> np.ndarray:
    """Crank and coupler of one length, and a slide through the pivot of the crank."""
    points = drawn_points(linkage, rng)
    points["axis"] = axis = np.array([np.cos(turn := rng.uniform(0.0, 6.28)), np.sin(turn)])
    points["q3"] = points["u1"] + 2.0 * ((points["q2"] - points["u1"]) @ axis) * axis
    return planar_screws(linkage, points, rng)


def isogram(linkage: Linkage, rng: np.random.Generator, flat: bool = False) -> np.ndarray:
    """A Bennett linkage: a skew isogram, with each axis across the two links that meet there.

    A half turn about the z axis takes each corner to the opposite one.
    """
    a, b = rng.uniform(0.3, 1.0, 3), rng.uniform(0.3, 1.0, 3) * [-1.0, 1.0, -1.0]
    if flat:
        b *= np.linalg.norm(a[:2]) / np.linalg.norm(b[:2])
    turn = np.array([-1.0, -1.0, 1.0])
    corners = {"u1": a, "q2": b, "q3": a * turn, "q4": b * turn}
    ring = ["u1", "q2", "q3", "q4"]
    shift, screws = rng.standard_normal(3), []
    for joint in linkage.joints:
        k = ring.index(joint.name)
        at = corners[joint.name]
        axis = np.cross(corners[ring[k - 1]] - at, corners[ring[(k + 1) % 4]] - at)
        axis /= np.linalg.norm(axis)
        screws.append([*axis, *np.cross(at + shift, axis)])
    return np.array(screws)


def flat_isogram(linkage: Linkage, rng: np.random.Generator) -> np.ndarray:
    """One whose opposite corners are all at one distance from the axis of symmetry."""
    return isogram(linkage, rng, flat=True)


def other_places(model: str) -> Callable:
    """Make a function that turns a gallery model into similar ones elsewhere."""

    def draw(_: Linkage, rng: np.random.Generator) -> np.ndarray:
        return screws_of(resized(model, 1, seed=int(rng.integers(1 << 31)))[0])

    return draw


def moved_joints(linkage: Linkage, rng: np.random.Generator) -> np.ndarray:
    """Joint centres moved at random, axes as they are."""
    model = linkage.name
    return screws_of(variants(model, 1, seed=int(rng.integers(1 << 31)), size=0.1)[0])


def screws_of(linkage: Linkage) -> np.ndarray:
    """Joint screws in SI units."""
    return np.array([joint.screw for joint in linkage.joints])


FIRST, SECOND = ("u1", "a", "b", "o4"), ("b", "c", "e", "d")
TOPOLOGIES = (
    Topology("four_bar_general", True, any_planar, (
        ("four_bar_kite", with_rings((kite, ("q4", "u1", "q2", "q3")))),
        ("four_bar_parallelogram", with_rings((parallelogram, ("u1", "q2", "q3", "q4")))),
        ("four_bar_antiparallelogram",
         with_rings((antiparallelogram, ("u1", "q2", "q3", "q4")))),
    )),
    Topology("slider_crank", False, any_planar, (("slider_crank", in_line_slider_crank),)),
    Topology("five_bar", True, any_planar, (("five_bar", other_places("five_bar")),)),
    Topology("four_rrr", True, any_planar, (
        ("four_rrr_parallel", other_places("four_rrr_parallel")),
        ("four_rrr_symmetric", other_places("four_rrr_symmetric")),
    )),
    Topology("six_bar_watt", True, any_planar, (
        (None, with_rings((parallelogram, FIRST))),
        (None, with_rings((kite, FIRST), (kite, SECOND))),
        (None, with_rings((parallelogram, FIRST), (parallelogram, SECOND))),
    )),
    Topology("six_bar_stephenson", True, any_planar, (
        (None, with_rings((parallelogram, FIRST))),
        (None, with_rings((kite, FIRST))),
    )),
    Topology("bennett", True, isogram, (
        ("bennett", other_places("bennett")), (None, flat_isogram),
    )),
    Topology("three_rsr", False, moved_joints, (("three_rsr", other_places("three_rsr")),)),
)  # fmt: skip


@pytest.mark.table(2)
@pytest.mark.parametrize("topology", TOPOLOGIES, ids=lambda topology: topology.model)
def test_every_integer(topology):
    linkage, rng = load(topology.model), np.random.default_rng(311)
    kinds = [-1] * COUNT
    wanted = max(len(topology.special), round(SPECIAL * COUNT))
    for number, place in enumerate(rng.choice(COUNT, wanted, replace=False).tolist()):
        kinds[place] = number % len(topology.special)
    draws = [*(draw for _, draw in topology.special), topology.draw]
    screws = np.array([draws[kind](linkage, rng) for kind in kinds])
    found = balance.space.design_space_many(linkage, screws)
    assert not found.refused
    numbers = zip(
        found.rank, found.nullity, found.serial_nullity, found.kmax, kinds, strict=True
    )
    models = [*(model for model, _ in topology.special), topology.model]
    models[-1] = topology.model if topology.exact else None
    exact = [model and exact_ranks(load(model)).rank for model in models]
    for k, (*ours, kind) in enumerate(numbers):
        (space,) = one_by_one(linkage, screws[k : k + 1])
        assert tuple(ours) == integers(space), (k, kind)
        assert exact[kind] is None or ours[0] == exact[kind], (k, kind)
