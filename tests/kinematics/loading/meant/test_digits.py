"""Intervals of the numbers of a file, by its digits."""

from math import ulp

import pytest

from kinematics.loading.meant.digits import FileDigits, file_digits
from kinematics.model.document.element import Element


def tree(*words):
    """The tree of a file with one joint whose origin has these words."""
    origin = Element("origin", {"xyz": " ".join(words)})
    return Element("robot", {}, (Element("joint", {"name": "j"}, (origin,)),))


@pytest.mark.parametrize(
    ("words", "word", "half"),
    [
        # Six decimals: half a unit of the sixth, however large the number is.
        (("12.345678", "0.001235", "-1.523461"), "12.345678", 5e-7),
        (("12.345678", "0.001235", "-1.523461"), "0.001235", 5e-7),
        # Six significant digits: half a unit of the sixth of each number.
        (("12.3457", "0.00123457", "0.412345"), "12.3457", 5e-5),
        (("12.3457", "0.00123457", "0.412345"), "0.00123457", 5e-9),
        # Zeros at the end that a writer left out; too many of them are no rounding.
        (("12.345678", "1.56783", "0"), "1.56783", 5e-7),
        (("12.345678", "1.5", "0"), "1.5", 0.0),
        (("12.345678", "1.5", "0"), "0", 0.0),
        # Where many are short, they are design values.
        (("12.345678", "1.5679", "0"), "1.5679", 0.0),
        # Short but for the last digits: off on purpose; with more digits, by round-off.
        (("1.234567890123", "0.500000000001", "0.699999999997"), "0.500000000001", 0.0),
        (("1.234567890123", "0.500000000001", "0.699999999997"), "0.699999999997", 0.0),
        (("0.1234567890123457", "0.30000000000000004", "0"), "0.30000000000000004", ulp(0.3)),
        # Fewer zeros suffice beside design values, and not beside rounded numbers.
        (("8.1500001", "1.5", "2.7"), "8.1500001", 0.0),
        (("10.99999", "8.79999", "2.7", "1.8"), "8.79999", 0.0),
        (("10.99999", "8.79997", "2.7", "1.8"), "8.79997", 0.0),
        (("10.99999", "11.55999", "2.7", "1.8"), "11.55999", 0.0),
        (("10.99999", "8.79134", "2.7", "1.8"), "8.79134", 5e-6),
        (("8.1500001", "1.5372914", "2.7415926"), "8.1500001", 5e-8),
        # So coarse that no length is rounded so.
        (("100002.2", "0.3", "1.7"), "0.3", 0.0),
        # A double and its neighbours.
        (("0.8660254037844386", "0", "0"), "0.8660254037844386", ulp(0.8660254037844386)),
    ],
)
def test_a_number_stands_for_half_a_unit_of_the_last_digit_of_its_file(words, word, half):
    digits = file_digits(tree(*words))
    assert digits is not None
    assert digits.half_unit(word) == pytest.approx(half, rel=1e-6)


def test_short_numbers_are_exact():
    assert file_digits(tree("0.3", "1.25", "12345")) is None


@pytest.mark.parametrize(
    ("axis", "rounded"),
    [
        ("0.707 0.707 0", True),
        ("-0.57735 0.57735 0.57735", True),
        ("0.6 -0.8 0", False),
        ("0.28 0 0.96", False),
        ("0 1 1", False),
        ("0.25 0.5 0.125", False),
        ("0.7 0.7 0", False),
    ],
)
def test_an_axis_of_length_one_to_its_digits_shows_rounding(axis, rounded):
    element = Element("joint", {"name": "j"}, (Element("axis", {"xyz": axis}, ()),))
    digits = file_digits(Element("robot", {}, (element,)))
    assert (digits is not None) == rounded


def test_digits_are_counted_without_signs_points_and_exponents():
    assert file_digits(tree("-1.23457e-3", "0", "0")) == FileDigits(8, 6, size=0.00123457)
