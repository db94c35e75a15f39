"""More points than a four-bar passes: planted ones, planted ones with errors, words."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from balance import synthesize
from balance.app.answers.text.synthesis import synthesis_facts
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.function_four_bars import FunctionPoint
from balance.studies.synthesis.near_four_bars import (
    near_function_four_bars,
    near_timed_four_bars,
)
from balance.studies.synthesis.positions import Position
from tests.support.covering import number_of_cases
from tests.support.planted_four_bars import move_file, planted_function, planted_point

pytestmark = pytest.mark.slow


def root_mean_square(values):
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def timed(points, angles):
    return [Position(z.real, z.imag, a) for z, a in zip(points, angles, strict=True)]


def listed(crank, rocker):
    return [FunctionPoint(*pair) for pair in zip(crank, rocker, strict=True)]


@pytest.mark.parametrize("count", [6, 9])
def test_points_in_time_have_the_four_bar_that_made_them(count):
    for seed in range(number_of_cases(2, 10)):
        alpha, A, B, points, _ = planted_point(count, seed)
        designs = near_timed_four_bars(timed(points, alpha))
        apart = [abs(x.crank_tip - A[0]) + abs(x.rocker_tip - B[0]) for x in designs]
        assert min(apart) < 1e-8
        assert designs[0].root_mean_square < 1e-12


@pytest.mark.parametrize("count", [6, 9])
def test_functions_have_the_four_bar_that_made_them(count):
    for seed in range(number_of_cases(2, 10)):
        alpha, psi, A, B = planted_function(count, seed)
        designs = near_function_four_bars(listed(alpha, psi))
        apart = [abs(x.crank_tip - A[0]) + abs(x.rocker_tip - B[0]) for x in designs]
        assert min(apart) < 1e-8
        assert designs[0].root_mean_square < 1e-12


def test_points_with_errors_are_at_least_as_near_as_to_the_planted_four_bar():
    """Its own errors are those that were added; the file has those that are said."""
    for seed in range(number_of_cases(2, 10)):
        alpha, _, _, points, _ = planted_point(8, seed)
        noise = 1e-3 * np.random.default_rng(seed).normal(size=(8, 2)) @ [1.0, 1.0j]
        best = near_timed_four_bars(timed(points + noise, alpha))[0]
        assert best.root_mean_square < root_mean_square(noise)
        there = move_file(four_bar_urdf(best), alpha - alpha[0])[0]
        apart = np.abs(there - points - noise)
        assert best.root_mean_square == pytest.approx(root_mean_square(apart), rel=1e-6)
        assert best.error == pytest.approx(apart.max(), rel=1e-6)


def test_functions_with_errors_are_at_least_as_near_as_to_the_planted_four_bar():
    for seed in range(number_of_cases(2, 10)):
        alpha, psi, *_ = planted_function(8, seed)
        noise = 1e-3 * np.random.default_rng(seed).normal(size=8)
        best = near_function_four_bars(listed(alpha, psi + noise))[0]
        assert best.root_mean_square < root_mean_square(noise - noise.mean())
        turns = move_file(four_bar_urdf(best), alpha - alpha[0])[1]
        first = best.positions[0].angle - best.start.angle
        errors = turns - (psi + noise - psi[0] - noise[0]) - first
        assert best.root_mean_square == pytest.approx(root_mean_square(errors), rel=1e-6)
        assert best.angle_error == pytest.approx(np.abs(errors).max(), rel=1e-6)


def test_an_answer_says_how_near_it_is_and_claims_no_more():
    """Without a distance that is accepted none is said to be the nearest of all."""
    alpha, _, _, points, _ = planted_point(7, 1)
    noise = 1e-3 * np.random.default_rng(7).normal(size=(7, 2)) @ [1.0, 1.0j]
    places = [tuple(each) for each in timed(points + noise, alpha)]
    answer = synthesize(places, kind="geared-four-bar", timed=True)
    assert answer.verdict == "undecided"
    assert "none of the four-bars that were tried reaches all positions" in answer.words
    assert any("another four-bar may be nearer" in words for words in answer.remarks)
    best = answer.mechanisms[0]
    facts = dict(synthesis_facts(answer))
    numbers = [float(word) for word in re.findall(r"([0-9.]+) mm", facts["distances"])]
    there = move_file(best.urdf, alpha - alpha[0])[0]
    apart = np.abs(there - points - noise)
    assert numbers == pytest.approx(
        [1e3 * apart.max(), 1e3 * root_mean_square(apart)], rel=1e-3
    )
    accepted = synthesize(places, kind="geared-four-bar", timed=True, within=0.01)
    assert accepted.verdict == "feasible" and "near the positions" in accepted.words


def test_a_function_is_followed_nearly():
    """y = x² from 0 to 1 at nine points: 90° of the crank, 60° of the rocker."""
    x = np.linspace(0.0, 1.0, 9)
    points = np.column_stack([0.5 * math.pi * x, math.pi / 3.0 * x**2]).tolist()
    answer = synthesize(kind="geared-four-bar", function=points, within=math.radians(1.0))
    best = answer.mechanisms[0]
    assert answer.verdict == "feasible" and "nearly follows the function" in answer.words
    assert 1e-6 < best.angle_error < math.radians(0.5)
    assert best.confirmation.confirmed and "errors" in dict(synthesis_facts(answer))
