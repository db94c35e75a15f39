"""The least largest moment of inertia of filled matter: its axes, its gap, and rounding."""

from __future__ import annotations

import numpy as np
import pytest

from balance import counterweights, design_space
from tests.support.gallery_run import changed_commands, changed_lines, run_commands
from tests.support.shapes import matrix

COMMANDS = tuple(
    f"counterweights {model} --balance force --links all --minimise inertia"
    for model in ("bennett", "four_bar_general", "four_bar_kite", "slider_crank")
)


def largest_moments(answer):
    """Moments of inertia (bodies, 3) about the origins of the links, ascending."""
    moments = []
    for z, frame in zip(answer.z, answer.space.frames, strict=True):
        shift = np.eye(4)
        shift[:3, 3] = -frame[:3, 3]
        S = (shift @ matrix(z) @ shift.T)[:3, :3]
        moments.append(np.linalg.eigvalsh(np.trace(S) * np.eye(3) - S))
    return np.array(moments)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "shared"), [("bennett", 1), ("four_bar_general", 3), ("four_bar_kite", 4)]
)
def test_the_largest_moments_are_equal_and_the_least(model, shared):
    """The bound is proved by sums over many rays; about some axes moments are equal."""
    answer = counterweights(design_space(model, balance="force"), "all", minimise="inertia")
    moments = largest_moments(answer)
    assert moments.max() == pytest.approx(answer.value, rel=1e-9)
    assert answer.gap is not None and answer.gap <= 1e-5
    assert np.sum(moments >= moments.max() * (1.0 - 1e-9)) == shared


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_printed_digit_depends_on_rounding(seed):
    changed = changed_commands(run_commands(COMMANDS), run_commands(COMMANDS, seed))
    assert not changed, changed_lines(changed)
