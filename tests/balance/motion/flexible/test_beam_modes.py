"""Modes of beams and their supports against closed forms and printed figures.

[M] J. P. Meijaard, V. van der Wijk, Mechanism and Machine Theory 172, 104784, 2022.
"""

import math

import mpmath
import numpy as np
import pytest

from balance.app.answers.text.flexible import supported_modes_table
from balance.app.answers.text.render import body_text
from balance.motion.flexible.beam import Beam
from balance.motion.flexible.free_beam_modes import free_modes, mode_shape, mode_slope
from balance.motion.flexible.support_points import (
    STATIC_POINT,
    static_deflection,
    support_points,
)
from balance.motion.flexible.supported_beam_modes import (
    Clamp,
    EndBody,
    Support,
    supported_modes,
)
from kinematics.errors import LinkageError

# [M] Table 1: frequencies and zeros with ξ > 0.
TABLE_1 = """
22.373285448061 0.275842477297642
61.672822867920 0.367892044836738
120.903391727124 0.144196546027406 0.405557156878000
199.859448127201 0.223219952829764 0.426547236535226
298.555535298176 0.090872761949790 0.273545148582375 0.439902184294380
416.990785835445 0.153816743433199 0.308384299946894 0.449148005799258
555.165247566790 0.066667818619707 0.199974461177663 0.333933062067607 0.455928271552871
713.078917978436 0.117648031330238 0.235271585291052 0.353470348802706 0.461113180787307
890.731797198328 0.052631539648058 0.157895608677945 0.263137734134352 0.368894522616056
 0.465206530177909
1088.123885220101 0.095238061218115 0.190476979213647 0.285696045172047 0.381380758557262
 0.468520193970497
1305.255182044067 0.043478262272491 0.130434751486348 0.217392024502036 0.304331171678712
 0.391695475204462 0.471257568407845
1542.125687670212 0.080000001234916 0.159999971369851 0.240000662541769 0.319984677944420
 0.400359837188104 0.473556962935217
""".replace("\n ", " ")


def test_frequencies_and_zeros_of_table_1():
    """[M] Table 1: every printed digit."""
    for mode, line in zip(free_modes(12), TABLE_1.split("\n")[1:], strict=False):
        frequency, *zeros = map(float, line.split())
        assert mode.frequency == pytest.approx(frequency, abs=6e-13)
        found = [zero for zero in mode.zeros if zero > 0.0]
        assert found == pytest.approx(zeros, abs=1.6e-15)
        assert (mode.zeros[0] == 0.0) == (mode.number % 2 == 0)


def test_modes_of_high_numbers_lose_no_digits():
    """λ up to 60 against 60 digits; the ends are at ±√2 of the amplitude, within e^-λ."""
    with mpmath.workdps(60):
        for mode in free_modes(19)[::3]:
            exact = mpmath.findroot(
                lambda x: mpmath.cos(x) - mpmath.sech(x), mpmath.mpf(mode.wave_number)
            )
            assert mode.wave_number == pytest.approx(float(exact), rel=1e-15)
            even = mode.number % 2 == 0
            wave, half = exact, exact / 2
            for xi in (0.0, 0.1, 0.31, 0.4999, 0.5):
                x = wave * mpmath.mpf(xi)
                value = (
                    mpmath.sin(x) + mpmath.sin(half) * mpmath.sinh(x) / mpmath.sinh(half)
                    if even
                    else mpmath.cos(x) + mpmath.cos(half) * mpmath.cosh(x) / mpmath.cosh(half)
                )
                point = np.array(xi)
                assert float(mode_shape(mode.number, point)) == pytest.approx(
                    float(value), abs=1e-13
                )


def test_slopes_are_derivatives_of_shapes():
    xi = np.array([-0.4, -0.1, 0.05, 0.3])
    for number in (1, 2, 5, 8):
        step = 1e-6
        numeric = (mode_shape(number, xi + step) - mode_shape(number, xi - step)) / (2 * step)
        assert mode_slope(number, xi) == pytest.approx(numeric, rel=1e-6)


def test_support_points_of_the_paper():
    """[M] Eqs. 31 and 34, Sec. 4, Table 1."""
    assert support_points(2).points[1] == pytest.approx(0.2758424773, abs=1e-10)
    three, four = support_points(3), support_points(4)
    assert three.points[2] == pytest.approx(0.356629311, abs=5e-10)
    assert three.weights == pytest.approx([0.320183421, 0.359633159, 0.320183421], abs=5e-10)
    assert four.points[2:] == pytest.approx([0.132607152, 0.394718293], abs=5e-10)
    assert four.weights[2:] == pytest.approx([0.264859936, 0.235140064], abs=5e-10)
    assert four.hinge == pytest.approx(0.255872813, abs=5e-10)
    (bar,) = four.bars
    assert bar.arms[0] * four.weights[2] == pytest.approx(bar.arms[1] * four.weights[3])
    assert STATIC_POINT == pytest.approx((3 - math.sqrt(6)) / 2)
    grid = np.linspace(0.0, 0.5, 5001)
    assert grid[np.argmin(static_deflection(grid))] == pytest.approx(STATIC_POINT, abs=1e-4)


