"""Studies of machines: their figures by a second route, and those in print.

Files are in docs/machines/, beside the pages that show them; docs/reproduction.md lists what is
in print.
"""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

import balance
import kinematics
from tests.support.pictures import curves_agree
from tests.support.source_files import ROOT

DOCS = ROOT / "docs"
MACHINES = DOCS / "machines"
PICTURES = sorted(path.stem for path in MACHINES.glob("*.svg"))

# --- the engine ----------------------------------------------------------------------------

# Khurmi and Gupta, example 22.1; the length of the rod is ours.
CRANK, ROD, SPEED = 0.15, 0.606, 240.0 * 2.0 * np.pi / 60.0
REVOLVING, PISTON, RADIUS = 37.0, 50.0, 0.4
START = np.arctan2(0.12, 0.09)


def engine_force(angle, weight, rod=ROD):
    """Force of the frame on the engine (N, 2), closed form, angles from the dead centre."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(rod**2 - CRANK**2 * s**2)
    slope = -(CRANK**2 * np.cos(2.0 * angle)) / root - (CRANK**2 * s * c) ** 2 / root**3
    piston = PISTON * SPEED**2 * (CRANK * c - slope)
    turning = (REVOLVING * CRANK - weight * RADIUS) * SPEED**2
    return -np.column_stack([piston + turning * c, turning * s])


def engine(weight, rod, folder):
    """The engine of the file with another weight and rod."""
    text = (MACHINES / "engine_book.urdf").read_text(encoding="utf-8")
    across = np.sqrt(rod**2 - 0.12**2)
    for old, new in (
        ('"26.375"', f'"{weight!r}"'),
        ('"0.594 -0.12 0"', f'"{across:.12f} -0.12 0"'),
        ('"0.684 0 0"', f'"{across + 0.09:.12f} 0 0"'),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "engine.urdf"
    path.write_text(text, encoding="utf-8")
    return kinematics.load(path)


@pytest.mark.parametrize(
    ("weight", "peak", "rms"),
    [
        (0.0, 9420.0, 6390.0),
        (13.875, 5910.0, 3450.0),
        (23.25, 3540.0, 2514.0),
        (24.93, 3119.0, 2550.0),
        (26.375, 3419.0, 2635.0),
    ],
)
def test_the_engine_shakes_as_its_closed_form_says(weight, peak, rms, tmp_path):
    """The rows of the page, and the shaking force at every sample by Pinocchio."""
    run = balance.verify(engine(weight, ROD, tmp_path), speed="240rpm").runs[0]
    by_hand = engine_force(START + run.trajectory.u[:, 0], weight)
    assert run.shaking[:, 3:5] == pytest.approx(by_hand, abs=1e-6 * 9420.0)
    assert run.peak("force") == pytest.approx(peak, rel=2e-3)
    assert run.rms("force") == pytest.approx(rms, rel=2e-3)


def test_the_engine_has_the_figures_of_the_book(tmp_path):
    """Balance mass 26.38 kg, residual force 2849 N at 60° for a rod without end.

    The book rounds the speed to 25.14 rad/s, which is 0.06 % of the force.
    """
    weight = (REVOLVING + PISTON * 2.0 / 3.0) * CRANK / RADIUS
    assert weight == pytest.approx(26.38, abs=0.006)
    for rod, residual in ((60.0, 2849.0), (ROD, 2743.0)):
        run = balance.verify(engine(weight, rod, tmp_path), speed="240rpm").runs[0]
        angles = np.rad2deg(START + run.trajectory.u[:, 0])
        assert np.interp(60.0, angles, run.sizes("force")) == pytest.approx(residual, rel=2e-3)


def test_the_best_weights_of_the_engine():
    """Half of the piston has the least root mean square, 0.589 of it the least peak."""
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    weights = np.linspace(20.0, 30.0, 2001)
    sizes = [np.linalg.norm(engine_force(angle, weight), axis=1) for weight in weights]
    rms = [np.sqrt(np.mean(size**2)) for size in sizes]
    assert weights[np.argmin(rms)] == pytest.approx(23.25, abs=0.006)
    assert weights[np.argmin(np.max(sizes, axis=1))] == pytest.approx(24.93, abs=0.02)
    linkage = kinematics.load(MACHINES / "engine.urdf")
    answer = balance.partial(
        balance.design_space(linkage, None, "force"),
        ["crank"],
        30.0,
        regions={"crank": "ball(-0.24,-0.32,0,0.01)"},
        motions=balance.motion.one_turn(linkage, SPEED),
    )
    assert answer.verdict == "optimal"
    moment = np.linalg.norm(answer.z[0, 1:3])  # half of the piston is balanced, half is left
    assert moment == pytest.approx(PISTON * CRANK / 2.0, rel=1e-3)


# --- the pictures --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_pictures_of_machines_are_current(name, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(str(DOCS))
    drawer = import_module("draw_studies")
    assert set(drawer.MACHINES) == set(PICTURES)
    drawn = drawer.picture(drawer.MACHINES[name]).decode()
    assert curves_agree(drawn, (MACHINES / f"{name}.svg").read_text(encoding="utf-8"))
