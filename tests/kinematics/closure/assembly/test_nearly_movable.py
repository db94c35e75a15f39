"""Joints at rest as written whose loops would move with slightly other axes."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from balance.masses import feasible
from kinematics.errors import OpenLoopError
from tests.support.urdf_text import along, joint, link, loop, saved

# Lengths in metres, with all digits of a double: nothing to round.
CRANK, FIRST, SECOND = (
    np.array(x)
    for x in ([0.02, 0, 0.1512345678912], [-0.0412345, 0.03, 0], [-0.0423456, -0.03, 0.0123456])
)


def neck(folder, longer, size=1.0, along_rod=False, apart=0.0):
    """A head on two parallelograms, at the end of a waist and beside an arm.

    The first of two rods is longer than the neck by ``longer`` metres; without ``along_rod``
    its end is shifted across it too. The frames at the end of the other are ``apart``.
    """
    body = dict(mass=1.0, inertia=0.1 * np.eye(3), origin=along([0.01, 0.02, 0.03]))
    names = ("torso", "chest", "arm", "neck", "head", "rod1", "rod2")
    above = np.array([0.01, 0, 0.3123456789123])
    crank = size * CRANK
    parts = [link(name, **body) for name in names]
    parts += [
        joint("waist", "continuous", "torso", "chest", along([0.013, 0, 0.2134]), [0, 0, 1]),
        joint("shoulder", "continuous", "chest", "arm", along([0.01, 0.21, 0.17]), [0, 1, 0]),
        joint("neck_pitch", "continuous", "chest", "neck", along(above), [0, 1, 0]),
        joint("head_pitch", "continuous", "neck", "head", along(crank), [0, 1, 0]),
    ]
    for k, (side, more) in enumerate(((FIRST, longer), (SECOND, 0.0)), 1):
        at, shift = size * side, np.array([more, 0, 0])
        if along_rod:
            shift = more * crank / np.linalg.norm(crank) + np.array([1e-3 * more, 0, 0])
        gap = np.array([0, 0, apart if k == 2 else 0.0])
        start, ends = along(above + at), (along(crank + shift), along(at + shift + gap))
        rod = f"rod{k}"
        parts.append(joint(f"{rod}_pitch", "continuous", "chest", rod, start, [0, 1, 0]))
        parts.append(loop(f"{rod}_end", "continuous", (rod, "head"), ends, [0, 1, 0]))
    return saved(folder, *parts)


@pytest.mark.table(1)
@pytest.mark.parametrize("along_rod", [False, True])
@pytest.mark.parametrize("size, longer", [(1.0, 1e-4), (0.2, 2.6e-5), (1.0, 1e-3)])
def test_a_parallelogram_that_is_off_by_a_hair_leaves_the_mobility_in_doubt(
    tmp_path, size, longer, along_rod
):
    exact = kinematics.load(neck(tmp_path, 0.0, size))
    assert exact.mobility == 3 and not exact.idle
    linkage = kinematics.load(neck(tmp_path, longer, size, along_rod))
    assert linkage.mobility == 2 and len(linkage.idle) == 6
    (text,) = [n.message for n in linkage.notices if n.code == "nearly_movable"]
    assert "1 degree of freedom more" in text and "neck_pitch" in text
    space = certify(design_space(linkage))
    assert space.level == "estimated"
    assert any(text in doubt for doubt in space.certainty.doubts)
    # Transfers through joints that may move are no design.
    answer = feasible(certify(design_space(linkage, balance="force")))
    assert answer.verdict == "undecided" and "which joints move" in answer.words
    assert feasible(certify(design_space(exact, balance="force"))).verdict == "feasible"


def test_the_answer_as_written_is_without_doubt(tmp_path):
    linkage = kinematics.load(neck(tmp_path, 1e-4), angles="as_written")
    assert linkage.mobility == 2
    assert "nearly_movable" not in {notice.code for notice in linkage.notices}
    assert certify(design_space(linkage)).level != "estimated"


@pytest.mark.parametrize("longer", [0.02, 0.0])
def test_a_frame_by_design_and_an_exact_parallelogram_have_no_doubt(tmp_path, longer):
    linkage = kinematics.load(neck(tmp_path, longer))
    assert linkage.mobility == (2 if longer else 3)
    assert "nearly_movable" not in {notice.code for notice in linkage.notices}


def test_loops_that_are_open_and_nearly_movable_are_refused_with_the_reason(tmp_path):
    """How far axes are from closing them, and which one: the long rod's, or one beside it."""
    with pytest.raises(
        OpenLoopError, match=r"1 degree of freedom, but that is \S+ of the size"
    ) as refusal:
        kinematics.load(neck(tmp_path, 1e-4, along_rod=True, apart=3e-8))
    assert refusal.value.distance == pytest.approx(3e-8, rel=1e-6)
    found = re.search(r"rad and (\S+) m, that of joint '(\w+)' furthest", str(refusal.value))
    assert 2e-5 < float(found[1]) < 1e-4  # the excess, shared by both ends and both rods
    assert found[2] in ("neck_pitch", "head_pitch", "rod1_pitch", "rod1_end")
