"""A crank at constant speed: textbook formula, momentum, limits, and the command."""

from __future__ import annotations

import csv
import math
import re

import numpy as np
import pytest

import balance
import kinematics
from balance import design, design_space
from balance.app.cli.main import main
from balance.app.cli.motion_source import read_speed
from balance.motion.verification.crank_revolution import STEPS, revolve_crank
from balance.motion.verification.verify_motions import verify, verify_second
from kinematics.errors import CoordinateError, MotionError, PoseError, UsageError
from tests.support.laws import altered
from tests.support.page_elements import without_breaks
from tests.support.verify_command import run

RPM = 2.0 * math.pi / 60.0
TURNING = ("four_bar_general", "bennett", "goldberg_five_bar", "six_bar_watt")
R, ROD, PISTON = 0.05, 0.2, 1.5


def slider_crank(folder, gear=""):
    """An in-line slider-crank at a crank angle of 90°; all its mass is the piston's."""
    far = math.sqrt(ROD**2 - R**2)
    path = folder / "engine.urdf"
    path.write_text(
        f"""<robot name="engine"><link name="base"/><link name="crank"/><link name="rod"/>
  <link name="piston"><inertial><mass value="{PISTON!r}"/><inertia ixx="0.001" iyy="0.001"
    izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="crank" type="continuous" independent="true"><parent link="base"/>
    <child link="crank"/><axis xyz="0 0 1"/></joint>
  <joint name="pin" type="continuous"><origin xyz="0 {R!r} 0"/><parent link="crank"/>
    <child link="rod"/><axis xyz="0 0 1"/></joint>
  <joint name="guide" type="prismatic"><origin xyz="{far!r} 0 0"/><parent link="base"/>
    <child link="piston"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <loop name="wrist" type="revolute"><predecessor link="rod">
    <origin xyz="{far!r} {-R!r} 0"/></predecessor><successor link="piston"/>
    <axis xyz="0 0 1"/></loop>{gear}</robot>""",
        encoding="utf-8",
    )
    return path


def four_bar(folder, a, b, c, d):
    """A planar four-bar: crank a, coupler b, rocker c, base d; the crank at 90°."""
    # The rocker's end from the ends of the crank and of the base: two circles.
    A, D = np.array([0.0, a]), np.array([d, 0.0])
    span = np.linalg.norm(D - A)
    along = (D - A) / span
    s = (b * b - c * c + span * span) / (2.0 * span)
    C = A + s * along + math.sqrt(b * b - s * s) * np.array([-along[1], along[0]])

    def words(p):
        return f"{float(p[0])!r} {float(p[1])!r} 0"

    def change(robot):
        robot.find("joint[@name='q2']/origin").set("xyz", words(A))
        robot.find("joint[@name='q4']/origin").set("xyz", words(D))
        robot.find("loop/predecessor/origin").set("xyz", words(C - A))
        robot.find("loop/successor/origin").set("xyz", words(C - D))

    return altered("four_bar_general", folder, change)


def harmonics(values):
    """Complex Fourier coefficients of one period, both of whose ends are given."""
    return np.fft.rfft(values[:-1], axis=0) / (len(values) - 1)


@pytest.mark.slow
def test_a_second_crank_turns_at_the_speed_of_the_first(tmp_path):
    """Without another word on the speed: the peak of the piston alone, for both."""
    linkage = kinematics.load(slider_crank(tmp_path))
    first = verify(linkage, speed=-300.0 * RPM)
    second = verify_second(first, linkage)
    assert second.crank == first.crank and second.crank.speed == -300.0 * RPM
    largest = PISTON * R * (300.0 * RPM) ** 2 * (1.0 + R / ROD)
    assert second.force == pytest.approx(largest, rel=1e-9)


