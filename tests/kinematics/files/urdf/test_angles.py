"""Angles that look rounded: which ones, where, how they are read, and exact arithmetic."""

import math
import re

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import kinematics
from balance import design_space
from kinematics.errors import LinkageError
from kinematics.files.urdf.nominal_angles import nearest_twelfth
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.files.urdf.rounded_angles import (
    find_rounded_angles,
    replace_rounded_angles,
)
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.loading.model_gallery import robots
from tests.support.chains import jointed, robot, written
from tests.support.urdf_text import INERTIAL

RIGHT = "1.5707963267948966"

ROUNDED = {
    "1.5708": 6, "-1.5708": -6, "+1.5708": 6, "1.570800": 6, "1.57080e0": 6, "15708e-4": 6,
    "0.15708E+1": 6, "1.5707": 6, "1.57079": 6, "1.570795": 6, "1.570796325": 6,
    "1.5707963705062866": 6, "-1.570796251296997": -6, "3.1416": 12, "3.14159": 12,
    "3.1415": 12, "0.7854": 3, "-.7853": -3, "1.0472": 4, "2.0944": 8, "0.5236": 2,
    "0.2618": 1, "1.309": 5, "2.35619": 9, "4.71239": 18, "6.2832": 24, "-6.28319": -24,
    "7.85398": 30, "314.1593": 1200,
    # Two and three decimals.
    "1.57": 6, "-1.570": -6, "1.571": 6, "3.14": 12, "3.141": 12, "3.142": 12, "-4.71": -18,
    "6.28": 24, "0.785": 3, "1.047": 4, "0.524": 2, 
    # π, π/2 and π/180 rounded or cut off, times a number.
    "1.57075": 6, "-1.57075": -6, "1.5705": 6, "0.785375": 3, "2.09433333333": 8,
    "1.0466666666666666": 4, "0.7855": 3, "3.14158": 12, "-3.14158": -12, "1.57077": 6,
    "1.570797": 6, "0.78525": 3,
    # Single precision.
    "1.5707964": 6, "1.57079637": 6, "3.1415927410125732": 12, "0.52359879": 2,
}  # fmt: skip
# Written to all digits, or to as many as the closure of a loop can tell.
FULL = {
    RIGHT: 6,
    "1.570796326794897": 6,
    "-1.5707963267949": -6,
    "1.57079632679": 6,
    "3.14159265358979": 12,
    "3.141592653589793116": 12,
    "1.0471975511965976": 4,
    "6.283185307179586": 24,
    "0.523598775598": 2,
}
OTHER = [
    "0", "-0.0", "0.0001", "1e-5", "-1.2246E-16", "1e-400", "1.5", "0.26", "0.79", "1.05",
    "1.572", "1.569", "1.56", "1.58", "0.787", "1.5709", "1.5706", "1.570828", "1.57074",
    "3.14153", "1.0471e1", "0.1", "1.6", "3.1", "-1.5707963267272802", "1.570796371123",
    "1e30", "15707963.267948966", "1.5708" + "0" * 500, "1e" + "0" * 5000,
]  # fmt: skip


@pytest.mark.parametrize("word", [*ROUNDED, *FULL, *OTHER], ids=lambda word: word[:24])
def test_what_stands_for_a_multiple(word):
    assert nearest_twelfth(word) == (ROUNDED | FULL).get(word, 0)


@given(st.integers(-60, 60).filter(bool), st.integers(4, 17), st.booleans())
def test_multiples_are_known_by_any_number_of_digits(k, places, cut):
    """Rounded or cut off to four decimals or more, from 50 digits."""
    with mpmath.workdps(50):
        scaled = k * mpmath.pi / 12 * 10**places
        digits = int(scaled) if cut else int(mpmath.nint(scaled))
    word = f"{'-' * (digits < 0)}{abs(digits):0{places + 1}d}"
    few = places - (len(word) - len(word.rstrip("0")))
    assume(few >= 4 or (few == 3 and abs(k) <= 24))
    assert nearest_twelfth(f"{word[:-places]}.{word[-places:]}") == k


