"""Quantities of a sweep against the functions that compute them, and formulas by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.partial.motion_loads import input_inertia
from balance.motion.verification.crank_revolution import revolve_crank
from kinematics.model.document.element import Document
from tests.support.sweep_topologies import gallery_text, write_numbers

pytestmark = pytest.mark.lanes

STUDIES = Path(__file__).resolve().parents[4] / "docs" / "studies"
ALL = {
    "rank": {}, "orders": {"count": 5}, "singular_values": {}, "distance": {},
    "design": {"minimise": "mass"}, "counterweights": {"links": ["crank", "rocker"]},
    "input_inertia": {}, "shaking": {"speed": 5.0}, "certainty": {},
}  # fmt: skip


def written(model: str, **values: float) -> kinematics.Linkage:
    """A model with numbers written into its file."""
    text = write_numbers(gallery_text(model), values)
    return kinematics.load(Document("written", text.encode()))


@pytest.mark.slow
def test_every_quantity_of_a_written_file():
    table = balance.sweep(
        "four_bar_general", {"q4.origin.x": [1.05, 1.15]}, quantities=ALL, balance="force"
    )
    assert not table.reasons
    for row, x in enumerate((1.05, 1.15)):
        linkage = written("four_bar_general", **{"q4.origin.x": x})
        # The crank stays where it is in the sweep; the reader moves it a little.
        space = balance.design_space(linkage, balance="force")
        found = {name: table[name][row] for name in table}
        ranks = [order.rank for order in space.orders]
        assert [found[f"rank_{k}"] for k in range(5)] == ranks + [space.rank] * (5 - len(ranks))
        assert found["design"] == balance.design(space, "mass").verdict == "feasible"
        matter = balance.counterweights(space, ["crank", "rocker"])
        assert found["counterweights"] == matter.verdict == "feasible"
        assert found["added_mass"] == pytest.approx(matter.added_mass, rel=1e-6)
        assert found["certainty"] in ("proved", "verified")
        assert 0.0 < found["dropped"] < 1e-12 < found["kept"] and found["distance"] > 0.0


@pytest.mark.slow
def test_shaking_and_inertia_do_not_depend_on_where_the_file_stands():
    """At the pose of the sweep: the crank as in the model, the loops closed."""
    options = {"shaking": {"speed": 5.0}, "input_inertia": {}}
    table = balance.sweep("four_bar_general", {"q4.origin.x": [1.1, 1.2]}, quantities=options)
    text = write_numbers(gallery_text("four_bar_general"), {"q4.origin.x": 1.2})
    model = kinematics.load("four_bar_general")
    for row, linkage in enumerate(
        (model, kinematics.load(Document("written", text.encode()), at={"u1": 0.0}))
    ):
        way, _ = revolve_crank(linkage, 5.0)
        wrench = balance.motion.shaking(linkage, way.q, way.qd, way.qdd)
        force = np.linalg.norm(wrench[:, 3:], axis=1)
        assert table["peak_force"][row] == pytest.approx(force.max(), rel=1e-3)
        assert table["rms_force"][row] == pytest.approx(np.sqrt(np.mean(force**2)), rel=1e-3)
        assert table["inertia_u1"][row] == pytest.approx(input_inertia(linkage)["u1"], rel=1e-9)


def test_verdicts_only_where_the_rank_drops():
    """On the grid of an antiparallelogram, one base is that of the coupler."""
    table = balance.sweep(
        "four_bar_antiparallelogram", {"q4.origin.x": "0.9:1.3:9"},
        quantities={"rank": {}, "design": {"where": "rank drop"}},
    )  # fmt: skip
    special = table["q4.origin.x"] == 1.0
    assert special.sum() == 1 and np.array_equal(table["rank"] == 7, special)
    assert table["design"][special].tolist() == ["feasible"]
    assert set(table["design"][~special]) == {""}
    assert np.array_equal(np.isnan(table["margin"]), ~special)


def test_masses_of_the_file_are_parameters():
    """``h`` is linear in the masses, and so is the inertia that the crank feels."""
    quantities = ("input_inertia",)
    path = "coupler.mass"
    table = balance.sweep("four_bar_general", {path: [0.9, 1.8, 2.7]}, quantities=quantities)
    one, two, three = table["inertia_u1"]
    assert two - one == pytest.approx(three - two, rel=1e-9) and two > one
    same = input_inertia(kinematics.load("four_bar_general"))["u1"]
    assert one == pytest.approx(same, rel=1e-12)
    broken = balance.sweep("four_bar_general", {path: [-1.0, 1.0]}, quantities=quantities)
    assert np.isnan(broken["inertia_u1"][0]) and "cannot exist" in broken["reason"][0]


@pytest.mark.slow
def test_the_study_of_five_bars_by_hand():
    """A uniform bar is balanced by matter at the far side of its joint, at the radius r.

    An upper link of length l and mass ρ l needs ``ρ l² / 2 r``. With it, it weighs on the end
    of the lower link, of length k, which needs ``(ρ k / 2 + ρ l + ρ l² / 2 r) k / r``.
    """
    study = balance.studies.read_study(STUDIES / "five_bar_footprint.toml")
    chunk = study.job().compute(6)
    mass = np.asarray(chunk["added_mass"])
    rho, r = 1.5, 0.12
    lower, upper = (np.asarray(chunk[f"left_{part}.length"]) for part in ("lower", "upper"))
    on_upper = rho * upper**2 / (2.0 * r)
    on_lower = (rho * lower / 2.0 + rho * upper + on_upper) * lower / r
    answered = ~np.isnan(mass)
    assert answered.any() and not answered.all()
    assert mass[answered] == pytest.approx(2.0 * (on_upper + on_lower)[answered], rel=1e-6)
    # Both legs must reach every corner, and cannot if it is further than both links together.
    for x, y in ((-0.12, 0.3), (0.12, 0.3), (-0.12, 0.4), (0.12, 0.4)):
        for side in (-0.5, 0.5):
            far = np.hypot(x - side * np.asarray(chunk["base"]), y)
            assert (far[answered] <= (lower + upper)[answered] + 1e-9).all()


@pytest.mark.slow
def test_transmission_and_grashof_by_turning_the_crank():
    """Angles at the poses of a revolution, and whether the crank turns at all."""
    grid = {"q4.origin.x": "0.8:1.3:6", "coupler.length": "0.6:1.2:5"}
    free = balance.sweep("four_bar_general", grid)
    crank = balance.sweep("four_bar_general", grid, constraints={"grashof": "crank"})
    angle = balance.sweep("four_bar_general", grid, constraints={"transmission": 40})
    for row in range(0, len(free), 4):
        values = {name: float(free[name][row]) for name in grid}
        linkage = written("four_bar_general", **values)
        try:
            way, _ = revolve_crank(linkage, 1.0)
        except kinematics.errors.PoseError:
            assert crank["reason"][row] and angle["reason"][row]
            continue
        assert not crank["reason"][row]
        names = [joint.name for joint in linkage.joints]
        turned = way.q[:, names.index("q3")]
        corner = np.array([joint.point for joint in linkage.joints])[:, :2]
        a, b, c = (corner[names.index(name)] for name in ("q2", "q3", "q4"))
        start = np.arctan2(*(a - b)[::-1]) - np.arctan2(*(c - b)[::-1])
        between = np.degrees(np.abs(np.angle(np.exp(1j * (start - turned)))))
        least = np.minimum(between, 180.0 - between).min()
        if abs(least - 40.0) > 0.5:
            assert (angle["reason"][row] == "") == (least > 40.0), (row, least)
