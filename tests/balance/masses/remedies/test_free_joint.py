"""A frame on a free hinge: turns by hand, and no momentum in its file along its motion."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.masses.remedies.balancers.free_joint import apply_free_joint
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import drive
from kinematics.loading.model_gallery import as_linkage
from kinematics.model.document.element import Document
from tests.support.remedy_files import momentum, momentum_by_pinocchio, table
from tests.support.remedy_requests import BALANCED_FORCE, request_of


def load_moved(request, applied):
    """The linkage on its hinge, and the motion as the file beside it says."""
    inputs = [*request.linkage.inputs, applied.details["joint"]]
    whole = kinematics.load(Document("whole.urdf", applied.urdf), inputs=inputs)
    columns = table(applied.files["motion.csv"])
    parts = [
        np.stack([columns[f"{rate}{name}"] for name in inputs], axis=1)[::100]
        for rate in ("", "velocity ", "acceleration ")
    ]
    return whole, drive(whole, columns["time"][::100], *parts)


@pytest.mark.slow
def test_arms_about_their_centre_of_mass_turn_the_frame_by_hand():
    """All turns with the first arm, 5/12 + 1 + 1/12 kg m²; the second has 1/12 of it.

    The first arm has 2 kg, with 1/12 kg m² and its centre at 0.5 m; the second its centre on
    its joint, 1 m away. On the hinge the first input feels nothing at all.
    """
    request = request_of(*BALANCED_FORCE)
    (applied,) = apply_free_joint(request)
    assert applied.verdict == "feasible" and applied.added_mass == pytest.approx(0.0, abs=1e-9)
    whole, motion = load_moved(request, applied)
    first, second = 1.0 / 12.0 + 2.0 * 0.25, 1.0 / 12.0
    total = first + 1.0 + second
    np.testing.assert_allclose(
        motion.ud[:, 2], -motion.ud[:, 0] - second / total * motion.ud[:, 1], atol=1e-9
    )
    felt = [applied.input_inertia[name] for name in request.linkage.inputs]
    assert felt == pytest.approx([0.0, second - second**2 / total], abs=1e-9)
    assert whole.mobility == 3 and applied.lost_freedoms == 0


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "five_bar"])
def test_no_momentum_is_left_along_the_motion_of_the_file(model):
    request = RemedyRequest(as_linkage(model))
    (applied,) = apply_free_joint(request)
    assert applied.verdict == "feasible" and applied.residual <= 1e-9
    whole, motion = load_moved(request, applied)
    assert np.ptp(motion.u[:, -1]) > 0.01
    total = momentum_by_pinocchio(whole, motion)
    parts = np.array([momentum(whole, *pair) for pair in zip(motion.q, motion.qd, strict=True)])
    size = np.abs(parts).sum(axis=1).max()
    assert np.abs(total).max() < 1e-9 * size
    assert np.abs(parts.sum(axis=1)).max() < 1e-9 * size


def test_where_a_free_hinge_is_no_remedy():
    for request, why in (
        (RemedyRequest(as_linkage("bennett")), "a spatial linkage"),
        (request_of(*BALANCED_FORCE, balance="force"), "only the force"),
    ):
        (applied,) = apply_free_joint(request)
        assert applied.verdict == "refused" and why in applied.reason
