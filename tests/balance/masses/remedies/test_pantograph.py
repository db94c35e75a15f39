"""Pantographs: masses by hand, and no momentum in their files by finite poses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import kinematics
from balance.masses.remedies.dyads.pantograph import apply_pantograph
from balance.motion.verification.trajectory import random_motions
from kinematics.model.document.element import Document
from tests.support.remedy_files import momentum
from tests.support.remedy_requests import PENDULUM, SLENDER, request_of, request_of_model, rod


def test_a_pendulum_of_rods_has_the_masses_of_the_closed_formula():
    """Two rods of 1 kg and 1 m, centres half-way; the pantograph is half as large.

    A mass m on the counter-arm, 0.25 m from A', and M on the bar, 0.75 m beyond the arm: of the
    second rod 0.5 kg m are left, across which the hinge of the bar is 0.25 m from A', so that
    ``m² / 16 = 0.25 + M² / 16``; of the first 1.5 kg m, which are ``0.5 m + 1.25 M``.
    """
    bar = brentq(lambda M: 0.5 * np.sqrt(4.0 + M**2) + 1.25 * M - 1.5, 0.0, 1.0)
    for aim, verdict in (("force", "feasible"), ("dynamic", "partial")):
        (applied,) = apply_pantograph(request_of(*PENDULUM, balance=aim))
        assert applied.verdict == verdict, applied.reason
        assert applied.added_mass == pytest.approx(bar + np.sqrt(4.0 + bar**2), rel=1e-5)
        assert len(applied.new_links) == 2 and len(applied.new_joints) == 3


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "slider_crank", "two rods"])
def test_its_file_has_no_linear_momentum(model):
    request = request_of_model(model)
    (applied,) = apply_pantograph(request)
    assert applied.verdict == "partial" and applied.residual > 0.0
    document = Document("pantograph.urdf", applied.urdf)
    linkage = kinematics.load(document, inputs=request.linkage.inputs)
    (motion,) = random_motions(linkage, 1, 9, seed=11)
    parts = np.array(
        [momentum(linkage, *pair) for pair in zip(motion.q, motion.qd, strict=True)]
    )
    size = np.abs(parts[..., 3:]).sum(axis=1).max()
    assert np.abs(parts.sum(axis=1)[:, 3:]).max() < 1e-9 * size
    masses = sum(body.inertia[0] for body in linkage.bodies)
    assert applied.added_mass == pytest.approx(masses - request.given_mass)


def test_no_pair_no_pantograph():
    (applied,) = apply_pantograph(request_of(PENDULUM[0]))
    assert applied.verdict == "refused" and "no pair of links" in applied.reason
    spatial = rod("b", "a", "1 0 0", 1.0, "0.5 0 0", SLENDER, axis="0 1 0")
    (applied,) = apply_pantograph(request_of(PENDULUM[0], spatial))
    assert applied.verdict == "refused"
