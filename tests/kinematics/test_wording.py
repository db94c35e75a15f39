"""Numbers in words: sizes of round-off are bounds, and last bits decide no digit."""

from typing import NamedTuple

import numpy as np
import pytest

from kinematics.wording import (
    check_summary,
    number_text,
    repr_lines,
    size_text,
    unit_text,
    vector_text,
)


@pytest.mark.parametrize("size", [0.0, 1e-300, 3e-17, -5e-16, 1.4e-15, 9e-13])
def test_sizes_of_round_off_are_written_as_one_bound(size):
    assert size_text(size) == "below 1e-12"


@pytest.mark.parametrize("size", [4.6e14, 1e300, np.inf])
def test_quotients_of_round_off_are_written_as_one_bound(size):
    assert size_text(size) == "above 1e+12"


def test_sizes_that_are_determined_are_written_as_numbers():
    assert size_text(2.5e-7) == "2.5e-07"
    assert size_text(1.234, ".3g") == "1.23"
    assert size_text(-3e-4) == "-3.0e-04"
    assert size_text(np.nan) == "nan"
    assert size_text(-np.inf) == "-inf"


@pytest.mark.parametrize("scale", [1e-6, 0.02, 1.0, 20.1, 99.0, 1e5])
def test_bounds_follow_the_scale_and_hold(scale):
    bound = float(size_text(1e-13 * scale, scale=scale).removeprefix("below "))
    assert 0.95e-12 * scale <= bound <= 0.95e-11 * scale
    assert size_text(2e-12 * scale, scale=scale) == f"{2e-12 * scale:.1e}"


@pytest.mark.parametrize("scale", [0.01, 1.0, 10.0])
def test_bounds_do_not_depend_on_the_last_bits_of_the_scale(scale):
    near = (np.nextafter(scale, 0.0), scale, np.nextafter(scale, 1e3))
    assert len({size_text(1e-16 * scale, scale=one) for one in near}) == 1


def test_a_size_without_a_scale_is_written_as_it_is():
    assert size_text(0.0, ".3g", 0.0) == "0"
    assert size_text(1e-20, scale=np.inf) == "1.0e-20"


def test_a_floor_of_its_own():
    assert size_text(3e-11, floor=1e-9) == "below 1e-09"
    assert size_text(3e9, floor=1e-9) == "above 1e+09"
    assert size_text(3e-8, floor=1e-9) == "3.0e-08"


@pytest.mark.parametrize("half", [0.12345, 2.5, 0.1125, 1e-3 * 1.2345])
def test_halves_are_written_alike(half):
    near = (np.nextafter(half, 0.0), half, np.nextafter(half, 10.0))
    assert len({number_text(float(x)) for x in near}) == 1
    assert len({number_text(float(x), ".1f") for x in near}) == 1


def test_numbers_beside_a_scale():
    assert number_text(-5.86e-14, ".3g", 1.0) == "0"
    assert number_text(5e-10, ".3g", 1.0, 1e-9) == "0"
    assert number_text(-5.86e-14, ".3g") == "-5.86e-14"
    assert number_text(-0.0) == "0"
    assert number_text(np.inf) == "inf"
    assert vector_text([1.0, -1e-12, 0.25]) == "(1, 0, 0.25)"


def test_the_summary_of_a_check():
    class Check(NamedTuple):
        accepted: bool
        error: float
        excluded: float
        left: float

    summary = check_summary(Check(True, 2.3e-16, 4.8e14, 0.65))
    assert summary == "Check: accepted, error below 1e-12, excluded above 1e+12, left 0.65"
    equal = check_summary(Check(False, 2.3e-16, 1e-17, 0.65))
    assert equal == "Check: not accepted, error and excluded below 1e-12, left 0.65"


@pytest.mark.parametrize(
    ("size", "text"),
    [(0.7449, "0.74"), (0.021, "0.021"), (1.0, "1.0"), (9.771e4, "98000"), (3.1e-3, "3.1e-03")],
)
def test_sizes_near_one_have_no_power_of_ten(size, text):
    assert size_text(size) == text
    assert float(text) == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize(
    ("size", "text"),
    [(9420.0, "9420 N"), (97710.0, "97.7 kN"), (-1.4712e6, "-1.47 MN"), (0.25, "0.25 N")],
)
def test_large_sizes_have_a_unit_with_a_prefix(size, text):
    assert unit_text(size, "N", ".3g") == text
    number, unit = text.split()
    factor = {"N": 1.0, "kN": 1e3, "MN": 1e6}[unit]
    assert float(number) * factor == pytest.approx(size, rel=5e-3)


def test_a_size_of_round_off_keeps_its_unit():
    assert unit_text(1e-10, "N m", ".3g", 1e5) == "below 1e-07 N m"


def test_a_verdict_is_printed_with_its_remedy_where_there_is_room():
    """The verdict goes on in further lines, and the other lines are cut."""
    verdict = f"infeasible: {'word ' * 30}; take thicker links"
    text = repr_lines("Design", verdict, "crank " * 40)
    lines = text.splitlines()
    assert lines[0] == "Design" and lines[-1].endswith(" …")
    assert " ".join(" ".join(lines[1:-1]).split()) == verdict
    assert all(len(line) <= 98 for line in lines)
    cut = repr_lines("Design", verdict, *["a", "b", "c", "d"]).splitlines()
    assert len(cut) == 6 and cut[1].endswith(" …") and cut[2:] == ["  a", "  b", "  c", "  d"]
