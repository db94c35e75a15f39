"""Balanced pantographs: masses of the source, momentum by other routes, and written files.

[B] G. Becht, MSc thesis, TU Delft, 2020, chapter 3.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from balance.app.cli.main import main
from balance.studies.synthesis.balanced_pantograph import BalancedPantograph, pantograph_urdf
from balance.studies.synthesis.confirm import confirm_along, confirm_balance
from balance.studies.synthesis.constrained_motion import (
    constrained_motion,
    list_defects,
    motion_csv,
)
from balance.studies.synthesis.pantograph import (
    PantographMasses,
    decouple,
    default_masses,
    first_centre,
    match_ratio,
    reduced_inertias,
    second_centre,
)
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.rr_chain import chain_from_moving_pivot
from balance.studies.synthesis.synthesize import balance_chain
from kinematics.errors import SynthesisError, UsageError
from tests.support.covering import number_of_cases
from tests.support.pantographs import S2, TABLE

A, B = Position(0.3, 0.1, 0.2), Position(0.1, 0.4, -0.7)


def points(masses, l1, s1, s2, s5, e1, e2):
    """Masses and places of [B] Fig. 2, recovered from Eqs. 3 and 4."""
    m = masses
    return [
        (m.m1, s1 * e1),
        (m.m2, l1 * e1 + s2 * e2),
        (m.m3, (l1 - m.s3) * e1 - m.l2 * e2),
        (m.m4, -m.l3 * e1 - m.s4 * e2),
        (m.m5, l1 * e1 + s5 * e2),
        (m.m6, -m.l3 * e1 - m.l2 * e2),
    ]


def momentum(masses, l1, s1, s2, s5, theta, rates):
    """Angular momentum about the fixed pivot and linear momentum, by differences of places."""
    h = 1e-6
    ends = [
        points(
            masses,
            l1,
            s1,
            s2,
            s5,
            *(cmath.exp(1j * (a + s * r * h)) for a, r in zip(theta, rates, strict=True)),
        )
        for s in (-1, 1)
    ]
    spin = masses.inertia_1 * rates[0] + masses.inertia_2 * rates[1]
    linear = 0.0
    for (mass, before), (_, after) in zip(*ends, strict=True):
        v, r = (after - before) / (2 * h), (after + before) / 2
        spin += mass * (r.conjugate() * v).imag
        linear += mass * v
    return spin, linear


def test_the_masses_of_the_table():
    """[B] table 1, l1 = 0.1 m: s1 = 24.319 mm, J1, J2 and C of the issue."""
    s1 = float(first_centre(TABLE, 0.1))
    assert s1 == pytest.approx(24.319e-3, abs=5e-7)
    J1, J2, C = reduced_inertias(TABLE, 0.1, 0.25, S2)
    assert J1 == pytest.approx(7.4338e-3, abs=5e-8)
    assert J2 == pytest.approx(1.46228e-2, abs=5e-8)
    assert C == pytest.approx(6.7030e-3, abs=5e-8)
    # The printed s2 leaves 25 g mm of 47 000: rounding. Force balance has 100.46 mm.
    assert float(second_centre(TABLE, 0.25).real) == pytest.approx(100.459e-3, abs=1e-6)
    # Eq. 19 prints (l1 - s3) m3: another s1, with which the force does not balance.
    printed = s1 + 2 * (0.1 - TABLE.s3) * TABLE.m3 / TABLE.m1
    s2 = float(second_centre(TABLE, 0.25).real)
    for centre, still in ((s1, True), (printed, False)):
        left = momentum(TABLE, 0.1, centre, s2, 0.25, (1.0, 0.3), (1.0, 0.0))[1]
        assert (abs(left) < 1e-9) == still


def test_the_momentum_is_that_of_the_masses():
    """J1, J2 and C against places of the masses and their differences, at random."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        numbers = rng.uniform(0.2, 2.0, 13)
        masses, l1 = PantographMasses(*numbers), float(rng.uniform(0.2, 2.0))
        s5 = complex(*rng.uniform(-1.0, 1.0, 2))
        theta, rates = rng.uniform(-3.0, 3.0, 2), rng.uniform(-1.0, 1.0, 2)
        s1, s2 = float(first_centre(masses, l1)), complex(second_centre(masses, s5))
        J1, J2, C = reduced_inertias(masses, l1, s5)
        m = masses
        closed = (l1 + m.l3) * (m.s4 * m.m4 + m.l2 * m.m6) + m.l2 * m.s3 * m.m3
        assert C == pytest.approx(closed, rel=1e-12)
        assert J1 * J2 > C * C
        c = C * math.cos(theta[0] - theta[1])
        spin, linear = momentum(masses, l1, s1, s2, s5, theta, rates)
        assert spin == pytest.approx((J1 + c) * rates[0] + (J2 + c) * rates[1], abs=1e-7)
        assert abs(linear) < 1e-7
        free = decouple(masses, l1)
        assert abs(reduced_inertias(free, l1, s5).coupling) < 1e-12
        ratio = -float(rng.uniform(0.2, 4.0))
        J1, J2, _ = reduced_inertias(match_ratio(free, l1, s5, ratio), l1, s5)
        assert -J2 / J1 == pytest.approx(ratio, rel=1e-12)


