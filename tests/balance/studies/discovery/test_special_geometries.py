"""Decisions on geometries whose relations are planted: exact ones, near ones, folded ones."""

import numpy as np
import pytest

import balance
from balance.studies.discovery.job import random_starts
from balance.studies.discovery.lane_motion import (
    follow_curves,
    lane_momentum_rows,
    momentum_rates,
)
from balance.studies.discovery.polish import decide_special
from balance.studies.discovery.rejections import judge_geometries
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import TOPOLOGIES, topology
from balance.studies.discovery.walk import generic_nullity
from tests.support.planted import four_bar_lanes, mirrored

pytestmark = pytest.mark.lanes

# Of most geometries: figures of the design document, and of transfers at joints.
NULLITY = {
    "four-bar": 4,
    "slider-crank": 5,
    "watt1": 7,
    "watt2": 7,
    "stephenson1": 7,
    "stephenson2": 7,
    "stephenson3": 7,
    "3-rsr": 27,
}


def planted(kind, count, seed, off=0.0):
    """Random four-bars of one kind; a length is off by a part of itself."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        A, B, C = rng.standard_normal((3, 2)) @ (1, 1j)
        D = A + C - B
        if kind == "kite":
            D = mirrored(B, A, C - A)
        if kind == "antiparallelogram":
            D = mirrored(D, A, C - A)
        if off:
            D = A + (D - A) * (1 + off * rng.choice((-1, 1)))
        corners = np.array([A, B, C, D])
        apart = abs(corners[:, None] - corners)[np.triu_indices(4, 1)]
        if apart.min() > 0.35 * apart.max():
            found.append(corners)
    return np.array(found)


def accepted(corners):
    """Which four-bars are taken for special, and their nullities."""
    graph, structure, geometry = four_bar_lanes(corners)
    ends = decide_special(structure, geometry, 4)
    fates = np.array(judge_geometries(graph, structure, geometry))
    return ends.special & (fates == "special"), ends.nullity


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("kind", "nullity"), [("kite", 5), ("antiparallelogram", 5), ("parallelogram", 7)]
)
def test_exact_ones_are_accepted(kind, nullity):
    special, found = accepted(planted(kind, 67, 3))
    assert special.all() and set(found.tolist()) == {nullity}


@pytest.mark.table(4)
@pytest.mark.parametrize("off", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("kind", ["kite", "antiparallelogram", "parallelogram"])
def test_near_ones_are_rejected(kind, off):
    special, _ = accepted(planted(kind, 23, 4, off))
    assert not special.any()


@pytest.mark.slow
def test_folded_ones_are_rejected():
    """Two joints in one place: the links turn about it as one."""
    points = planted("kite", 40, 5)
    points[:, 2] = points[:, 0]
    special, _ = accepted(points)
    assert not special.any()


@pytest.mark.slow
def test_four_bars_at_a_meeting_of_motions_are_rejected():
    """In line: at this pose the conditions are nearly dependent, whatever the lengths."""
    rng = np.random.default_rng(6)
    lengths = rng.uniform(0.5, 1.5, (40, 3)).cumsum(axis=1)
    points = np.zeros((40, 4), complex)
    points[:, 1:] = lengths
    points[:, 2] += 1e-7j
    special, _ = accepted(points)
    assert not special.any()


@pytest.mark.parametrize("name", NULLITY)
def test_most_geometries_have_the_known_nullity(name):
    structure = topology(name).structure()
    sample = random_starts(structure, 5, range(8))
    assert generic_nullity(structure, sample) == NULLITY[name]


@pytest.mark.parametrize("name", ["four-bar", "slider-crank", "watt2", "geared-five-bar"])
def test_the_linkage_of_a_geometry_has_the_same_nullity(name):
    """By the engine's series at one pose, instead of poses along curves."""
    graph = topology(name)
    structure = graph.structure()
    sample = random_starts(structure, 6, range(4))
    generic = generic_nullity(structure, sample)
    assert balance.design_space(to_linkage(graph, structure, sample, 1)).nullity == generic


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_derivatives_of_the_momentum(name):
    """Against central differences of poses that are closed anew."""
    from balance.studies.discovery import lane_motion

    structure = topology(name).structure()
    geometry = random_starts(structure, 7, range(6))
    poses = follow_curves(structure, geometry, 0.4, 3)
    rng = np.random.default_rng(8)
    z = rng.standard_normal((6, 2, structure.unknowns))
    step = rng.standard_normal(len(structure.shifts))
    rates = momentum_rates(structure, geometry, poses, z) @ step

    def momentum(size):
        moved = structure.move(geometry, np.tile(size * step, (6, 1)))
        screws = structure.screws(moved)
        q = lane_motion._close(structure, screws, poses.q, poses.frames)
        there = lane_motion._poses(structure, screws, q, poses.frames, 1)
        return np.einsum("lru,lsu->lsr", lane_momentum_rows(structure, there), z)

    differences = (momentum(1e-6) - momentum(-1e-6)) / 2e-6
    good = poses.residual < 1e-12
    error = np.abs(differences - rates)[good].max(axis=(1, 2))
    assert good.sum() >= 3
    assert np.median(error / np.abs(rates)[good].max(axis=(1, 2))) < 1e-7
