"""Modes of motion that meet at a pose, against points of bars closed by another Newton method.

What tells the modes of a linkage apart is known by hand: sides that stay parallel, pins that
stay on each other. Every closed pose that the independent route finds next to the flat one
satisfies the conditions of one mode, every mode has such poses, and its pose satisfies them
too.
"""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from kinematics.errors import CoordinateError, MeetingModesError, MobilityError
from tests.independent.bar_modes import bars_of, freedoms, poses_near
from tests.support.meeting_linkages import (
    FLAT,
    FlatLinkage,
    folded_sarrus,
    limit_pose,
    parallel_cells,
    slider_crank,
    spherical,
    three_upu,
    wunderlich,
)

# Points of a four-bar in the order of `bars_of`: A, B, D, C. Each condition vanishes on a mode.
PARALLEL = ("sides parallel", lambda z: z[1] - z[0] - z[3] + z[2])
ON_D = ("B on D", lambda z: z[1] - z[2])
ON_A = ("C on A", lambda z: z[3] - z[0])
NONE = ("general", None)
# Modes in the order of their numbers: condition and mobility; then those that another mode
# leads to.
KNOWN = {
    "parallelogram": ([(PARALLEL, 1), (NONE, 1)], []),
    "kite": ([(ON_D, 1), (NONE, 1)], []),
    "kite on its side": ([(ON_A, 1), (NONE, 1)], []),
    "rhombus": ([(ON_D, 1), (PARALLEL, 1)], [(ON_A, 1)]),
    "rhombus folded": ([(ON_A, 1), (ON_D, 1)], [(PARALLEL, 1)]),
    "two kites": ([(NONE, 1), (ON_D, 2)], []),
}


def modes_of(path):
    with pytest.raises(MeetingModesError) as caught:
        kinematics.load(path)
    return caught.value.modes


def points_of(linkage, mode):
    """Points of the bars at the pose on a mode, from the angles of the joints of the tree.

    The two ways to each pin that closes a loop agree.
    """
    places = linkage.places(mode.positions)
    assert all(abs(one - other) < 1e-9 for one, other in places.values())
    x, _ = bars_of(linkage.pins)
    points = np.zeros((len(x), 2))
    known = []
    for pin, one, other, at in linkage.pins:
        same = (k for k, each in enumerate(known) if each[0] == at and each[1] & {one, other})
        k = next(same, None)
        if k is None:
            k = len(known)
            known.append((at, {one, other}))
        known[k][1].update((one, other))
        points[k] = places[pin][0].real, places[pin][0].imag
    return points


def holds(condition, points):
    """Whether the points satisfy the condition of a mode, and no other mode's."""
    _, vanishing = condition
    return vanishing is not None and bool(np.abs(vanishing(points)).max() < 1e-7)


def condition_of(points, modes):
    """The mode whose condition the points satisfy; the general one if they satisfy none."""
    named = [known for known in modes if known[0][1] is not None and holds(known[0], points)]
    assert len(named) <= 1
    return named[0] if named else next(known for known in modes if known[0] is NONE)


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWN)
def test_the_modes_of_flat_linkages_are_those_known_by_hand(name, tmp_path):
    linkage, (here, further) = FLAT[name], KNOWN[name]
    modes = modes_of(linkage.write(tmp_path, "flat"))
    assert [mode.here for mode in modes] == [True] * len(here) + [False] * len(further)
    assert [mode.number for mode in modes] == list(range(1, len(modes) + 1))
    x, members = bars_of(linkage.pins)
    for mode, (condition, mobility) in zip(modes, [*here, *further], strict=True):
        points = points_of(linkage, mode)
        # The points themselves have the freedoms that the mode has, off the flat pose.
        assert freedoms(points, x, members) == mode.mobility == mobility
        assert np.abs(points[:, 1]).max() > 0.1
        assert condition_of(points, [*here, *further])[0] is condition
    seen = set()
    for count, poses in poses_near(x, members, 0.05, 60, 7).items():
        for points in poses:
            condition, mobility = condition_of(points, here)
            assert count == mobility
            seen.add(condition[0])
    assert seen == {condition[0] for condition, _ in here}


