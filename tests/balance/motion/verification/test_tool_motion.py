"""Paths of a tool: against closed inverse kinematics, and against tables of the inputs."""

import json

import numpy as np
import pytest

import balance
from kinematics.errors import BodyError, CoordinateError, FileError, PoseError
from tests.support.command_runs import asked

LINK, POINT = "left_upper", (0.7, 0.5, 0.0)
# The arms of the model: elbow in the frame of the lower link, end in that of the upper one.
LEFT = (0.0 + 0.0j, -0.2 + 0.6j, 0.7 + 0.5j)
RIGHT = (0.9 + 0.1j, 0.3 + 0.4j, -0.7 + 0.6j)
TIME = np.linspace(0.0, 1.0, 61)


def quintic(time):
    return 10 * time**3 - 15 * time**4 + 6 * time**5


def shift(time):
    """Displacement of the end of both arms, a complex number, metres."""
    return (0.09 - 0.05j) * quintic(time)


def arm_angle(base, elbow, end, at):
    """The turn of the first link of an arm that reaches a point, by the law of cosines.

    The elbow stays on the side on which it is in the model.
    """
    start, reach = base + elbow + end, at - base
    a, b, c = abs(elbow), abs(end), abs(reach)
    side = np.sign(np.imag(np.conj(start - base) * elbow))
    inner = np.arccos((a * a + c * c - b * b) / (2 * a * c))
    return np.angle(reach * np.exp(1j * side * inner) / elbow)


def inputs_at(time):
    """Both inputs (N, 2) by the law of cosines."""
    tip = LEFT[0] + LEFT[1] + LEFT[2] + shift(time)
    return np.stack([arm_angle(*LEFT, tip), arm_angle(*RIGHT, tip)], axis=1)


def write_path(path, digits=12, head="time,x,y", scale=1.0, time=TIME, noise=0.0):
    at = shift(time) * scale + noise
    rows = [
        f"{t:.9g},{x.real:.{digits}f},{x.imag:.{digits}f}"
        for t, x in zip(time, at, strict=True)
    ]
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    return path


def test_inputs_of_a_five_bar_are_those_of_the_law_of_cosines(tmp_path):
    """Displacements, and rates against differences of the closed form."""
    moved = balance.motion.from_tool_csv(
        "five_bar", write_path(tmp_path / "path.csv"), LINK, POINT
    )
    np.testing.assert_allclose(moved.u, inputs_at(TIME), atol=1e-9)
    step = 1e-4
    after, now, before = (inputs_at(TIME + k * step) for k in (1, 0, -1))
    np.testing.assert_allclose(moved.ud, (after - before) / (2 * step), atol=1e-5)
    bend = (after - 2 * now + before) / step**2
    np.testing.assert_allclose(moved.udd, bend, atol=2e-3 * np.abs(bend).max())
    millimetres = write_path(tmp_path / "mm.csv", head="time,x [mm],y [mm]", scale=1e3)
    same = balance.motion.from_tool_csv("five_bar", millimetres, LINK, POINT)
    np.testing.assert_allclose(same.u, moved.u, atol=1e-9)


@pytest.mark.slow
def test_loads_are_those_of_the_table_of_the_inputs(tmp_path):
    """The command along the path of the tool, and `verify` along angles in closed form."""
    path = write_path(tmp_path / "path.csv")
    table, rows = tmp_path / "inputs.csv", np.column_stack([TIME, inputs_at(TIME)])
    np.savetxt(table, rows, fmt="%.14g", delimiter=",", header="time,u1,u2", comments="")
    by_angles = balance.verify("five_bar", motions=table)
    tool = balance.motion.from_tool_csv("five_bar", path, LINK, POINT)
    by_tool = balance.verify("five_bar", motions=[tool])
    assert by_tool.force == pytest.approx(by_angles.force, rel=1e-5)
    assert by_tool.moment == pytest.approx(by_angles.moment, rel=1e-5)
    words = ["verify", "five_bar", "--tool-path", f"{LINK}@0.7,0.5,0={path}", "--json"]
    done = asked(words)
    assert (done.code, done.err) == (1, "")
    assert json.loads(done.out)["shaking"]["force"] == pytest.approx(by_tool.force, rel=1e-9)


@pytest.mark.parametrize("digits", [4, 5])
def test_errors_hold_what_the_rounding_of_the_path_makes_of_the_inputs(tmp_path, digits):
    """Paths within half a unit of the last digit give inputs within the bounds."""
    rounded = balance.motion.from_tool_csv(
        "five_bar", write_path(tmp_path / "path.csv", digits), LINK, POINT
    )
    truth = inputs_at(TIME)
    assert np.all(np.abs(rounded.u - truth) <= 1.5 * rounded.errors.u + 1e-9)
    step = 1e-4
    speed = (inputs_at(TIME + step) - inputs_at(TIME - step)) / (2 * step)
    assert np.all(np.abs(rounded.ud - speed) <= 1.5 * rounded.errors.ud + 1e-5)
    assert rounded.errors.u.max() < 20 * 10.0**-digits


def test_paths_that_cannot_be_followed_are_refused(tmp_path):
    path = write_path(tmp_path / "path.csv")
    with pytest.raises(BodyError, match="ghost"):
        balance.motion.from_tool_csv("five_bar", path, "ghost")
    with pytest.raises(CoordinateError, match="cannot move this way"):
        balance.motion.from_tool_csv("five_bar", path, "left_lower")
    far = write_path(tmp_path / "far.csv", scale=40.0)
    with pytest.raises(PoseError, match="cannot be closed"):
        balance.motion.from_tool_csv("five_bar", far, LINK, POINT)
    table = write_path(tmp_path / "inputs.csv", head="time,u1,u2")
    with pytest.raises(FileError, match="line 1: names no direction of a tool; head"):
        balance.motion.from_tool_csv("five_bar", table, LINK, POINT)
    with pytest.raises(FileError, match="unit of angle"):
        degrees = write_path(tmp_path / "deg.csv", head="time,x [deg],y")
        balance.motion.from_tool_csv("five_bar", degrees, LINK, POINT)


def test_the_words_of_the_option(tmp_path):
    """No file, no link, no point, two motions: exit code 2, and the option is named."""
    path = write_path(tmp_path / "path.csv")
    for word in (LINK, f"={path}", f"{LINK}@0,0={path}", f"{LINK}="):
        done = asked(["verify", "five_bar", "--tool-path", word])
        assert done.code == 2 and "argument --tool-path" in done.err, word
    words = ["--tool-path", f"{LINK}={path}", "--speed", "u1=300rpm"]
    done = asked(["verify", "five_bar", *words])
    assert done.code == 2 and "not allowed with" in done.err


@pytest.mark.slow
def test_weights_along_the_path_of_a_tool(tmp_path):
    """The mean square over the motion, by Pinocchio, is what partial balance promises."""
    tool = balance.motion.from_tool_csv(
        "five_bar", write_path(tmp_path / "path.csv"), LINK, POINT
    )
    links = ["left_lower", "right_lower"]
    answer = balance.partial("five_bar", links, 0.3, motions=tool)
    given = balance.verify("five_bar", motions=tool)
    made = balance.verify(balance.load(answer.to_urdf()), motions=tool)

    def measure(check):
        (run,) = check.runs
        moment, force = np.split(run.about, 2, axis=1)
        square = (force**2).sum(axis=1) + (moment**2).sum(axis=1) / answer.weight_moment**2
        return float(np.sqrt(np.trapezoid(square, TIME)))

    assert measure(made) / measure(given) == pytest.approx(answer.share, abs=2e-3)
    assert answer.share < 0.97
