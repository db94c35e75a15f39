"""Walks to geometries that masses balance which can be built."""

import numpy as np
import pytest

import balance
from balance.studies.discovery import lane_motion
from balance.studies.discovery.buildable_walk import BuildableResidual, margins, mass_cones
from balance.studies.discovery.job import DiscoveryJob, geometry_of_text, random_starts
from balance.studies.discovery.lane_motion import lane_momentum_rows
from balance.studies.discovery.polish import decide_special
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import topology
from balance.studies.discovery.walk import LaneConditions, conditions_at
from tests.support.planted import four_bar_lanes, mirrored

pytestmark = pytest.mark.lanes

ROOT = np.sqrt(2.0)


def corners_of(kind, base, other=1.0, angle=1.1):
    """Corners A, B, C, D; AD is the base, and the other length is that of the other pair."""
    A, D = 0.0, base
    if kind == "antiparallelogram":
        B = other * np.exp(1j * angle)
        C = mirrored(B + D, B, D - B)
    elif kind == "kite about AC":
        # The crank is as long as the base, and B is near D, so that C can be reached.
        B = base * np.exp(1j * angle / base)
        half = (B + D) / 2.0
        C = half + np.sqrt(other**2 - abs(B - D) ** 2 / 4.0) * half / abs(half)
    else:
        C = D - base * np.exp(-1j * angle / base)
        half = C / 2.0
        B = half + np.sqrt(other**2 - abs(C) ** 2 / 4.0) * (half - D) / abs(half - D)
    return [A, B, C, D]


def margin_of(corners):
    """Nullity and margin of a four-bar, and its linkage."""
    graph, structure, geometry = four_bar_lanes(np.array([corners]))
    ends = decide_special(structure, geometry, 4)
    return ends.nullity[0], margins(structure, ends)[0], to_linkage(graph, structure, geometry)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["antiparallelogram", "kite about AC", "kite about BD"])
def test_masses_can_be_built_if_the_base_is_longer_than_root_2(kind):
    """The base over the other length, by the cones of the walk and by verdicts of designs."""
    for base in (0.6, 0.8, 1.3, 1.40, 1.413, 1.4155, 1.43, 1.6, 2.5):
        nullity, margin, linkage = margin_of(corners_of(kind, base))
        assert nullity == 5
        assert (margin > 0.0) == (base > ROOT), base
        if abs(base - ROOT) > 0.01:
            verdict = balance.masses.feasible(balance.design_space(linkage)).verdict
            assert verdict == ("feasible" if base > ROOT else "infeasible"), base


@pytest.fixture(scope="module")
def walked():
    job = DiscoveryJob("four-bar", 100, buildable=True)
    return job, [job.compute(0), job.compute(1)]


@pytest.mark.slow
def test_one_walk_in_twenty_ends_where_masses_can_be_built(walked):
    job, chunks = walked
    found = [
        geometry_of_text(rows["geometry"][k])
        for rows in chunks
        for k, fate in enumerate(rows["outcome"])
        if fate == "special"
    ]
    assert len(found) >= 5
    for geometry in found:
        space = balance.design_space(to_linkage(job.topology, job.structure, geometry))
        assert space.nullity == 5 and balance.masses.feasible(space).verdict == "feasible"


@pytest.mark.slow
def test_only_special_ends_of_these_walks_have_a_margin(walked):
    _, chunks = walked
    for rows in chunks:
        outcomes = np.array(rows["outcome"])
        assert np.all(rows["margin"][outcomes == "special"] > 0.0)
        assert np.all(rows["margin"][outcomes == "cannot be built"] == 0.0)


@pytest.mark.slow
def test_walks_without_cones_find_fewer(walked):
    """The same starts: few special geometries can be built."""
    _, chunks = walked
    plain = DiscoveryJob("four-bar", 100)
    counts = [
        sum(np.sum(np.nan_to_num(rows["margin"]) > 0.0) for rows in some)
        for some in (chunks, [plain.compute(0), plain.compute(1)])
    ]
    assert counts[0] > 2 * counts[1]


@pytest.mark.parametrize("name", ["four-bar", "watt2", "spherical-four-bar"])
def test_no_other_masses_leave_less_momentum(name):
    """Against masses that can be built: mixtures of the minimiser with random ones."""
    structure = topology(name).structure()
    found = conditions_at(structure, random_starts(structure, 2, range(6)))
    cones, rng = mass_cones(structure), np.random.default_rng(1)
    for lane in np.flatnonzero(found.usable)[:3]:
        rows = found.values[lane][:, None] / found.values[lane, 0] * found.Vt[lane]
        z = cones.least_momentum(rows).z
        least = np.linalg.norm(rows @ z)
        P = np.einsum("bnij,n->bij", cones.blocks, z)
        assert cones.total @ z == pytest.approx(1.0) and P[:, -1, -1].min() > 0.0
        for _ in range(300):
            other = random_masses(cones, rng)
            mixed = z + rng.uniform(0.0, 1.0) ** 4 * (other - z)
            assert np.linalg.norm(rows @ mixed) > least - 1e-8


def random_masses(cones, rng):
    """Parameters of random points of mass, which satisfy the limit and have the total 1."""
    count, unknowns, k, _ = cones.blocks.shape
    points = rng.standard_normal((count, 6, k)) * rng.uniform(0.05, 1.0, (count, 1, 1))
    points[..., -1] = 1.0
    P = np.einsum("bpi,bpj->bij", points, points * rng.uniform(0.0, 1.0, (count, 6, 1)))
    P = P / np.einsum("bii->", P) + 0.01 * np.eye(k)
    columns = np.moveaxis(cones.blocks, 1, -1).reshape(-1, unknowns)
    if cones.planar:
        P[:, 0, 0] = P[:, 1, 1] = (P[:, 0, 0] + P[:, 1, 1]) / 2.0
        P[:, 0, 1] = P[:, 1, 0] = 0.0
    z = np.linalg.lstsq(columns, P.ravel(), rcond=None)[0]
    return z / (cones.total @ z)


@pytest.mark.parametrize("name", ["four-bar", "watt2"])
def test_the_gradient_of_the_momentum_that_is_left(name):
    """``Jᵀ r`` against central differences of the minimum, with masses found anew."""
    structure = topology(name).structure()
    geometry = random_starts(structure, 7, range(8))
    found = conditions_at(structure, geometry)
    cones, poses = mass_cones(structure), found.poses
    lanes = np.flatnonzero(found.usable)
    left = BuildableResidual(structure, geometry, found, cones)
    step = np.random.default_rng(8).standard_normal(len(structure.shifts))
    slopes = left.terms(lanes)[1] @ step

    def halves(size):
        moved = structure.move(geometry, np.tile(size * step, (len(geometry.points), 1)))
        screws = structure.screws(moved)
        q = lane_motion._close(structure, screws, poses.q, poses.frames)
        there = lane_motion._poses(structure, screws, q, poses.frames, 1)
        U, values, Vt = np.linalg.svd(lane_momentum_rows(structure, there)[lanes], False)
        same = LaneConditions(there, U, values, Vt, np.ones(len(lanes), bool))
        rest = BuildableResidual(structure, moved, same, cones)
        return 0.5 * (rest.ratio * values[:, 0] / found.values[lanes, 0]) ** 2

    differences = (halves(1e-4) - halves(-1e-4)) / 2e-4
    assert np.median(abs(differences / slopes - 1.0)) < 1e-3