@pytest.mark.parametrize("count", [1, 5, 12, 25])
def test_any_number_of_supports_silences_as_many_modes_less_one(count):
    found = support_points(count)
    assert found.weights.sum() == pytest.approx(1.0) and found.weights.min() > 0.0
    assert np.all(np.diff(found.points) > 0.0) and abs(found.points).max() < 0.5
    for mode in free_modes(2 * count):
        total = found.weights @ mode_shape(mode.number, found.points, mode.wave_number)
        assert (abs(total) < 1e-12) == (mode.number < 2 * count - 1 or mode.number % 2 == 0)


def coupler(hinge):
    """Length and frequencies ω / 2π of a unit beam with hinges a unit apart at ± hinge."""
    length = 0.5 / hinge
    supports = [Support((length / 2 - 0.5,)), Support((length / 2 + 0.5,))]
    found = supported_modes(Beam(length, 1.0, 1.0), supports, 8)
    return found.frequencies / (2.0 * np.pi)


def test_frequencies_of_the_coupler_on_its_supports():
    """[M] Sec. 5, to the printed digits, and to 0.2 % for the seventh mode."""
    assert coupler(0.5)[0] == pytest.approx(np.pi / 2, rel=1e-6)
    assert coupler(support_points(2).hinge)[:3] == pytest.approx(
        [1.0838, 2.0282, 3.4854], abs=6e-5
    )
    assert coupler(3**0.5 / 6)[:3] == pytest.approx([1.1803, 2.3906, 3.8367], abs=6e-5)
    four = support_points(4)
    length = 0.5 / four.hinge
    s, w = (four.points + 0.5) * length, 2 * four.weights
    supports = [Support(tuple(s[:2]), tuple(w[:2])), Support(tuple(s[2:]), tuple(w[2:]))]
    found = supported_modes(Beam(length, 1.0, 1.0), supports, 8).frequencies / (2.0 * np.pi)
    assert found[1] == pytest.approx(2.2887, abs=6e-5)
    assert found[6] == pytest.approx(13.42, rel=2e-3)


def test_a_support_at_a_node_leaves_the_free_mode():
    """The second route of the free modes: elements on no support, and on the nodes."""
    free = supported_modes(Beam(2.0, 3.0, 0.7), [], 5)
    unit = math.sqrt(3.0 / (0.7 * 2.0**4))
    exact = [mode.frequency * unit for mode in free_modes(3)]
    assert free.frequencies[2:] == pytest.approx(exact, rel=1e-6)
    nodes = [Support((2.0 * (0.5 + xi),)) for xi in (-0.275842477297642, 0.275842477297642)]
    held = supported_modes(Beam(2.0, 3.0, 0.7), nodes, 1)
    assert held.frequencies[0] == pytest.approx(exact[0], rel=1e-6)


@pytest.mark.parametrize(
    ("supports", "rigid"),
    [
        ([], [lambda s: np.ones_like(s), lambda s: s - 1.2]),
        ([Support((0.5,))], [lambda s: s - 0.5]),
        ([Support((0.5, 1.5), (0.5, 0.5))], [lambda s: s - 1.0]),
        ([Support((0.5, 1.0), (2.0, -2.0))], [lambda s: np.ones_like(s)]),
        ([Clamp(0.0)], []),
        ([Support((0.0,)), Support((2.0,))], []),
    ],
)
def test_rigid_motions_have_no_frequency(supports, rigid):
    """Translation, and rotation about the centre of mass or the only pin: lines, at 0 Hz."""
    body = EndBody(0.35, 0.0, 0.01)  # the centre of mass of beam and body is at 1.2 m
    modes = supported_modes(Beam(2.0, 3.0, 0.7), supports, 4, end_body=body)
    assert np.count_nonzero(modes.frequencies == 0.0) == len(rigid)
    for shape, line in zip(modes.shapes, rigid, strict=False):
        expected = line(modes.positions)
        assert shape == pytest.approx(expected / expected[np.argmax(abs(expected))], abs=1e-12)


