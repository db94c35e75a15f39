"""Four-bars through four positions and near more, planted and by a global search."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import differential_evolution

import balance
from balance.studies.synthesis.four_bars import FOUR_BARS
from balance.studies.synthesis.many_positions import four_bars_near
from balance.studies.synthesis.positions import Position, size_of
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases


def coupler_poses(kind, ratio, angles):
    """Crank tips and angles of the coupler, by the intersection of two circles."""
    poses = []
    for alpha in angles:
        tip = complex(math.cos(alpha), math.sin(alpha))
        coupler, rocker = (1.0, ratio) if kind == "kite" else (ratio, 1.0)
        apart = ratio - tip
        along = (coupler**2 - rocker**2 + abs(apart) ** 2) / (2.0 * abs(apart))
        across = math.sqrt(max(coupler**2 - along**2, 0.0))
        unit = apart / abs(apart)
        # Of both assemblies that which is no parallelogram, and no folded kite.
        ends = [tip + (along + side * 1j * across) * unit for side in (1.0, -1.0)]
        folded = 0j if kind == "kite" else tip + ratio
        end = max(ends, key=lambda z, folded=folded: abs(z - folded))
        poses.append((tip, np.angle(end - tip)))
    tips, turns = map(np.array, zip(*poses, strict=True))
    return tips, np.unwrap(turns)


def planted(rng, kind, count):
    """Positions that a random four-bar passes in order."""
    ratio, side = rng.uniform(1.5, 4.0), rng.choice([-1.0, 1.0])
    angles = side * np.sort(rng.uniform(0.3, 2.8, count))
    tips, turns = coupler_poses(kind, ratio, angles)
    arm, turn = complex(*rng.uniform(-1.5, 1.5, 2)), rng.uniform(-3.0, 3.0)
    scale, fixed = complex(*rng.uniform(-0.5, 0.5, 2)), complex(*rng.uniform(-1.0, 1.0, 2))
    points = fixed + scale * (tips + arm * np.exp(1j * turns))
    return [
        Position(z.real, z.imag, float(a)) for z, a in zip(points, turns + turn, strict=True)
    ]


@pytest.mark.table(1)
@pytest.mark.parametrize("kind", FOUR_BARS)
@pytest.mark.parametrize("count", [4, 5])
def test_positions_of_a_four_bar_are_met(kind, count):
    """Four positions of one, and five, which the least squares must find to round-off."""
    rng = np.random.default_rng([count, FOUR_BARS.index(kind)])
    for _ in range(number_of_cases(1, 25)):
        positions = planted(rng, kind, count)
        best = four_bars_near(positions, kind)[0]
        assert best.miss < 1e-9 * size_of(positions)
        # By the circles of the links it has, and the tool that it carries.
        tips, turns = coupler_poses(kind, best.ratio, best.crank_angles)
        start = best.scale * tips[0] + best.fixed
        for tip, turn, place in zip(tips, turns, positions, strict=True):
            arm = (best.first.point - start) * np.exp(1j * (turn - turns[0]))
            assert abs(best.scale * tip + best.fixed + arm - place.point) < 1e-8
            assert math.remainder(
                place.angle - positions[0].angle - turn + turns[0], math.tau
            ) == (pytest.approx(0.0, abs=1e-8))


def smallest_left(kind, positions):
    """What the best four-bar leaves, by differential evolution over ratio and crank angles."""
    goal = np.array([each.point for each in positions])
    wanted = np.array([each.angle for each in positions])

    def left(x, side):
        tips, turns = coupler_poses(kind, x[0], side * x[1:])
        M = np.column_stack([tips, np.ones(len(tips)), np.exp(1j * turns)])
        apart = M @ np.linalg.lstsq(M, goal, rcond=1e-10)[0] - goal
        gaps = turns - wanted
        arcs = size_of(positions) * np.angle(np.exp(1j * gaps) / np.exp(1j * gaps).sum())
        return float(np.sum(np.abs(apart) ** 2) + np.sum(arcs**2))

    least = np.inf
    bounds = [(1.42, 12.0)] + [(0.05, math.pi - 0.05)] * len(positions)
    for side in (1.0, -1.0):
        search = differential_evolution(
            left, bounds, (side,), seed=1, tol=1e-12, maxiter=400, popsize=20
        )
        least = min(least, search.fun)
    return math.sqrt(least)


@pytest.mark.slow
def test_a_global_search_finds_nothing_nearer():
    """Random positions: no other method leaves less than 0.95 of what is left here."""
    rng = np.random.default_rng(7)
    for k in range(number_of_cases(2, 20)):
        count = 4 + k % 2
        angles = np.cumsum(rng.uniform(0.1, 0.3, count))
        positions = [Position(*rng.uniform(-0.3, 0.3, 2), float(a)) for a in angles]
        for kind in FOUR_BARS:
            designs = four_bars_near(positions, kind)
            # Where the coupler cannot turn so far, nothing comes near either.
            far = 0.1 * size_of(positions)
            left = min((root_of_squares(each) for each in designs), default=far)
            assert smallest_left(kind, positions) > 0.95 * left - 1e-9, (k, kind)


def root_of_squares(design):
    """What a design leaves, from its points and turns."""
    points = design.tool_points(design.crank_angles)
    apart = points - np.array([each.point for each in design.positions])
    _, turns = coupler_poses(design.kind, design.ratio, design.crank_angles)
    gaps = turns - turns[0] + design.first.angle - [each.angle for each in design.positions]
    arcs = size_of(design.positions) * np.angle(np.exp(1j * gaps))
    return float(np.sqrt(np.sum(np.abs(apart) ** 2) + np.sum(arcs**2)))


@pytest.mark.slow
def test_the_written_four_bar_is_balanced_and_near_is_said():
    """Four planted positions are met; five others only within a distance that is given."""
    rng = np.random.default_rng(11)
    synthesis = balance.synthesize(planted(rng, "kite", 4), kind="four-bar", density=None)
    assert synthesis.verdict == "feasible" and synthesis.mechanisms[0].meets
    linkage = load(Document("kite", synthesis.mechanisms[0].urdf))
    assert balance.verify(linkage, trajectories=1).balanced
    places = [(0, 0, 0), (0.1, 0.05, 0.2), (0.2, 0.05, 0.4), (0.3, 0, 0.6), (0.35, -0.1, 0.9)]
    far = balance.synthesize(places, kind="four-bar", density=None)
    assert far.verdict == "infeasible" and "the nearest misses by up to" in far.words
    miss = max(
        far.mechanisms[0].position_error,
        size_of(far.positions) * far.mechanisms[0].angle_error,
    )
    near = balance.synthesize(places, kind="four-bar", within=1.01 * miss, density=None)
    assert near.verdict == "feasible" and near.mechanisms[0].meets


@pytest.mark.parametrize(
    ("places", "options", "said"),
    [
        ([(0, 0, 0), (1, 0, 0.2), (1, 1, 0.2), (0, 1, 0.5)], {}, "a pantograph passes"),
        ([(0, 0, 0), (1, 0, 0.2)], {"within": 0.1, "fixed": 1j}, "met exactly"),
        (
            [(0, 0, 0), (1, 0, 0.2), (1, 1, 0.3), (0, 1, 0.5)],
            {"kind": "four-bar", "fixed": 1j},
            "choose none",
        ),
        ([(0, 0, 0.1 * k) for k in range(21)], {"kind": "four-bar"}, "give 2 to 20"),
    ],
)
def test_requests_that_contradict_are_refused(places, options, said):
    with pytest.raises(UsageError, match=said):
        balance.synthesize(places, **options)