def shortened(value, places):
    """A positive number to so many decimals: rounded, and cut off."""
    scaled = value * mpmath.mpf(10) ** places + mpmath.mpf(10) ** -30
    return {f"{int(mpmath.nint(scaled)):0{places + 1}d}", f"{int(scaled):0{places + 1}d}"}


def point(digits, places):
    """A number from its digits."""
    return f"{digits[:-places]}.{digits[-places:]}"


def written_by_people(k, places):
    """The decimals of so many places that are an angle, or a product of a rounded constant."""
    found = shortened(k * mpmath.pi / 12, places)
    for constant, least in ((mpmath.pi, 2), (mpmath.pi / 2, 2), (mpmath.pi / 180, 5)):
        times = k * mpmath.pi / 12 / constant
        if constant != mpmath.pi and abs(times - mpmath.nint(times)) > 1e-30:
            continue
        for digits in range(least, 17):
            for word in shortened(constant, digits):
                scaled = times * mpmath.mpf(word) * mpmath.mpf(10) ** (places - digits)
                if digits <= places:
                    found |= shortened(scaled / mpmath.mpf(10) ** places, places)
                elif abs(scaled - mpmath.nint(scaled)) < 1e-20:
                    found.add(f"{int(mpmath.nint(scaled)):0{places + 1}d}")
    return {point(word, places) for word in found}


# Every angle of the robots of example-robot-data that is within 5e-3, but not 1e-11, of a
# multiple of π/12 other than 0.
PUBLISHED = """
0.2618 -0.5235988 0.5235988 -0.785 -0.7854 0.7854 -1.0510016535897932 1.308458 -1.309 1.309 1.57
-1.57 1.57079 1.570796 -1.570796 1.570796325 -1.570796325 -1.5707963259 1.5707963259
-1.570796327 -1.57079633 1.5708 -1.5708 1.571 -2.090591 2.8782 3.14 3.14036612 -3.14036612
3.14148426 3.1415 3.14158 -3.14159 3.14159 -3.141592 3.141592 3.1415926 -3.14159265
3.1415926518 3.1416 -3.1416 3.142 4.71239
"""


@pytest.mark.parametrize("word", PUBLISHED.split())
def test_angles_of_public_robots(word):
    """Against all ways to write the nearest multiple, by mpmath."""
    k = round(float(word) * 12 / math.pi)
    places = len(word.partition(".")[2].rstrip("0"))
    with mpmath.workdps(50):
        known = word.lstrip("-").rstrip("0") in {
            text.rstrip("0") for text in written_by_people(abs(k), places)
        }
    assert nearest_twelfth(word) == (k if known else 0)


def test_the_published_angles_are_those_of_the_package():
    """So that a new robot there is looked at."""
    if not (paths := robots()):
        pytest.skip("example-robot-data is not installed")
    found = set()
    for path in paths.values():
        for text in re.findall(r'rpy="([^"$]*)"', path.read_text("utf-8", "ignore")):
            found |= set(text.split())
    multiples = {word: round(float(word) * 12 / math.pi) for word in found}
    off = {word: abs(float(word) - k * math.pi / 12) for word, k in multiples.items() if k}
    assert len(found) > 200
    near = {word for word, e in off.items() if 1e-11 < e < 5e-3}
    assert len(near) > 30 and near <= set(PUBLISHED.split())


@pytest.mark.table(4)
@pytest.mark.parametrize("k", [1, 2, 3, 4, 6, 8, 12, 15, 18, 24])
def test_every_way_to_write_a_multiple_is_known(k):
    """With four decimals and more; with fewer, as the module says."""
    for places in range(2, 9):
        with mpmath.workdps(50):
            words = written_by_people(k, places)
        for word in words:
            few = len(word.partition(".")[2].rstrip("0"))
            if few >= 3 or (few == 2 and k % 6 == 0):
                assert nearest_twelfth(word) == k and nearest_twelfth(f"-{word}") == -k, word


