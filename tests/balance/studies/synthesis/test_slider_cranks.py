"""Slider-cranks through positions: lengths, Becht's chain, least squares, and files."""

from __future__ import annotations

import math

import numpy as np
import pytest

from balance import design_space, synthesize
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.rr_chain import chain_from_three_positions
from balance.studies.synthesis.slider_cranks import slider_crank_through, slider_crank_urdf
from kinematics import load
from kinematics.errors import SynthesisError
from kinematics.model.document.element import Document
from tests.independent.synthesis_run import judge_task, random_task
from tests.support.covering import number_of_cases

FOUR = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22), (-0.2, 0.4, -1.57)]


def places_of(positions):
    return [Position(*each) for each in positions]


@pytest.mark.parametrize("count", [2, 3])
def test_links_keep_their_lengths_and_the_slider_its_line(count):
    """At all positions, as the tool carries the pivots of the coupler there."""
    for seed in range(number_of_cases(5, 60)):
        positions, pivot = random_task(count, seed)
        places = places_of(positions)
        design = slider_crank_through(places, **pivot)
        start = design.pivots()
        G, line = start["crank_base"], design.line
        length = abs(start["crank_tip"] - G)
        assert abs(abs(line) - 1.0) < 1e-12
        for k, place in enumerate(places):
            now, turn = design.pivots(k), np.exp(1j * (place.angle - places[0].angle))
            near = 1e-9 * (length + 1.0)
            for name in ("crank_tip", "slider"):
                carried = place.point + turn * (start[name] - places[0].point)
                assert abs(now[name] - carried) < near
            assert abs(abs(now["crank_tip"] - G) - length) < near
            assert abs(abs(now["slider"] - now["crank_tip"]) - length) < near
            assert abs(((now["slider"] - G) * line.conjugate()).imag) < near
        for name, chosen in pivot.items():
            assert (
                abs(start[{"fixed": "crank_base", "moving": "crank_tip"}[name]] - chosen) < 1e-9
            )


def test_it_moves_the_tool_as_the_chain_whose_links_turn_as_far():
    """The slider takes the place of the belt of a pantograph with k = -1."""
    for seed in range(5):
        places = places_of(random_task(3, seed)[0])
        chain = chain_from_three_positions(places, -1.0)
        pivots = slider_crank_through(places).pivots()
        assert pivots["crank_base"] == pytest.approx(chain.fixed, abs=1e-9)
        assert pivots["crank_tip"] == pytest.approx(chain.moving, abs=1e-9)


def test_more_positions_are_met_if_they_can_be_and_else_are_nearest():
    """Planted ones are met; of others, no other pivots leave a smaller sum of squares."""
    rng = np.random.default_rng(3)
    G, P, Q = rng.normal(size=3) + 1j * rng.normal(size=3)
    turns = np.array([0.0, 0.4, 0.9, 1.3, 2.0])
    w = np.exp(1j * turns)
    planted = G + P * w.conjugate() + Q * w
    places = [Position(z.real, z.imag, 0.2 + a) for z, a in zip(planted, turns, strict=True)]
    design = slider_crank_through(places)
    assert design.miss < 1e-12 and abs(design.crank_base - G) < 1e-10

    moved = planted + 0.1 * (rng.normal(size=5) + 1j * rng.normal(size=5))
    places = [Position(z.real, z.imag, a) for z, a in zip(moved, turns, strict=True)]
    design = slider_crank_through(places)
    assert design.angle_error < 1e-12

    def left(G, P, Q):
        return np.sum(np.abs(G + P * w.conjugate() + Q * w - moved) ** 2)

    best = np.array([design.crank_base, design.crank, design.arm])
    for _ in range(20):
        step = 1e-3 * (rng.normal(size=3) + 1j * rng.normal(size=3))
        assert left(*(best + step)) > left(*best)


def test_the_angles_count_up_to_whole_turns():
    """From 170° to -170° the crank turns by 20°."""
    places = [Position(0.0, 0.0, math.radians(170.0)), Position(0.3, 0.1, math.radians(-170.0))]
    design = slider_crank_through(places, fixed=0.2 - 0.4j)
    assert abs(np.diff(design.crank_angles)[0]) == pytest.approx(math.radians(20.0))
    assert design.pressure_angle == pytest.approx(math.radians(10.0))


def test_its_file_has_the_design_space_of_the_family():
    """Six dimensions, five of which are inertia transfers, of a random one."""
    urdf = slider_crank_urdf(slider_crank_through(places_of(FOUR[:3])))
    space = design_space(load(Document("slider-crank", urdf), bodies="all"))
    assert (space.nullity, space.serial_nullity, space.linkage.mobility) == (6, 5, 1)


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_files_are_balanced_and_meet_their_positions(count, tmp_path):
    """By `verify`, and by a walk from position to position that only reads the file."""
    for seed in range(number_of_cases(3, 30)):
        line = judge_task("slider-crank", count, seed, False, False, tmp_path)
        assert not line.get("wrong") and not line.get("undecided"), line


@pytest.mark.slow
def test_masses_are_as_asked_and_four_positions_are_missed():
    synthesis = synthesize(FOUR[:3], kind="slider-crank")
    (best,) = synthesis.mechanisms
    assert synthesis.verdict == "feasible" and best.good
    assert best.numbers["coupler_mass"] > 0.999 and best.numbers["slider_mass"] > 0.0999
    missed = synthesize(FOUR, kind="slider-crank", density=None)
    assert missed.verdict == "infeasible" and "no slider-crank meets" in missed.words
    assert "°" not in missed.words
    (nearest,) = missed.mechanisms
    assert (
        synthesize(
            FOUR, kind="slider-crank", density=None, within=1.01 * nearest.position_error
        )
        .mechanisms[0]
        .meets
    )


def test_a_tool_that_turns_too_far_folds_the_links():
    """At half a turn of the tool, crank and coupler lie on each other at both ends."""
    for degrees, kinds in ((150.0, []), (165.0, ["branch"])):
        places = [Position(0.0, 0.0, 0.0), Position(1.0, 1.0, math.radians(degrees))]
        design = slider_crank_through(places, fixed=0.3j)
        assert [each.kind for each in design.defects] == kinds
        assert design.pressure_angle == pytest.approx(math.radians(degrees / 2.0))


def test_positions_in_another_order_are_named():
    places = places_of([FOUR[0], FOUR[2], FOUR[1]])
    (defect,) = slider_crank_through(places).defects
    assert defect.kind == "order" and "1, 3, 2" in defect.words


@pytest.mark.parametrize(
    ("places", "pivot", "said"),
    [
        ([(0, 0, 0), (1, 0, 0)], {"moving": 0.3j}, "angles"),
        ([(0, 0, 0), (1, 0, math.pi)], {"fixed": 0.3j}, "half a turn"),
        ([(0, 0, 0), (1, 0, 0.3), (2, 0, 0.3)], {}, "angles"),
        ([(1, 0, 0), (math.cos(1), math.sin(1), 1)], {"fixed": 0j}, "about a pole"),
        ([(1, 0, 0), (math.cos(1), math.sin(1), 1)], {"moving": 0j}, "about a pole"),
    ],
)
def test_positions_without_a_slider_crank_are_refused(places, pivot, said):
    with pytest.raises(SynthesisError, match=said):
        slider_crank_through(places_of(places), **pivot)
