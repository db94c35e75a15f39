"""Numbers of a file that stand for roots, sines and cosines, and numbers that do not."""

from fractions import Fraction
from math import nextafter

import numpy as np
import pytest
from mpmath import cos, mpf, pi, sin, sqrt, workdps

from kinematics.files.urdf.read_roots import read_roots
from kinematics.model.document.element import Element
from kinematics.numerics.linalg.cyclotomic import FieldNumber


def tree_of(*vectors, rpy="0 0 0"):
    """A robot with one joint for each vector, whose origin it is."""
    return Element(
        "robot",
        {},
        tuple(
            Element("joint", {"name": f"j{k}"}, (Element("origin", {"xyz": xyz, "rpy": rpy}),))
            for k, xyz in enumerate(vectors)
        ),
    )


def origin(tree, k=0):
    """The origin of a joint."""
    return tree.children[k].children[0]


def read(tree, k=0):
    """The vector of an origin as it is read."""
    item, roots = origin(tree, k), read_roots(tree)
    words = item.attributes["xyz"].split()
    return tuple(map(Fraction, words)) if roots is None else roots.vector(item, "xyz", words)


def near(x):
    """A number of a field to 40 digits."""
    x = x.nearby if isinstance(x, FieldNumber) else x
    return mpf(x.numerator) / x.denominator


@pytest.mark.parametrize("size", ["1", "0.125", "0.0325", "3"])
@pytest.mark.parametrize(
    "value",
    [
        lambda: sqrt(3) / 2,
        lambda: sqrt(2) / 2,
        lambda: -sqrt(5),
        lambda: mpf(1) / 3,
        lambda: sqrt(mpf(2) / 3),
        lambda: cos(pi / 9),
        lambda: sin(pi / 10),
        lambda: cos(2 * pi / 7),
        lambda: mpf(1) + 2 * sqrt(3),
    ],
)
def test_roots_and_cosines_times_short_decimals_are_read(value, size):
    with workdps(40):
        exact = value() * mpf(size)
        tree = tree_of(f"{float(exact)!r} 0.01 0")
        assert abs(near(read(tree)[0]) - exact) < mpf("1e-36")


def test_a_number_that_is_a_few_units_away_is_not_read():
    word = float(np.sqrt(3) / 2)
    for _ in range(5):
        word = nextafter(word, 1)
    assert read_roots(tree_of(f"{word!r} 1 0")) is None
    assert read_roots(tree_of("0.866025403784 1 0")) is None


@pytest.mark.slow
def test_hardly_any_of_random_numbers_are_read():
    rng = np.random.default_rng(3)
    for _ in range(4):
        vectors = [" ".join(map(repr, v)) for v in rng.uniform(-1, 1, (100, 3)).tolist()]
        assert read_roots(tree_of(*vectors)) is None


def test_vectors_that_are_another_one_turned_are_read_so():
    with workdps(40):
        x, y = mpf("0.3184712345678901"), mpf("-0.1174120987654321")
        first = x, y, mpf("0.7")
        c, s = cos(2 * pi / 3), sin(2 * pi / 3)
        second = c * first[0] - s * first[1], s * first[0] + c * first[1], first[2]
        words = [" ".join(repr(float(t)) for t in v) for v in (first, second)]
        tree = tree_of(*words)
        assert read(tree) == tuple(map(Fraction, words[0].split()))
        assert all(
            abs(near(a) - b) < mpf("1e-36")
            for a, b in zip(read(tree, 1)[:2], second[:2], strict=True)
        )


def test_round_off_is_zero_and_angles_are_parts_of_a_turn():
    tree = tree_of("0.5 1.2246467991473532e-16 0", rpy=f"0 0 {2 * np.pi / 3!r}")
    roots = read_roots(tree)
    assert read(tree) == (Fraction(1, 2), 0, 0) and roots.conductor == 12
    quarter, half = roots.half_angle(2 * np.pi / 3)
    with workdps(40):
        assert quarter == 1 and abs(near(half) - (2 - sqrt(3))) < mpf("1e-36")
    assert roots.half_angle(1.0) is None
    assert {notice.code for notice in roots.notices} == {"read_as_root"}


def test_fields_of_large_degree_are_left_out():
    words = [repr(float(np.cos(2 * np.pi * 5 / N))) for N in (28, 36, 60)]
    roots = read_roots(tree_of(" ".join(words)))
    assert 0 < len(roots.numbers) < 3