@given(st.integers(-60, 60).filter(bool), st.floats(2e-6, 9e-5), st.sampled_from([-1, 1]))
def test_calibrated_angles_are_not_rounded_ones(k, off, sign):
    """Digits that go on beyond those in which an angle differs are meant."""
    word = f"{k * math.pi / 12 + sign * off:.12f}"
    assert nearest_twelfth(word) == (k if len(word.rstrip("0").partition(".")[2]) < 7 else 0)


EVERYWHERE = robot(
    '<link name="a"><inertial><origin rpy="0 3.1416 0"/></inertial>'
    '<visual><origin rpy="1.5708 0 0"/></visual></link>',
    '<joint name="j" type="revolute"><origin xyz="1.5708 0 0" rpy=" 1.5708 0  0.5 "/>'
    '<axis xyz="1.5708 0 0"/><mimic joint="k" multiplier="1.5708" offset="0.7854"/></joint>',
    '<joint name="k" type="prismatic"><mimic joint="l" offset="1.5708"/></joint>',
    '<joint name="f" type="fixed"><origin rpy="1.5707963267949 0 0"/>'
    '<mimic joint="l" offset="1.5708"/></joint>',
    '<loop name="c"><predecessor link="a"><origin rpy="1.0472 0 0"/></predecessor>'
    '<successor link="l0"><origin rpy="0 0 -1.5708"/></successor></loop>',
    '<transmission><origin rpy="1.5708 0 0"/></transmission>',
)


def test_angles_are_looked_for_where_the_reader_uses_them():
    tree = build_tree(EVERYWHERE.encode())
    found = [
        (r.label.partition(" (")[0], r.attribute, r.word) for r in find_rounded_angles(tree)
    ]
    assert found == [
        ("link 'a'", "rpy", "3.1416"),
        ("joint 'j'", "rpy", "1.5708"),
        ("joint 'j'", "offset", "0.7854"),
        ("loop 'c'", "rpy", "1.0472"),
        ("loop 'c'", "rpy", "-1.5708"),
    ]


def test_only_those_angles_are_replaced():
    """And to the nearest double, those of twelve digits too; the rest of the tree is kept."""
    tree = build_tree(EVERYWHERE.encode())
    full = {
        "0 3.1416 0": "0 3.141592653589793 0",
        ' rpy=" 1.5708 0  0.5 "': f' rpy="{RIGHT} 0 0.5"',
        'offset="0.7854"': 'offset="0.7853981633974483"',
        "1.5707963267949 ": f"{RIGHT} ",
        "1.0472": "1.0471975511965979",
        "0 0 -1.5708": f"0 0 -{RIGHT}",
    }
    text = EVERYWHERE
    for old, new in full.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    changed = replace_rounded_angles(tree)
    assert changed == build_tree(text.encode())
    assert find_rounded_angles(changed) == []
    assert replace_rounded_angles(changed) is changed


def test_nominal_is_what_all_digits_give(tmp_path):
    """To the last bit; as written, the axes are those of the digits."""
    rpys = ["1.5708 0 -0.7854", "0.2618 1.5708 0.3", "0 0.123 2.0944"]
    short = written(tmp_path, robot(*(jointed(i, rpy) for i, rpy in enumerate(rpys, 1))))
    full = [
        "1.5707963267948966 0 -0.7853981633974483",
        "0.2617993877991494 1.5707963267948966 0.3",
        "0 0.123 2.0943951023931953",
    ]
    long = written(tmp_path, robot(*(jointed(i, rpy) for i, rpy in enumerate(full, 1))), "full")
    expected, found = kinematics.load(long), kinematics.load(short)
    assert [n.code for n in found.notices] == ["rounded_angles"] and not expected.notices
    for mine, its in zip(found.joints, expected.joints, strict=True):
        assert np.array_equal(mine.screw, its.screw)
    for mine, its in zip(found.bodies, expected.bodies, strict=True):
        assert np.array_equal(mine.inertia, its.inertia)
    turned = Rotation.identity()
    for literal, rpy in zip(
        kinematics.load(short, angles="as_written").joints, rpys, strict=True
    ):
        turned = turned * Rotation.from_euler("xyz", [float(x) for x in rpy.split()])
        assert np.abs(literal.screw[:3] - turned.apply([0, 0, 1])).max() < 1e-15