@pytest.mark.slow
@pytest.mark.parametrize("cells", [1, 2])
def test_each_cell_of_coupled_parallelograms_may_cross(cells, tmp_path):
    """Every combination of parallel and crossed cells is a mode, and the tracer finds each."""
    linkage = parallel_cells(cells)

    def crossed(places):
        cranks = [places[f"b{i}"] - places[f"a{i}"] for i in range(cells)]
        cranks.append(places[f"c{cells - 1}"] - places[f"a{cells}"])
        return tuple(bool(abs(p - q) > 1e-6) for p, q in zip(cranks, cranks[1:], strict=False))

    modes = modes_of(linkage.write(tmp_path, "cells"))
    found = [
        crossed({pin: one for pin, (one, _) in linkage.places(mode.positions).items()})
        for mode in modes
    ]
    assert len(set(found)) == len(modes) == 2**cells and all(mode.here for mode in modes)


def crossed_faces(corner):
    """Which of the six faces of a cube in the plane are no parallelograms, by its corners."""
    found = []
    for axis in range(3):
        for side in (0, 1):
            v = [
                corner[tuple(np.insert(sides, axis, side).tolist())]
                for sides in ((0, 0), (0, 1), (1, 0), (1, 1))
            ]
            found.append(bool(abs(v[0] - v[1] - v[2] + v[3]) > 1e-6))
    return tuple(found)


@pytest.mark.slow
def test_wunderlichs_linkage_changes_between_mobility_one_and_two(tmp_path):
    """On each mode other faces of the cube are parallelograms; the tracer finds each mode.

    Where all of them are, or opposite faces alike, bars of two directions are free. With a
    parallelogram opposite each crossed face, one freedom is left.
    """
    lengths = (9.0, 6.0, 4.0)
    linkage = wunderlich(*lengths)
    x, members = bars_of(linkage.pins)
    corners = {v: x.index(float(np.dot(lengths, v))) for v in np.ndindex(2, 2, 2)}
    modes = {}
    for mode in modes_of(linkage.write(tmp_path, "wunderlich")):
        points = points_of(linkage, mode)
        assert freedoms(points, x, members) == mode.mobility and mode.here
        faces = crossed_faces({v: complex(*points[k]) for v, k in corners.items()})
        assert faces not in modes
        modes[faces] = mode.mobility
    traced = {}
    for count, poses in poses_near(x, members, 0.3, 300, 1).items():
        for points in poses:
            faces = crossed_faces({v: complex(*points[k]) for v, k in corners.items()})
            assert traced.setdefault(faces, count) == count
    assert modes == traced and sorted(modes.values()) == [1] * 8 + [2] * 5
    for faces, mobility in modes.items():
        alike = [faces[2 * axis] == faces[2 * axis + 1] for axis in range(3)]
        assert all(alike) if mobility == 2 else not any(alike)


@pytest.mark.slow
def test_a_folded_sarrus_linkage_lifts_its_platform_or_swings_its_legs(tmp_path):
    """It lifts with mobility 1, or both legs swing about their axes on the ground."""
    path = folded_sarrus(tmp_path)
    lifting, swinging = modes_of(path)
    assert (lifting.mobility, swinging.mobility) == (1, 2)
    q = lifting.positions
    assert q["r3"] == pytest.approx(q["r1"], abs=1e-12)
    assert q["r2"] == pytest.approx(-2 * q["r1"], abs=1e-12)
    assert q["s2"] == pytest.approx(-2 * q["s1"], abs=1e-12)
    H = lifting.linkage.places["platform"].pose
    assert H[:3, :3] == pytest.approx(np.eye(3), abs=1e-12)
    # Both legs are isosceles triangles on the way along y.
    assert H[1, 3] == pytest.approx(2 * np.sin(q["r1"]), abs=1e-12)
    assert H[1, 3] == pytest.approx(-3 * np.sin(q["s1"]), abs=1e-12)
    assert H[[0, 2], 3] == pytest.approx(0, abs=1e-12)
    q = swinging.positions
    assert q["r3"] == pytest.approx(-q["r1"], abs=1e-12) and "r2" not in q and "s2" not in q
    positions = dict(zip(swinging.linkage.inputs, (0.3, -0.4), strict=True))
    both = kinematics.load(path, mode=2, at=positions)
    assert both.places["platform"].pose == pytest.approx(np.eye(4), abs=1e-12)


