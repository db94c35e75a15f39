"""Ways from links to the ground, and what locks and welds make of them, on random trees."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.model.chain import carriers, loop_joints, loop_signs, path, paths, rigid_parts

SEEDS = range(8)


def random_tree(rng, count=12):
    """Links that carry each joint, -1 for the ground; carriers come first."""
    return [int(rng.integers(-1, j)) if j else -1 for j in range(count)]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_ways_of_all_links_solve_the_tree_s_incidence_equations(seed):
    """A link's way is its carrier's and its own joint: ``(1 - P) W = 1``, P the carriers."""
    parent = random_tree(np.random.default_rng(seed))
    n = len(parent)
    P = np.zeros((n, n))
    for j, link in enumerate(parent):
        if link >= 0:
            P[j, link] = 1.0
    ways = paths(parent)
    assert np.array_equal(ways[:-1], np.linalg.inv(np.eye(n) - P).round())
    assert not ways[-1].any()
    for link in range(-1, n):
        assert sorted(path(parent, link)) == np.flatnonzero(ways[link]).tolist()


@pytest.mark.parametrize("seed", SEEDS)
def test_around_a_loop_joints_add_up_to_the_motion_of_one_end_beyond_the_other(seed):
    """Joint rates times signs: the difference of sums gathered by walking each way."""
    rng = np.random.default_rng(seed)
    parent, rates = random_tree(rng), rng.standard_normal(12)
    ends = [tuple(map(int, rng.integers(-1, 12, 2))) for _ in range(5)]
    signs = loop_signs(parent, ends)
    for row, (end, successor) in zip(signs, ends, strict=True):
        sums = [sum(rates[path(parent, link)], 0.0) for link in (end, successor)]
        assert row @ rates == pytest.approx(sums[0] - sums[1], abs=1e-13)
        assert set(np.flatnonzero(row).tolist()) == loop_joints(parent, end, successor)
    assert loop_signs(parent, []).shape == (0, 12)


@pytest.mark.parametrize("seed", SEEDS)
def test_links_are_carried_by_the_first_joint_that_is_not_locked(seed):
    rng = np.random.default_rng(seed)
    parent = random_tree(rng)
    kept = np.flatnonzero(rng.random(12) < 0.5).tolist()
    found = carriers(parent, kept)
    for link in range(-1, 12):
        on_the_way = [j for j in path(parent, link) if j in kept]
        assert found[link] == (kept.index(on_the_way[0]) if on_the_way else -1)
    assert np.array_equal(carriers(parent, range(12)), [*range(12), -1])


@pytest.mark.parametrize("seed", SEEDS)
def test_rigid_parts_are_the_components_of_the_graph_of_welds(seed):
    """Against powers of the adjacency matrix."""
    rng = np.random.default_rng(seed)
    welds = [tuple(map(int, rng.integers(-1, 10, 2))) for _ in range(5)]
    joined = np.eye(11, dtype=bool)
    for one, other in welds:
        joined[one, other] = joined[other, one] = True
    joined = np.linalg.matrix_power(joined.astype(float), 11) > 0
    part = rigid_parts(10, welds)
    assert np.array_equal(np.equal.outer(part, part), joined)
    assert part[-1] == 0
    firsts = [int(np.flatnonzero(part == p)[0]) for p in range(1, int(part.max()) + 1)]
    assert firsts == sorted(firsts)
