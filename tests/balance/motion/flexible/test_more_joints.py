"""Links that bend with one or three joints, tip masses in modes, and the table of a motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import balance
import kinematics
from balance.app.cli.main import main
from balance.motion.flexible.flex_data import beam_deflection
from kinematics.errors import LinkageError
from tests.support.json_answers import json_answer

SPEED, BOB = 5.0, 0.6
HANGING = f"""
  <link name="bob"><inertial><mass value="{BOB}"/>
    <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="u2" type="continuous" independent="true"><origin xyz="PLACE"/>
    <parent link="coupler"/><child link="bob"/><axis xyz="0 0 1"/></joint>
</robot>"""
ARM = """<robot name="arm"><link name="base"/><link name="arm"><inertial>
  <origin xyz="0.4 0 0"/><mass value="1"/>
  <inertia ixx="0" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="u1" type="continuous"><parent link="base"/><child link="arm"/>
  <axis xyz="0 0 1"/></joint></robot>"""


def parallelogram_with_bob(folder, place):
    """The parallelogram with a mass on a joint of its coupler, 1 m long."""
    text = Path(kinematics.load("four_bar_parallelogram").source).read_text("utf-8")
    path = folder / "bob.urdf"
    path.write_text(text.replace("</robot>", HANGING.replace("PLACE", place)), encoding="utf-8")
    return kinematics.load(path)


def test_a_link_with_three_joints_carries_a_load_in_its_middle(tmp_path):
    """5 ρA a L⁴ / (384 EI) + m a L³ / (48 EI), a along the normal of the coupler."""
    linkage = parallelogram_with_bob(tmp_path, "0.5 0 0")
    found = balance.flexible.simulate_flexible(
        linkage,
        ["coupler=EI:300,rhoA:0.4"],
        {"u1": f"speed:{SPEED}"},
        1e-3,
        samples=2,
        modes=12,
    )
    across = 0.5 * SPEED**2 * 0.8
    static = across * (5.0 * 0.4 / 384.0 + BOB / 48.0) / 300.0
    bends = beam_deflection(found.motion, found.flexible, "coupler")[0]
    assert bends == pytest.approx(static, rel=5e-3)


def test_joints_that_are_not_on_a_line_are_refused(tmp_path):
    linkage = parallelogram_with_bob(tmp_path, "0.5 0.1 0")
    with pytest.raises(LinkageError, match="its joints are not on a line"):
        balance.flexible.simulate_flexible(linkage, ["coupler=EI:300,rhoA:0.4"])


@pytest.mark.slow
def test_a_link_with_one_joint_is_a_cantilever(tmp_path):
    """It spins up slowly: a load ρA α x of a cantilever, 11 ρA α L⁵ / (120 EI) at its tip."""
    path = tmp_path / "arm.urdf"
    path.write_text(ARM, encoding="utf-8")
    linkage = kinematics.load(path)
    with pytest.raises(LinkageError, match="has 1 joint: give length"):
        balance.flexible.simulate_flexible(linkage, ["arm=EI:200,rhoA:1"])
    found = balance.flexible.simulate_flexible(
        linkage, ["arm=EI:2000,rhoA:1,length:0.8"], {"u1": "spin:0.1,1"}, 1.0, samples=101
    )
    turning = 0.1 * (1.0 - np.cos(2.0 * np.pi * found.time))
    static = 11.0 * turning * 0.8**5 / (120.0 * 2000.0)
    bends = beam_deflection(found.motion, found.flexible, "arm")
    assert np.abs(bends - static).max() < 0.02 * static.max()
    assert "arm" in found.flexible.tangents


def test_a_mass_at_the_tip_of_a_cantilever(capsys):
    """1 + cos λ cosh λ + μ λ (cos λ sinh λ - sin λ cosh λ) = 0, μ the part of the tip."""
    words = ("modes", "--beam", "length:2,EI:8,rhoA:0.5", "--clamp", "0", "--count", "3")
    _, found = json_answer(capsys, "flex", *words, "--tip", "0.7")

    def equation(x):
        return (
            1.0
            + np.cos(x) * np.cosh(x)
            + 0.7 * x * (np.cos(x) * np.sinh(x) - np.sin(x) * np.cosh(x))
        )

    grid = np.linspace(0.1, 10.0, 400)
    signs = np.flatnonzero(np.diff(np.sign(equation(grid))))[:3]
    roots = np.array([brentq(equation, grid[k], grid[k + 1]) for k in signs])
    hertz = roots**2 * np.sqrt(8.0 / 0.5) / 2.0**2 / (2.0 * np.pi)
    assert np.allclose(found["frequencies"], hertz, rtol=1e-5)
    for word in ("0", "-1", "1,2,3,4", "x"):
        assert main(["flex", *words, f"--tip={word}"]) == 2


def test_the_table_of_a_simulation(tmp_path, capsys):
    path = tmp_path / "motion.csv"
    words = (
        "four_bar_kite",
        "--flex",
        "coupler=EI:50,rhoA:1",
        "--duration",
        "0.02",
        "--samples",
        "5",
        "--table",
        str(path),
    )
    _, found = json_answer(capsys, "flex", "simulate", *words)
    names, *rows = path.read_text("utf-8").splitlines()
    assert names == "time,force_x,force_y,moment,energy,bending coupler"
    table = np.array([list(map(float, row.split(","))) for row in rows])
    assert np.array_equal(table[:, 0], found["times"])
    assert np.array_equal(table[:, 1:3], found["force"])
    assert np.array_equal(table[:, 3], found["moment"])
    assert table[:, 5].max() == found["beams"][0]["peak_deflection"]
