"""Planted geometries: exact ones of several families are accepted, and no others."""

import numpy as np
import pytest

from balance.studies.discovery.job import motion_splits, random_starts
from balance.studies.discovery.polish import decide_special
from balance.studies.discovery.rejections import judge_geometries
from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.topologies import topology
from balance.studies.discovery.walk import generic_nullity
from tests.fuzz.random_requests import check
from tests.support.command_runs import asked
from tests.support.covering import number_of_cases
from tests.support.planted import (
    FAMILIES,
    lanes_of,
    mirrored,
    planted_corners,
    similar_ternaries,
)

pytestmark = pytest.mark.lanes

# Members of each family: all together 200, or more.
COUNT = number_of_cases(6, 34)


def judged(name, corners):
    """Decisions on planted linkages of a topology, and what becomes of each."""
    graph = topology(name)
    structure, geometry = lanes_of(graph, corners)
    generic = generic_nullity(structure, random_starts(structure, 1, range(8)))
    ends = decide_special(structure, geometry, generic)
    fates = np.array(judge_geometries(graph, structure, geometry))
    return ends, fates, ends.special & (fates == "special")


def size_of(corners):
    """The root mean square of the distances of the joints from their mean (lanes, 1)."""
    return np.std(corners, axis=1, keepdims=True)


@pytest.mark.table(4)
@pytest.mark.parametrize("family", FAMILIES)
def test_exact_members_are_accepted(family):
    name, nullity, codimension, _ = FAMILIES[family]
    ends, fates, accepted = judged(name, planted_corners(family, COUNT, 3))
    assert accepted.all(), (fates, ends.nullity, ends.codimension)
    assert set(ends.nullity.tolist()) == {nullity}
    assert set(ends.codimension.tolist()) == {codimension}


@pytest.mark.table(5)
@pytest.mark.parametrize("family", FAMILIES)
def test_members_off_in_a_random_direction_are_rejected(family):
    """All joints are moved by a thousandth of the size."""
    corners = planted_corners(family, COUNT, 4)
    rng = np.random.default_rng(5)
    moves = rng.standard_normal((*corners.shape, 2)) @ (1, 1j)
    moves /= abs(moves).max(axis=1, keepdims=True)
    ends, _, accepted = judged(FAMILIES[family][0], corners + 1e-3 * size_of(corners) * moves)
    assert not accepted.any(), ends.nullity


@pytest.mark.table(5)
@pytest.mark.parametrize("family", FAMILIES)
def test_members_with_one_joint_off_are_rejected(family):
    corners = planted_corners(family, COUNT, 6)
    rng, size = np.random.default_rng(7), size_of(corners)[:, 0]
    off = rng.integers(1, 3, len(corners))
    corners[range(len(corners)), off] += 1e-3 * size * np.exp(6.0j * rng.random(len(corners)))
    _, _, accepted = judged(FAMILIES[family][0], corners)
    assert not accepted.any()


@pytest.mark.parametrize("bend", [1e-3, 1e-5, 1e-7])
def test_near_ones_at_a_node_are_rejected(bend):
    """Parallelograms nearly in line: the conditions of one pose hold to 1e-13 there."""
    rng = np.random.default_rng(8)
    lanes = number_of_cases(8, 40)
    a, b = rng.uniform(0.5, 1.5, (2, lanes))
    B = a * np.exp(1j * bend)
    C = B + b * (1.0 + 1e-3 * rng.choice((-1.0, 1.0), lanes))
    corners = np.stack([0.0 * B, B, C, 0.0 * B + b], axis=1)
    _, _, accepted = judged("four-bar", corners)
    assert not accepted.any()


def test_a_loop_beside_a_flat_parallelogram_is_rejected():
    """Off by 3e-5, sums of lengths equal: its momentum vanishes to 1e-16, but a step is left.

    A walk of Stephenson III ended there. Lengths 0.92248, 1.30817, 0.92251, 1.30814.
    """
    points = np.zeros((1, 7, 3))
    points[0, :, :2] = [
        [-0.3097804439022615, -0.3872054259423171],
        [0.3574882134454598, 0.24976506155497208],
        [0.3853960533727609, 1.5576127481152788],
        [0.36413935039439793, -0.08053108783153105],
        [-0.29363708639987895, -0.7887197822626427],
        [-0.28194246052071026, 0.9206730374277718],
        [-0.221663626389768, -1.4715945510615316],
    ]
    axes = np.broadcast_to([0.0, 0.0, 1.0], points.shape).copy()
    structure = topology("stephenson3").structure()
    ends = decide_special(structure, LaneGeometry(points, axes), 7)
    assert ends.dropped[0] < 1e-14 and ends.gap[0] > 1e-7 and not ends.special[0]


