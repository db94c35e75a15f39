"""What a simulation says of attitude, of inputs at speed, and of masses on the ground."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.verification.crank_revolution import revolve_crank
from tests.support.json_answers import json_answer

SLIDER = """<robot name="slider"><link name="base">{ground}</link><link name="block"><inertial>
  <mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link><joint name="x" type="prismatic"><origin xyz="0 {beside} 0"/><parent link="base"/>
  <child link="block"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="9" velocity="9"/>
  </joint></robot>"""
MASS = """<inertial><mass value="7"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
BASE = ("--base", "free", "--base-mass", "3", "--base-inertia", "1", "--duration", "0.05")


def simulated(tmp_path, capsys, beside=0.0, ground=""):
    """Exit code and JSON of a block that slides past the centre of its base."""
    path = tmp_path / "slider.urdf"
    path.write_text(SLIDER.format(beside=beside, ground=ground), encoding="utf-8")
    return json_answer(capsys, "verify", str(path), *BASE, schema="floating_base")


@pytest.mark.table(1)
@pytest.mark.parametrize(("beside", "turns"), [(0.0, False), (0.1, True)])
def test_attitude_has_a_verdict(tmp_path, capsys, beside, turns):
    """A block that slides through the centre of the base moves it, and does not turn it."""
    code, found = simulated(tmp_path, capsys, beside)
    assert code == 1
    assert found["verdict"] == "the base moves" + ("" if turns else ", but does not turn")
    assert found["turning_residual"] > 1e-3 if turns else found["turning_residual"] < 1e-12


@pytest.mark.slow
def test_masses_on_the_ground_are_told(tmp_path, capsys):
    codes = [
        [one["code"] for one in simulated(tmp_path, capsys, ground=text)[1]["warnings"]]
        for text in ("", MASS)
    ]
    assert "ground_mass" not in codes[0] and "ground_mass" in codes[1]


@pytest.mark.slow
def test_inputs_at_speed_start_with_momentum():
    """The base rests at the start, so the momentum is that of the linkage alone."""
    linkage = kinematics.load("four_bar_kite")
    base = balance.motion.FloatingBase(10.0, 1.0)
    along, _ = revolve_crank(linkage, 6.0)
    found = balance.motion.simulate_floating_base(linkage, base, motions=along, duration=0.05)
    assert any("momentum of that motion" in remark for remark in found.remarks)
    assert not found.samples.twist[0].any()
    rest = balance.motion.simulate_floating_base(linkage, base, duration=0.05)
    assert not any("momentum of that motion" in remark for remark in rest.remarks)
    assert np.isfinite(rest.residual)