def test_a_piston_shakes_as_the_textbook_says(tmp_path):
    """``F = m r ω² (cos θ + A₂ cos 2θ - A₄ cos 4θ + …)`` with λ = r/l, by the series in λ.

    ``x = r cos θ + l sqrt(1 - λ² sin² θ)``; A₂ = λ + λ³/4 + 15 λ⁵/128 + …,
    A₄ = λ³/4 + 3 λ⁵/16 + …, to order λ⁵; the next terms are below 5e-5 and 6e-5.
    """
    speed = 300.0 * RPM
    found = verify(kinematics.load(slider_crank(tmp_path)), speed=speed)
    (way,) = found.runs
    k = R / ROD
    primary = PISTON * R * speed**2
    force = -way.middle[:, 3]
    theta = way.trajectory.u[:, 0] + math.pi / 2.0
    second = k + k**3 / 4.0 + 15.0 * k**5 / 128.0
    fourth = k**3 / 4.0 + 3.0 * k**5 / 16.0
    series = np.cos(theta) + second * np.cos(2.0 * theta) - fourth * np.cos(4.0 * theta)
    assert np.abs(force / primary - series).max() < 2e-4
    # The same, without the angle of the series: amplitudes of the harmonics.
    found_at = 2.0 * np.abs(harmonics(force)) / primary
    assert found_at[1] == pytest.approx(1.0, rel=1e-12)
    assert found_at[2] == pytest.approx(second, abs=5e-5)
    assert found_at[4] == pytest.approx(fourth, abs=6e-5)
    assert np.abs(found_at[[0, 3, 5]]).max() < 1e-12
    # Peak at top dead centre, θ = 0: 1 + λ exactly. Mean square by Parseval's theorem.
    assert found.force == pytest.approx(primary * (1.0 + k), rel=1e-12)
    assert way.rms("force") == pytest.approx(
        primary * math.sqrt(0.5 * np.sum(found_at[1:] ** 2)), rel=1e-12
    )


@pytest.mark.table(1)
@pytest.mark.parametrize("model", TURNING)
def test_the_force_is_the_derivative_of_the_momentum_over_the_revolution(model):
    """By the Fourier series of the momentum that Pinocchio finds, all around."""
    speed = -40.0
    found = verify(model, speed=speed)
    (way,) = found.runs
    c = harmonics(way.momentum)
    order = np.arange(len(c))[:, None]
    rate = np.fft.irfft(1j * order * abs(speed) * c * STEPS, STEPS, axis=0)
    size = np.abs(way.shaking).max(axis=0)
    assert np.abs(rate - way.shaking[:-1]).max() < 1e-9 * size.max()
    assert found.agreed and found.agreement < 1e-12 and found.crank.periodic
    assert way.trajectory.u[-1, 0] == pytest.approx(-2.0 * math.pi, rel=1e-15)
    # A periodic force has the same mean of squares from wherever it is counted.
    assert way.rms("moment") == pytest.approx(
        np.sqrt(np.mean(way.sizes("moment")[:-1] ** 2)), rel=1e-12
    )


@pytest.mark.table(1)
@pytest.mark.parametrize("model", TURNING)
def test_forces_grow_with_the_square_of_the_speed(model):
    slow, fast, back = (verify(model, speed=speed) for speed in (3.0, 30.0, -3.0))
    for part in ("force", "moment"):
        for ask in ("peak", "rms"):
            one, other, third = (getattr(x.runs[0], ask)(part) for x in (slow, fast, back))
            assert other == pytest.approx(100.0 * one, rel=1e-10)
            assert third == pytest.approx(one, rel=1e-9)
    assert slow.duration == pytest.approx(10.0 * fast.duration) and slow.seed is None


@pytest.mark.parametrize("links", [(0.5, 0.6, 0.35, 0.55), (0.4, 0.5, 0.45, 0.8)])
def test_a_crank_that_cannot_turn_says_how_far(links, tmp_path):
    """The diagonal from crank to base is |b - c| to b + c long: by the law of cosines."""
    a, b, c, d = links
    path = four_bar(tmp_path, a, b, c, d)
    with pytest.raises(PoseError) as caught:
        revolve_crank(kinematics.load(path), 10.0)
    low, high = map(float, re.findall(r"(-?[\d.]+)°", str(caught.value)))
    assert str(caught.value).startswith(f"{path}: the crank u1 cannot turn fully: only from ")
    with pytest.raises(PoseError) as brief:
        revolve_crank(kinematics.load(path), 10.0, explain=False)
    assert str(caught.value).startswith(f"{brief.value}: only from ")
    ends = [
        math.degrees(math.acos((a * a + d * d - e * e) / (2.0 * a * d)))
        for e in (b - c, b + c)
        if abs(a * a + d * d - e * e) < 2.0 * a * d
    ]
    # About the pose of the file at 90°; below the base line by symmetry.
    first, last = (min(ends), max(ends)) if len(ends) == 2 else (-ends[0], ends[0])
    assert low == pytest.approx(first - 90.0, abs=0.006)
    assert high == pytest.approx(last - 90.0, abs=0.006)


