"""Loops of every type, closed and open, against the constraints that define them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinematics.files.urdf.loop_joints import perpendicular_to
from kinematics.model.linkage import GROUND
from tests.support.urdf_text import (
    DEGREES,
    EYE,
    UNIT_INERTIA,
    about,
    along,
    joint,
    link,
    loop,
    pose_of,
    random_pose,
    screw,
    words,
)


def test_perpendicular_directions():
    for n, u in ([0, 1], [1, 2], [2, 0]):
        assert perpendicular_to(np.eye(3)[n]).tolist() == np.eye(3)[u].tolist()
    for n in np.random.default_rng(0).normal(size=(200, 3)):
        n = n / np.linalg.norm(n)
        u = perpendicular_to(n)
        assert abs(u @ n) < 1e-15 and abs(u @ u - 1) < 1e-15


def freedom(rng, kind, axis, second):
    """A random displacement (4, 4) that a loop's joint allows, in the predecessor's frame."""
    turn, slide = about(axis, rng.uniform(-2.5, 2.5)), along(axis * rng.normal())
    across = rng.normal(size=3)
    glide = along(across - axis * (axis @ across))
    return {
        "fixed": np.eye(4),
        "revolute": turn,
        "continuous": turn,
        "prismatic": slide,
        "cylindrical": slide @ turn,
        "planar": glide @ turn,
        "spherical": pose_of([0, 0, 0], rng.uniform(-1.4, 1.4, 3)),
        "universal": turn @ about(second, rng.uniform(-2.5, 2.5)),
    }[kind]


def bench(read, kind, rng, axis=None, second=None, error=EYE, ends=("b", "c")):
    """Two links on the ground, joined by a loop whose joint has moved; and F_p, F_s.

    ``error`` displaces the successor's loop frame, in its own axes.
    """
    poses = {"a": EYE, "b": random_pose(rng), "c": random_pose(rng), "d": EYE}
    poses["d"] = poses["c"] @ random_pose(rng)
    n = np.array([1.0, 0, 0]) if axis is None else np.asarray(axis) / np.linalg.norm(axis)
    b = perpendicular_to(n) if second is None else np.asarray(second, dtype=float)
    here = random_pose(rng)
    before = poses[ends[0]] @ here
    after = before @ freedom(rng, kind, n, b) @ error
    there = np.linalg.inv(poses[ends[1]]) @ after
    more = "" if second is None else f'<axis2 xyz="{words(second)}"/>'
    draft = read(
        link("a"),
        link("b", **UNIT_INERTIA),
        link("c", **UNIT_INERTIA),
        link("d"),
        joint("j1", "revolute", "a", "b", poses["b"]),
        joint("j2", "revolute", "a", "c", poses["c"]),
        joint("f", "fixed", "c", "d", np.linalg.inv(poses["c"]) @ poses["d"]),
        loop("k", kind, ends, (here, there), axis, more),
    )
    return draft, before, after, before[:3, :3] @ n


AXES = [None, [0, 0, 1], [0, -2, 0], [0.3, -0.5, 0.9]]


@pytest.mark.table
@pytest.mark.parametrize("ends", [("b", "c"), ("b", "d"), ("b", "a"), ("a", "d")])
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("kind", DEGREES)
def test_closed_loops(read, kind, axis, ends):
    rng = np.random.default_rng(5)
    draft, before, after, n = bench(read, kind, rng, axis, ends=ends)
    links = {"a": GROUND, "b": 0, "c": 1, "d": 1}
    count = DEGREES[kind]
    added, (weld,) = draft.joints[2:], draft.loops
    assert weld.name == "k" and np.array_equal(weld.gap, EYE)
    assert [j.name for j in added] == (
        ["k"] if count == 1 else [f"k.{i}" for i in range(count)]
    )
    assert all(j.in_loop for j in added) and not any(j.in_loop for j in draft.joints[:2])
    start, end = links[ends[0]], links[ends[1]]
    chain = [start, *range(2, 2 + count)]
    assert [j.parent for j in added] == chain[:-1]
    expected = (end, start) if chain[-1] == GROUND else (chain[-1], end)
    assert (weld.end, weld.successor) == expected
    screws = np.array([j.screw for j in added]).reshape(-1, 6)
    np.testing.assert_allclose(screws, loop_screws(kind, before, after, n, screws), atol=1e-12)


def loop_screws(kind, before, after, n, found):
    """Screws of the loop's joints; axes that the type leaves open are taken from ``found``."""
    p, slide = before[:3, 3], np.concatenate([np.zeros(3), n])
    if kind == "planar":
        u = found[0, 3:]
        assert abs(u @ n) < 1e-12
        directions = [[0, 0, 0, *u], [0, 0, 0, *np.cross(n, u)]]
        return [*directions, screw(n, after[:3, 3])]
    if kind == "spherical":
        u = found[1, :3]
        assert abs(u @ n) < 1e-12
        return [screw(n, p), screw(u, p), screw(np.cross(n, u), p)]
    if kind == "universal":
        axis = before[:3, :3].T @ n
        return [screw(n, p), screw(after[:3, :3] @ perpendicular_to(axis), p)]
    turn = screw(n, p)
    chains = {"fixed": np.zeros((0, 6)), "prismatic": [slide], "cylindrical": [turn, slide]}
    return chains.get(kind, [turn])


