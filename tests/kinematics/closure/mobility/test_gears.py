"""Gears: joints that follow others on one axis, without a loop."""

from __future__ import annotations

import numpy as np

from kinematics import ScrewJoint, from_screws


def test_a_gear_on_the_axis_of_its_joint_may_have_no_size():
    """Two coaxial joints that follow each other, with centres of mass on the axis to rounding.

    They close no loop, so that their size beside the distance from the ground is no matter.
    """
    point = (0.6, 0.0, 0.5)
    joints = [
        ScrewJoint("j", "base", "link", axis=(0, 1, 0), point=point),
        ScrewJoint("spin", "base", "rotor", axis=(0, 1, 0), point=point, mimic=("j", -2.0)),
    ]
    bodies = {name: (1.0, (0.6 + 1.3e-14, 0.0, 0.5), np.eye(3)) for name in ("link", "rotor")}
    assert from_screws(joints, bodies=bodies).mobility == 1
