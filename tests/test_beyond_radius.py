"""Poses that are far beyond the radius of convergence, but within reach."""

import json

import numpy as np
import pytest
from urdf_text import UNIT_INERTIA, along, joint, link, loop, saved

from balance.cli import main


def nearly_dead(folder, angle=0.03):
    """A slider-crank driven by its slider, its arms almost in line; and its stroke."""
    elbow = np.array([np.cos(angle), np.sin(angle), 0.0])
    stroke = elbow[0] + np.sqrt(2.25 - elbow[1] ** 2)
    limits = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
    ends = along([stroke, 0, 0] - elbow), np.eye(4)
    parts = [link("base"), *(link(name, **UNIT_INERTIA) for name in ("crank", "rod", "block"))]
    parts += [
        joint("a", "continuous", "base", "crank", axis=[0, 0, 1]),
        joint("b", "continuous", "crank", "rod", along(elbow), [0, 0, 1]),
        joint("s", "prismatic", "base", "block", along([stroke, 0, 0]), [1, 0, 0], limits),
        loop("k", "revolute", ("rod", "block"), ends, [0, 0, 1]),
    ]
    return saved(folder, *parts), stroke


def test_a_pose_far_beyond_the_radius_is_the_same_at_every_order(tmp_path, capsys):
    """By the law of cosines; predictions beyond the radius grow with the order."""
    path, stroke = nearly_dead(tmp_path)
    x = stroke - 0.4
    angle = np.arccos((1 + x * x - 2.25) / (2 * x))
    for order in ("2", "6", "12"):
        words = ["--inputs", "s", "--to", "s=-0.4", "--order", order]
        assert main(["motion", str(path), *words, "--json"]) == 0
        report = json.loads(capsys.readouterr().out)
        (pose,), names = report["poses"], [each["name"] for each in report["joints"]]
        corrected = dict(zip(names, pose["corrected"], strict=True))
        assert corrected["a"] == pytest.approx(angle - 0.03, abs=1e-10)
        assert report["radius"] < 0.01
    assert max(np.abs(pose["predicted"])) > 1e9
