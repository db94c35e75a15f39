"""Files of remedies by a momentum of our own: links placed by matrix exponentials, in NumPy.

The momentum of a body is that of its spatial inertia, carried along by its displacement; joints
move as in a random motion of the file. Wheels are inputs of their own, which balance for their
motion alone; constraints take freedoms: both have tests elsewhere.
"""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import random_motions
from kinematics.loading.model_gallery import as_linkage
from tests.support.double_pendulum import pendulum
from tests.support.remedy_files import momentum, placed

MODELS = (
    "four_bar_general",
    "slider_crank",
    "double_pendulum",
    "five_bar",
    "four_bar_kite",
    "four_bar_parallelogram",
    "bennett",
    "four_bar_antiparallelogram",
    "principal_vector_linkage",
    "zero_reaction_arm",
    "four_bar_spherical",
    "slider_pantograph",
)
WHOLE = (
    "own_masses",
    "separate_rotors",
    "counter_rotary_masses",
    "planetary_transmission",
    "parallelogram_transmission",
    "duplicates",
    "added_dyad",
)


def test_the_momentum_is_that_of_the_centres():
    """Mass times the velocity of each centre of mass, by finite differences of the poses."""
    linkage = pendulum(gear=1.0, radius=0.1).linkage
    q, qd, step = np.array([0.4, -0.7]), np.array([1.1, 0.6]), 1e-5
    after, before = (placed(linkage, q + sign * step * qd, qd)[0] for sign in (1.0, -1.0))
    for body, found in zip(linkage.bodies, momentum(linkage, q, qd), strict=True):
        moment = np.append(body.inertia[1:4], body.inertia[0])
        speed = (after[body.link] - before[body.link]) @ moment / (2.0 * step)
        np.testing.assert_allclose(found[3:], speed[:3], rtol=1e-7, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_no_file_that_is_called_balanced_has_momentum(name, tmp_path):
    """Of force and moment; of counterweights for the force, of the force alone."""
    if name not in kinematics.gallery():
        pytest.importorskip("example_robot_data")
    request = RemedyRequest(as_linkage(name))
    comparison = compare_request(request, [*WHOLE, "force_masses", "pantograph"])
    balanced = [applied for applied in comparison.results if applied.urdf is not None]
    assert balanced or comparison.verdict != "feasible"
    for applied in balanced:
        path = tmp_path / f"{applied.remedy}.urdf"
        applied.to_urdf(path)
        linkage = kinematics.load(path, inputs=request.linkage.inputs)
        (motion,) = random_motions(linkage, 1, 9, seed=7)
        parts = np.array(
            [momentum(linkage, q, qd) for q, qd in zip(motion.q, motion.qd, strict=True)]
        )
        rows = slice(3, 6) if applied.verdict == "partial" else slice(0, 6)
        size = np.abs(parts).sum(axis=1).max()
        assert np.abs(parts.sum(axis=1)[:, rows]).max() < 1e-9 * size, applied
