"""Legs that share no joint but their crank are closed one by one."""

import numpy as np
import pytest

from kinematics.closure.assembly import close_loops as module
from kinematics.closure.assembly.close_loops import close_by_pieces, close_loops
from kinematics.closure.mobility.components import split_components
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.model.document.element import Document
from tests.support.urdf_text import FOUR_BAR
from tests.support.walking_legs import walking_legs


def draft_of(legs, dialect="loop"):
    return read_unassembled(Document("legs", walking_legs(legs, dialect).encode()))


def distances(draft, closed):
    """How far the points of each ball are apart, by the poses of the links that are placed."""
    found = []
    for loop in draft.tree.every("loop"):
        ends = []
        for role in ("predecessor", "successor"):
            side = loop.first(role)
            point = side.first("origin").vector("xyz", "0 0 0")
            ends.append(closed.places[side.attributes["link"]].pose @ [*point, 1.0])
        found.append(np.abs(ends[0] - ends[1]).max())
    return found


def check(draft):
    closed = close_loops(draft)
    assert max(distances(draft, closed)) <= 1e-9 < 0.1 < max(distances(draft, draft))
    (told,) = [notice.message for notice in closed.notices if notice.code == "assembled"]
    legs = len(draft.loops) // 3
    assert f"in {legs} pieces one after another" in told


def test_legs_are_closed_where_few_starts_close_all_of_them(monkeypatch):
    monkeypatch.setattr(module, "NEAR_STARTS", 1)
    monkeypatch.setattr(module, "FAR_DISTANCES", (0.1,))
    check(draft_of(6))


@pytest.mark.slow
@pytest.mark.parametrize("dialect", ["loop", "drake"])
def test_twelve_legs(dialect):
    check(draft_of(12, dialect))


def test_a_single_loop_is_left_whole():
    (part,) = split_components(read_unassembled(Document("bars", FOUR_BAR.encode())))
    assert close_by_pieces(part, lambda piece: pytest.fail("it has no pieces")) == (None, 0)


def test_joints_that_are_held_couple_no_loops():
    draft = draft_of(3)
    (crank,) = [k for k, joint in enumerate(draft.joints) if joint.name == "crank"]
    parts = split_components(draft, frozenset({crank}))
    assert [part.loops for part in parts] == [(0, 1, 2), (3, 4, 5), (6, 7, 8)]