def random_pantograph(seed):
    """A chain through two random positions with random masses, and its ratio."""
    rng = np.random.default_rng(seed)
    turn = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.5))
    start = Position(*rng.uniform(-0.5, 0.5, 2), float(rng.uniform(-3.0, 3.0)))
    end = Position(*rng.uniform(-0.5, 0.5, 2), start.angle + turn)
    ratio = -round(float(rng.uniform(0.3, 1.5)), 3)
    chain = chain_from_moving_pivot([start, end], ratio, complex(*rng.uniform(-0.5, 0.5, 2)))
    own = default_masses(chain.length, abs(chain.reach))
    factors = rng.uniform(0.5, 2.0, 6)
    masses = replace(
        own,
        l2=own.l2 * factors[0],
        l3=own.l3 * factors[1],
        m1=factors[2],
        m2=factors[3],
        m4=factors[4],
        m5=0.1 * factors[5],
        m6=float(rng.choice([0.0, 0.4])),
        s4=float(rng.choice([0.0, 0.2])) * own.l2,
    )
    return balance_chain(chain, ratio, masses), ratio


@pytest.mark.slow
def test_random_linear_syntheses_are_confirmed_by_the_core():
    """Design space of one input, and Pinocchio: momentum below 1e-10 of the bodies' own.

    All fifty with ``ALL_CASES=1``.
    """
    for seed in range(number_of_cases(4, 50)):
        pantograph, ratio = random_pantograph(seed)
        found = confirm_balance(pantograph_urdf(pantograph, ratio))
        assert found.confirmed and found.momentum < 1e-10, (seed, found)
        wrong = confirm_balance(pantograph_urdf(pantograph, ratio * 1.01))
        assert not wrong.confirmed and wrong.momentum > 1e-6, seed


def relation(ratio):
    """The elbow is θ2 - θ1, and θ2 = θ1 / k."""
    return f"elbow={1.0 / ratio - 1.0!r}*shoulder"


@pytest.mark.slow
def test_the_commands_confirm_a_written_file(tmp_path, capsys):
    pantograph, ratio = random_pantograph(4)
    path = tmp_path / "pantograph.urdf"
    path.write_bytes(pantograph_urdf(pantograph))
    assert main(["report", str(path), "--motion", relation(ratio)]) == 0
    assert "as given      balanced" in capsys.readouterr().out
    words = ["verify", str(path), "--trajectories", "1", "--motion"]
    assert main([*words, relation(ratio)]) == 0
    assert main([*words, relation(1.1 * ratio)]) == 1
    # The same motion as a table, which is that of the integral of the momentum too.
    table = tmp_path / "motion.csv"
    motion = constrained_motion(pantograph)
    assert np.allclose(motion.u[:, 1], (1.0 / ratio - 1.0) * motion.u[:, 0], atol=1e-12)
    table.write_bytes(motion_csv(motion))
    assert main(["verify", str(path), "--csv", str(table)]) == 0
    assert confirm_along(pantograph_urdf(pantograph), motion).confirmed