@pytest.mark.slow
def test_modes_that_are_tangent_to_one_another_are_both_listed(tmp_path):
    """The slider stays, or is at -2 sin a; a is of second order in the angle o that drives."""
    staying, sliding = modes_of(limit_pose(tmp_path))
    for mode in (staying, sliding):
        q = mode.positions
        rocker = 2 * np.exp(1j * (q["a"] + np.pi / 2))
        pin = -3 + 2j + np.exp(1j * q["o"])
        assert abs(rocker - pin) == pytest.approx(2, abs=1e-12)
    assert "s" not in staying.positions and "b" not in staying.positions
    q = sliding.positions
    assert q["s"] == pytest.approx(-2 * np.sin(q["a"]), abs=1e-12)
    assert q["b"] == pytest.approx(-2 * q["a"], abs=1e-12)


@pytest.mark.slow
def test_two_branches_on_one_closed_curve_are_one_motion(tmp_path):
    """A four-bar with 2 + 5 = 4 + 3 passes its flat pose twice; the way between is found."""
    path = FLAT["change point"].write(tmp_path, "flat")
    linkage = kinematics.load(path)
    (text,) = [x.message for x in linkage.notices if x.code == "left_singular_pose"]
    assert "2 degrees of freedom there at first order, 1 elsewhere; a single motion" in text
    # Both tangents of the four-bar at its flat pose have the rates of one motion: the rocker,
    # at the crank angle t, is at y(t) from a quadratic equation with one smooth solution each.
    x, members = bars_of(FLAT["change point"].pins)
    slopes = {
        round(float(np.sign(z[1, 1] * z[3, 1]))) for z in poses_near(x, members, 0.02, 40, 3)[1]
    }
    assert slopes == {1, -1}
    assert kinematics.load(path, mode=1).mobility == 1
    with pytest.raises(MobilityError, match="one mode of motion leaves its pose; leave out"):
        kinematics.load(path, mode=2)


@pytest.mark.slow
def test_both_halves_of_a_cone_are_one_mode(tmp_path):
    """The flat five-bar: closed poses are a cone over two circles, opposite one another."""
    linkage = kinematics.load(FLAT["five-bar"].write(tmp_path, "flat"))
    assert linkage.mobility == 2 and linkage.displaced is not None


# General dimensions of six-bars with all pins on one line, that can leave it.
WATT = dict(a=2.0, b=2.4, d=3.5, c=0.7, e=1.5, h=1.4, f=4.4)
STEPHENSON = dict(a=2.8, b=4.6, d=4.3, c=1.0, e=0.8, h=3.1, f=4.8)


@pytest.mark.slow
@pytest.mark.parametrize("places, carrier", [(WATT, "l3"), (STEPHENSON, "l2")])
def test_six_bars_folded_flat(places, carrier, tmp_path):
    """Every pose next to the flat one is on a branch through it; modes are whole curves."""
    chain = (
        ("a", "g", "l1"),
        ("b", "l1", "l2"),
        ("d", "g", "l3"),
        ("c", "l2", "l3"),
        ("e", carrier, "l4"),
        ("h", "g", "l5"),
        ("f", "l4", "l5"),
    )
    linkage = FlatLinkage(tuple((*each, places[each[0]]) for each in chain))
    modes = modes_of(linkage.write(tmp_path, "six_bar"))
    x, members = bars_of(linkage.pins)
    for mode in modes:
        assert freedoms(points_of(linkage, mode), x, members) == mode.mobility == 1
    assert 1 < len(modes) <= 4
    assert set(poses_near(x, members, 0.02, 40, 5)) == {1}


def test_a_slider_crank_of_equal_bars_turns_or_slides(tmp_path):
    """Folded on each other, crank and coupler turn as one; or the slider goes 2 l cos φ."""
    turning, sliding = modes_of(slider_crank(tmp_path))
    assert set(turning.positions) == {"a"} and set(sliding.positions) == {"a", "b", "s"}
    q = sliding.positions
    assert q["b"] == pytest.approx(-2 * q["a"], abs=1e-12)
    assert q["s"] == pytest.approx(-2 * np.sin(q["a"]), abs=1e-12)


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "name, angles, here, further",
    [
        ("parallelogram", (0, 0.4, 1.2, 0.8), 2, 0),
        ("kite", (0, 0.7, 1.6, 0.7), 2, 0),
        ("rhombus", (0, 0.7, 1.4, 0.7), 2, 1),
    ],
)
def test_spherical_four_bars_have_the_modes_of_planar_ones(
    name, angles, here, further, tmp_path
):
    modes = modes_of(spherical(tmp_path, angles, name))
    assert [mode.here for mode in modes] == [True] * here + [False] * further
    axes = [np.array([np.cos(x), np.sin(x), 0]) for x in angles]
    for mode in modes:
        q = {joint: mode.positions.get(joint, 0.0) for joint in "abd"}
        crank, coupler, rocker = (
            Rotation.from_rotvec(q[j] * axes["abcd".index(j)]) for j in "abd"
        )
        assert (crank * coupler).apply(axes[2]) == pytest.approx(
            rocker.apply(axes[2]), abs=1e-9
        )
        off = np.array([crank.apply(axes[1]), rocker.apply(axes[2])])
        assert np.abs(off[:, 2]).max() > 0.1