def test_errors_bound_the_frequencies_and_the_digits_that_are_printed():
    """Against (kπ)² of the pinned beam."""
    modes = supported_modes(Beam(1.0, 1.0, 1.0), [Support((0.0,)), Support((1.0,))], 40)
    exact = (np.arange(1, 41) * np.pi) ** 2
    errors = abs(modes.frequencies / exact - 1.0)
    assert np.all(errors[:30] < 1.1 * modes.errors[:30] + 1e-12)
    assert np.all(modes.errors[5:30] < 3.0 * errors[5:30] + 1e-12)
    rows = body_text([supported_modes_table(modes)]).splitlines()[1:]
    for row, omega, error in list(zip(rows, exact, errors, strict=True))[:30]:
        printed = row.split()[2]
        digits = len(printed.partition("e")[0].replace(".", ""))
        assert abs(float(printed) / omega - 1.0) < error + 5.5 * 10.0**-digits


def test_low_frequencies_of_many_elements_keep_their_digits():
    """Products of strains lose 1e-7 of the first frequency to round-off; strains do not."""
    modes = supported_modes(Beam(1.0, 1.0, 1.0), [Clamp(0.0)], 1)
    assert modes.frequencies[0] == pytest.approx(1.875104068711961**2, rel=1e-9)


def test_frequencies_converge_with_the_order_of_the_elements():
    """Fourth order, against the pinned beam (kπ)² and the clamped one cos λ cosh λ = -1."""
    pinned = [Support((0.0,)), Support((1.0,))]
    clamped = 1.875104068711961**2
    for supports, exact in ((pinned, np.pi**2), ([Clamp(0.0)], clamped)):
        errors = [
            supported_modes(Beam(1.0, 1.0, 1.0), supports, 1, n).frequencies[0] / exact - 1.0
            for n in (2, 4, 8)
        ]
        assert all(error > 0.0 for error in errors)
        assert np.diff(np.log2(errors)) == pytest.approx([-4.0, -4.0], abs=0.15)


def test_arms_with_tip_masses():
    """[M] Sec. 2.1: 5.85, 5.69 and 5.82 Hz, with more digits from the frequency equation."""
    for length, bending, line_mass, tip, printed in (
        (0.1, 0.0045, 0.0, 0.01, 5.8477),
        (0.1, 0.0045, 0.024, 0.01, 5.6888),
        (0.05, 0.001125, 0.0135, 0.02, 5.8246),
    ):
        beam = Beam(length, bending, line_mass)
        found = supported_modes(beam, [Clamp(0.0)], 1, 24, EndBody(tip)).frequencies[0]
        assert found / (2 * np.pi) == pytest.approx(printed, abs=1e-4)
        assert found == pytest.approx(tip_mass_frequency(beam, tip), rel=1e-6)


def tip_mass_frequency(beam, tip):
    """1 + cos λ cosh λ = (m / ρAl) λ (sin λ cosh λ - cos λ sinh λ); sqrt(3EI/ml³) massless."""
    if beam.line_mass == 0.0:
        return math.sqrt(3.0 * beam.bending / (tip * beam.length**3))
    ratio = tip / beam.mass
    wave = float(
        mpmath.findroot(
            lambda x: (
                1
                + mpmath.cos(x) * mpmath.cosh(x)
                - ratio * x * (mpmath.sin(x) * mpmath.cosh(x) - mpmath.cos(x) * mpmath.sinh(x))
            ),
            0.9,
        )
    )
    return wave**2 * math.sqrt(beam.bending / (beam.line_mass * beam.length**4))


def test_shear_and_rotary_inertia_lower_the_pinned_frequencies():
    """The frequency equation of Timoshenko for a pinned beam, quadratic in ω²."""
    beam = Beam(1.0, 1.0, 1.0, shear=200.0, rotary=2e-3)
    found = supported_modes(beam, [Support((0.0,)), Support((1.0,))], 3, 64)
    for n, omega in enumerate(found.frequencies, 1):
        k2 = (n * np.pi) ** 2
        roots = np.roots(
            [beam.rotary / beam.shear, -(1.0 + k2 * (1.0 / beam.shear + beam.rotary)), k2**2]
        )
        assert omega == pytest.approx(math.sqrt(min(roots)), rel=5e-4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Beam(1.0, -2.0, 1.0), "bending -2 is not positive"),
        (lambda: Beam(0.0, 1.0, 1.0), "length 0 is not positive"),
        (lambda: supported_modes(Beam(1.0, 1.0, 1.0), [Support((2.0,))]), "not on the beam"),
        (lambda: supported_modes(Beam(1.0, 1.0, 1.0), [Support((0.5,))] * 2), "the same"),
        (lambda: support_points(0), "from 1 to 40"),
        (lambda: free_modes(0), "from 1 to 500"),
    ],
)
def test_wrong_beams_are_refused(make, message):
    with pytest.raises(LinkageError, match=message):
        make()
