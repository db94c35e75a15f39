"""Rational numbers for rounded ones: decimals, angles, rotations, and the screws of files."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import kinematics
from kinematics.errors import ExactError
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.model.linkage import names_of
from kinematics.numerics.linalg import rational
from kinematics.numerics.linalg.rational import BITS
from tests.support.laws import MODELS, altered
from tests.support.urdf_text import DEGREES, INERTIAL, joint, link, loop, pose_of, saved, words

UNIT = dict(mass=1.0, inertia=np.eye(3))
# Files are written with doubles: positions compare to their round-off.
ROUND_OFF = 1e-13


def difference(linkage, geometry):
    """Largest difference between the exact screws, made unit, and those of the linkage."""
    found = np.array([[float(x) for x in screw] for screw in geometry.screws])
    lengths = np.sqrt([float(x) for x in geometry.squares])
    known = np.array([joint.screw for joint in linkage.joints])
    return np.abs(found / lengths[:, None] - known).max()


def serial(tmp_path, *rpys, axis="0 0 1", reading="as_written"):
    """A chain of revolute joints whose frames are turned one after the other."""
    parts = ['<link name="l0"/>']
    for i, angles in enumerate(rpys, 1):
        parts.append(f'<link name="l{i}">{INERTIAL}</link>')
        parts.append(
            f'<joint name="j{i}" type="continuous"><parent link="l{i - 1}"/>'
            f'<child link="l{i}"/><origin xyz="0.3 0.1 0.2" rpy="{angles}"/>'
            f'<axis xyz="{axis}"/></joint>'
        )
    return kinematics.load(saved(tmp_path, *parts), angles=reading)


def test_pi_has_the_digits_of_another_library():
    with mpmath.workprec(400):
        found = mpmath.mpf(rational.pi().numerator) / rational.pi().denominator
        assert abs(found - mpmath.pi) < mpmath.mpf(2) ** -(BITS + 100)


@pytest.mark.slow
@given(st.fractions(-10, 10, max_denominator=10**6))
def test_half_angle_tangents_are_right_to_their_bits(angle):
    """Quarter turns and the rest add up to the angle, and the tangent is that of the rest."""
    count, rest = rational.quarters(angle)
    t = rational.tangent(rest)
    assert (t * 2**BITS).denominator == 1
    with mpmath.workprec(300):
        quarter = mpmath.pi / 2
        exact = mpmath.mpf(angle.numerator) / angle.denominator - count * quarter
        assert abs(exact) <= quarter / 2 + 1e-50
        error = mpmath.mpf(t.numerator) / t.denominator - mpmath.tan(exact / 2)
        assert abs(error) <= mpmath.mpf(2) ** -(BITS + 1) + mpmath.mpf(2) ** -100


@given(st.fractions(0, 10**6, max_denominator=10**6))
def test_roots_are_exact_or_refused(x):
    assert rational.root(x * x) == x
    assert rational.root(2 * x * x) is None or x == 0


@given(st.lists(st.lists(st.integers(-3, 3), min_size=4, max_size=4), max_size=4))
def test_null_spaces_are_complete(rows):
    exact = [[Fraction(x) for x in row] for row in rows]
    found = rational.rational_null_space(exact, 4)
    assert all(rational.dot(row, vector) == 0 for row in exact for vector in found)
    rank = np.linalg.matrix_rank(np.array(rows or [[0] * 4]))
    assert len(found) == 4 - rank
    assert len(rational.echelon(found)[0]) == len(found)


@given(st.lists(st.integers(-9, 9), min_size=12, max_size=12))
def test_the_bracket_is_that_of_the_screws(entries):
    from kinematics.model.spatial.screws import ad

    a, b = entries[:6], entries[6:]
    found = rational.rational_bracket([Fraction(x) for x in a], [Fraction(x) for x in b])
    assert [float(x) for x in found] == (ad(a) @ b).tolist()


@pytest.mark.parametrize("word", ["0.5", "-1e-3", "+.25", "3.", "1e-400", "0"])
def test_decimals_are_read_as_they_are(word):
    assert rational.decimal(word) == (0 if word == "1e-400" else Fraction(word))


def test_endless_decimals_are_refused():
    with pytest.raises(ExactError, match="5002 characters"):
        rational.decimal("0." + "3" * 5000)


@pytest.mark.table
@pytest.mark.parametrize("model", MODELS)
def test_screws_are_those_of_the_linkage(model):
    linkage = kinematics.load(model)
    geometry = exact_geometry(linkage)
    assert difference(linkage, geometry) < ROUND_OFF
    replaced = {"hprs": 1, "three_rsr": 4}
    assert len(geometry.notices) == replaced.get(model, 0)
    assert {notice.code for notice in geometry.notices} <= {"not_exact", "open_in_decimals"}


@pytest.mark.table
@pytest.mark.parametrize("kind", DEGREES)
@pytest.mark.parametrize("place", ["tree", "loop"])
def test_every_type_of_joint_has_its_screws(kind, place, tmp_path):
    """Frames are turned by random angles; a loop closes a chain of eight joints."""
    rng = np.random.default_rng(list(DEGREES).index(kind))
    frames = [pose_of(rng.normal(size=3), rng.uniform(-1.4, 1.4, 3)) for _ in range(9)]
    parts = [link("l0"), *(link(f"l{i}", **UNIT) for i in range(1, 9))]
    for i in range(8):
        axis = rng.normal(size=3) if i else None
        parts.append(joint(f"j{i}", "continuous", f"l{i}", f"l{i + 1}", frames[i], axis))
    n = rng.normal(size=3)
    if place == "tree":
        parts.append(link("tip", **UNIT))
        parts.append(joint("k", kind, "l8", "tip", frames[8], n if kind != "fixed" else None))
    else:
        total = np.eye(4)
        for frame in frames[:8]:
            total = total @ frame
        # The frames of the loop: one on the tip, and the same seen from the ground.
        n = n if kind != "universal" else np.array([1.0, 0.0, 0.0])
        parts.append(loop("k", kind, ("l8", "l0"), (frames[8], total @ frames[8]), n))
    linkage = kinematics.load(saved(tmp_path, *parts))
    geometry = exact_geometry(linkage)
    assert len(linkage.joints) == 8 + DEGREES[kind]
    assert difference(linkage, geometry) < 10 * ROUND_OFF
    assert all(notice.code in ("not_exact", "open_in_decimals") for notice in geometry.notices)


def test_a_second_axis_is_made_perpendicular(tmp_path):
    """The reader accepts six digits; n and u are exactly perpendicular all the same."""
    parts = [link("l0"), link("l1", **UNIT)]
    more = '<axis2 xyz="1 0.0000001 0"/>'
    parts.append(joint("j", "universal", "l0", "l1", axis=[0.0, 3.0, 4.0], more=more))
    linkage = kinematics.load(saved(tmp_path, *parts))
    geometry = exact_geometry(linkage)
    first, second = geometry.screws
    assert rational.dot(first[:3], second[:3]) == 0
    assert difference(linkage, geometry) < ROUND_OFF


QUARTERS = {
    "1.5707963267948966": 1,
    "-1.57079632679": -1,
    "3.141592653589793": 2,
    "3.1415926535897931": 2,
    "4.71238898038469": 3,
    "-0.157079632679489662e1": -1,
}


@pytest.mark.parametrize("word", QUARTERS)
def test_quarter_turns_with_twelve_digits_are_exact(word, tmp_path):
    """The axes are whole numbers again, in the directions of the turned frame."""
    linkage = serial(tmp_path, f"{word} 0 0", f"0 {word} 0", f"0 0 {word}", reading="nominal")
    geometry = exact_geometry(linkage)
    assert len(geometry.notices) == 3
    assert all(f"{QUARTERS[word]} π/2" in notice.message for notice in geometry.notices)
    angles = np.diag([QUARTERS[word] * np.pi / 2] * 3)
    turned, axes = Rotation.identity(), []
    for rotation in Rotation.from_euler("xyz", angles):
        turned = turned * rotation
        axes.append(np.rint(turned.apply([0, 0, 1])).tolist())
    assert [[int(x) for x in screw[:3]] for screw in geometry.screws] == axes
    assert all(x.denominator == 1 for screw in geometry.screws for x in screw[:3])


@pytest.mark.parametrize("word", ["1.5707963", "1.57079632680", "0.3", "-2.2", "100"])
def test_other_angles_are_rational_rotations(word, tmp_path):
    """The length of an axis does not change, and its direction is right to 2^-63."""
    linkage = serial(tmp_path, f"{word} 0 0", axis="0 0.6 0.8")
    geometry = exact_geometry(linkage)
    assert "no rational rotation" in geometry.notices[-1].message
    n = geometry.screws[0][:3]
    assert geometry.squares == (1,) and rational.dot(n, n) == 1
    with mpmath.workprec(300):
        c, s = mpmath.cos(mpmath.mpf(word)), mpmath.sin(mpmath.mpf(word))
        expected = (mpmath.mpf(3) * c - 4 * s) / 5, (mpmath.mpf(3) * s + 4 * c) / 5
        for x, y in zip(n[1:], expected, strict=True):
            assert abs(mpmath.mpf(x.numerator) / x.denominator - y) < mpmath.mpf(2) ** -62


def test_twelve_digits_that_round_something_else_are_not_a_quarter_turn(tmp_path):
    geometry = exact_geometry(serial(tmp_path, "1.570796326797 0 0"))
    assert "no rational rotation" in geometry.notices[0].message


def test_offsets_of_mimics_move_the_frames(tmp_path):
    """Ratios and offsets add up along a chain of mimics, and slides go along their axes."""
    follow = '<mimic joint="{}" multiplier="{}" offset="{}"/>'
    parts = [link("l0"), *(link(f"l{i}", **UNIT) for i in range(1, 5))]
    frame = pose_of([0.3, -0.2, 0.1], [0.0, 0.0, 0.0])
    screws = '<screw_thread_pitch value="0.2"/>'
    parts += [
        joint("a", "continuous", "l0", "l1", frame, [0.0, 3.0, 4.0]),
        joint("b", "continuous", "l1", "l2", frame, [2, 1, 2], follow.format("a", 2, 0.7)),
        joint("c", "prismatic", "l2", "l3", frame, [1, 2, 2], follow.format("b", -1.5, 0.1)),
        joint(
            "d", "continuous", "l3", "l4", frame, [0, 0, 2], follow.format("c", 1, 1) + screws
        ),
    ]
    tip = [link("l5", **UNIT), joint("e", "continuous", "l4", "l5", frame, [1, 0, 0])]
    linkage = kinematics.load(saved(tmp_path, *parts, *tip))
    geometry = exact_geometry(linkage)
    assert difference(linkage, geometry) < ROUND_OFF
    assert geometry.ratios == (2, Fraction(-3, 2), 1)
    parts[5] = parts[5].replace(words([0, 3, 4]), words([0, 1, 1]))
    parts[6] = parts[6].replace(words([2, 1, 2]), words([0, 1, 1]))
    linkage = kinematics.load(saved(tmp_path, *parts, *tip))
    with pytest.raises(ExactError, match="irrational length"):
        exact_geometry(linkage)


def test_a_pose_that_closes_the_loops_is_told(tmp_path):
    def opened(robot):
        robot.find("loop/successor/origin").set("xyz", "-0.2 0.701 0")

    linkage = kinematics.load(altered("four_bar_general", tmp_path, opened))
    geometry = exact_geometry(linkage)
    assert difference(linkage, geometry) < ROUND_OFF
    told = [notice.message.split("'")[1] for notice in geometry.notices]
    carriers = {joint.parent for joint in linkage.joints}
    assert told == [each.name for j, each in enumerate(linkage.joints) if j in carriers]


def test_robots_that_are_in_no_file_are_refused():
    from yourdfpy import URDF

    path = kinematics.gallery()["hprs"]
    linkage = kinematics.load(URDF.load(str(path), load_meshes=False))
    with pytest.raises(ExactError, match="decimals of a URDF file"):
        exact_geometry(linkage)


def test_a_fixed_base_and_a_file_of_loops_are_what_was_loaded(tmp_path):
    urdf, yaml = tmp_path / "robot.urdf", tmp_path / "other.yaml"
    parts = [
        link("world"),
        link("base"),
        link("crank", **UNIT),
        link("rod", **UNIT),
        link("end"),
    ]
    parts += [
        joint("free", "floating", "world", "base"),
        joint("a", "continuous", "base", "crank", axis=[0, 0, 1]),
        joint("b", "continuous", "base", "rod", pose_of([1, 0, 0], [0, 0, 0]), [0, 0, 1]),
        joint("c", "fixed", "rod", "end", pose_of([-1, 0, 0], [0, 0, 0])),
    ]
    urdf.write_text(f'<robot name="r">{"".join(parts)}</robot>', encoding="utf-8")
    yaml.write_text("closed_loop: [[crank, end]]\ntype: [3d]\n", encoding="utf-8")
    linkage = kinematics.load(urdf, yaml, fix_base=True)
    geometry = exact_geometry(linkage)
    assert len(geometry.screws) == len(linkage.joints) == 5
    assert "crank/end.0" in names_of(linkage.joints)


def test_a_gap_whose_square_no_number_holds_closes_too(tmp_path):
    """A loop that its decimals leave open by 1e-200 m."""
    text, end = kinematics.gallery()["five_bar"].read_text(encoding="utf-8"), 'xyz="0.7 0.5 0"'
    assert end in text
    path = tmp_path / "open.urdf"
    path.write_text(text.replace(end, f'xyz="0.7 0.5 {1e-200:.200f}"'), encoding="utf-8")
    linkage = kinematics.load(path)
    geometry = exact_geometry(linkage)
    assert difference(linkage, geometry) < ROUND_OFF
    assert any("closed there" in notice.message for notice in geometry.notices)
