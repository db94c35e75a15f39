"""Inputs are joints for which the file has a transmission, where they are well conditioned."""

import pytest

import kinematics
from tests.support.urdf_text import UNIT_INERTIA, along, joint, link, saved

AXIS = [0, 0, 1]
PARTS = (
    link("base"),
    *(link(name, **UNIT_INERTIA) for name in ("a", "b", "c")),
    joint("j1", "revolute", "base", "a", axis=AXIS),
    joint("ball", "spherical", "a", "b", along([1, 0, 0])),
    joint("j2", "revolute", "base", "c", along([2, 0, 0]), AXIS),
)
TWO = (
    '<loop name="k" type="spherical"><predecessor link="b"><origin xyz="1 1 0.5"/>'
    '</predecessor><successor link="c"><origin xyz="0 1 0.5"/></successor></loop>'
)
DRIVE = '<transmission name="t{0}"><type>t</type><joint name="{0}"/></transmission>'


@pytest.mark.parametrize(("driven", "first"), [("", "j1"), ("j1", "j1"), ("j2", "j2")])
def test_an_actuated_joint_is_the_first_input(tmp_path, driven, first):
    """Of a rod between two balls that turns about itself and follows two cranks."""
    more = (DRIVE.format(driven),) if driven else ()
    linkage = kinematics.load(saved(tmp_path, *PARTS, TWO, *more, DRIVE.format("nowhere")))
    assert linkage.mobility == 2 and first in linkage.inputs


def test_a_marked_input_wins(tmp_path):
    parts = [part.replace('name="j1"', 'name="j1" independent="true"') for part in PARTS]
    linkage = kinematics.load(saved(tmp_path, *parts, TWO, DRIVE.format("j2")))
    assert linkage.inputs[0] == "j1"
