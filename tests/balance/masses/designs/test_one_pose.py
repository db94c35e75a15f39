"""Balance at one pose alone: no momentum there, and momentum elsewhere."""

from __future__ import annotations

import json
import shlex

import numpy as np
import pytest

import kinematics
from balance import design, design_space
from balance.app.cli.main import main
from balance.momentum import momentum_regressor

CASES = ["four_bar_general", "five_bar", "three_rsr"]


@pytest.mark.parametrize("minimise", [None, "mass", "change"])
@pytest.mark.parametrize("model", CASES)
def test_no_momentum_at_the_pose_and_some_elsewhere(model, minimise):
    linkage = kinematics.load(model)
    at = dict.fromkeys(linkage.inputs, 0.1)
    linkage = kinematics.load(model, at=at)
    space = design_space(linkage, max_order=0)
    found = design(space, minimise, one_pose=True)
    assert found.verdict == "feasible" and found.words.endswith("at the reference pose alone")
    z, size = found.z.reshape(-1), np.abs(found.z).sum()
    here = momentum_regressor(linkage, np.zeros(linkage.mobility), spatial=True) @ z
    there = momentum_regressor(linkage, np.full(linkage.mobility, 0.1), spatial=True) @ z
    assert np.abs(here).max() < 1e-11 * size < 1e-4 * size < np.abs(there).max()


def test_conditions_of_more_than_one_pose_are_refused():
    with pytest.raises(ValueError, match="max_order=0"):
        design(design_space("four_bar_kite"), one_pose=True)


def test_the_command_gives_no_notice_of_further_conditions(tmp_path, capsys, caplog):
    """For one pose, order 0 is all there is; what it writes is checked there."""
    out, at = tmp_path / "out.urdf", ["--at", "u1=0.1,u3=-0.05"]
    assert main(["design", "fuga_i", *at, "--max-order", "0", "--out", str(out)]) == 0
    (remark,) = caplog.messages
    command = shlex.split(remark.partition(": balance ")[2])
    assert command[0] == "report"
    capsys.readouterr()
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["as_given"]["balanced"] is True
    assert main(["report", "fuga_i", *at, "--max-order", "0", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["as_given"]["balanced"] is False
    caplog.clear()
    assert main(["design", "four_bar_general", "--max-order", "1"]) == 4
    assert "not_settled" in caplog.text
