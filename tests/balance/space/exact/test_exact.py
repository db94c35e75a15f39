"""Ranks without a tolerance, against rational arithmetic that shares nothing with them."""

from fractions import Fraction
from itertools import count
from math import lcm, prod
from xml.etree import ElementTree

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from balance.space.exact import modular, radicals
from balance.space.exact.chain import exact_chain
from balance.space.exact.modular_ranks import MIN_PLATEAU
from kinematics import Motion
from kinematics.errors import ExactError
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.numerics.linalg.rational import root as rational_root
from tests.independent.exactly import Planar4R, Series, coupled, determinant, modulo
from tests.support.figures import FIGURES, Figure
from tests.support.laws import altered, exact_rank
from tests.support.modular_rows import conditions
from tests.support.urdf_text import INERTIAL, joint, link, pose_of, saved

# Overconstrained linkages: that they close at all orders does not follow from their ranks.
OVERCONSTRAINED = {"bennett", "bennett_rational", "goldberg_five_bar", "sarrus"}


def found_for(figure: Figure, path=None, **options):
    linkage = kinematics.load(path or figure.model)
    return exact_ranks(
        linkage, figure.motion or None, figure.balance, spatial=figure.spatial, **options
    )


def rows_of(chain, rays, order, p):
    """Remainders of the conditions, of loops that close."""
    X, closed = conditions(chain, np.array(rays), order, p)
    assert closed == order + 1
    return X


@pytest.mark.table
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_figures_come_out(figure: Figure):
    found = found_for(figure)
    expected = figure.ranks
    assert found.ranks == (*expected, *expected[-1:] * MIN_PLATEAU)
    assert found.agreed and found.settled
    assert (found.rank, found.nullity) == (figure.ranks[-1], figure.nullity)
    assert found.kmax == len(expected) - 1
    assert found.regular == (figure.model not in OVERCONSTRAINED)
    assert len(set(found.primes)) == 2
    assert bool(found.notices) == (figure.model in ("hprs", "three_rsr"))


def test_the_primes_are_primes():
    for p in modular.PRIMES:
        assert p < 2**30 and all(p % d for d in range(2, int(p**0.5) + 1))


@pytest.mark.parametrize("prime, used, agreed", [(5, False, True), (11, True, False)])
def test_a_prime_that_will_not_do_does_no_harm(prime, used, agreed, monkeypatch):
    """5 divides the denominators of decimals; modulo 11 a rank falls short."""
    monkeypatch.setattr(radicals, "PRIMES", (prime, *modular.PRIMES))
    found = exact_ranks(kinematics.load("four_bar_general"))
    assert (prime in found.primes, found.agreed) == (used, agreed)
    assert found.ranks == (3, 6, 7, 8, 8, 8, 8)
    assert found.witness.prime > 2**29


@pytest.mark.parametrize("model", ["four_bar_general", "four_bar_kite"])
def test_planar_four_bars_by_another_route(model):
    """Cosines and sines of the links as series, by Newton's method on fractions.

    The rows are those of the kernel, entry by entry, and their ranks those of the table.
    """
    linkage = kinematics.load(model)
    pivots = [[Fraction(str(round(x, 9))) for x in j.point[:2]] for j in linkage.joints]
    expected = Planar4R(pivots[0], pivots[1], pivots[3], pivots[2]).rows(5)
    chain = exact_chain(linkage, exact_geometry(linkage))
    for p in modular.PRIMES[:2]:
        found = rows_of(chain, [[1]], 5, p)[:, 0, 0].tolist()
        assert found == [[[modulo(x, p) for x in row] for row in order] for order in expected]
    rows = [row for order in expected for row in order]
    common = lcm(*(x.denominator for row in rows for x in row))
    whole = [[int(x * common) for x in row] for row in rows]
    figure = next(f for f in FIGURES if f.model == model)
    ranks = [exact_rank(whole[: 3 * k + 3]) for k in range(5)]
    assert ranks == [*figure.ranks, *figure.ranks[-1:] * (5 - len(figure.ranks))]


