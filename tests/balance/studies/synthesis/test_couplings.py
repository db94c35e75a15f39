"""Belts and slots of pantographs, against the joints and the motion of the written file."""

from __future__ import annotations

import cmath
import xml.etree.ElementTree as ET
from io import StringIO

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from balance.studies.synthesis.angle_error import chain_angles
from balance.studies.synthesis.balanced_pantograph import BalancedPantograph, pantograph_urdf
from balance.studies.synthesis.constrained_motion import constrained_motion
from balance.studies.synthesis.couplings import belt_coupling, slot_coupling, slot_file
from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.rr_chain import RRChain
from kinematics import load
from kinematics.model.document.element import Document
from tests.support.pantographs import random_triple


def varying_pantograph(seed):
    """A pantograph of a varying ratio through three positions, by integration of its motion."""
    places, masses, fixed, moving = random_triple(seed)
    positions = tuple(Position(*map(float, place)) for place in places)
    steps = displacements(positions)
    pivots = np.array([fixed]), np.array([moving])
    turns = np.cumsum(chain_angles(positions[0], steps, *pivots, masses).link_turns, axis=0)
    chain = RRChain(positions, fixed, moving, (0.0, *turns[:, 0].tolist()))
    return BalancedPantograph(chain, masses)


def arms_in_file(pantograph):
    """Fixed pivot and both arms of each pin, from the joints of the file at its pose."""
    linkage = load(Document("pantograph", pantograph_urdf(pantograph)))
    at = {joint.name: complex(*joint.point[:2]) for joint in linkage.joints}
    second = at["joint3"] - at["elbow"]
    # The tool is fixed to link 2, which has turned from position 1 to the pose of the file.
    tool = pantograph.chain.reach * cmath.exp(1j * pantograph.pose[1])
    return at["shoulder"], {
        "tool": (at["elbow"] - at["shoulder"], tool),
        "joint3": (at["elbow"] - at["shoulder"], second),
        "joint34": (at["joint4"] - at["shoulder"], second),
    }


@pytest.mark.parametrize("seed", range(5))
def test_the_pin_of_the_file_runs_in_the_slot(seed):
    """Places, curvature and pressure angle from the table of the motion, which is in time."""
    pantograph = varying_pantograph(seed)
    slot, motion = slot_coupling(pantograph), constrained_motion(pantograph)
    G, arms = arms_in_file(pantograph)
    a, b = arms[slot.pin]
    shoulder, elbow = motion.u.T
    first, second = a * np.exp(1j * shoulder), b * np.exp(1j * (shoulder + elbow))
    pin = G + first + second
    # The elbow turns against δ, with which the points of the slot are equally spaced.
    steps = (elbow - elbow.min()) / np.ptp(elbow) * (len(slot.points) - 1)
    if np.abs(pin[np.argmin(elbow)] - slot.points[0]) > np.ptp(np.abs(pin)) * 1e-6:
        steps = len(slot.points) - 1 - steps
    grid = np.arange(len(slot.points))
    curve = CubicSpline(grid, slot.points)
    assert np.abs(curve(steps) - pin).max() < 1e-7 * pantograph.chain.length
    # Curvature of a spline through places in time, away from its ends and from rest.
    slope, bend = (
        CubicSpline(grid, slot.points)(grid, 1),
        CubicSpline(grid, slot.points)(grid, 2),
    )
    curvature = np.imag(slope.conj() * bend) / np.abs(slope) ** 3
    assert np.allclose(slot.curvature[5:-5], curvature[5:-5], rtol=1e-3, atol=1e-3)
    # Virtual work: the normal of the slot, and the pin with the input held.
    speeds = motion.ud
    velocity = 1j * (speeds[:, 0] * (first + second) + speeds[:, 1] * second)
    held = second if slot.driven == "shoulder" else first + second
    moving = slice(20, None)
    normal = (1j * velocity / np.where(velocity == 0, 1, np.abs(velocity)))[moving]
    cosine = np.abs(np.real(normal.conj() * 1j * held[moving])) / np.abs(held[moving])
    angles = CubicSpline(grid, np.cos(slot.pressure_angle))(steps)[moving]
    assert np.allclose(angles, cosine, atol=1e-6)


def test_another_pin_or_input_has_no_smaller_pressure_angle():
    """All six slots by finite differences of the motion of the file."""
    for seed in range(5):
        pantograph = varying_pantograph(seed)
        slot, motion = slot_coupling(pantograph), constrained_motion(pantograph)
        _, arms = arms_in_file(pantograph)
        shoulder, elbow = motion.u.T
        largest = []
        for a, b in arms.values():
            first, second = a * np.exp(1j * shoulder), b * np.exp(1j * (shoulder + elbow))
            slope = np.gradient(first + second, elbow)
            for held in (second, first + second):
                cosine = np.abs(np.real(slope.conj() * held))
                angle = np.arccos(np.clip(cosine / np.abs(slope * held), 0.0, 1.0))
                largest.append(angle[5:-5].max())
        assert slot.largest_pressure_angle == pytest.approx(min(largest), abs=0.03)


def test_a_belt_has_the_ratio_of_rolling():
    """A belt rolls on both pulleys: their rims move alike, seen from the arm."""
    for ratio in (-0.5, -1.0, -2.5):
        radii = belt_coupling(ratio).radii
        arm, tool = 1.0, 1.0 / ratio
        assert radii * (0.0 - arm) == pytest.approx(tool - arm, rel=1e-14)


def test_files_of_the_slot_hold_its_points():
    ezdxf = pytest.importorskip("ezdxf")
    slot = slot_coupling(varying_pantograph(1))
    rows = np.loadtxt(StringIO(slot_file(slot, "csv").decode()), delimiter=",", skiprows=1)
    assert np.allclose(rows[:, 0] + 1j * rows[:, 1], slot.points, rtol=0, atol=1e-15)
    assert np.allclose(np.radians(rows[:, 3]), slot.pressure_angle)
    root = ET.fromstring(slot_file(slot, "svg"))
    (line,) = root
    drawn = [complex(*map(float, pair.split(","))) for pair in line.get("points").split()]
    assert np.allclose(np.conj(drawn), 1e3 * slot.points, rtol=1e-5)
    assert root.get("width").endswith("mm")
    drawing = ezdxf.read(StringIO(slot_file(slot, "dxf").decode()))
    assert (drawing.units, drawing.header["$MEASUREMENT"]) == (ezdxf.units.MM, 1)
    (line,) = drawing.modelspace().query("LWPOLYLINE")
    corners = [complex(*point) for point in line.get_points("xy")]
    assert np.allclose(corners, 1e3 * slot.points, atol=1e-4)
