"""The momentum matrix and its null space: by differences of poses, and by counts of dimensions.

[N] D. N. Nenchev, Reaction null space of a multibody system with applications in robotics,
Mechanical Sciences 4, 2013.
"""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.pose import momentum_map, momentum_matrix, reaction_null_space
from kinematics import ScrewJoint, from_screws
from kinematics.errors import PoseError, UsageError
from tests.support.laws import point_masses, relative, unit_vector
from tests.support.pairs import momentum_of_motion

COMPONENTS = {"both": slice(0, 6), "moment": slice(0, 3), "force": slice(3, 6)}


def arm(count, seed=0, planar=False):
    """An open chain of revolute joints with bodies of any kind, flat ones in a plane."""
    rng = np.random.default_rng(seed)
    joints, bodies = [], {}
    for k in range(count):
        axis = [0, 0, 1] if planar else unit_vector(rng)
        point = rng.standard_normal(3) * ([0.4, 0.4, 0.0] if planar else 1.0)
        parent = f"l{k - 1}" if k else "base"
        joints.append(ScrewJoint(f"j{k}", parent, f"l{k}", axis, point))
        masses, points = point_masses(rng)
        if planar:
            points[:, 2] = 0.0
        centre = masses @ points / masses.sum()
        d = points - centre
        tensor = np.einsum(
            "k,kij->ij",
            masses,
            np.einsum("ki,ki->k", d, d)[:, None, None] * np.eye(3)
            - d[:, :, None] * d[:, None, :],
        )
        bodies[f"l{k}"] = masses.sum(), centre, tensor
    return from_screws(joints, bodies=bodies)


@pytest.mark.parametrize("model", ["five_bar", "three_rsr", "slider_crank", "hprs", "delta"])
def test_columns_are_momenta_by_differences_of_poses(model):
    linkage = kinematics.load(model)
    u = np.full(linkage.mobility, 0.05)
    M = momentum_matrix(linkage, u)
    other = np.column_stack([momentum_of_motion(linkage, u, e) for e in np.eye(len(u))])
    size = sum(np.abs(body.inertia).max() for body in linkage.bodies)
    assert M.shape == (6, linkage.mobility)
    assert np.abs(M - other).max() < 1e-10 * size


@pytest.mark.parametrize(("count", "whole", "part"), [(7, 1, 4), (6, 0, 3), (8, 2, 5)])
def test_dimensions_of_a_spatial_arm(count, whole, part):
    """[N]: n - 6 rates without momentum, n - 3 without moment, in general."""
    linkage = arm(count)
    u = 0.2 * np.random.default_rng(1).standard_normal(count)
    found = {what: reaction_null_space(linkage, u, what) for what in COMPONENTS}
    assert [found[what].dimension for what in COMPONENTS] == [whole, part, part]
    for what, rows in COMPONENTS.items():
        for rates in found[what].basis.T:
            h = momentum_of_motion(linkage, u, rates)
            assert np.abs(h[rows]).max() < 1e-10 * np.abs(found[what].matrix).max()
        rest = found[what].directions[:, 0]
        assert np.abs(momentum_of_motion(linkage, u, rest)[rows]).max() > 0.01


@pytest.mark.parametrize("count", [3, 4, 5])
def test_dimensions_of_a_planar_arm(count):
    """[N]: n - 3 without momentum, n - 1 without moment about a point, n - 2 without force."""
    linkage = arm(count, planar=True)
    u = 0.3 * np.random.default_rng(1).standard_normal(count)
    found = [reaction_null_space(linkage, u, what).dimension for what in COMPONENTS]
    assert found == [count - 3, count - 1, count - 2]


def test_the_point_of_the_moment_matters_without_the_force_alone():
    linkage, point = arm(5), np.array([0.3, -2.0, 1.0])
    u = np.full(5, 0.1)
    here, there = (
        reaction_null_space(linkage, u, "moment", about=about) for about in (None, point)
    )
    assert here.dimension == there.dimension == 2
    for rates, about in ((here.basis[:, 0], np.zeros(3)), (there.basis[:, 0], point)):
        h = momentum_of_motion(linkage, u, rates)
        assert np.abs(h[:3] - np.cross(about, h[3:])).max() < 1e-9
        assert np.abs(h[:3] - np.cross(point - about, h[3:])).max() > 1e-3
    with pytest.raises(UsageError, match="no components 'torque'"):
        reaction_null_space(linkage, u, "torque")


@pytest.mark.slow
@pytest.mark.lanes
def test_a_map_holds_the_matrices_of_its_poses():
    linkage = kinematics.load("five_bar")
    grid = {"u3": np.linspace(-0.3, 0.2, 6), "u1": [0.3, 0.1, -0.1]}
    names = list(linkage.inputs)
    grid = {names[1]: grid["u3"], names[0]: grid["u1"]}
    found = momentum_map(linkage, grid)
    assert found.reached.all() and found.matrix.shape == (6, 3, 6, 2)
    for i, second in enumerate(grid[names[1]]):
        for k, first in enumerate(grid[names[0]]):
            u = [first, second]
            one = reaction_null_space(linkage, u)
            assert relative(found.matrix[i, k], one.matrix) < 1e-12
            assert relative(found.singular_values[i, k], one.singular_values) < 1e-12
            quiet = found.quietest[i, k]
            other = momentum_of_motion(linkage, u, quiet)
            assert relative(found.matrix[i, k] @ quiet, other) < 1e-9


@pytest.mark.lanes
@pytest.mark.slow
def test_a_map_ends_at_the_edge_of_the_workspace():
    """What is not reached is empty; what is reached closes its loops."""
    linkage = kinematics.load("five_bar")
    values = np.linspace(-2.5, 2.5, 41)
    found = momentum_map(linkage, dict.fromkeys(linkage.inputs, values))
    share = found.reached.mean()
    assert 0.1 < share < 0.95
    assert np.isnan(found.smallest[~found.reached]).all()
    assert (found.dimension[~found.reached] == -1).all()
    for i, k in np.argwhere(found.reached)[::97]:
        u = [values[i], values[k]]
        q = found.positions[i, k]
        assert relative(momentum_matrix(linkage, q), found.matrix[i, k]) < 1e-9
        assert np.abs(q[linkage.positions_of(linkage.inputs)] - u).max() < 1e-12


@pytest.mark.lanes
@pytest.mark.slow
def test_the_progress_of_a_map_ends_with_all_poses():
    linkage, calls = kinematics.load("five_bar"), []
    axes = dict.fromkeys(linkage.inputs, np.linspace(-0.3, 0.3, 40))
    poses = momentum_map(linkage, axes, progress=lambda *done: calls.append(done))
    assert poses.reached.all() and calls[-1] == (1600, 1600) and calls == sorted(calls)


def test_wrong_grids_are_refused():
    linkage = kinematics.load("five_bar")
    first = linkage.inputs[0]
    for grid, text in (
        ({"q2": [0.0]}, "not an input"),
        ({first: [0.0, 0.2, 0.1]}, "rise or"),
        ({first: [np.nan]}, "finite"),
        ({}, "give positions"),
        ({first: [3.0, 3.01]}, "no pose of the grid"),
    ):
        with pytest.raises(PoseError, match=text):
            momentum_map(linkage, grid)
