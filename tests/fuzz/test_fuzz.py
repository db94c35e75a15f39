"""Mutants of the gallery: refused in one line, or read as the standard library reads them.

More of them: ``python -m tests.fuzz.fuzz --cases 100000``; a thousand with ``ALL_CASES=1``.
"""

import resource
from pathlib import Path

import pytest

from kinematics import gallery
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.read_options import ReadOptions
from tests.fuzz.fuzz import run, written
from tests.fuzz.mutants import mutant
from tests.independent.second_reading import read
from tests.independent.second_words import Strange
from tests.support.comparison import compare
from tests.support.covering import number_of_cases
from tests.support.time_limit import Hang, time_limit

CASES = number_of_cases(250, 1000)
EXACT = ReadOptions(angles="as_written")


@pytest.mark.slow
def test_no_mutant_is_misread(tmp_path):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    *_, tally = run(range(CASES), tmp_path)
    assert not tally.found, "\n".join(tally.found)
    assert sum(tally.counts.values()) == CASES
    # The mutants are bad in many ways, and good often enough.
    assert tally.counts["refused by the reader"] < 0.75 * CASES
    assert tally.counts["refused after reading"] > 0.02 * CASES
    assert (
        tally.counts["linkage"] > 0.15 * CASES and tally.counts["design space"] > 0.005 * CASES
    )
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 400 * 1024


def test_a_seed_is_one_case():
    assert mutant(7) == mutant(7) and mutant(7).urdf != mutant(8).urdf
    assert len({mutant(seed).urdf for seed in range(200)}) > 190


@pytest.mark.table
@pytest.mark.parametrize("name", sorted(gallery()))
def test_the_gallery_itself(name):
    compare(
        read_unassembled(gallery()[name], options=EXACT), read(gallery()[name].read_bytes())
    )


# What the second reading must notice: text replaced, and its replacement, of the Bennett.
WRONG = {
    "axis": ('<axis xyz="-0.36 ', '<axis xyz="-0.3600001 '),
    "position": ('<origin xyz="-0.2 ', '<origin xyz="-0.2000001 '),
    "angle": ('xyz="-0.3 0.5 -0.3" rpy="0 ', 'xyz="-0.3 0.5 -0.3" rpy="1e-7 '),
    "weld": ('<origin xyz="-0.7 ', '<origin xyz="-0.7000001 '),
    "mass": ('<mass value="', '<mass value="1'),
    "inertia": ('ixx="', 'ixx="1'),
    "type": ('type="continuous"', 'type="prismatic"'),
    "input": (' independent="true"', ""),
    "loop": ('<loop name="', '<loop name="x'),
}


@pytest.mark.parametrize("case", WRONG)
def test_the_comparison_sees_a_difference(case):
    """One file read by the product, another by the second reader."""
    text = gallery()["bennett"].read_text(encoding="utf-8")
    old, new = WRONG[case]
    changed = text.replace(old, new, 1)
    assert changed != text
    draft = read_unassembled(gallery()["bennett"], options=EXACT)
    compare(draft, read(text.encode()))
    with pytest.raises(AssertionError):
        compare(draft, read(changed.encode()))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<axis ", "<Axis "),
        ("<origin ", "<orgin "),
        ("xyz=", "xzy="),
        ("<loop ", "<lop "),
        ("</robot>", "<joint/></robot>"),
        ("<robot", "<robots"),
    ],
)
def test_the_second_reader_is_strict(old, new):
    text = gallery()["bennett"].read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(Strange):
        read(text.replace(old, new).encode())


def test_a_hang_ends():
    with pytest.raises(Hang), time_limit(0.05):
        while True:
            pass


def test_files_of_a_case(tmp_path):
    cases = [mutant(seed) for seed in range(60)]
    beside = next(case for case in cases if case.yaml is not None)
    plain = next(case for case in cases if case.yaml is None)
    path = written(beside, Path(tmp_path))
    assert path.with_suffix(".yaml").read_bytes() == beside.yaml
    assert written(plain, tmp_path).read_bytes() == plain.urdf
    assert not path.with_suffix(".yaml").exists()


def test_an_origin_repeated_with_its_numbers_is_one_for_both_readers(tmp_path):
    text = gallery()["bennett"].read_text(encoding="utf-8")
    origin = '<origin xyz="-0.3 0.5 -0.3"'
    (line,) = [each for each in text.splitlines() if origin in each]
    path = tmp_path / "robot.urdf"
    path.write_text(text.replace(line, f"{line}\n{line}"), encoding="utf-8")
    draft = read_unassembled(path, options=EXACT)
    assert "oddities" in {notice.code for notice in draft.notices}
    compare(draft, read(path.read_bytes()))
    with pytest.raises(Strange, match="twice"):
        read(text.replace(line, f"{line}\n{line.replace('0.5', '0.6')}").encode())
