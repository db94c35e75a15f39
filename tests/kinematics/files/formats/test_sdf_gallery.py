"""The gallery written as SDF, in ten styles: the linkages of the URDF files.

Each model is written in one style, and each style has all types of joints; all styles of all
models with ``ALL_CASES=1``.
"""

from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from balance import design_space
from kinematics import gallery, load
from kinematics.files.formats.robot_files import read_unassembled
from tests.support.covering import covering_pairs, joint_types
from tests.support.sdf_text import STYLES, fits, sdf_of

MODELS = sorted(gallery())
PAIRS = covering_pairs({name: joint_types(gallery()[name]) for name in MODELS}, STYLES)
EXACT = 1e-12


def test_all_of_the_gallery_is_written():
    assert sum(fits(ElementTree.parse(gallery()[name]).getroot()) for name in MODELS) >= 20


@cache
def of_urdf(name):
    return read_unassembled(gallery()[name])


def saved(tmp_path, name, style):
    path = tmp_path / f"{name}.sdf"
    path.write_text(sdf_of(gallery()[name], style, seed=len(name)), encoding="utf-8")
    return path


def off(screw, other, either_sign):
    """How far screws are apart; those of joints that are turned round up to the sign."""
    apart = [np.abs(screw - sign * other).max() for sign in (1, -1)[: 1 + either_sign]]
    return min(apart)


@pytest.mark.table
@pytest.mark.parametrize(("name", "style"), PAIRS)
def test_drafts_agree(name, style, tmp_path):
    said, found = of_urdf(name), read_unassembled(saved(tmp_path, name, style))
    bodies = {body.name: body for body in found.bodies}
    assert set(bodies) == {body.name for body in said.bodies}
    for body in said.bodies:
        assert np.abs(bodies[body.name].inertia - body.inertia).max() < EXACT
    joints = {joint.name: joint for joint in found.joints}
    assert set(joints) == {joint.name for joint in said.joints}
    for joint in said.joints:
        # Balls have the axes of the frame of their joint.
        if joint.numbered and style in ("joint_poses", "reversed"):
            continue
        assert off(joints[joint.name].screw, joint.screw, style == "reversed") < EXACT
    assert len(found.loops) == len(said.loops) and len(found.mimics) == len(said.mimics)


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_ranks_agree(name, tmp_path):
    """One style for each model, another one than that of its drafts."""
    path = saved(tmp_path, name, STYLES[(MODELS.index(name) + 5) % len(STYLES)])
    said = design_space(load(gallery()[name]))
    inputs = said.linkage.inputs
    found = design_space(load(path, inputs=inputs))
    assert [order.rank for order in found.orders] == [order.rank for order in said.orders]
    assert found.linkage.mobility == said.linkage.mobility
    assert sorted(found.bodies) == sorted(said.bodies)