def test_universal_loop_with_its_own_second_axis(read):
    rng = np.random.default_rng(6)
    axis = np.array([1.0, 2.0, 2.0]) / 3
    second = np.array([2.0, 1.0, -2.0])
    draft, before, after, n = bench(read, "universal", rng, axis, second)
    assert np.array_equal(draft.loops[0].gap, EYE)
    b = after[:3, :3] @ second / 3
    np.testing.assert_allclose(draft.joints[3].screw, screw(b, before[:3, 3]), atol=1e-12)


@pytest.mark.table
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", DEGREES)
def test_open_loops(read, kind, seed):
    """The gap carries a pose that the joint can reach onto the successor's, minimally."""
    rng = np.random.default_rng(seed)
    error = pose_of(0.02 * rng.normal(size=3), 0.03 * rng.normal(size=3))
    axis = rng.normal(size=3)
    draft, before, after, n = bench(read, kind, rng, axis, error=error)
    gap = draft.loops[0].gap
    reached = np.linalg.inv(gap) @ after
    local = np.linalg.inv(before) @ reached
    a = before[:3, :3].T @ n
    b = perpendicular_to(a)
    assert constraint(kind, local, a, b) < 1e-12
    assert constraint(kind, np.linalg.inv(before) @ after, a, b) > 1e-4
    assert not np.array_equal(gap, EYE)
    best = distance(reached, after)
    for _ in range(20):
        other = before @ local @ small(rng, kind, local, a, b)
        assert constraint(kind, np.linalg.inv(before) @ other, a, b) < 1e-12
        assert distance(other, after) >= best - 1e-12


def small(rng, kind, local, a, b):
    """A small motion of the end's frame, in its axes, that the joint allows there."""
    R = local[:3, :3]
    n, q = R.T @ a, 1e-3 * rng.normal(size=5)
    d = rng.normal(size=3)
    turn, slide = about(n, q[0]), along(q[1] * n)
    return {
        "fixed": EYE,
        "prismatic": slide,
        "cylindrical": slide @ turn,
        "planar": along(1e-3 * (d - n * (n @ d))) @ turn,
        "spherical": about(d, q[2]),
        "universal": turn @ about(b, q[3]),
    }.get(kind, turn)


def constraint(kind, local, a, b):
    """How far a displacement (4, 4) in the predecessor's frame is from those allowed."""
    R, d = local[:3, :3], local[:3, 3]
    on_axis, on_plane = np.linalg.norm(d - a * (a @ d)), abs(a @ d)
    axis_kept, rotation = np.linalg.norm(R @ a - a), np.linalg.norm(R - np.eye(3))
    whole = np.linalg.norm(d)
    return {
        "fixed": whole + rotation,
        "prismatic": on_axis + rotation,
        "cylindrical": on_axis + axis_kept,
        "planar": on_plane + axis_kept,
        "spherical": whole,
        "universal": whole + abs(a @ R @ b),
    }.get(kind, whole + axis_kept)


def distance(first, second):
    """Squared distance of origins plus the squared angle between two poses."""
    rotation = Rotation.from_matrix(first[:3, :3].T @ second[:3, :3])
    return np.sum((first[:3, 3] - second[:3, 3]) ** 2) + rotation.magnitude() ** 2


def test_universal_loop_with_parallel_axes(read):
    """Two axes a quarter turn off: any perpendicular axis will do, and all stays finite."""
    draft = read(
        link("a"),
        link("b", **UNIT_INERTIA),
        joint("j", "revolute", "a", "b"),
        loop("k", "universal", ("b", "a"), axis=[0, 0, 1], more='<axis2 xyz="0 0 1"/>'),
    )
    screws = np.array([j.screw[:3] for j in draft.joints[1:]])
    np.testing.assert_allclose(screws @ screws.T, np.eye(2), atol=1e-12)
    angle = Rotation.from_matrix(draft.loops[0].gap[:3, :3]).magnitude()
    assert abs(angle - np.pi / 2) < 1e-12


def test_several_loops_follow_the_tree(read):
    draft = read(
        *(link(name, **UNIT_INERTIA) for name in "abc"),
        joint("j1", "revolute", "a", "b"),
        joint("j2", "revolute", "a", "c"),
        loop("s", "spherical", ("b", "c")),
        loop("w", "fixed", ("b", "c")),
        loop("t", "revolute", ("c", "a")),
    )
    assert [j.name for j in draft.joints] == ["j1", "j2", "s.0", "s.1", "s.2", "t"]
    assert [j.parent for j in draft.joints[2:]] == [0, 2, 3, 1]
    assert [(w.end, w.successor) for w in draft.loops] == [(4, 1), (0, 1), (5, GROUND)]
