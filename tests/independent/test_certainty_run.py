"""Hard cases of certainty beside the oracle: a few of each family, and the oracle itself.

``tests/independent/certainty_run.py`` runs as many as it is told.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from tests.independent.certainty_cases import FAMILIES, certainty_case
from tests.independent.certainty_run import judge_case, main, table
from tests.independent.hard_families import add_yoke, loops_last
from tests.independent.judging import SURE
from tests.independent.plain_linkage import AXES, Joint, Linkage, Mimic, vector
from tests.independent.planar_families import ring
from tests.independent.prime_roots import prime_with_roots, root_of_fraction
from tests.independent.true_ranks import truth
from tests.support.covering import number_of_cases

HARD = ("related", "yokes", "turned", "oblique", "coupled")
# Quick ones of each family: levels, structures, numbers of digits, readings.
SAMPLE = {
    "related": (2, 6, 102, 127),
    "yokes": (4, 14, 17, 113),
    "turned": (3, 8, 131, 30057),
    "oblique": (4, 8, 106, 115),
    "coupled": (14, 17, 118, 127),
}


@pytest.mark.slow
@pytest.mark.parametrize("family", HARD)
def test_hard_cases(family, tmp_path):
    for seed in SAMPLE[family]:
        line = judge_case(family, seed, tmp_path)
        assert line["outcome"] in ("right", "irregular"), line
        assert line["outcome"] == "irregular" or line["level"] in SURE, line


def test_a_special_geometry_below_the_digits_is_no_proof(tmp_path):
    """A ball whose centre lies on the axis of a crank, up to the six digits of the file."""
    line = judge_case("turned", 30098, tmp_path)
    assert (line["code"], line["level"]) == (4, "estimated"), line


@pytest.mark.parametrize(
    ("family", "seed"),
    [
        # A Bennett linkage in exact decimals, as written.
        ("overconstrained", 40012),
        # Two pins of a dyad that coincide up to fifteen digits.
        ("oblique", 40504),
        # An arm of four joints in five digits, to which its axes have length one.
        ("turned", 40246),
        # A parallelogram of a millionth of its arm, at another pose than that of the file.
        ("small_loop", 50282),
        # Rhombuses off by a unit of the last of their few digits.
        ("coupled", 20003),
        ("coupled", 21027),
        ("coupled", 22125),
        # A rhombus in three digits, which is a kite up to fewer.
        ("turned", 21056),
    ],
)
def test_special_places_are_read(family, seed, tmp_path):
    line = judge_case(family, seed, tmp_path)
    assert line["outcome"] in ("right", "moved") and line["code"] == 0, line
    assert line["level"] in SURE, line


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "seed"),
    [
        # A ball whose centre lies on the axis of a crank, up to fourteen digits.
        ("turned", 40557),
        # The same in another file, where a long lever enlarges the condition.
        ("turned", 41320),
        # Slides of four loops, at a special pose up to nine digits.
        ("oblique", 50216),
        # Cylindrical joints, one on the axis of the crank, up to twelve digits.
        ("turned", 21337),
        # Five loops that were closed within their nine digits.
        ("oblique", 21295),
    ],
)
def test_conditions_that_floating_point_does_not_see_are_no_proof(family, seed, tmp_path):
    line = judge_case(family, seed, tmp_path)
    assert (line["code"], line["level"]) == (4, "estimated"), line


def test_decimals_that_a_tilt_of_round_off_opens_are_in_doubt_as_written(tmp_path):
    """A kite in exact decimals, one of whose axes is tilted by 1e-14: its relations hold."""
    line = judge_case("embedded", 30051, tmp_path)
    assert (line["outcome"], line["code"]) == ("right", 4), line


@pytest.mark.slow
@pytest.mark.parametrize("family", HARD)
def test_more_hard_cases(family, tmp_path, capsys):
    words = ["--count", str(number_of_cases(15, 300)), "--seed", "500", "--family", family]
    assert main(words) == 0
    share = capsys.readouterr().out.splitlines()[1].split()[6]
    assert float(share.rstrip("%")) >= 85.0


@pytest.mark.slow
def test_a_run_goes_on_with_its_table(tmp_path, capsys):
    path = tmp_path / "cases.jsonl"
    words = ["--family", "tilted_arm", "--table", str(path), "--count"]
    assert main([*words, "1"]) == 0
    first = path.read_text()
    assert main([*words, "2"]) == 0
    second = path.read_text()
    assert second.startswith(first) and len(second.splitlines()) == 2
    assert main([*words, "2"]) == 0 and path.read_text() == second
    assert "tilted_arm" in capsys.readouterr().out


def test_the_table_counts_what_is_wrong():
    common = {"family": "grid", "seconds": [1, 2], "detail": "", "note": ""}
    lines = [
        common | {"outcome": outcome, "level": level, "code": code}
        for outcome, level, code in (
            ("right", "proved", 0),
            ("right", "estimated", 0),
            ("wrong", "verified", 0),
            ("wrong", "estimated", 0),
            ("wrong", "estimated", 4),
            ("irregular", "", 3),
            ("crash", "", 70),
        )
    ]
    row = table(lines)[1].split()
    assert row == ["grid", "7", "5", "2", "1", "0", "20.0%", "1", "1", "1", "1", "0", "1", "21"]


def test_cases_are_the_same_each_time():
    for family in FAMILIES:
        assert certainty_case(family, 3) == certainty_case(family, 3)
        assert certainty_case(family, 3).text != certainty_case(family, 4).text


def test_roots_modulo_a_prime_are_of_one_field():
    squares = [Fraction(x) for x in ("2", "3", "8", "6", "0.5", "18/25", "1000003")]
    p = prime_with_roots(squares, 998244353)
    roots = [root_of_fraction(x, p) for x in squares]
    for square, root in zip(squares, roots, strict=True):
        assert (root * root * square.denominator - square.numerator) % p == 0
    two, three, eight, six, half = roots[:5]
    assert (eight, six, half * 2 % p) == (2 * two % p, two * three % p, two)


def test_relations_between_axes_of_irrational_ratio():
    """The figures are those of a program that shares no code with this oracle."""
    kite = [vector(*p, 0) for p in ((0, 0), ("0.500000000001", "1.2"), (2, 0), ("0.5", "-1.2"))]
    arm = Joint("R", 0, 4, vector("0.5", "-0.8", "0.3"), vector(1, 1, 0))
    joints, mimics = loops_last([*ring(kite), arm], [Mimic(4, 0, Fraction(1))])
    true = truth(Linkage(joints, mimics, spatial=True))
    assert (true.ranks, true.serial, true.parallel) == ((6, 12, 15, 17), 22, 1)


def test_a_motion_between_axes_of_irrational_ratio():
    """Two yokes of 1 mm, and two joints that turn alike."""
    joints, mimics = [Joint("R", 0, 1, vector(0, 0, 0))], []
    pin, x = vector("0.001", 0, 0), vector(1)[0]
    first = add_yoke(joints, mimics, 0, x, vector(0, 0, 0), pin, False)
    add_yoke(joints, mimics, first, x, vector(0, 3, 0), pin, False)
    # The first crank is the source itself: the yoke hangs on a copy that follows it.
    links = max(joint.after for joint in joints)
    joints += [
        Joint("R", 0, links + 1, vector(5, -2, 1), AXES[2]),
        Joint("R", links + 1, links + 2, vector(6, -3, 2), vector(1, 1, 1)),
    ]
    bare = tuple(k for k in range(2, links + 1) if k != 6)
    names = [f"j{k}" for k in (0, 7, 8)]
    linkage = Linkage(
        *loops_last(joints, mimics),
        bare=bare,
        spatial=True,
        inputs=tuple(names),
        relations=(vector(0, 1, -1),),
    )
    assert truth(linkage, orders=40).ranks == (11, 15, 16, 19)