def test_a_crank_turns_through_poses_where_branches_meet(tmp_path):
    """A parallelogram at 90° has a sample just where it is flat: the coupler translates."""
    linkage = kinematics.load(four_bar(tmp_path, 0.5, 1.0, 0.5, 1.0))
    found = verify(linkage, speed=5.0)
    way = found.runs[0].trajectory
    coupler = way.q[:, [linkage.joints.index(j) for j in linkage.joints if j.name == "q2"]]
    assert np.abs(way.u + coupler - (way.u[0] + coupler[0])).max() < 1e-9
    assert found.agreed and any("singularity" in remark for remark in found.remarks)


def test_what_a_flat_pose_amplifies_gives_no_verdict():
    """A balanced antiparallelogram folds flat: its round-off there is no shaking."""
    linkage = kinematics.load("four_bar_antiparallelogram")
    masses = design(design_space(linkage)).z
    found = verify(linkage, masses, speed=30.0)
    assert found.agreed and not found.balanced and found.conditioning < 0.02
    assert found.verdict == "no verdict" and found.to_dict()["balanced"] is None
    assert any("stay clear" in remark for remark in found.remarks)


def test_what_shakes_more_than_a_flat_pose_amplifies_is_not_balanced():
    found = verify("four_bar_antiparallelogram", speed=30.0)
    assert found.conditioning < 0.02 and found.verdict == "not balanced"


def test_a_crank_whose_linkage_does_not_come_back(tmp_path):
    """A counterweight geared down to half the speed needs two revolutions."""
    gear = (
        '<link name="wheel"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia '
        'ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="gear" type="continuous"><parent link="base"/><child link="wheel"/>'
        '<axis xyz="0 0 1"/><mimic joint="crank" multiplier="0.5"/></joint>'
    )
    found = verify(kinematics.load(slider_crank(tmp_path, gear)), speed=5.0)
    assert not found.crank.periodic
    assert any("does not bring all joints back" in remark for remark in found.remarks)
    assert verify(kinematics.load(slider_crank(tmp_path)), speed=5.0).crank.periodic


def test_other_inputs_stand_still_or_follow(tmp_path):
    linkage = kinematics.load("hprs")
    way, crank = revolve_crank(linkage, 4.0, "revolute")
    at = linkage.inputs.index("revolute")
    assert np.abs(np.delete(way.ud, at, axis=1)).max() == 0.0 and crank.joint == "revolute"
    assert np.array_equal(way.ud[:, at], np.full(STEPS + 1, 4.0)) and not way.udd.any()
    relations = [f"{name}=0" for name in linkage.inputs if name not in ("revolute", "wrist_x")]
    motion = kinematics.Motion.parse([*relations, "wrist_x=-2*revolute"], linkage.inputs)
    both, _ = revolve_crank(linkage, 4.0, "revolute", motion)
    assert both.ud[7, linkage.inputs.index("wrist_x")] == pytest.approx(-8.0)
    still = kinematics.Motion.parse(relations + ["revolute=0"], linkage.inputs)
    with pytest.raises(MotionError, match="does not let revolute turn"):
        revolve_crank(linkage, 4.0, "revolute", still)
    for name, problem in (
        (None, "which is the crank"),
        ("prismatic", "not revolute"),
        ("nothing", "not an input"),
    ):
        with pytest.raises(CoordinateError, match=problem):
            revolve_crank(linkage, 4.0, name)
    with pytest.raises(CoordinateError, match="name it, as in --speed revolute=300rpm"):
        revolve_crank(linkage, 4.0, None, motion)
    for speed in (0.0, math.nan, math.inf, 1e-7, 1e7):
        with pytest.raises(PoseError, match="is no speed of a crank"):
            revolve_crank(linkage, speed, "revolute")
    with pytest.raises(ValueError, match="either a speed or motions"):
        verify(linkage, speed=1.0, motions=[way])


@pytest.mark.parametrize(
    ("relation", "joint", "rates"),
    [("u2=u1", "u1", [1.0, 1.0]), ("u1=u2", "u1", [1.0, 1.0]), ("u1=0", "u2", [0.0, 1.0])],
)
def test_a_motion_of_one_degree_of_freedom_leaves_one_crank(relation, joint, rates):
    linkage = kinematics.load("five_bar")
    motion = kinematics.Motion.parse([relation], linkage.inputs)
    way, crank = revolve_crank(linkage, 1.0, None, motion)
    assert crank.joint == joint and np.all(way.ud == rates)