@pytest.mark.parametrize("family", ["kite", "antiparallelogram", "parallelogram"])
def test_short_links_are_rejected(family):
    """All of them are exact, but two links are shorter than 0.08 of the size."""
    rng = np.random.default_rng(9)
    A, B = np.zeros(8, complex), 1.0 + rng.random(8) + 0j
    short = 0.03 * np.exp(1j * rng.uniform(0.7, 2.4, 8))
    C, D = B + short, A + short
    if family == "kite":
        D = B * np.exp(0.02j)
        half = (B + D) / 2.0
        C = half * (1.0 + np.sqrt(0.03**2 - abs(B - half) ** 2) / abs(half))
    if family == "antiparallelogram":
        C = mirrored(C, B, D - B)
    ends, fates, accepted = judged("four-bar", np.stack([A, B, C, D], axis=1))
    assert not accepted.any() and set(fates) == {"short link"}
    assert np.sum(ends.nullity > 4) >= 4


@pytest.mark.slow
def test_folded_members_are_rejected():
    """Two pairs of links that turn as one."""
    for family in ("kite", "antiparallelogram"):
        corners = planted_corners(family, 20, 10)
        corners[:, 2] = corners[:, 0]
        assert not judged("four-bar", corners)[2].any()


# Three cranks carry one link, which stands still unless all are equal and parallel; a four-bar
# beside it has the one freedom of the topology.
CARRIED = "0-1 0-2 0-3 1-4 2-4 3-4 0-5 5-6 6-7 0-7"


def carried(rng, parallel):
    """Joints of three cranks with the link that they carry, and of a four-bar."""
    feet, crank = rng.standard_normal((3, 2)) @ (1, 1j), np.exp(6.0j * rng.random())
    tips = feet + (crank if parallel else np.exp(6.0j * rng.random(3)))
    return [*feet, *tips, *_quadrangle(rng)]


def _quadrangle(rng):
    A, B, C, D = np.exp(1j * np.array([0.0, 1.3, 3.0, 4.5])) * rng.uniform(0.7, 1.4, 4)
    return [A, B, C, D]


def test_motions_that_split_are_recognised_and_rejected():
    rng = np.random.default_rng(12)
    corners = np.array([carried(rng, True) for _ in range(8)])
    structure, geometry = lanes_of(topology(CARRIED), corners)
    assert structure.width == 1 and motion_splits(structure, geometry).all()
    assert not decide_special(structure, geometry, 10).special.any()
    others = np.array([carried(rng, False) for _ in range(8)])
    assert not motion_splits(*lanes_of(topology(CARRIED), others)).any()


@pytest.mark.parametrize("family", FAMILIES)
def test_members_move_as_one(family):
    structure, geometry = lanes_of(
        topology(FAMILIES[family][0]), planted_corners(family, 8, 11)
    )
    assert not motion_splits(structure, geometry).any()


def test_a_node_does_not_split_the_motion():
    """A parallelogram in line can move on as an antiparallelogram: there alone it has two."""
    corners = np.array([[0.0, 1.0, 3.0, 2.0], [0.0, 0.7, 2.0, 1.3]], complex)
    structure, geometry = lanes_of(topology("four-bar"), corners)
    assert not motion_splits(structure, geometry).any()


def test_special_parts_are_rejected():
    """A special Stephenson linkage that carries two more links is nothing new."""
    rng, lanes = np.random.default_rng(14), []
    while len(lanes) < 6:
        six = similar_ternaries(rng, len(lanes) % 2 == 0)
        H, K, L = rng.standard_normal((3, 2)) @ (1, 1j)
        lanes.append([*six, H, K, L])
    # Links 6 and 7 are a dyad between links 1 and 3.
    name = "0-1 1-2 2-3 0-3 2-4 4-5 0-5 1-6 6-7 3-7"
    ends, fates, accepted = judged(name, np.array(lanes))
    assert not accepted.any()
    usable = ends.nullity > 10
    assert usable.sum() >= 3 and set(fates[usable]) <= {"explained by a part", "short link"}


def test_links_that_do_not_turn_are_rejected():
    """Parallelograms on one another: the links between them keep their direction."""
    rng, lanes = np.random.default_rng(15), []
    for _ in range(8):
        a, b, c, d = rng.standard_normal((4, 2)) @ (1, 1j)
        lanes.append([0.0, a, a + b, b, a + c, a + c + d, b + d + c])
    _, fates, accepted = judged("watt1", np.array(lanes))
    assert not accepted.any(), fates


@pytest.mark.parametrize("job", [["run", "--starts", "1", "--workers", "0"], ["walk"]])
def test_a_topology_whose_loops_never_stay_closed_is_refused_before_a_file_is_made(
    tmp_path, job
):
    """A chain of universal and turning joints that closes at no random geometry."""
    out = ["--out", str(tmp_path / "a.db")] if job[0] == "run" else ["--start", "0"]
    words = ["discover", *job, "--topology=space: R0-1 R0-2 R2-4 R3-5 U5-6 R2-6 R6-3", *out]
    done = asked(words)
    assert check(words, done) == "discover: 2"
    assert "random geometries stay closed" in done.err and not [*tmp_path.iterdir()]
