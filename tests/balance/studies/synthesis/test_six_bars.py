"""Six-bars through positions: their dyad, their masses, and what they cannot do."""

from __future__ import annotations

import numpy as np
import pytest

from balance import synthesize, verify
from balance.masses import feasible
from balance.studies.synthesis.four_bar_masses import bare_space, four_bar_urdf
from balance.studies.synthesis.general_four_bars import general_four_bars
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.six_bars import six_bars
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.independent.synthesis_run import judge_task, miss_of_file, random_task
from tests.support.covering import number_of_cases

PLACES = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22)]


@pytest.fixture(scope="module")
def six_bar():
    """A six-bar through the positions, and its design space."""
    designs = general_four_bars([Position(*each) for each in PLACES])
    return six_bars(designs[:2])[0]


def test_the_dyad_keeps_its_lengths_and_does_not_fold(six_bar):
    """Its hinges on base, crank or rocker are points of them, at every position."""
    design, _ = six_bar
    start, end = design.pivots(), f"dyad_{design.side}"
    base, tip = f"{design.side}_base", f"{design.side}_tip"
    for k in range(len(PLACES)):
        now = design.pivots(k)
        turn = (now[tip] - now[base]) / (start[tip] - start[base])
        assert abs(turn) == pytest.approx(1.0, abs=1e-9)
        assert now["dyad_base"] == start["dyad_base"]
        assert now[end] == pytest.approx(
            now[base] + turn * (start[end] - start[base]), abs=1e-9
        )
        links = [now["dyad_middle"] - now[name] for name in ("dyad_base", end)]
        given = [start["dyad_middle"] - start[name] for name in ("dyad_base", end)]
        assert np.abs(links) == pytest.approx(np.abs(given), rel=1e-9)
        angle = abs(np.angle(links[0] / links[1]))
        assert min(angle, np.pi - angle) >= design.dyad_transmission - 1e-3
        side = np.angle(links[0] / links[1]) * np.angle(given[0] / given[1])
        assert side > 0.0


def test_the_dyad_makes_the_balance(six_bar):
    """Without it no bodies that can be built balance the four-bar; with it some do."""
    design, space = six_bar
    assert feasible(space).verdict == "feasible"
    four_bar = bare_space("four-bar", four_bar_urdf(design))
    assert feasible(four_bar).verdict == "infeasible"
    assert space.linkage.mobility == four_bar.linkage.mobility == 1


@pytest.mark.slow
def test_a_six_bar_is_balanced_and_meets_its_positions(tmp_path):
    synthesis = synthesize(PLACES, kind="six-bar")
    best = synthesis.mechanisms[0]
    assert synthesis.verdict == "feasible" and best.position_error < 1e-10
    assert "dyad between base and" in synthesis.remarks[0]
    masses = [
        sum(mass for name, mass in each.numbers.items() if name.endswith("_mass"))
        for each in synthesis.mechanisms
    ]
    assert masses == sorted(masses)
    path = tmp_path / "six.urdf"
    synthesis.to_urdf(path)
    checked = verify(load(path), trajectories=2)
    assert checked.balanced and checked.moment_residual < 1e-10
    assert miss_of_file(path, best, PLACES) < 1e-8
    # A little more mass on the dyad, and it shakes.
    text = best.urdf.decode()
    at = text.index('<link name="dyad_1">')
    mass = text[at:].partition('mass value="')[2].partition('"')[0]
    heavier = text[:at] + text[at:].replace(f'"{mass}"', f'"{1.01 * float(mass)!r}"', 1)
    assert not verify(load(Document("heavier", heavier.encode())), trajectories=1).balanced


@pytest.mark.slow
def test_random_tasks_are_balanced_or_not_said_to_be(tmp_path):
    for count in (2, 3):
        for seed in range(number_of_cases(1, 20)):
            line = judge_task("six-bar", count, seed, False, False, tmp_path)
            assert not line.get("wrong"), line


@pytest.mark.parametrize(
    ("count", "options", "said"),
    [(6, {}, "up to five positions"), (5, {"within": 1e-3}, "meets its positions")],
)
def test_what_a_six_bar_cannot_do_is_refused(count, options, said):
    places = random_task(count, 0)[0]
    with pytest.raises(UsageError, match=said):
        synthesize(places, kind="six-bar", **options)
