"""Angle errors, their map and its zero contour, beside numerical integration.

[B] G. Becht, MSc thesis, TU Delft, 2020, chapter 3, section 4.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from balance.studies.synthesis.angle_error import angle_error, chain_angles
from balance.studies.synthesis.error_map import angle_error_map, offsets_without_error
from balance.studies.synthesis.momentum_integral import (
    delta_at_link_turn,
    link_reverses,
    link_turn_rate,
)
from balance.studies.synthesis.pantograph import ReducedInertias, reduced_inertias
from balance.studies.synthesis.pivot_line import fixed_pivot_line, moving_pivot_line
from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.zero_contour import zero_contour
from kinematics.errors import SynthesisError
from tests.support.pantographs import S2, TABLE, integrated

# The case of the issue: l1 = 0.1 m, θ1 = 90°, θ2 = 0, β = 40°, the tool 0.25 m from W1.
MOVING, BETA = 0.1j, math.radians(40.0)


def positions():
    """The second one from numerical integration of [B] Eq. 17, its sign corrected."""
    turn = integrated(reduced_inertias(TABLE, 0.1, 0.25, S2), math.pi / 2, BETA)
    end = MOVING * cmath.exp(1j * BETA) + 0.25 * cmath.exp(1j * turn)
    return Position(0.25, 0.1, 0.0), Position(end.real, end.imag, turn)


def test_the_turn_of_the_tool_of_the_table():
    """-0.255648 rad, by integration and in closed form."""
    inertias = reduced_inertias(TABLE, 0.1, 0.25, S2)
    end = float(delta_at_link_turn(math.pi / 2, BETA, inertias))
    closed = BETA - (end - math.pi / 2)
    assert closed == pytest.approx(-0.255648, abs=5e-7)
    assert closed == pytest.approx(integrated(inertias, math.pi / 2, BETA), abs=1e-12)


@pytest.mark.parametrize(
    ("ratio", "printed"),
    [
        (0.0, (-0.00851, 0.00887)),
        (0.045, (-0.00786, 0.00826)),
        (0.1, (-0.0070, 0.00745)),
        (0.2, (-0.00513, 0.00566)),
        (0.326, (0.0, 0.00064)),
        (0.35, ()),
        (0.5, ()),
    ],
)
def test_the_zero_contour_of_the_table(ratio, printed):
    """G_x of the issue, from -0.03 to 0.06 m; at R = 0.326 there is a second one."""
    places = positions()
    line = fixed_pivot_line(places, MOVING)
    ends = sorted(line.offsets_of_x([-0.03, 0.06]))
    masses = replace(TABLE, inertia_1=ratio * TABLE.inertia_2)
    roots = offsets_without_error(places, line, masses, *ends, S2)
    fixed, _ = line.pivots(roots)
    assert sorted(fixed.real) == pytest.approx(printed, abs=6e-6)
    for pivot in fixed:
        inertias = reduced_inertias(masses, abs(MOVING - pivot), 0.25, S2)
        second = displacements(places)[0].move(MOVING)
        beta = cmath.phase((second - pivot) / (MOVING - pivot))
        turn = integrated(inertias, cmath.phase(MOVING - pivot), beta)
        assert turn == pytest.approx(places[1].angle, abs=1e-10)


def test_the_map_and_its_contour():
    """Roots along the rows are on the contour, which ends between R = 0.326 and 0.35."""
    places = positions()
    line = fixed_pivot_line(places, MOVING)
    x = np.linspace(-0.03, 0.06, 46)
    done = []
    found = angle_error_map(
        places,
        line,
        TABLE,
        line.offsets_of_x(x),
        [0.0, 0.045, 0.1, 0.2, 0.3, 0.326, 0.4],
        s2=S2,
        progress=lambda k, n: done.append((k, n)),
    )
    assert found.errors.shape == (7, 46) and done[-1] == (7, 7)
    assert np.abs(found.contour.residuals).max() < 1e-10
    fixed, _ = line.pivots(found.contour.points[:, 0])
    ratios = found.contour.points[:, 1]
    for ratio, printed in ((0.045, (-0.00786, 0.00826)), (0.2, (-0.00513, 0.00566))):
        own = np.sort(fixed.real[ratios == ratio])
        assert own == pytest.approx(printed, abs=6e-6)
    assert 0.326 < ratios.max() < 0.35 or ratios.max() <= 0.35
    # One curve, each inner point on two segments.
    counts = np.bincount(found.contour.segments.ravel(), minlength=len(fixed))
    assert set(counts) <= {1, 2} and (counts == 1).sum() == 2


def test_the_printed_arctangent_has_another_contour():
    """[B] Eq. 24 with the arctangent: the design of the issue itself would have an error."""
    places = positions()
    half = 0.5 * abs(displacements(places)[0].move(MOVING) - MOVING) / 0.1
    assert 2 * math.asin(half) == pytest.approx(BETA, abs=1e-12)
    inertias = reduced_inertias(TABLE, 0.1, 0.25, S2)
    wrong = integrated(inertias, math.pi / 2, 2 * math.atan(half))
    assert abs(wrong - places[1].angle) > 1e-3


def test_random_motions_without_momentum():
    """The closed form beside integration; reversals are found where the rate has a pole."""
    rng = np.random.default_rng(4)
    reversals = 0
    for _ in range(60):
        J1, J2 = rng.uniform(0.2, 2.0, 2)
        inertias = ReducedInertias(
            *map(np.asarray, (J1, J2, rng.uniform(-1, 1) * (J1 * J2) ** 0.5))
        )
        opening, beta = rng.uniform(-math.pi, math.pi), rng.uniform(-2.0, 2.0)
        end = float(delta_at_link_turn(opening, beta, inertias))
        path = np.linspace(opening, opening + 2.0 * math.pi, 2000)
        vanishes = (np.diff(np.sign(J2 + inertias.coupling * np.cos(path))) != 0).any()
        assert link_reverses(opening, opening + 2.0 * math.pi, inertias).any() == vanishes
        if math.isnan(end):
            assert vanishes
            reversals += 1
            continue
        assert beta - (end - opening) == pytest.approx(
            integrated(inertias, opening, beta), abs=1e-8
        )
        slope = float(link_turn_rate(end, inertias)[0])
        c = float(inertias.coupling) * math.cos(end)
        assert slope * (J1 + c) + (slope - 1.0) * (J2 + c) == pytest.approx(0.0, abs=1e-12)
    assert 2 <= reversals <= 30


def test_the_lines_of_pivots_keep_the_distance():
    """Source Eqs. 20 to 23: the pivots are as far apart at the second position."""
    places = Position(0.3, 0.1, 0.2), Position(0.1, 0.4, -0.7)
    step = displacements(places)[0]
    for line in (fixed_pivot_line(places, 0.2 - 0.1j), moving_pivot_line(places, 0.3j)):
        G, W = line.pivots([-1.0, 0.0, 0.4])
        assert np.allclose(abs(W - G), abs(step.move(W) - G), atol=1e-14)
    flat = fixed_pivot_line((Position(0, 0, 0), Position(1, 0, 0.0)), 0.5j)
    with pytest.raises(SynthesisError, match="chord of the pivot is horizontal"):
        flat.offsets_of_x([0.0])
    for make in (fixed_pivot_line, moving_pivot_line):
        with pytest.raises(SynthesisError, match="is the pole"):
            make(places, step.pole)


def test_marching_squares_find_a_circle_and_a_saddle():
    x, y = np.linspace(-1.5, 1.5, 31), np.linspace(-1.4, 1.4, 29)

    def circle(x, y):
        return x * x + y * y - 1.0

    found = zero_contour(x, y, circle(x, y[:, None]), circle, 1e-12)
    assert np.allclose(np.hypot(*found.points.T), 1.0, atol=1e-12)
    ends = found.points[found.segments]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(2.0 * math.pi, rel=2e-3)

    def saddle(x, y):
        return x * y - 1e-3

    found = zero_contour(x, y, saddle(x, y[:, None]), saddle, 1e-12)
    ends = found.points[found.segments]
    assert (np.sign(ends[:, 0]) == np.sign(ends[:, 1])).all()

    def pole(x, y):
        return 1.0 / (x - 0.03) + 0.0 * y

    with np.errstate(divide="ignore"):
        assert not len(zero_contour(x, y, pole(x, y[:, None]), pole, 1e-9).points)


def test_errors_are_none_where_the_first_link_reverses():
    places = Position(0.25, 0.1, 0.0), Position(0.1, 0.2, -2.0)
    line = fixed_pivot_line(places, 0.02 + 0.09j)
    angles = chain_angles(places[0], (line.step,), *line.pivots(np.linspace(-1, 1, 200)), TABLE)
    errors = angle_error(angles, (line.step,))[0]
    assert np.isnan(errors).any() and np.isfinite(errors).any()