def test_the_notice_says_which_where_and_how_they_are_read(tmp_path):
    path = written(tmp_path, robot(*(jointed(i, "1.5708 0 0") for i in range(1, 6))))
    (notice,) = kinematics.load(path).notices
    assert notice.code == "rounded_angles"
    assert notice.message == (
        f"{path}: 5 angles look rounded, read as multiples of π/12, the default: 1.5708 in rpy "
        "of joint 'j1' (line 1), 1.5708 in rpy of joint 'j2' (line 1), 1.5708 in rpy of joint "
        "'j3' (line 1) and 2 more; write all 16 digits, or choose --as-written "
        "(angles='as_written')"
    )
    (notice,) = kinematics.load(path, angles="as_written").notices
    assert "5 angles look rounded, taken as written: 1.5708 in rpy" in notice.message
    assert notice.message.endswith("or choose --nominal (angles='nominal')")
    with pytest.raises(LinkageError, match="angles 'exact' unknown; choose from nominal, as_w"):
        kinematics.load(path, angles="exact")


@pytest.mark.parametrize("word", ["1.5707963267948966", "1.57079632679", "1.56", "0.3"])
def test_other_angles_give_no_notice(word, tmp_path):
    path = written(tmp_path, robot(jointed(1, f"{word} 0 0")))
    for reading in ("nominal", "as_written"):
        assert kinematics.load(path, angles=reading).notices == ()


@pytest.mark.parametrize("rpy", ["1.5708 0 0", "0 3.1416 0", "0 4.714 0", "0 0 -1.57079632679"])
def test_right_angles_that_are_meant_are_exact(rpy, tmp_path):
    """Axes are whole numbers in exact arithmetic, which says what it took the angles for."""
    path = written(tmp_path, robot(*(jointed(i, rpy) for i in range(1, 5))))
    found = exact_geometry(kinematics.load(path))
    whole = all(x.denominator == 1 for screw in found.screws for x in screw[:3])
    assert whole == ("4.714" not in rpy)
    assert [notice.code for notice in found.notices] == ["not_exact"] * 4
    assert all(("π/2" in notice.message) == whole for notice in found.notices)


def test_opposite_multiples_cancel_in_exact_arithmetic(tmp_path):
    """π/3 and 2π/3 have no rational rotations, but those used for them make half a turn."""
    path = written(tmp_path, robot(jointed(1, "1.0472 0 0"), jointed(2, "2.0944 0 0")))
    found = exact_geometry(kinematics.load(path))
    assert tuple(found.screws[1][:3]) == (0, 0, -1)
    assert "taken as 4 π/12, has no rational rotation" in found.notices[0].message
    n = found.screws[0][:3]
    with mpmath.workprec(200):
        for x, y in zip(n[1:], (-mpmath.sqrt(3) / 2, mpmath.mpf(1) / 2), strict=True):
            assert abs(mpmath.mpf(x.numerator) / x.denominator - y) < mpmath.mpf(2) ** -62


def test_exact_arithmetic_reads_what_the_linkage_reads(tmp_path):
    """The digits as written are a rotation of their own."""
    path = written(tmp_path, robot(jointed(1, "1.5708 0 0")))
    found = exact_geometry(kinematics.load(path, angles="as_written"))
    x = found.screws[0][2]
    with mpmath.workprec(200):
        literal = mpmath.cos(mpmath.mpf("1.5708"))
        assert abs(mpmath.mpf(x.numerator) / x.denominator - literal) < mpmath.mpf(2) ** -62