@pytest.mark.table(2)
@pytest.mark.parametrize(
    "model, motion",
    [
        ("bennett_rational", None),
        ("hprs", None),
        ("rusr", None),
        ("three_rsr_rational", "u2=u3"),
    ],
)
def test_the_kernels_are_the_formulas_in_fractions(model, motion):
    """Screws by the adjoint of displacements, momentum from pseudo-inertias at each pose."""
    linkage = kinematics.load(model)
    motion = Motion.parse(motion, linkage.inputs) if motion else None
    chain = exact_chain(linkage, exact_geometry(linkage), motion)
    ray = [Fraction(k + 2) for k in range(chain.width)]
    expected = Series(chain, ray, 2).rows()
    p = modular.PRIMES[0]
    found = rows_of(chain, [[int(x) for x in ray]], 2, p)[:, 0]
    assert found.shape == np.shape(expected)
    wrong = [
        (x, y)
        for x, y in zip(found.ravel(), np.ravel(expected), strict=True)
        if x != modulo(y, p)
    ]
    assert not wrong


@pytest.mark.table
@pytest.mark.parametrize("figure", FIGURES[:14], ids=str)
def test_a_minor_shows_that_the_rank_is_not_less(figure: Figure):
    """The determinant of the pivots' rows and columns, by big integers modulo the prime."""
    found = found_for(figure)
    prime, rays, pivots = found.witness
    assert len(pivots) == found.rank
    rows = rows_of(found.chain, rays, max(p.order for p in pivots), prime)
    size = len(found.chain.parameters)
    minor = [
        [
            int(rows[a.order, a.ray, a.column, a.row, b.body * size + b.parameter])
            for b in pivots
        ]
        for a in pivots
    ]
    assert determinant(minor, prime) != 0
    minor[-1] = minor[0]
    assert determinant(minor, prime) == 0


@pytest.mark.parametrize("digits", range(2, 15))
def test_an_antiparallelogram_is_general_however_little_it_is_off(digits, tmp_path):
    """The base longer by a part of 10^-digits."""

    def lengthened(robot):
        longer = Fraction(1, 10**digits)
        places = {"joint[@name='q4']/origin": 1 + longer}
        places["loop/successor/origin"] = Fraction("-0.488") - longer
        for path, x in places.items():
            origin = robot.find(path)
            origin.set("xyz", " ".join([decimals(x), *origin.get("xyz").split()[1:]]))

    model = "four_bar_antiparallelogram"
    linkage = kinematics.load(altered(model, tmp_path, lengthened))
    assert exact_ranks(linkage).ranks == (3, 6, 7, 8, 8, 8, 8)


def test_a_chain_of_many_loops_needs_many_orders(tmp_path):
    """Ten coupled four-bars: each but the first two adds three orders."""
    path = tmp_path / "chain.urdf"
    path.write_text(coupled(10), encoding="utf-8")
    found = exact_ranks(kinematics.load(path))
    assert (found.kmax, found.rank, found.nullity, found.agreed) == (30, 53, 31, True)
    assert found.regular and found.settled
    low = exact_ranks(kinematics.load(path), max_order=14)
    assert low.ranks == found.ranks[:15] and not low.settled


def test_orders_go_on_to_the_rank_expected():
    """Without it three orders that add nothing are the end; one too high is never reached."""
    linkage = kinematics.load("four_bar_kite")
    found = exact_ranks(linkage, expected=8)
    assert len(found.ranks) > 100 and found.rank == 7 and not found.settled
    assert exact_ranks(linkage, max_order=1).ranks == (3, 6)