def test_the_tool_of_the_file_is_at_the_positions():
    """By forward kinematics of the file: shoulder and elbow turned as the chain says."""
    from kinematics import load
    from kinematics.model.document.element import Document

    pantograph, _ = random_pantograph(5)
    chain = pantograph.chain
    linkage = load(Document("p", pantograph_urdf(pantograph)))
    link, tool = chain.link_turns[1], chain.tool_turns[1]
    assert linkage.inputs == ("shoulder", "elbow")
    by_name = {joint.name: joint for joint in linkage.joints}
    fixed, moving = (complex(*by_name[n].point[:2]) for n in ("shoulder", "elbow"))
    first = chain.positions[0].point
    point = moving + (first - moving) * cmath.exp(1j * (tool - link))
    point = fixed + (point - fixed) * cmath.exp(1j * link)
    assert point == pytest.approx(chain.positions[1].point, abs=1e-12)


def test_defects_are_named():
    chain = chain_from_moving_pivot([A, B], -0.5, 0.2 - 0.1j)
    good = balance_chain(chain, -0.5)
    assert list_defects(good) == ()
    # Link 2 through the tool would be flat on the way.
    straight = replace(good, link_angle=0.0)
    assert min(straight.deltas) < 0.0 < max(straight.deltas)
    assert [one.kind for one in list_defects(straight)] == ["branch", "circuit"]
    wide = chain_from_moving_pivot([A, Position(0.1, 0.4, -2.2)], -0.9, 0.2 - 0.1j)
    assert list_defects(balance_chain(wide, -0.9))[0].kind == "branch"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"m3": 0.0}, "m3 = 0 must be positive"),
        ({"l2": -1.0}, "l2 = -1 must be positive"),
        ({"m5": -0.1}, "m5 = -0.1 is negative"),
        ({"m1": math.nan}, "m1 = nan is not a finite"),
        ({"inertia_2": -1.0}, "inertia_2 = -1 is negative"),
    ],
)
def test_masses_that_are_none_are_refused(change, said):
    chain = chain_from_moving_pivot([A, B], -0.5, 0.2 - 0.1j)
    with pytest.raises(UsageError, match=said):
        balance_chain(chain, -0.5, replace(default_masses(0.3, 0.2), **change))


def test_links_that_turn_the_same_way_cannot_balance():
    chain = chain_from_moving_pivot([A, B], 0.5, 0.2 - 0.1j)
    with pytest.raises(SynthesisError, match="the same way"):
        balance_chain(chain, 0.5)


def test_point_masses_are_written():
    """No moment of inertia at all: still a file that loads, and that balances."""
    chain = chain_from_moving_pivot([A, B], -0.5, 0.2 - 0.1j)
    masses = replace(default_masses(chain.length, 0.2), inertia_1=0.0, inertia_2=0.0, m6=0.5)
    angle = balance_chain(chain, -0.5).link_angle
    pantograph = BalancedPantograph(chain, masses, angle)
    written = pantograph_urdf(pantograph)
    assert b'izz="0"' in written
    assert confirm_along(written, constrained_motion(pantograph)).confirmed
    # On another motion of the same inputs it keeps its momentum.
    motion = constrained_motion(pantograph)
    straight = motion._replace(u=np.linspace(motion.u[0], motion.u[-1], len(motion.time)))
    slope = np.broadcast_to(motion.u[-1] - motion.u[0], motion.u.shape)
    straight = straight._replace(ud=slope, udd=np.zeros_like(motion.udd))
    assert not confirm_along(written, straight).confirmed
