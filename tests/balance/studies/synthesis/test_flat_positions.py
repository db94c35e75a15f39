"""Pantographs whose parallelogram is nearly flat at a position: branch, pose and words."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

import balance
import kinematics
from balance.studies.synthesis.constrained_motion import list_defects
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.rr_chain import chain_from_moving_pivot
from balance.studies.synthesis.synthesize import balance_chain
from kinematics.closure.joint_positions import joint_positions

PLACES = [(0.0, 0.0, 0.0), (0.2, 0.1, math.radians(84.0))]


@pytest.fixture(scope="module")
def found():
    return balance.synthesize(PLACES, -1.0, moving=0.05 + 0.05j)


def test_a_turn_of_168_degrees_between_the_links_is_feasible(found):
    """The links pass 6° from flat at both ends; issue 38 was called infeasible."""
    assert found.verdict == "feasible"
    (best,) = found.mechanisms
    assert best.confirmation.confirmed and not best.defects


def test_the_written_file_passes_through_both_positions(found, tmp_path):
    """Its pose is not position 1, and it says where that is."""
    (best,) = found.mechanisms
    path = tmp_path / "pantograph.urdf"
    path.write_bytes(best.urdf)
    at = best.first_position
    assert set(at) == {"shoulder"} and abs(at["shoulder"]) > 0.1
    moved = {"shoulder": at["shoulder"] + best.link_turns[1]}
    linkage = kinematics.load(path)
    shoulder, elbow = (
        next(complex(*j.point[:2]) for j in linkage.joints if j.name == name)
        for name in ("shoulder", "elbow")
    )
    H = linkage.places["tool"].pose
    for (x, y, angle), pose in zip(PLACES, (at, moved), strict=True):
        assert np.abs(joint_positions(linkage, pose)).max() < math.pi  # the loops close
        turn = -2.0 * pose["shoulder"]  # of the elbow, which the belt drives
        tool = elbow + (complex(*H[:2, 3]) - elbow) * cmath.exp(1j * turn)
        tool = shoulder + (tool - shoulder) * cmath.exp(1j * pose["shoulder"])
        assert tool == pytest.approx(complex(x, y), abs=1e-9)
        turned = math.atan2(H[1, 0], H[0, 0]) + turn + pose["shoulder"]
        assert turned == pytest.approx(angle, abs=1e-9)


def test_a_file_at_position_1_says_nothing():
    good = balance.synthesize([(0.3, 0.1, 0.2), (0.1, 0.4, -0.7)], -0.5, moving=0.2 - 0.1j)
    assert good.mechanisms[0].first_position == {}


@pytest.mark.parametrize("degrees", [130.0, -130.0, 100.0])
def test_the_first_flat_pose_is_named(degrees):
    """δ turns from a right angle by twice the turn: it is flat first after a quarter turn."""
    places = [Position(0.0, 0.0, 0.0), Position(0.2, 0.1, math.radians(degrees))]
    chain = chain_from_moving_pivot(places, -1.0, 0.05 + 0.05j)
    words = list_defects(balance_chain(chain, -1.0))[0].words
    assert f"flat {'-' if degrees > 0 else '+'}90.0° of δ on" in words
