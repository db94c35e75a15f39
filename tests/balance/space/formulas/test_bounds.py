"""Bounds on lengths against cone programs on both sides; open cells against random points."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import balance
import balance.masses
from kinematics import ScrewJoint, from_screws
from tests.support.four_bar_spaces import space_of

sympy = pytest.importorskip("sympy")
from balance.space.formulas.bounds import decide_ratios, length_bounds  # noqa: E402
from balance.space.formulas.open_cells import OpenCells, isolated_roots  # noqa: E402

CLOSE = ("1.40", "1.43")
FAR = ("0.45", "0.8", "1.1", "1.3", "1.6", "2.5", "4")
KITES = {
    "four_bar_kite": lambda d: space_of(0.5, 0.5, 0.5 * d, 0.5 * d, 0.7),
    "four_bar_antiparallelogram": lambda d: space_of(0.5, 0.5 * d, 0.5, 0.5 * d, 0.7, True),
}


@cache
def bounds_of(name):
    """Bounds of a linkage of the gallery, dynamic balance."""
    return balance.formulas(name, buildable=True).bounds


@pytest.mark.parametrize("name", KITES)
def test_bound_of_kite_and_antiparallelogram(name):
    """The longer side of a kite or an antiparallelogram exceeds the root of 2 of the other."""
    bounds = bounds_of(name)
    assert bounds.text() == "l_ground^2 > 2 l_crank^2"
    (interval,) = bounds.intervals
    assert abs(interval.low.value - 2**0.5) < 1e-15 and interval.high is None
    assert eval(bounds.python(), {"l_ground": 1.42, "l_crank": 1.0})
    assert not eval(bounds.python(), {"l_ground": 1.41, "l_crank": 1.0})


@pytest.mark.parametrize("name", KITES)
@pytest.mark.parametrize(
    "ratio",
    [*CLOSE, *(pytest.param(each, marks=pytest.mark.slow) for each in FAR)],
)
def test_cone_programs_on_both_sides_of_the_bound(name, ratio):
    """A solver in floating point finds masses, or a certificate, in the geometry itself."""
    bounds = bounds_of(name)
    space = KITES[name](float(ratio))
    assert space.rank == 7
    verdict = balance.masses.feasible(space).verdict
    assert verdict == ("feasible" if bounds.contains(float(ratio)) else "infeasible")


@pytest.mark.slow
def test_bounds_do_not_depend_on_frames():
    """A kite whose links hang on each other the other way round: frames start elsewhere."""
    joints = [
        ScrewJoint("A", "base", "crank"),
        ScrewJoint("B", "crank", "coupler", point=(0.3, 0.4, 0.0)),
        ScrewJoint("D", "coupler", "rocker", point=mirror_of_origin(0.3 + 0.4j, 1.0)),
    ]
    loop = ScrewJoint("C", "base", "rocker", point=(1.0, 0.0, 0.0))
    formulas = balance.formulas(from_screws(joints, [loop]), buildable=True)
    assert "m_rocker" in formulas.text()
    assert formulas.bounds.text() == "l_ground^2 > 2 l_crank^2"


def mirror_of_origin(first, second):
    """The origin mirrored in the line through two complex points."""
    along = second - first
    z = first + along * ((0 - first) / along).conjugate()
    return z.real, z.imag, 0.0


SMALL = {
    "four_bar_parallelogram": "none",
    "four_bar_general": "none",
    "five_bar": "none",
    "slider_crank": "all",
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(each, marks=[pytest.mark.slow] * (each == "five_bar")) for each in SMALL],
)
def test_all_lengths_or_none(name):
    bounds = bounds_of(name)
    verdict = balance.masses.feasible(balance.design_space(name)).verdict
    assert bounds.verdict == SMALL[name]
    assert verdict == ("feasible" if bounds.verdict == "all" else "infeasible")


def test_forces_alone_are_balanced_for_all_lengths():
    assert balance.formulas("four_bar_general", "force", buildable=True).bounds.verdict == "all"


def test_what_is_not_derived_has_a_reason():
    formulas = balance.formulas("four_bar_kite")
    assert formulas.bounds is None
    failed = length_bounds(replace(formulas, geometries=0))
    assert failed.verdict == "unknown" and "check" in failed.reason
    spatial = balance.formulas("four_bar_spherical", "force", buildable=True).bounds
    assert spatial.text() == "not derived: they are of planar linkages"


RATIO, FREE = sympy.symbols("ratio u", real=True)
ROOTS = {
    # What is projected vanishes at the root of 2, and nothing changes there.
    "no change": ([FREE, FREE - RATIO**2 + 2], "all", "for all lengths", [1.0, 2**0.5, 3.0]),
    "a point less": ([(RATIO - 1) ** 2 * FREE], "some", "b > a or a > b", [0.9, 1.1]),
    "in doubt": (
        [(RATIO**2 - 2) ** 2 * FREE],
        "some",
        "2 b^2 > a^2 or a^2 > 2 b^2; not decided at a/b = 1.41421",
        [1.4, 1.5],
    ),
    "between two roots": (
        [FREE, 3 * RATIO - RATIO**2 - 1 - FREE],
        "some",
        "a/b > 0.381966, 2.61803 > a/b",
        [0.4, 2.6],
    ),
    "never": ([FREE, -FREE - RATIO], "none", "for no lengths", []),
}


@pytest.mark.parametrize("name", ROOTS)
def test_intervals_between_roots(name):
    """Inequalities in the ratio of a and b, and u: solved by hand."""
    sides, verdict, text, inside = ROOTS[name]
    problem = SimpleNamespace(
        lengths=("a", "b"), ratio=RATIO, positive=True, sides=[RATIO, *sides], free=[FREE]
    )
    bounds = decide_ratios(problem)
    assert (bounds.verdict, bounds.text()) == (verdict, text)
    for ratio in (0.3, *inside, 1.0, 2.7):
        if bounds.python() and abs(ratio - 2**0.5) > 1e-9:
            assert bounds.contains(ratio) == eval(bounds.python(), {"a": ratio, "b": 1.0})
    assert all(bounds.contains(ratio) for ratio in inside)


def random_inequalities(rng):
    """Lines, conics and a parameter t, in small integers."""
    t, u, v = sympy.symbols("t u v", real=True)

    def number():
        return rng.randrange(-3, 4)

    line = number() * u + number() * v + t - 2
    x, y = u + number(), v + number() * u + number()
    return (t, u, v), [t, x, line, t * x * y - (number() * u + number()) ** 2 - 1]


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 12))]
)
def test_open_cells_against_points_drawn_at_random(seed):
    """Where points solve inequalities, cells do; and what cells find solves them."""
    rng = random.Random(seed)
    variables, sides = random_inequalities(rng)
    cells = OpenCells(sides, variables)
    evaluate = sympy.lambdify(variables, sides, "numpy")
    points = np.random.default_rng(seed).standard_cauchy((2, 20_000))
    edges = [0.0, *(float(root) for root in cells.roots() if float(root) > 0)]
    for low, high in zip(edges, [*edges[1:], edges[-1] + 2], strict=True):
        empty = None
        for share in (0.2, 0.6):
            value = Fraction(low + share * (high - low))
            at = sympy.Rational(value.numerator, value.denominator)
            solution = cells.solution([at])
            if solution is None:
                drawn = [np.broadcast_to(x, 20_000) for x in evaluate(float(at), *points)]
                assert not np.all(np.array(drawn) > 1e-9, axis=0).any()
            else:
                numbers = dict(zip(variables, solution, strict=True))
                assert all(side.subs(numbers) > 0 for side in sides)
            # No root of a projection lies between: the verdict is one.
            assert empty in (None, solution is None)
            empty = solution is None


def test_roots_are_isolated():
    """Roots of several polynomials, rational and not, in order, with exact signs."""
    x = sympy.Symbol("x")
    polynomials = [sympy.Poly(f, x) for f in (x**2 - 2, 5 * x - 7, x**3 - 3, x**2 * (x - 1))]
    roots = isolated_roots(polynomials)
    exact = [-(2**0.5), 0, 1, 1.4, 2**0.5, 3 ** (1 / 3)]
    assert np.allclose([float(root) for root in roots], exact, rtol=0, atol=1e-14)
    assert [root.sign_of(polynomials[0]) for root in roots] == [0, -1, -1, -1, 0, 1]
