"""Relations between inputs are read as written, and their solutions solve them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space

from kinematics import Motion
from kinematics.errors import MotionError
from tests.support.laws import outside


def rows_solved(relations, inputs, rows):
    """The motion has the null space of ``rows`` as its displacements."""
    motion = Motion.parse(relations, inputs)
    expected = null_space(np.array(rows, float)) if len(rows) else np.eye(len(inputs))
    assert motion.inputs == tuple(inputs) and motion.relations == tuple(relations)
    assert motion.basis.shape == expected.shape
    assert outside(motion.basis, expected) < 1e-12
    assert outside(expected, motion.basis) < 1e-12
    return motion


@pytest.mark.parametrize(
    ("relation", "row"),
    [
        ("j4=j7", (0, 1, -1)),
        ("  j4 =\tj7 ", (0, 1, -1)),
        ("j4=-2*j7", (0, 1, 2)),
        ("j4 = - 2 * j7", (0, 1, 2)),
        ("j3=0", (1, 0, 0)),
        ("0=j3", (1, 0, 0)),
        ("j3=0.0", (1, 0, 0)),
        ("-j3=+0", (1, 0, 0)),
        ("j3=-j4-j7", (1, 1, 1)),
        ("j3+j4=j7", (1, 1, -1)),
        ("+j3 - j4 = 3*j7 + j3", (0, -1, -3)),
        ("j3+j3+j4=0", (2, 1, 0)),
        ("1.5e-3*j3=2.E+1*j4", (1.5e-3, -20, 0)),
        (".25*j3=1e2*j7", (0.25, 0, -100)),
    ],
)
def test_a_relation_is_read_as_written(relation, row):
    rows_solved([relation], ("j3", "j4", "j7"), [row])


def test_no_relation_leaves_everything_free():
    motion = rows_solved([], ("a", "b"), [])
    assert np.array_equal(motion.basis, np.eye(2))
    assert np.array_equal(Motion.free(["a", "b"]).basis, np.eye(2))
    rows_solved(["a=a"], ("a", "b"), [(0, 0)])
    rows_solved(["0=0"], ("a", "b"), [(0, 0)])


def test_repeated_relations_count_once():
    rows_solved(["a=b", "b=a", "2*a-2*b=0"], ("a", "b", "c"), [(1, -1, 0)])
    rows_solved(["a=b", "b=c", "c=a"], ("a", "b", "c"), [(1, -1, 0), (0, 1, -1)])


@pytest.mark.parametrize("factor", ["1e6", "1e-6", "1e13", "1e-13"])
def test_relations_may_be_multiplied_by_a_number(factor):
    """A relation means the same in any unit, and says the same thing twice when repeated."""
    relation = f"{factor}*a={3 * float(factor)!r}*b"
    rows_solved([relation], ("a", "b", "c"), [(1, -3, 0)])
    rows_solved(["0.1*a=0.3*b", relation], ("a", "b", "c"), [(1, -3, 0)])


NAMES = ("leg", "leg1", "leg1.0", "leg1.1", "leg-1", "leg-1-x", "1", "2nd_joint", "e5", "x/y")


@pytest.mark.parametrize("name", NAMES)
def test_names_are_read_whole(name):
    """Names hold digits, dots and dashes, and one may be the beginning of another."""
    row = np.array([other == name for other in NAMES], float)
    rows_solved([f"{name}=0"], NAMES, [row])
    rows_solved([f"-3*{name}=0"], NAMES, [row])
    other = NAMES[(NAMES.index(name) + 1) % len(NAMES)]
    both = row - 2.5 * np.array([each == other for each in NAMES])
    rows_solved([f"{name} = 2.5*{other}"], NAMES, [both])
    rows_solved([f"-{name} + 2.5 * {other}=0"], NAMES, [both])


@pytest.mark.parametrize(
    ("relations", "inputs"),
    [
        (["a=b", "a=-b"], ("a", "b")),
        (["a=0"], ("a",)),
        (["a=b", "b=2*c", "c=a"], ("a", "b", "c")),
        (["a=2*a"], ("a",)),
    ],
)
def test_contradictions_leave_nothing_to_move(relations, inputs):
    with pytest.raises(MotionError) as caught:
        Motion.parse(relations, inputs)
    text = str(caught.value)
    assert all(relation in text for relation in relations)
    assert "leaves no input to move" in text and caught.value.valid == inputs


@pytest.mark.parametrize(
    ("relation", "unknown"),
    [
        ("j4=j8", "j8"),
        ("j40=j4", "j40"),
        ("j4=-2*elbow", "elbow"),
        ("j4.0=0", "j4.0"),
        ("j4+knee-1=j7", "knee-1"),
        ("j4=nan*j7", "nan"),
        ("j4=inf", "inf"),
    ],
)
def test_unknown_names_are_named(relation, unknown):
    with pytest.raises(MotionError) as caught:
        Motion.parse(["j4=j7", relation], ("j4", "j7"))
    error = caught.value
    assert error.relation == relation and error.valid == ("j4", "j7")
    assert f"'{unknown}' is not an input" in str(error)
    assert "the inputs are j4, j7" in str(error)


@pytest.mark.parametrize(
    "relation",
    ["", "j4", "j4=", "=j4", "=", "j4==j7", "j4=j7=0", "j4=1", "j4=2", "j4=j7+1", "j4=2*",
     "j4=*j7", "j4=2**j7", "j4=2 j7", "j4 j7=0", "j4=j7*2", "j4=2/3*j7", "j4=(j7)", "j4=--j7",
     "j4=j7+", "j4=1,5*j7", "j4=0*0", "j4=sin(j7)", "j4<j7", "j4=1e*j7", "j4=1e999*j7"],
)  # fmt: skip
def test_malformed_relations_are_refused(relation):
    with pytest.raises(MotionError) as caught:
        Motion.parse([relation], ("j4", "j7"))
    text = str(caught.value)
    assert f"motion '{relation}'" in text and "j4, j7" in text and "\n" not in text


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.data())
def test_the_basis_solves_the_relations(data):
    """Small integers and eighths: exact in floating point, so the rank is not in doubt."""
    n = data.draw(st.integers(1, 6))
    eighths = st.lists(st.integers(-9, 9), min_size=n, max_size=n)
    rows = np.array(data.draw(st.lists(eighths, max_size=4)), float).reshape(-1, n) / 8
    inputs = [f"j{i}" for i in range(n)]
    relations = [
        "".join(f"{x:+}*{name}" for x, name in zip(row, inputs, strict=True)) + "=0"
        for row in rows
    ]
    expected = null_space(rows) if len(rows) else np.eye(n)
    if expected.shape[1] == 0:
        with pytest.raises(MotionError):
            Motion.parse(relations, inputs)
        return
    motion = rows_solved(relations, inputs, rows)
    assert np.abs(rows @ motion.basis).max(initial=0.0) < 1e-12
    assert not motion.basis.flags.writeable


def test_sides_may_be_exchanged():
    rng = np.random.default_rng(30)
    inputs = ("a", "b", "c", "d")
    for _ in range(20):
        left, right = rng.integers(-5, 6, (2, 4))
        sides = [
            " ".join(f"{'+-'[int(x < 0)]} {abs(x)}*{n}" for x, n in zip(s, inputs, strict=True))
            for s in (left, right)
        ]
        rows_solved([" = ".join(sides)], inputs, [left - right])
        rows_solved([" = ".join(sides[::-1])], inputs, [left - right])
