"""The study of Clavel's Delta: its figures by circles of elbows, and bars of even mass by hand.

Its file and page are in docs/machines/. Arrays are (samples, legs, 3).
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from tests.support.source_files import ROOT

FILE = ROOT / "docs" / "machines" / "clavel_delta.urdf"
# R. Clavel, 1991: lengths in metres, masses in kilograms; a pair of rods has one mass.
ARM, ROD, GAP = 0.2, 0.4, 0.126
ARM_MASS, ELBOW, RODS, PLATE = 0.1, 0.018, 0.045, 0.1
# Ours: the radius of the plate, and the cosine of the arms in the pose of the file.
RADIUS, COSINE = 0.04, 0.57
OUT = np.array([[np.cos(a), np.sin(a), 0.0] for a in np.deg2rad([0.0, 120.0, 240.0])])
AXES = np.cross([0.0, 0.0, 1.0], OUT)
DOWN = np.array([0.0, 0.0, -1.0])
SHOULDERS = (GAP + RADIUS) * OUT
HOME = (ARM * np.sqrt(1.0 - COSINE**2) + np.sqrt(ROD**2 - (GAP + ARM * COSINE) ** 2)) * DOWN
AT_ELBOW, AT_PLATE = ARM_MASS / 2 + ELBOW + RODS / 2, PLATE + 3 * RODS / 2
REACH = {"arm": 0.12, "rod": 0.17}
REGIONS = {
    "arm1": "ball(-0.057,0,0.08216,0.02)",
    "arm2": "ball(0.0285,-0.049363,0.08216,0.02)",
    "arm3": "ball(0.0285,0.049363,0.08216,0.02)",
    "rod1a": "ball(0.09,0,0.12,0.02)",
}


def elbows(plate):
    """Elbows and wrists of the arms whose rods reach the centre of the plate (samples, 3)."""
    wrists = plate[:, None] + RADIUS * OUT
    way = wrists - SHOULDERS
    out, down, aside = ((way * v).sum(axis=2) for v in (OUT, DOWN, AXES))
    chord = (ARM**2 - ROD**2 + out**2 + down**2 + aside**2) / (2.0 * ARM)
    angle = np.arctan2(down, out) - np.arccos(chord / np.hypot(out, down))
    turned = np.cos(angle)[..., None] * OUT + np.sin(angle)[..., None] * DOWN
    return SHOULDERS + ARM * turned, wrists


def loads(plate, step, weights=()):
    """Shaking force and moment about the origin over time (samples, 3), N and N m.

    Weights are a link, its leg and a mass, behind the shoulder or the elbow.
    """
    ends, wrists = elbows(plate)
    starts = np.broadcast_to(SHOULDERS, ends.shape)
    linear, angular = np.zeros((2, *plate.shape))

    def add(mass, start, end):
        """A thin bar of even mass; a point where both ends are one."""
        nonlocal linear, angular
        v, w = (np.gradient(p, step, axis=0, edge_order=2) for p in (start, end))
        linear = linear + mass * (v + w) / 2.0
        twice = np.cross(2.0 * start + end, v) + np.cross(start + 2.0 * end, w)
        angular = angular + mass * twice / 6.0

    for leg in range(3):
        add(ARM_MASS, starts[:, leg], ends[:, leg])
        add(ELBOW, ends[:, leg], ends[:, leg])
        add(RODS, ends[:, leg], wrists[:, leg])
    add(PLATE, plate, plate)
    for link, leg, mass in weights:
        joint, end, length = {
            "arm": (starts, ends, ARM),
            "rod": (ends, wrists, ROD),
        }[link]
        place = (joint - REACH[link] / length * (end - joint))[:, leg]
        add(mass, place, place)
    return tuple(np.gradient(x, step, axis=0, edge_order=2) for x in (linear, angular))


def peaks(weights=(), about=(0.0, 0.0, -0.3239), samples=3001):
    """Largest force and moment of the motion of the page, N and N m, about its point."""
    s = np.linspace(0.0, 1.0, samples)
    across = 0.2 * (s**3 * (10 - 15 * s + 6 * s**2) - 0.5)
    lift = 0.025 * 64 * s**3 * (1 - s) ** 3
    plate = HOME + np.column_stack([across, 0.0 * s, lift])
    force, moment = loads(plate, 0.3 / (samples - 1), weights)
    moment = moment - np.cross(about, force)
    return tuple(np.linalg.norm(x[3:-3], axis=1).max() for x in (force, moment))


def least_weights():
    """Mass of each weight that balances the force, by hand."""
    rod = AT_PLATE * ROD / REACH["rod"]
    other = AT_ELBOW * ARM / REACH["arm"]
    first = (AT_ELBOW + AT_PLATE + rod) * ARM / REACH["arm"]
    return {"rod1a": rod, "arm1": first, "arm2": other, "arm3": other}


def all_weights():
    """The same as weights of `loads`."""
    return [(link[:3], int(link[3]) - 1, mass) for link, mass in least_weights().items()]


def test_the_file_of_the_delta_has_the_masses_of_the_thesis():
    linkage = kinematics.load(FILE)
    known = {body.name: balance.bodies.mass_properties(body.inertia) for body in linkage.bodies}
    ends, wrists = (x[0] for x in elbows(HOME[None]))
    total = 0.0
    for leg in range(3):
        arm = known[f"arm{leg + 1}"]
        pair = [known[f"rod{leg + 1}{side}"] for side in "ab"]
        moment = ARM_MASS * (SHOULDERS[leg] + ends[leg]) / 2.0 + ELBOW * ends[leg]
        assert arm.mass == pytest.approx(ARM_MASS + ELBOW, abs=1e-12)
        assert arm.mass * arm.com == pytest.approx(moment, abs=1e-9)
        assert [rod.mass for rod in pair] == pytest.approx([RODS / 2] * 2, abs=1e-12)
        middle = (pair[0].com + pair[1].com) / 2.0
        assert middle == pytest.approx((ends[leg] + wrists[leg]) / 2.0, abs=1e-8)
        for rod in pair:
            bar = RODS / 2 * ROD**2 / 12.0
            assert np.linalg.eigvalsh(rod.inertia) == pytest.approx([0, bar, bar], abs=1e-10)
        total += arm.mass + 2 * pair[0].mass
    assert known["plate"].com == pytest.approx(HOME, abs=1e-8)
    assert total + known["plate"].mass == pytest.approx(0.589, abs=1e-12)


def test_the_delta_shakes_as_its_bars_say():
    """Rows of the page: no weights, one behind each arm, and one on a rod too.

    The last moment is 2.603 N m on the page, where the weight is beside the middle of the rods.
    """
    assert peaks() == pytest.approx((3.352, 0.3138), abs=1e-3)
    half = AT_ELBOW * ARM / REACH["arm"]
    assert half == pytest.approx(0.15, abs=1e-3)
    arms = peaks([("arm", leg, half) for leg in range(3)])
    assert arms == pytest.approx((2.223, 0.530), abs=1e-3)
    assert peaks(all_weights()) == pytest.approx((0.0, 2.601), abs=1e-3)


def test_four_weights_balance_the_delta_and_three_do_not():
    """13 conditions, as the rods of an arm are parallel; the least masses by hand."""
    space = balance.design_space(FILE, None, "force")
    assert space.rank == 13
    answer = balance.counterweights(space, list(REGIONS), REGIONS, density=None)
    masses = least_weights()
    assert answer.added_mass == pytest.approx(sum(masses.values()), rel=1e-4)
    assert sum(masses.values()) == pytest.approx(1.783, abs=1e-3)
    arms = [link for link in REGIONS if link != "rod1a"]
    assert balance.counterweights(space, [*arms, "plate"], density=None).verdict == "infeasible"


@pytest.mark.slow
def test_a_moment_that_a_table_does_not_tell_from_zero_is_none(tmp_path):
    """Straight up and down a Delta has no moment; a weight of one arm makes one."""
    s = np.linspace(0.0, 1.0, 61)
    law = s**3 * (10 - 15 * s + 6 * s**2)
    table, heavier = tmp_path / "up.csv", tmp_path / "heavier.urdf"
    rows = np.column_stack([0.3 * s, 0.1 * (law - 0.5)])
    np.savetxt(table, rows, "%.12f", ",", header="time,z", comments="")
    text = FILE.read_text(encoding="utf-8")
    heavier.write_text(text.replace('<mass value="0.118"/>', '<mass value="0.2"/>', 1))
    linkage = kinematics.load(FILE)
    motion = balance.motion.from_tool_csv(linkage, table, "plate")
    before = balance.verify(linkage, motions=[motion])
    pair = balance.motion.verify_against(heavier, before, motions=[motion])
    assert "moment 0 → " in pair.sentence
    pair = balance.motion.verify_against(before, before)
    assert "moment 0 N m peak" in pair.sentence