@pytest.mark.slow
def test_the_three_upu_translates_or_turns_too(tmp_path):
    """A leg holds its outer axis n, n on the platform and its own direction in one plane.

    Without rotation of the platform that is so at every place: one mode of mobility 3. Above
    the base, all legs are parallel, and two rotations are free at first order: the other mode
    has rotations, and three freedoms by the null space of the three conditions at its pose.
    """
    modes = modes_of(three_upu(tmp_path))
    assert [mode.mobility for mode in modes] == [3, 3]
    turned = []
    for mode in modes:
        H = mode.linkage.places["platform"].pose
        errors, rates = conditions_of_legs(H, mode.linkage)
        assert np.abs(errors).max() < 1e-9 and np.linalg.matrix_rank(rates, tol=1e-5) == 3
        turned.append(float(np.abs(H[:3, :3] - np.eye(3)).max()))
    assert min(turned) < 1e-9 < 1e-2 < max(turned)


def conditions_of_legs(H, linkage):
    """``n · (d × R n)`` of each leg of the 3-UPU, and differences by six motions."""

    def errors(R, t):
        found = []
        for k in range(3):
            angle = 2 * np.pi * k / 3
            foot = np.array([np.cos(angle), np.sin(angle), 0])
            n = np.array([-np.sin(angle), np.cos(angle), 0])
            head = R @ (foot - [1, 0, 0]) + t  # the frame of the platform is at its first head
            found.append(n @ np.cross(head - foot, R @ n))
        return np.array(found)

    R, t, rates = H[:3, :3], H[:3, 3], []
    for axis in np.eye(3):
        ends = [
            errors(Rotation.from_rotvec(s * axis).as_matrix() @ R, t) for s in (1e-6, -1e-6)
        ]
        rates.append((ends[0] - ends[1]) / 2e-6)
        rates.append((errors(R, t + 1e-6 * axis) - errors(R, t - 1e-6 * axis)) / 2e-6)
    return errors(R, t), np.array(rates).T


@pytest.mark.slow
def test_modes_have_one_order_in_every_frame_and_scale(tmp_path):
    """Numbers, and angles at the poses, stay; lengths grow by the scale."""
    text = FLAT["rhombus"].write(tmp_path, "flat").read_text()
    first = modes_of(tmp_path / "flat.urdf")
    moved = text.replace("</robot>", "").replace('<link name="g"/>', '<link name="world"/>')
    moved += (
        '<link name="g"/><joint name="placed" type="fixed"><parent link="world"/>'
        '<child link="g"/><origin xyz="3 -2 0.5" rpy="0.3 -0.7 1.1"/></joint></robot>'
    )
    (tmp_path / "moved.urdf").write_text(moved)
    again = modes_of(tmp_path / "moved.urdf")
    large = FlatLinkage(tuple((*pin[:3], 37.5 * pin[3]) for pin in FLAT["rhombus"].pins))
    for others in (again, modes_of(large.write(tmp_path, "large"))):
        for mode, other in zip(first, others, strict=True):
            assert mode[:3] == other[:3]
            assert mode.positions == pytest.approx(other.positions, abs=1e-7)


@pytest.mark.slow
def test_a_mode_is_followed_from_its_pose(tmp_path):
    path = FLAT["kite"].write(tmp_path, "flat")
    folded = kinematics.load(path, mode=1)
    # The rocker, on the base, drives it.
    assert folded.inputs == ("d",) and folded.idle == ("a", "c")
    (driven,) = [k for k, joint in enumerate(folded.joints) if joint.name == "d"]
    assert folded.at == {"d": pytest.approx(folded.displaced[driven])}
    (text,) = [x.message for x in folded.notices if x.code == "mode_of_motion"]
    assert "mode 1 of 2" in text
    further = kinematics.load(path, mode=1, at={"d": 1.25})
    assert further.displaced[driven] == pytest.approx(1.25, abs=1e-12)
    with pytest.raises(MobilityError, match="2 modes of motion leave .* from 1 to 2"):
        kinematics.load(path, mode=3)
    with pytest.raises(CoordinateError, match="input a: .* positions of inputs set the pose"):
        kinematics.load(path, mode=1, at={"a": 0.3})
    with pytest.raises(CoordinateError, match="stands still"):
        kinematics.load(path, inputs=["a"], mode=1)