def test_relations_are_rescaled_by_the_lengths_of_axes(tmp_path):
    """An axis five times as long, and the relation means the same motion."""

    def stretched(axis):
        def change(robot):
            robot.find("joint[@name='u2']/axis").set("xyz", axis)

        return change

    model, motion = "three_rsr_rational", "2*u2 = 3*u3 - u1"
    plain = exact_ranks(kinematics.load(model), motion, max_order=3)
    for axis, length in (("-4 -3 0", 5), ("-0.08 -0.06 0", Fraction(1, 10))):
        linkage = kinematics.load(altered(model, tmp_path, stretched(axis)))
        found = exact_ranks(linkage, motion, max_order=3)
        assert found.ranks == plain.ranks
        for column in zip(*found.chain.columns, strict=True):
            rates = dict(zip([j.name for j in linkage.joints], column, strict=True))
            assert 2 * length * rates["u2"] == 3 * rates["u3"] - rates["u1"]
    # With a ratio of √2 between the lengths.
    linkage = kinematics.load(altered(model, tmp_path, stretched("-1 -1 0")))
    found = exact_ranks(linkage, motion, max_order=3)
    assert {b for numbers in found.chain.radicands for b in numbers} == {2}
    assert found.agreed and found.ranks[-1] >= exact_ranks(linkage, "u2=0").ranks[-1]


def test_motions_without_text_are_taken_from_their_basis():
    linkage = kinematics.load("three_rsr_rational")
    basis = np.array([[1.0, 0.0], [0.0, 0.5], [0.0, 0.5]])
    found = exact_ranks(linkage, Motion(linkage.inputs, (), basis))
    assert found.ranks == exact_ranks(linkage, "u2=u3").ranks


def test_a_relation_that_repeats_another_up_to_its_decimals_is_one():
    """Exact arithmetic would take the two for no motion at all."""
    linkage = kinematics.load("three_rsr_rational")
    twice = ["u2=0.333333333333333*u3", "3*u2=u3"]
    assert exact_ranks(linkage, twice).ranks == exact_ranks(linkage, twice[:1]).ranks


def mimicking(tmp_path, axis):
    """A serial arm of which one joint follows another twice as fast; and its lengths."""
    follow = '<mimic joint="a" multiplier="2"/>'
    parts = [link("l0"), *(f'<link name="l{i}">{INERTIAL}</link>' for i in (1, 2, 3))]
    frame = pose_of([0.3, -0.2, 0.1], [0.0, 0.0, 0.0])
    parts += [
        joint("a", "continuous", "l0", "l1", frame, [0.0, 3.0, 4.0]),
        joint("b", "continuous", "l1", "l2", frame, axis, follow),
        joint("c", "continuous", "l2", "l3", frame, [1, 0, 0]),
    ]
    return kinematics.load(saved(tmp_path, *parts))


def test_mimics_are_rescaled_by_the_lengths_of_axes(tmp_path):
    linkage = mimicking(tmp_path, [2, 1, 2])
    found = exact_ranks(linkage)
    assert found.chain.mimics == ((Fraction(-10, 3), 1, 0),)
    assert found.regular and linkage.mobility == 2
    float_ranks = [order.rank for order in design_space(linkage).orders]
    assert list(found.ranks[: len(float_ranks)]) == float_ranks


@pytest.mark.parametrize("model", ["four_bar_general", "four_bar_kite"])
def test_a_mimic_about_an_axis_of_irrational_length(model, tmp_path):
    """An arm about (1, 1, 0), geared to the crank, is one about x that is turned by π/4."""

    def geared(axis, yaw):
        def change(robot):
            crank, ground = kinematics.load(model).inputs[0], robot.find("link").get("name")
            text = f'''<robot><link name="arm">{INERTIAL}</link>
              <joint name="gear" type="continuous">
                <parent link="{ground}"/><child link="arm"/><axis xyz="{axis}"/>
                <origin xyz="0.4 -0.8 0.3" rpy="0 0 {yaw}"/>
                <mimic joint="{crank}" multiplier="-0.5"/>
              </joint></robot>'''
            robot.extend(ElementTree.fromstring(text))

        return change

    quarter = "0.78539816339744830961566084581988"
    turned = altered(model, tmp_path, geared("1 0 0", quarter))
    plain = exact_ranks(kinematics.load(turned))
    root = altered(model, tmp_path, geared("1 1 0", "0"))
    found = exact_ranks(kinematics.load(root))
    assert {b for numbers in found.chain.radicands for b in numbers} == {2}
    assert plain.chain.radicands == ((),) * 5
    assert found.agreed and found.ranks == plain.ranks


