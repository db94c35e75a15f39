"""Any four-bars through positions: circle points by another method, files by Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

from balance import synthesize, verify
from balance.studies.synthesis.circle_points import cranks_through
from balance.studies.synthesis.four_bars import place_four_bar
from balance.studies.synthesis.general_four_bars import general_four_bars
from balance.studies.synthesis.mirrored_base import antiparallelograms_through
from balance.studies.synthesis.positions import Position
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.independent.second_synthesis import admissible, search_general, task_of
from tests.independent.synthesis_run import judge_task, planted_task, random_task
from tests.support.covering import number_of_cases


def places_of(positions):
    return [Position(*each) for each in positions]


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_cranks_keep_their_lengths(count):
    """The moving pivots, carried by the tool, stay on circles about the fixed ones."""
    seen = 0
    for seed in range(number_of_cases(3, 30)):
        positions = random_task(count, seed)[0]
        cranks = cranks_through(places_of(positions))
        task = task_of(positions)
        radii = np.abs(task.move(cranks.moving) - cranks.fixed)
        assert np.all(np.ptp(radii, axis=0) < 1e-10 * (task.size + radii[0]))
        seen += len(cranks.fixed)
    assert seen


def test_five_positions_of_a_known_four_bar_have_its_cranks():
    """Cranks at 0 and 1 with tips that close: both are among at most four."""
    alpha = np.array([0.4, 0.7, 1.1, 1.3, 1.9])
    A = 0.4 * np.exp(1j * alpha)
    gap = np.abs(1.0 - A)
    along = (0.9**2 - 0.8**2 + gap**2) / (2.0 * gap)
    B = A + (along + 1j * np.sqrt(0.9**2 - along**2)) * (1.0 - A) / gap
    U = (B - A) / 0.9
    tool = A + (0.3 + 0.5j) * U
    places = [
        Position(z.real, z.imag, angle)
        for z, angle in zip(tool, np.unwrap(np.angle(U)), strict=True)
    ]
    cranks = cranks_through(places)
    assert len(cranks.fixed) <= 4
    for base, tip in ((0.0, A[0]), (1.0, B[0])):
        apart = np.abs(cranks.fixed - base) + np.abs(cranks.moving - tip)
        assert apart.min() < 1e-9
    pivots = [each.pivots() for each in general_four_bars(places)]
    assert any(abs(at["crank_base"]) + abs(at["rocker_base"] - 1.0) < 1e-8 for at in pivots)


@pytest.mark.parametrize("count", [4, 5, 6])
def test_planted_antiparallelograms_are_found_in_closed_form(count):
    """Checked by the lengths of its links; positions moved a little have none."""
    for seed in (1, 3, 5):
        positions = planted_task(count, seed)[0]
        designs = antiparallelograms_through(places_of(positions))
        assert designs
        task = task_of(positions)
        names = ("crank_base", "rocker_base", "crank_tip", "rocker_tip")
        for design in designs[::17]:
            G, H, W, Z = (design.pivots()[name] for name in names)
            lengths = abs(W - G), abs(Z - H), abs(Z - W), abs(H - G)
            assert lengths[0] == pytest.approx(lengths[1], rel=1e-9)
            assert lengths[2] == pytest.approx(lengths[3], rel=1e-9)
            for base, tip in ((G, W), (H, Z)):
                assert np.ptp(np.abs(task.move(tip) - base)) < 1e-9 * task.size
        x, y, angle = positions[-1]
        moved = [*positions[:-1], (x + 1e-3 * task.size, y, angle)]
        assert antiparallelograms_through(places_of(moved)) == ()


def test_an_antiparallelogram_of_five_positions_is_the_planted_one():
    """Five tangents determine the conic; the ratio of base and crank is that of the plan."""
    alpha = np.array([0.4, 0.8, 1.3, 1.9, 2.6])
    A, B = place_four_bar("antiparallelogram", 2.3, alpha)
    U = (B - A) / abs(B[0] - A[0])
    tool = A + (0.2 - 0.7j) * U
    places = [
        Position(z.real, z.imag, a) for z, a in zip(tool, np.unwrap(np.angle(U)), strict=True)
    ]
    designs = antiparallelograms_through(places)
    assert {round(each.ratio, 8) for each in designs} == {2.3}
    assert any(abs(each.fixed) < 1e-8 for each in designs)


FOUR_PLACES = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22), (-0.2, 0.4, -1.57)]


@pytest.mark.slow
def test_a_second_search_meets_the_four_positions():
    assert search_general(FOUR_PLACES) is not None


def test_a_geared_four_bar_is_balanced_and_meets_four_positions():
    """The file by Pinocchio; the pivots by the second search's own judgement of defects."""
    synthesis = synthesize(FOUR_PLACES, kind="geared-four-bar")
    best = synthesis.mechanisms[0]
    assert synthesis.verdict == "feasible" and best.position_error < 1e-10
    linkage = load(Document("geared", best.urdf))
    assert linkage.mobility == 1
    checked = verify(linkage, trajectories=1)
    assert checked.balanced and checked.moment_residual < 1e-10
    # Not one of the special four-bars.
    assert not any(
        admissible(kind, task_of(FOUR_PLACES), tuple(best.pivots.values()))
        for kind in ("kite", "antiparallelogram")
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["four-bar", "geared-four-bar"])
def test_random_tasks(kind, tmp_path):
    """Files pass, and what is said not to be is not found by another search."""
    for count in (2, 3, 4, 5):
        for seed in range(number_of_cases(2, 20)):
            line = judge_task(kind, count, seed, False, True, tmp_path)
            assert not line.get("wrong") and not line.get("undecided"), line


@pytest.mark.parametrize(
    ("count", "options", "said"),
    [
        (6, {}, "up to five positions"),
        (5, {"within": 1e-3}, "meets its positions"),
        (3, {"ratio": -1.0}, "ratio"),
    ],
)
def test_what_a_geared_four_bar_cannot_do_is_refused(count, options, said):
    places = random_task(count, 0)[0]
    with pytest.raises(UsageError, match=said):
        synthesize(places, kind="geared-four-bar", **options)
