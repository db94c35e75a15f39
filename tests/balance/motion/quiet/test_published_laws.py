"""Laws of the centre of mass: factors of m d / T² that are published, or follow by hand.

S. Briot, V. Arakelian and J.-P. Le Baron (2012): constant acceleration and braking on a
straight line of the centre of mass has the least peak, 4.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
from tests.support.planned_arms import TASKS, base_wrenches, planar_arm, slide

# On a slide of 2 kg over 0.5 m in 1 s, m d / T² is 1.
ENDS = ([0.0], [0.5], 1.0)


@pytest.mark.parametrize(
    ("measure", "least", "quintic", "trapezoidal"),
    [
        ("peak", 4.0, 10.0 / np.sqrt(3.0), 4.5),
        ("rms", np.sqrt(12.0), np.sqrt(120.0 / 7.0), 4.5 * np.sqrt(2.0 / 3.0)),
    ],
)
def test_factors_of_the_laws(measure, least, quintic, trapezoidal):
    plan = balance.quiet_motion(slide(), *ENDS, measure=measure)
    assert plan.bound == pytest.approx(least, rel=1e-12)
    assert plan.quintic.value == pytest.approx(quintic, rel=1e-4)
    assert plan.trapezoidal.value == pytest.approx(trapezoidal, rel=2e-3)
    assert least <= plan.after.value < 1.006 * least
    assert plan.verdict == "optimal"


def test_the_factors_scale_with_mass_distance_and_time():
    plan = balance.quiet_motion(slide(5.0), [0.1], [-0.2], 0.4)
    assert plan.bound == pytest.approx(np.sqrt(12.0) * 5.0 * 0.3 / 0.16, rel=1e-12)
    assert plan.after.value == pytest.approx(plan.bound, rel=2e-3)


def test_a_serial_robot_moves_its_centre_of_mass_on_a_line():
    """The bound of the two-link arm is reached, with the acceleration constant in size."""
    arm = planar_arm(2)
    plan = balance.quiet_motion(arm, [0.2, 0.4], [1.4, 1.5], 1.0, measure="peak")
    assert plan.verdict == "optimal" and plan.law == "planned"
    motion = plan.trajectory(81)
    wrench = balance.motion.shaking(arm, motion.u, motion.ud, motion.udd)
    sizes = np.linalg.norm(wrench[:, 3:], axis=1)
    away = np.abs(motion.time - 0.5) > 0.06
    assert np.ptp(sizes[away]) < 0.02 * sizes.max()
    directions = wrench[away, 3:] / sizes[away, None]
    assert np.abs(directions @ directions[0]) == pytest.approx(1.0, abs=0.02)
    # The reduction of the peak is that of the laws, and what the straight line saves.
    assert plan.after.value / plan.quintic.value < 4.0 / (10.0 / np.sqrt(3.0))


@pytest.mark.slow
def test_a_parallel_robot_moves_its_centre_of_mass_on_a_line():
    """The same of a five-bar, its force by Pinocchio: 4 m d / T², but in the middle."""
    build, start, end = TASKS["five_bar"]
    linkage = build()
    plan = balance.quiet_motion(linkage, start, end, 0.5, measure="peak")
    assert plan.verdict == "optimal" and plan.law == "planned"
    time, *motion = plan.samples(201)
    force = base_wrenches(linkage, *motion)[:, 3:]
    sizes = np.linalg.norm(force, axis=1)
    away = np.abs(time - 0.25) > 0.03
    assert plan.bound <= sizes.max() * (1 + 1e-6)
    assert sizes.max() < 1.01 * plan.bound and sizes[away].min() > 0.97 * plan.bound
    directions = force[away] / sizes[away, None]
    assert np.abs(directions @ directions[0]) == pytest.approx(1.0, abs=0.02)
    assert sizes.max() / plan.quintic.value < 4.0 / (10.0 / np.sqrt(3.0))