def test_square_roots_keep_their_relations():
    """√2 √3 = √6 modulo every prime, and primes are those in which they exist."""
    squares = [Fraction(x) for x in ("2", "3", "6", "1/2", "9", "0.12", "245", "1.0201")]
    classes = radicals.square_classes(squares)
    assert classes[2] == classes[0] | classes[1] and classes[0] == classes[3]
    assert classes[5] == classes[1] and not classes[4] and not classes[7]
    for square, radicands in zip(squares, classes, strict=True):
        assert rational_root(square * prod(radicands)) is not None
    every = sorted(frozenset().union(*classes))
    primes = list(radicals.primes_with_roots(every))
    assert len(set(primes)) == 4
    for p in primes:
        assert p < 2**30 and all(p % d for d in range(2, int(p**0.5) + 1))
        assert all(radicals.modular_root(b, p) ** 2 % p == b for b in every)
    with pytest.raises(ExactError, match="square roots"):
        list(radicals.primes_with_roots([2] * 11))


@pytest.mark.table
@pytest.mark.parametrize("figure", [f for f in FIGURES if not f.spatial][:12], ids=str)
def test_a_plane_may_lie_anywhere(figure: Figure, tmp_path):
    """All coordinates turned by the angles of 3-4-5 triangles, about two axes."""
    turn = np.array([[15, 12, -16], [0, 20, 15], [20, -9, 12]]) / 25

    def turned(robot):
        for item in (*robot.iter("origin"), *robot.iter("axis")):
            v = [Fraction(word) for word in item.get("xyz").split()]
            R = [[Fraction(round(25 * x), 25) for x in row] for row in turn]
            w = [sum(a * b for a, b in zip(row, v, strict=True)) for row in R]
            item.set("xyz", " ".join(decimals(x) for x in w))

    assert found_for(figure, altered(figure.model, tmp_path, turned)).ranks == (
        found_for(figure).ranks
    )


def decimals(x: Fraction) -> str:
    """A fraction of which the denominator divides a power of ten, as a decimal."""
    places = next(k for k in count() if 10**k % x.denominator == 0)
    digits = str(abs(x.numerator) * 10**places // x.denominator).zfill(places + 1)
    head, tail = digits[: len(digits) - places], digits[len(digits) - places :]
    return f"{'-' if x < 0 else ''}{head}.{tail or '0'}"


@pytest.mark.parametrize("second, rank", [([2, 1, -2], 4), ([], 2)])
def test_sliding_bodies_have_a_plane(second, rank, tmp_path):
    """For each direction: the sum of the masses, and that of their moments across it."""
    parts = [link("l0"), f'<link name="l1">{INERTIAL}</link>']
    parts.append(joint("j1", "prismatic", "l0", "l1", axis=[1, 2, 2]))
    if second:
        parts.append(f'<link name="l2">{INERTIAL}</link>')
        parts.append(joint("j2", "prismatic", "l1", "l2", axis=second))
    linkage = kinematics.load(saved(tmp_path, *parts))
    assert linkage.planar
    found = exact_ranks(linkage)
    assert found.ranks == (rank,) * (MIN_PLATEAU + 1)
    assert found.rank == design_space(linkage).rank


def rewritten(tmp_path, model, joint, axis):
    """A model of the gallery with another axis on one joint."""

    def change(robot):
        robot.find(f"joint[@name='{joint}']/axis").set("xyz", axis)

    return kinematics.load(altered(model, tmp_path, change), angles="as_written")


def test_overconstrained_linkages_in_rounded_decimals_are_refused(tmp_path):
    """Twelve digits close the loop to round-off, and to no order exactly."""
    linkage = rewritten(tmp_path, "bennett_rational", "q2", "0.360000000001 0.48 0.8")
    assert linkage.mobility == 1
    with pytest.raises(ExactError, match="not exactly representable.*close at 0 orders"):
        exact_ranks(linkage)


def test_a_plane_that_is_rounded_is_refused(tmp_path):
    linkage = rewritten(tmp_path, "four_bar_general", "q2", "0 0.0000000001 1")
    assert linkage.planar
    with pytest.raises(ExactError, match="planar only up to rounding"):
        exact_ranks(linkage)