def test_an_input_of_the_file_that_rests_on_a_mode_is_replaced(tmp_path):
    path = FLAT["kite"].write(tmp_path, "flat")
    marked = path.read_text().replace('name="a" type', 'name="a" independent="true" type')
    path.write_text(marked)
    assert kinematics.load(path, mode=2).inputs == ("a",)
    folded = kinematics.load(path, mode=1)
    assert folded.inputs == ("d",)  # the rocker, on the base
    (text,) = [x.message for x in folded.notices if x.code == "inputs_of_mode"]
    assert text == "a of the file cannot drive this mode: the inputs are d"


@pytest.mark.slow
def test_the_modes_of_a_pose_that_is_asked_for(tmp_path):
    """A parallelogram that is moved to its flat pose: numbers are those of the modes there."""
    path = FLAT["parallelogram"].write(tmp_path, "flat")
    crossed = kinematics.load(path, mode=2)
    (tmp_path / "crossed.urdf").write_text(crossed.to_urdf())
    path = tmp_path / "crossed.urdf"
    flat = {"a": -crossed.at["a"]}
    with pytest.raises(MeetingModesError, match="2 modes of motion meet there"):
        kinematics.load(path, at=flat)
    parallel = kinematics.load(path, at=flat, mode=1)
    q = dict(zip([joint.name for joint in parallel.joints], parallel.displaced, strict=True))
    turns = {name: q[name] + crossed.displaced[k] for k, name in enumerate("abd")}
    assert turns["a"] == pytest.approx(turns["d"], abs=1e-9) and abs(turns["a"]) > 0.1
    assert turns["b"] == pytest.approx(-turns["a"], abs=1e-9)
    with pytest.raises(MobilityError, match="2 modes of motion leave its pose; .* from 1 to 2"):
        kinematics.load(path, at=flat, mode=3)
    with pytest.raises(MobilityError, match="one mode of motion leaves its pose"):
        kinematics.load(path, at={"a": -0.1}, mode=2)


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2])
def test_a_mode_is_followed_straight_through_the_meeting(number, tmp_path):
    """On the parallelogram the sides stay parallel on both sides of the flat pose."""
    path = FLAT["parallelogram"].write(tmp_path, "flat")
    for a in (-2.0, -0.3, 0.3):
        linkage = kinematics.load(path, mode=number, at={"a": a})
        q = dict(zip([joint.name for joint in linkage.joints], linkage.displaced, strict=True))
        assert q["a"] == pytest.approx(a, abs=1e-12)
        assert (abs(q["d"] - a) < 1e-9) == (number == 1)


def test_a_list_that_may_be_incomplete_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("kinematics.closure.mobility.reachable_modes.MAX_MODES", 2)
    with pytest.raises(MeetingModesError) as caught:
        kinematics.load(FLAT["rhombus"].write(tmp_path, "flat"))
    assert caught.value.doubt == "no more than 2 are listed" and len(caught.value.modes) == 2
    assert "there may be more: no more than 2 are listed; " in str(caught.value)
    monkeypatch.setattr("kinematics.closure.mobility.reachable_modes.MAX_STEPS", 3)
    with pytest.raises(MeetingModesError) as caught:
        kinematics.load(FLAT["parallelogram"].write(tmp_path, "flat"))
    assert caught.value.doubt == "a mode was not followed to its end"


@pytest.mark.slow
def test_a_regular_linkage_loads_no_module_of_modes():
    text = (
        "import sys, kinematics\n"
        "kinematics.load('four_bar_kite')\n"
        "words = ('motion_modes', 'tangent_cone', 'singular_pose', 'follow_mode')\n"
        "assert not [name for name in sys.modules if name.rpartition('.')[2] in words]"
    )
    subprocess.run([sys.executable, "-c", text], check=True)


def test_the_file_of_a_regular_pose_has_one_mode(tmp_path):
    assert kinematics.load("four_bar_kite", mode=1).displaced is None
    with pytest.raises(MobilityError, match="one mode of motion leaves its pose"):
        kinematics.load("four_bar_kite", mode=2)