@pytest.mark.parametrize("noise", ["-1.2246E-16", "6.1232339957367660359e-17"])
def test_noise_in_place_of_zero_is_zero_to_exact_arithmetic(noise, tmp_path):
    path = written(tmp_path, robot(jointed(1, f"1.5708 {noise} 0")))
    linkage = kinematics.load(path)
    assert tuple(exact_geometry(linkage).screws[0][:3]) == (0, -1, 0)
    assert "origin_noise" in {notice.code for notice in linkage.notices}


def test_offsets_of_turning_mimic_joints_are_angles(tmp_path):
    """Half a turn by two offsets of a quarter, one of them through another mimic joint."""
    follow = '<mimic joint="j{}" multiplier="{}" offset="{}"/>'.format
    parts = [
        jointed(1, "0 0 0"),
        jointed(2, "0 0 0", follow(1, 2, "1.5708"), axis="1 0 0"),
        jointed(3, "0 0 0", follow(2, 2, "0.25"), axis="1 0 0", kind="revolute"),
        jointed(4, "0 0 0", follow(1, 1, "1.5708"), kind="prismatic", axis="1 0 0"),
        jointed(5, "0 0 0"),
    ]
    path = written(tmp_path, robot(*parts))
    linkage = kinematics.load(path)
    assert "1 angle looks rounded" in linkage.notices[0].message
    half = 3 * math.pi / 2 + 0.25
    assert linkage.joints[4].screw[:3] == pytest.approx([0, -math.sin(half), math.cos(half)])
    along = linkage.joints[4].point[0]
    assert along == pytest.approx(5 * 0.3 + 1.5708, abs=1e-15)
    exact = exact_geometry(linkage)
    assert float(exact.screws[2][2]) == 0.0 and exact.screws[4][2] != 0
    literal = kinematics.load(path, angles="as_written")
    half = 3 * 1.5708 + 0.25
    assert literal.joints[4].screw[:3] == pytest.approx([0, -math.sin(half), math.cos(half)])


def test_rounded_frames_of_inertia_count_for_the_masses_given(tmp_path):
    """Two discs turn against each other; one has its axes in a frame that is turned."""
    inertial = (
        '<inertial><origin rpy="1.5708 0 0"/><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>'
    )
    counter = inertial.replace('rpy="1.5708 0 0"', 'rpy="0 0 0"').replace(
        'iyy="2" iyz="0" izz="3"', 'iyy="3" iyz="0" izz="2"'
    )
    more = '<mimic joint="j1" multiplier="-1"/>'
    parts = [
        jointed(1, "0 0 0").replace(INERTIAL, inertial),
        jointed(2, "0 0 0", more)
        .replace(INERTIAL, counter)
        .replace('"l1"/><child', '"l0"/><child'),
    ]
    path = written(tmp_path, robot(*parts))
    for reading, balanced in (("nominal", True), ("as_written", False)):
        linkage = kinematics.load(path, angles=reading)
        assert "1 angle looks rounded" in linkage.notices[0].message
        found = design_space(linkage, spatial=True)
        assert found.as_given.balanced == balanced


def test_constants_have_as_many_digits_as_the_angles_of_a_file():
    """1.8328 is 3.142 × 7/12 by hand, and 1.83280 where all angles have six digits."""
    general = ("0.328233 0.993624 0.594238", "-0.796607 0.115709 -2.60842")
    hand = "<robot>{}</robot>"
    for words, count in ((("1.8328 0 0",), 1), (("1.8328 0 1.5708", *general), 1)):
        origins = "".join(
            f'<joint name="j{k}"><origin rpy="{word}"/></joint>' for k, word in enumerate(words)
        )
        found = find_rounded_angles(build_tree(hand.format(origins).encode()))
        assert len(found) == count
        assert (found[0].word == "1.8328") == (len(words) == 1)
