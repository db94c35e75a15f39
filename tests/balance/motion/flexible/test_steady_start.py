"""Links that bend under an input at speed start without a blow."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.flexible.flex_data import beam_deflection
from kinematics.errors import LinkageError
from tests.support.flexible_cases import four_bar_text

SPEED = 5.0


def crank_at_speed(link, duration=0.2, **options):
    """The parallelogram, its coupler 1 m long, with the crank at speed."""
    return balance.flexible.simulate_flexible(
        "four_bar_parallelogram",
        [f"coupler={link}"],
        {"u1": f"speed:{SPEED}"},
        duration,
        samples=21,
        **options,
    )


@pytest.mark.slow
def test_the_coupler_of_a_parallelogram_bends_as_a_beam_under_its_inertia():
    """It translates on a circle of 0.5 m: 5 ρA a L⁴ / (384 EI) in its middle, and no more."""
    found = crank_at_speed("EI:300,rhoA:0.4", modes=8)
    angle = np.arctan2(0.4, 0.3) + SPEED * found.time
    across = 0.5 * SPEED**2 * np.abs(np.sin(angle))
    static = 5.0 * 0.4 * across / (384.0 * 300.0)
    bends = beam_deflection(found.motion, found.flexible, "coupler")
    assert np.abs(bends - static).max() < 2e-3 * static.max()


@pytest.mark.slow
def test_the_shaking_does_not_grow_with_the_number_of_modes():
    """The blow did: 46.9, 64.5, 100.9 N in issue 38. It comes on request."""
    link = "rect(0.01,0.006),steel"
    peaks = [crank_at_speed(link, modes=modes).peak_force for modes in (2, 6, 12)]
    assert np.ptp(peaks) < 1e-4 * peaks[0]
    blows = [crank_at_speed(link, modes=m, from_rest=True).peak_force for m in (2, 6)]
    assert blows[1] > 1.3 * blows[0] > 1.3 * peaks[0]


@pytest.mark.slow
def test_stiff_links_start_as_rigid_ones(tmp_path):
    """The coupler is a uniform rod: the base reaction of rigid bodies, by the regressor."""
    path = tmp_path / "four_bar.urdf"
    path.write_text(four_bar_text(1.0), encoding="utf-8")
    linkage = kinematics.load(path)
    rigid = balance.motion.shaking(linkage, q=[0.0], qd=[SPEED], qdd=[0.0])
    found = balance.flexible.simulate_flexible(
        linkage, ["coupler=EI:1e5,rhoA:1"], {"u1": f"speed:{SPEED}"}, 0.01, samples=3
    )
    # The shaking is the reverse of the base reaction.
    assert np.allclose(found.force[0], -rigid[3:5], rtol=0, atol=1e-3 * np.abs(rigid).max())


def test_inputs_that_start_from_rest_start_at_rest():
    found = balance.flexible.simulate_flexible(
        "four_bar_parallelogram",
        ["coupler=EI:30,rhoA:0.4"],
        {"u1": "spin:3,0.1"},
        0.02,
        samples=3,
    )
    assert not found.motion.velocities[0].any()
    assert np.array_equal(found.motion.positions[0], found.flexible.mechanism.start)


@pytest.mark.parametrize(("share", "told"), [(0.028, False), (0.033, True)])
def test_large_bending_is_told(share, told):
    """5 ρA a L⁴ / (384 EI) is a part of the length of 1 m, the coupler's at its start."""
    stiffness = 5.0 * 0.4 * 0.5 * SPEED**2 * 0.8 / (384.0 * share)
    found = crank_at_speed(f"EI:{stiffness!r},rhoA:0.4", duration=1e-4)
    assert any(one.code == "large_bending" for one in found.notices) == told


def test_bending_without_end_is_refused():
    with pytest.raises(LinkageError, match="bend too far at this speed"):
        crank_at_speed("EI:0.001,rhoA:5")
