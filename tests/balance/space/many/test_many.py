"""Many geometries at once: what `design_space` says of each, whatever the number of threads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import balance
from balance.space.inertial_parameters.body_inertia import in_link_frames
from balance.space.many import many_geometries
from benchmarks.inputs.geometry import variants
from kinematics import load
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import LinkageError
from kinematics.model.linkage import Mimic
from tests.support.drafts import axis_edge, linked
from tests.support.laws import outside
from tests.support.one_by_one import integers, one_by_one

pytestmark = pytest.mark.lanes


def four_bars(count, seed):
    """Corners of four-bars (count, 4, 2): any, kites, parallelograms, antiparallelograms.

    In the order ground, crank, rocker's tip, rocker's foot.
    """
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        a, b = rng.uniform(-1.0, 1.0, (2, 2)) + [[0.0, 1.5], [2.0, 1.5]]
        foot = np.array([rng.uniform(1.5, 3.0), 0.0])
        if k % 4 == 1:  # mirrored at the line from the foot of the crank to the other corner
            axis = b / np.linalg.norm(b)
            foot = 2.0 * (a @ axis) * axis - a
        elif k % 4 == 2:
            b = a + foot
        elif k % 4 == 3:  # a parallelogram, its corner mirrored at the diagonal across
            along = (foot - a) / np.linalg.norm(foot - a)
            b = a + 2.0 * (foot @ along) * along - foot
        corners = np.array([[0.0, 0.0], a, b, foot])
        turn, size = rng.uniform(0.0, 6.28), 10.0 ** rng.uniform(-2.0, 2.0)
        R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        found.append(size * (corners @ R.T + rng.standard_normal(2)))
    return np.array(found)


def screws_of(linkage, corners):
    """Joint screws (count, 4, 6) of four-bars whose joints are at these corners."""
    order = [["u1", "q2", "q3", "q4"].index(joint.name) for joint in linkage.joints]
    points = corners[:, order]
    screws = np.zeros((len(corners), 4, 6))
    screws[..., 2], screws[..., 3], screws[..., 4] = 1.0, points[..., 1], -points[..., 0]
    return screws


@pytest.mark.parametrize("workers", [2, 3, 4, 8])
@pytest.mark.parametrize("count", [20_000, 200_000, 10**6])
def test_threads_get_as_many_geometries_each(count, workers):
    """The busiest of threads that take turns has at most 2 % more than its share."""
    size = many_geometries._chunk_size(count)
    assert size <= many_geometries.LARGE_CHUNK_SIZE
    assert -(-count // size // workers) * size <= 1.02 * count / workers


def agree(found, spaces, frames):
    """Every number, and the spans of the bases."""
    for k, space in enumerate(spaces):
        numbers = found.rank[k], found.nullity[k], found.serial_nullity[k], found.kmax[k]
        assert numbers == integers(space), k
        # A singular pose was left: bases are compared where the bodies carry them.
        theirs = space.basis_in_link_frames()
        ours = in_link_frames(found.basis(k), frames, space.axes, space.labels)
        size = np.abs(theirs).max(axis=1, keepdims=True) + 1e-300
        ours, theirs = ours / size, theirs / size
        assert outside(ours, theirs) < 1e-9 and outside(theirs, ours) < 1e-9, k


@pytest.mark.slow
def test_four_bars_of_every_kind(monkeypatch):
    monkeypatch.setattr(many_geometries, "CHUNK_SIZE", 128)
    linkage = load("four_bar_general")
    screws = screws_of(linkage, four_bars(300, seed=91))
    found = balance.space.design_space_many(linkage, screws, bases=True, workers=2)
    assert not found.refused
    agree(found, one_by_one(linkage, screws), linkage.frames)
    assert [set(found.rank[k::4].tolist()) for k in range(4)] == [{8}, {7}, {5}, {7}]
    again = balance.space.design_space_many(linkage, screws, bases=True, workers=1)
    assert np.array_equal(again.bases, found.bases)


@pytest.mark.table(3)
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("three_rsr", {}),
        ("four_bar_general", {"spatial": True}),
        ("five_bar", {"balance": "force"}),
        ("slider_crank", {}),
        ("hprs", {}),
        ("pantograph", {}),
    ],
)
def test_other_topologies_in_other_places(name, options):
    linkage = load(name)
    rng = np.random.default_rng(92)
    screws = []
    for _ in range(3):
        size, shift = rng.uniform(0.5, 2.0), rng.standard_normal(3)
        moved = np.array([joint.screw for joint in linkage.joints])
        turning = np.any(moved[:, :3] != 0.0, axis=1)
        moved[turning, 3:] = size * moved[turning, 3:] + np.cross(shift, moved[turning, :3])
        screws.append(moved)
    found = balance.space.design_space_many(linkage, np.array(screws), bases=True, **options)
    agree(found, one_by_one(linkage, screws, **options), linkage.frames)


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("name", "kmax"), [("six_bar_stephenson", 6), ("eight_bar", 9), ("three_rsr", 1)]
)
def test_high_orders_and_slow_joints_stay_in_the_loop(name, kmax, monkeypatch):
    """Orders beyond the first expansion are settled there, as `design_space` settles them."""
    linkage, copies = load(name), variants(name, 6, seed=93)
    screws = np.array([[joint.screw for joint in copy.joints] for copy in copies])
    expected = list(one_by_one(linkage, screws))
    assert {space.kmax for space in expected} == {kmax}
    alone = []
    monkeypatch.setattr(
        many_geometries._Sweep, "solve_alone", lambda sweep, number: alone.append(number)
    )
    found = balance.space.design_space_many(linkage, screws, bases=True)
    assert not alone
    agree(found, expected, linkage.frames)


def test_a_basis_is_that_of_the_pose_given():
    """A parallelogram 0.01 rad from flat: crank and rocker turn, the coupler is carried along.

    The momentum of each body is written down by hand, for a unit rate of the crank.
    """
    linkage, height = load("four_bar_parallelogram"), 0.01
    corners = {"u1": (0, 0), "q2": (1, height), "q3": (3, height), "q4": (2, 0)}
    places = [corners[joint.name] for joint in linkage.joints]
    found = balance.space.design_space_many(
        linkage, [[[0, 0, 1, y, -x, 0] for x, y in places]], bases=True
    )
    rows = {
        "crank": [[0, 0, 0, 1], [0, 0, -1, 0], [0, 1, 0, 0]],
        "coupler": [[0, 1, height, 0], [-height, 0, 0, 0], [1, 0, 0, 0]],
        "rocker": [[0, -2, 0, 1], [0, 0, -1, 0], [-2, 1, 0, 0]],
    }
    X = np.hstack([rows[body.name] for body in linkage.bodies]).astype(float)
    basis = found.basis(0)
    assert found.nullity[0] == basis.shape[1] == np.linalg.matrix_rank(basis) == 7
    assert np.abs(X @ basis).max() < 1e-13 * np.abs(basis).max()


@pytest.mark.slow
def test_geometries_near_round_off_are_told():
    """The revolute axis of an arm is parallel to the helical one, nearly so, or not at all."""
    linkage = load("hprs")
    (joint,) = (j for j, each in enumerate(linkage.joints) if each.name == "revolute")
    screws = []
    for tilt in (0.0, 1e-9, 1e-7, 0.3):
        moved = np.array([joint.screw for joint in linkage.joints])
        n = np.array([0.6 * tilt, 0.0, 1.0]) / np.hypot(0.6 * tilt, 1.0)
        moved[joint] = [*n, *np.cross(linkage.joints[joint].point, n)]
        screws.append(moved)
    found = balance.space.design_space_many(linkage, screws)
    assert not found.refused and {*found.unsure} == {1, 2}
    assert all("decides about transfers" in reason for reason in found.unsure.values())
    assert found.serial_nullity[[0, 3]].tolist() == [16, 14]


@pytest.mark.parametrize("kinds", [("revolute",) * 4, ("revolute", "prismatic") * 2])
def test_joints_that_follow_others(kinds):
    rng = np.random.default_rng(95)
    axes = {"revolute": np.array([0.0, 0.0, 1.0]), "prismatic": np.array([0.6, 0.8, 0.0])}
    edges = [
        axis_edge(kind, axes[kind], np.r_[rng.standard_normal(2), 0.0], (j, j + 1), f"j{j}")
        for j, kind in enumerate(kinds)
    ]
    follow = (Mimic(1, 0, 0.5), Mimic(3, 2, -2.0))
    linkage = assemble(replace(linked(edges, range(1, 5), rng), mimics=follow))
    screws = np.array([[joint.screw for joint in linkage.joints]] * 3)
    turning = np.any(screws[0, :, :3] != 0.0, axis=1)
    screws[:, turning, 3:5] += rng.standard_normal((3, int(turning.sum()), 2))
    found = balance.space.design_space_many(linkage, screws, bases=True)
    assert not found.refused
    agree(found, one_by_one(linkage, screws), linkage.frames)


@pytest.mark.slow
def test_what_cannot_be_assembled_is_told_and_the_rest_answered():
    linkage = load("four_bar_general")
    corners = four_bars(5, seed=93)
    corners[2, :, 1] = 0.0  # all joints in a line: a dead centre
    screws = screws_of(linkage, corners)
    screws[3, 1] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    found = balance.space.design_space_many(linkage, screws)
    assert set(found.refused) >= {3}
    assert found.rank[[0, 1, 4]].tolist() == [8, 7, 8]
    assert all(found.rank[k] == found.nullity[k] == -1 for k in found.refused)
    assert all(
        text.startswith(linkage.source) and "\n" not in text for text in found.refused.values()
    )


def test_screws_of_another_kind_are_refused():
    linkage = load("four_bar_general")
    screws = screws_of(linkage, four_bars(2, seed=94))
    with pytest.raises(ValueError, match=r"shape \(count, 4, 6\)"):
        balance.space.design_space_many(linkage, screws[0])
    for change in ([0, 0, 2, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 1, 0, 0, 1], [np.nan] * 6):
        wrong = screws.copy()
        wrong[1, 2] = change
        with pytest.raises(LinkageError, match="geometry 1 is not that of a revolute joint"):
            balance.space.design_space_many(linkage, wrong)
    with pytest.raises(ValueError, match="balance must be"):
        balance.space.design_space_many(linkage, screws, "static")
    linkage = load("hprs")
    screws = np.array([[joint.screw for joint in linkage.joints]])
    for number in (np.nan, np.inf):
        screws[0, 0, 4] = number
        with pytest.raises(LinkageError, match="is not that of a helical joint"):
            balance.space.design_space_many(linkage, screws)
