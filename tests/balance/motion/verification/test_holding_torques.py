"""What inputs hold at rest, by Pinocchio: generalised gravity of chains, energies of loops."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.motion import holding_torques
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import UsageError

GRAVITY = (0.6, -9.1, 1.4)


def pinocchio_model(linkage):
    inertias = np.array([body.inertia for body in linkage.bodies])
    model = PinocchioModel(linkage, inertias).model
    model.gravity.linear = np.array(GRAVITY)
    return model


def test_chains_hold_the_generalised_gravity_of_pinocchio():
    linkage = kinematics.load("hprs")
    rng = np.random.default_rng(3)
    q = np.array(
        [joint_positions(linkage, u) for u in rng.uniform(-0.4, 0.4, (6, linkage.mobility))]
    )
    there = pinocchio_model(linkage)
    data = there.createData()
    expected = [pin.computeGeneralizedGravity(there, data, row).copy() for row in q]
    held = holding_torques(linkage, q, GRAVITY)
    assert held == pytest.approx(np.array(expected), abs=1e-11)
    assert np.abs(held).max() > 1.0


@pytest.mark.parametrize("model", ["four_bar_general", "five_bar", "slider_crank"])
def test_loops_hold_the_derivative_of_the_energy_of_pinocchio(model):
    linkage, h = kinematics.load(model), 1e-3
    there = pinocchio_model(linkage)
    data = there.createData()
    u = np.linspace(0.1, 0.25, linkage.mobility)
    (held,) = holding_torques(linkage, joint_positions(linkage, u)[None], GRAVITY)
    for k in range(linkage.mobility):
        ends = [
            pin.computePotentialEnergy(
                there, data, joint_positions(linkage, u + sign * h * np.eye(len(u))[k])
            )
            for sign in (2, 1, -1, -2)
        ]
        slope = (8 * (ends[1] - ends[2]) - (ends[0] - ends[3])) / (12 * h)
        assert held[k] == pytest.approx(slope, abs=1e-8 * max(map(abs, ends)))


def test_a_balanced_linkage_holds_nothing(tmp_path):
    path = str(tmp_path / "hangs.urdf")
    words = ["--require", "gravity", "--gravity=0.6,-9.1,1.4"]
    assert main(["design", "four_bar_general", *words, "--out", path]) == 0
    linkage = kinematics.load(path)
    q = np.array([joint_positions(linkage, [x]) for x in np.linspace(-0.3, 0.3, 5)])
    weight = sum(body.inertia[0] for body in linkage.bodies) * 9.3
    assert np.abs(holding_torques(linkage, q, GRAVITY)).max() < 1e-8 * weight
    bare = kinematics.load("four_bar_general")
    assert np.abs(holding_torques(bare, q, GRAVITY)).max() > 1e-2 * weight


def test_verify_shows_what_is_held(capsys):
    assert (
        main(["verify", "four_bar_general", "--trajectories", "1", "--gravity=0,-9.81,0"]) == 1
    )
    assert "held by u1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["--gravity", "0,0,0"], 2, "nothing is held"),
        (["--gravity", "0,-9.81,0", "--tolerance", "mass=2%"], 2, "not with --tolerance"),
        (["five_bar", "--gravity", "0,-9.81,0"], 2, "on a fixed base"),
    ],
)
def test_what_verify_refuses(words, code, told, capsys):
    assert main(["verify", "four_bar_general", *words]) == code
    assert told in capsys.readouterr().err.splitlines()[0]


def test_gravity_has_three_coordinates():
    linkage = kinematics.load("four_bar_general")
    with pytest.raises(UsageError, match="three coordinates"):
        holding_torques(linkage, np.zeros((1, 4)), (0, -9.81))
    assert balance.motion.holding_torques is holding_torques
