"""Files whose loops are open: exact arithmetic at the pose found, and that pose as a file."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from yourdfpy import URDF

import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from balance.space.certification.exact_ranks import exact_ranks
from kinematics.errors import ExactError, FileError
from kinematics.files.urdf.rational_poses import rotation
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from kinematics.model.arrays import freeze
from kinematics.numerics.linalg.rational import dot
from tests.support.figures import FIGURES
from tests.support.laws import altered, posed
from tests.support.sidecar_text import PAIR, bench, written
from tests.support.urdf_text import UNIT_INERTIA, about, along, joint, link, pose_of, saved

# Linkages whose ranks are those of any with as many bars.
GENERAL = ("five_bar", "four_bar_general", "four_bar_spherical", "six_bar_watt", "three_rrr")
SPATIAL = ("rusr", "stewart_6ups")
# And linkages that are not: bars of equal lengths.
SPECIAL = (
    "four_bar_antiparallelogram",
    "four_bar_kite",
    "four_bar_parallelogram",
    "slider_crank",
)
ORIGIN = "<origin [^>]*/>"


def opened(model, folder, angle=0.02, seed=1):
    """The model with the turning joints of its tree turned one way or the other."""
    rng, source = np.random.default_rng(seed), kinematics.gallery()[model]
    joints = [each for each in kinematics.load(source).joints if each.kind == "revolute"]
    turning = [each.name for each in joints if not each.in_loop and not each.numbered]
    signs = rng.choice([-1, 1], len(turning))
    return altered(model, folder, posed(dict(zip(turning, angle * signs, strict=True))))


def rewritten(linkage, folder):
    path = folder / "closed.urdf"
    path.write_bytes(write_at_reference_pose(linkage).data)
    return path


@pytest.mark.table(2)
@pytest.mark.parametrize("model", GENERAL + SPATIAL)
def test_the_ranks_of_an_open_file_are_exact(model, tmp_path):
    linkage = kinematics.load(opened(model, tmp_path))
    assert [notice.code for notice in linkage.notices][-1] == "assembled"
    found = exact_ranks(linkage)
    other = exact_ranks(kinematics.load(rewritten(linkage, tmp_path)))
    assert found.ranks == other.ranks and found.regular and other.regular
    figure = next(f for f in FIGURES if f.model == model and not f.motion)
    if (figure.balance, figure.spatial) == ("dynamic", False):
        assert found.ranks[: figure.kmax + 1] == figure.ranks
    assert {notice.code for notice in found.notices} >= {"not_exact"}
    assert any("closed by Newton's method" in notice.message for notice in found.notices)


@pytest.mark.table(2)
@pytest.mark.parametrize("model", GENERAL)
def test_open_files_are_as_certain_as_closed_ones(model, tmp_path):
    linkage = kinematics.load(opened(model, tmp_path))
    other = kinematics.load(rewritten(linkage, tmp_path))
    levels = [certify(design_space(each)).certainty for each in (linkage, other)]
    assert levels[0].level == levels[1].level == "proved"
    assert re.search(r"with \d+ numbers of the file replaced", levels[0].reason)


@pytest.mark.parametrize("model", SPECIAL)
def test_special_linkages_stay_as_certain_when_they_are_open(model, tmp_path):
    """Exact arithmetic loses what is special; floating point keeps it, with a wide gap."""
    figure = next(f for f in FIGURES if f.model == model and not f.spatial)
    found = certify(design_space(kinematics.load(opened(model, tmp_path))))
    assert tuple(order.rank for order in found.orders) == figure.ranks
    assert (found.serial_nullity, found.nullity) == (figure.serial, figure.nullity)
    assert found.certainty.level == "verified" and not found.certainty.doubts
    assert found.dropped < 1e-14


@pytest.mark.table(3)
@pytest.mark.parametrize("model", GENERAL + SPATIAL)
def test_exact_screws_are_those_of_the_pose_found(model, tmp_path):
    linkage = kinematics.load(opened(model, tmp_path))
    given, geometry = kinematics.load(model), exact_geometry(linkage)
    for each, screw in zip(linkage.joints, geometry.screws, strict=True):
        n = screw[:3] if any(screw[:3]) else screw[3:]
        found = np.array([float(x) for x in screw]) / float(dot(n, n)) ** 0.5
        assert found == pytest.approx(each.screw, abs=1e-13)
    # Exactly orthogonal rotations keep the lengths of axes, which here are the file's.
    if not given.notices:
        assert geometry.squares == exact_geometry(given).squares


def test_rotations_are_exactly_orthogonal():
    n, tau = (Fraction(2, 3), Fraction(-1, 7), Fraction(5)), Fraction(3, 11)
    R = rotation(n, tau)
    assert [[dot(a, b) for b in R] for a in R] == np.eye(3).tolist()
    assert tuple(dot(row, n) for row in R) == n
    length = float(dot(n, n)) ** 0.5
    expected = about([float(x) for x in n], 2 * np.arctan(float(tau) * length))[:3, :3]
    assert np.array(R, dtype=float) == pytest.approx(expected, abs=1e-15)


def test_a_bennett_linkage_is_exact_at_a_pose_that_was_found(tmp_path):
    linkage = kinematics.load(opened("bennett", tmp_path))
    assert exact_ranks(linkage).ranks[:4] == (6, 10, 13, 13)


@pytest.mark.parametrize("model", ["goldberg_five_bar", "sarrus"])
def test_overconstrained_loops_at_a_pose_that_was_found_are_refused(model, tmp_path):
    linkage = kinematics.load(opened(model, tmp_path))
    with pytest.raises(ExactError, match="not exactly representable"):
        exact_ranks(linkage)
    assert kinematics.load(rewritten(linkage, tmp_path)).mobility == linkage.mobility


def test_axes_that_were_moved_are_refused(tmp_path):
    def off(robot):
        robot.find("loop/predecessor/origin").set("xyz", "0 0 0.000001")

    linkage = kinematics.load(altered("four_bar_spherical", tmp_path, off))
    assert [notice.code for notice in linkage.notices][-1] == "closes_to_rounding"
    with pytest.raises(ExactError, match="axes that are in the file"):
        exact_geometry(linkage)


@pytest.mark.table(4)
@pytest.mark.parametrize("model", GENERAL + SPATIAL + ("bennett", "delta", "slider_crank"))
def test_a_written_file_is_the_same_linkage_closed(model, tmp_path):
    path = opened(model, tmp_path)
    linkage = kinematics.load(path)
    posed_file = write_at_reference_pose(linkage)
    again = kinematics.load(rewritten(linkage, tmp_path))
    assert all(np.array_equal(loop.gap, np.eye(4)) for loop in again.loops)
    assert again.displaced is None and "assembled" not in {n.code for n in again.notices}
    assert (again.mobility, again.planar) == (linkage.mobility, linkage.planar)
    assert again.frames == pytest.approx(linkage.frames, abs=1e-13)
    for one, other in zip(linkage.bodies, again.bodies, strict=True):
        assert other.inertia == pytest.approx(one.inertia, rel=1e-12, abs=1e-13)
    # Nothing but origins differs, in bytes.
    before, after = path.read_text(), posed_file.data.decode()
    assert re.sub(ORIGIN, "", before) == re.sub(ORIGIN, "", after)
    assert len(re.findall(ORIGIN, after)) == before.count("<origin")


@pytest.mark.parametrize("model", ["four_bar_general", "bennett", "six_bar_watt"])
def test_links_are_where_another_reader_puts_them(model, tmp_path):
    """yourdfpy moves the joints of the file by what was told; links of the written file."""
    path = opened(model, tmp_path)
    linkage = kinematics.load(path)
    found = write_at_reference_pose(linkage)
    paths = path, rewritten(linkage, tmp_path)
    robots = [URDF.load(str(p), load_meshes=False) for p in paths]
    robots[0].update_cfg(
        {name: found.moved.get(name, 0.0) for name in robots[0].actuated_joint_names}
    )
    for name in robots[0].link_map:
        poses = [robot.get_transform(name) for robot in robots]
        assert poses[0] == pytest.approx(poses[1], abs=1e-12)


KINDS = ("revolute", "prismatic", "cylindrical", "planar", "spherical")


@pytest.mark.table(15)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("rpy", [(0, 0, 0), (0.3, -0.2, 0.9), (np.pi / 2, 0, 0.4)])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.6, 0, 0.8)])
def test_origins_of_joints_of_every_kind(kind, rpy, axis, tmp_path):
    """A link moves by its joint in the frame of the joint; axes stay in the link."""
    kind_of = "continuous" if kind == "revolute" else kind
    limits = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    parts = [link("base"), link("a", **UNIT_INERTIA)]
    parts.append(joint("j", kind_of, "base", "a", pose_of([1, 2, 3], rpy), axis, limits))
    linkage = kinematics.load(saved(tmp_path, *parts))
    q = np.array([0.3, -0.4, 0.5])[: len(linkage.joints)]
    H = np.eye(4)
    for each, position in zip(linkage.joints, q, strict=True):
        n, m = each.screw[:3], each.screw[3:]
        turn = each.kind != "prismatic"
        H = H @ (about(n, position, np.cross(n, m)) if turn else along(position * m))
    moved = kinematics.load(rewritten(replace(linkage, displaced=freeze(q)), tmp_path))
    assert moved.frames[0] == pytest.approx(H @ linkage.frames[0], abs=1e-14)
    if kind == "revolute":
        assert moved.joints[0].screw == pytest.approx(linkage.joints[0].screw, abs=1e-14)


def test_a_planar_linkage_keeps_its_plane_to_the_last_digit(tmp_path):
    path = opened("four_bar_general", tmp_path)
    text = rewritten(kinematics.load(path), tmp_path).read_text()
    angles = [each.split() for each in re.findall(r'rpy="([^"]*)"', text)]
    assert angles and all(roll in "0.0 0" and pitch in "0.0 0" for roll, pitch, _ in angles)


def test_an_origin_that_is_missing_is_added(tmp_path):
    parts = [link("base"), link("a", **UNIT_INERTIA), joint("j", "continuous", "base", "a")]
    path = saved(tmp_path, *parts)
    path.write_text(re.sub(ORIGIN, "", path.read_text(), count=2))
    linkage = kinematics.load(path)
    moved = kinematics.load(rewritten(replace(linkage, displaced=freeze([0.25])), tmp_path))
    assert moved.frames[0] == pytest.approx(about([1, 0, 0], 0.25), abs=1e-15)


def test_what_cannot_be_written_at_another_pose(tmp_path):
    parts = [link("base"), link("a", **UNIT_INERTIA)]
    parts.append(joint("j", "universal", "base", "a", axis=[0, 0, 1]))
    linkage = kinematics.load(saved(tmp_path, *parts))
    with pytest.raises(FileError, match="second axis"):
        write_at_reference_pose(replace(linkage, displaced=freeze([0.1, 0.2])))
    model = URDF.load(str(kinematics.gallery()["hprs"]), load_meshes=False)
    with pytest.raises(FileError, match="in memory"):
        write_at_reference_pose(kinematics.load(model))


def test_the_command_writes_the_closed_file(tmp_path, capsys, caplog):
    path, out = opened("four_bar_general", tmp_path), tmp_path / "out.urdf"
    assert main(["report", str(path), "--write-closed", str(out)]) == 0
    told = next(r.message for r in caplog.records if r.message.startswith("closed_pose"))
    assert str(out) in told and re.search(r"moved are \w+ by -?[\d.]+ rad", told)
    first = capsys.readouterr().out
    caplog.clear()
    assert main(["report", str(out), "--certainty", "proved"]) == 0
    assert not caplog.records
    orders = [text.splitlines()[-4:] for text in (first, capsys.readouterr().out)]
    assert orders[0] == orders[1]


def test_a_file_that_is_closed_is_written_as_it_was(tmp_path, capsys, caplog):
    path, out = kinematics.gallery()["four_bar_general"], tmp_path / "out.urdf"
    assert main(["report", str(path), "--write-closed", str(out)]) == 0
    assert out.read_bytes() == path.read_bytes()
    assert "its loops close at its own pose" in caplog.text


@pytest.mark.parametrize(
    ("name", "extra", "code"), [("none/x.html", [], 3), ("x.html", ["--html"], 2)]
)
def test_paths_that_cannot_be_written(name, extra, code, tmp_path, capsys):
    """A folder that is not there; and the page in the same place as the file."""
    out = str(tmp_path / name)
    options = [*extra, out] if extra else []
    assert main(["report", "four_bar_general", "--write-closed", out, *options]) == code
    error = capsys.readouterr().err
    assert out in error and len(error.splitlines()) == (2 if code == 2 else 1)
    assert not (tmp_path / "x.html").exists()


def test_loops_beside_the_file_are_told(tmp_path, capsys, caplog):
    path = written(tmp_path, bench(), PAIR + "type: ['3d']\n")
    out = tmp_path / "out.urdf"
    assert main(["report", str(path), "--write-closed", str(out)]) == 0
    assert "give that with --loops" in caplog.text
    again = kinematics.load(out, tmp_path / "robot.yaml")
    assert "assembled" not in {notice.code for notice in again.notices}
    assert again.mobility == kinematics.load(path).mobility