@pytest.mark.parametrize(
    "word",
    [
        "300rpm",
        "300 RPM",
        "5hz",
        "5Hz",
        "5rev/s",
        "5 1/s",
        "31.41592653589793rad/s",
        "1800deg/s",
        "3e2rpm",
        "+300rpm",
    ],
)
def test_units_of_speed(word):
    assert read_speed(word) == (None, pytest.approx(10.0 * math.pi, rel=1e-15))
    assert read_speed(f"u 1={word}") == ("u 1", pytest.approx(10.0 * math.pi, rel=1e-15))
    assert read_speed("-60rpm") == (None, pytest.approx(-2.0 * math.pi))


@pytest.mark.parametrize(
    "words",
    [
        ["--speed", "300"],
        ["--speed", "rpm"],
        ["--speed", "300m/s"],
        ["--speed", "=300rpm"],
        ["--speed", "nanrpm"],
        ["--speed", "300rpm", "--csv", "a.csv"],
        ["--speed", "300rpm", "--trajectories", "3"],
        ["--speed", "300rpm", "--seed", "0"],
        ["--table", "a.csv", "--against", "bennett"],
    ],
)
def test_words_of_a_speed_that_are_refused(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["verify", "four_bar_general", *words]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and streams.err.startswith("balance verify: error: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_tells_peak_and_rms(capsys, tmp_path):
    page, table = tmp_path / "a.html", tmp_path / "a.csv"
    code, report = run(
        capsys,
        "four_bar_general",
        "--speed",
        "300rpm",
        "--html",
        str(page),
        "--table",
        str(table),
    )
    same = verify("four_bar_general", speed=10.0 * math.pi)
    assert code == 1 and {**same.to_dict(), "against": None, "sentence": None} == report
    speed = report["speed"]
    assert (speed["input"], speed["periodic"], report["seed"]) == ("u1", True, None)
    assert speed["rpm"] == pytest.approx(300.0) and report["duration"] == pytest.approx(0.2)
    assert speed["force"]["peak"] == report["shaking"]["force"] > speed["force"]["rms"] > 0.0
    assert main(["verify", "four_bar_general", "--speed", "u1=5hz"]) == 1
    out = capsys.readouterr().out
    assert "(31.4159 rad/s), 720 steps; its angle counts from the pose of the file" in out
    force = speed["force"]
    assert re.search(
        rf"shaking force +peak {force['peak']:.3g} N at [\d.]+°, rms "
        rf"{force['rms']:.3g} N;",
        out,
    )
    text = without_breaks(page.read_text("utf-8"))
    assert "one revolution of u1 at 300 rpm (0.2 s)" in text and f"{force['rms']:.3g} N" in text
    with open(table, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time", "u1", *(f"{p}_{x}" for p in ("force", "moment") for x in "xyz")]
    values = np.array(rows, dtype=float)
    assert values.shape == (STEPS + 1, 8)
    assert np.linalg.norm(values[:, 2:5], axis=1).max() == pytest.approx(force["peak"])
    assert np.array_equal(values[:, 2:5], -same.runs[0].shaking[:, 3:])


@pytest.mark.slow
def test_two_cranks_turn_at_one_speed(capsys, tmp_path):
    page = tmp_path / "a.html"
    pair = ["four_bar_general", "--against", "bennett", "--speed=-60rpm"]
    code, report = run(capsys, *pair, "--html", str(page))
    assert code == 1 and report["against"]["speed"]["rpm"] == report["speed"]["rpm"]
    assert report["against"]["trajectories"] == 1
    assert main(["verify", *pair]) == 1
    assert "one revolution of u1 at -60 rpm" in capsys.readouterr().out


def test_a_crank_that_cannot_turn_exits_with_3(capsys):
    words = ["verify", "four_bar_general", "--inputs", "q4", "--speed", "9rpm"]
    for more in (["--json"], []):
        assert main([*words, *more]) == 3
        streams = capsys.readouterr()
        assert streams.out == "" and streams.err.count("\n") == 1
        assert "the crank q4 cannot turn fully: only from -6.08° to 45.42°" in streams.err
    assert main(["verify", "five_bar", "--speed", "9rpm"]) == 3
    assert "choose from u1, u2" in capsys.readouterr().err
    assert main(["verify", "five_bar", "--speed", "u1=1e9rpm"]) == 3


def test_a_speed_may_have_a_unit():
    linkage = kinematics.load("four_bar_general")
    turn = balance.motion.one_turn(linkage, "300rpm")
    np.testing.assert_allclose(turn.u[-1], 2.0 * np.pi, rtol=1e-12)
    assert turn.duration == pytest.approx(0.2, rel=1e-12)
    with pytest.raises(UsageError, match="unit of length: write angular velocity in rad/s"):
        balance.motion.one_turn(linkage, "300mm")
