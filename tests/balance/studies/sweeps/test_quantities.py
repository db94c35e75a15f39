"""Quantities of a sweep against the functions that compute them, and formulas by hand."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.partial_balance.motion_loads import input_inertia
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.verify_motions import PinocchioModel
from balance.studies.sweeps import swept_motion
from kinematics.model.document.element import Document
from tests.support.points import point_counterweights
from tests.support.sweep_topologies import gallery_text, write_numbers

pytestmark = pytest.mark.lanes

STUDIES = Path(__file__).resolve().parents[4] / "docs" / "studies"
ALL = {
    "rank": {},
    "orders": {"count": 5},
    "singular_values": {},
    "distance": {},
    "design": {"minimise": "mass"},
    "counterweights": {"links": ["crank", "rocker"]},
    "input_inertia": {},
    "shaking": {"speed": 5.0},
    "certainty": {},
}


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
        mean = np.sqrt(np.trapezoid(force**2) / (force.size - 1))
        assert table["rms_force"][row] == pytest.approx(mean, rel=1e-3)
        assert table["inertia_u1"][row] == pytest.approx(input_inertia(linkage)["u1"], rel=1e-9)


def test_turns_in_a_sweep_are_those_of_the_written_files():
    """By Pinocchio, at as many samples; cranks that cannot turn have no numbers."""
    samples, bases = 12, [1.5, 1.1]
    table = balance.sweep(
        "four_bar_general",
        {"q4.origin.x": bases},
        quantities={"shaking": {"speed": "300rpm", "samples": samples}},
    )
    assert table["reason"].tolist() == ["shaking: the crank u1 cannot turn fully", ""]
    assert np.isnan(table["peak_force"][0])
    text = write_numbers(gallery_text("four_bar_general"), {"q4.origin.x": bases[1]})
    linkage = kinematics.load(Document("written", text.encode()), at={"u1": 0.0})
    way, _ = revolve_crank(linkage, 10.0 * np.pi, steps=samples)
    wrench = PinocchioModel(linkage, mass_parameters(linkage)).reactions(way)
    for name, part in (("force", wrench[:, 3:]), ("moment", wrench[:, :3])):
        size = np.linalg.norm(part, axis=1)
        mean = np.sqrt(np.trapezoid(size**2) / samples)
        assert table[f"rms_{name}"][1] == pytest.approx(mean, rel=1e-9)
        # The peak is that of closer samples about the largest one.
        assert size.max() * (1 - 1e-9) <= table[f"peak_{name}"][1] < 1.2 * size.max()


def test_quantities_of_one_motion_follow_it_once(monkeypatch):
    """Two turns of each geometry, before and after matter is added, are one; others are not."""
    followed = []

    def counted(linkage, *args, **options):
        followed.append(options["steps"])
        return revolve_crank(linkage, *args, **options)

    monkeypatch.setattr(swept_motion, "revolve_crank", counted)
    turn = {"speed": 5.0, "samples": 6}
    quantities = {
        "counterweights": {"links": ["crank", "rocker"], "density": "none"},
        "shaking": turn,
        "shaking after counterweights": {**turn, "samples": 8},
    }
    values = {"q4.origin.x": [1.15]}
    apart = balance.sweep("four_bar_general", values, balance="force", quantities=quantities)
    assert sorted(followed) == [6, 6, 8, 8]  # one of each is that of the model
    followed.clear()
    quantities["shaking after counterweights"] = turn
    together = balance.sweep("four_bar_general", values, balance="force", quantities=quantities)
    assert followed == [6, 6, 6]  # the options of each quantity are checked against the model
    assert np.array_equal(together["peak_moment"], apart["peak_moment"])
    # What round-off leaves of a force that is balanced is 0.
    assert together["peak_force_after"][0] == together["rms_force_after"][0] == 0.0


def test_verdicts_only_where_the_rank_drops():
    """On the grid of an antiparallelogram, one base is that of the coupler."""
    table = balance.sweep(
        "four_bar_antiparallelogram",
        {"q4.origin.x": "0.9:1.3:9"},
        quantities={"rank": {}, "design": {"where": "rank drop"}},
    )
    special = table["q4.origin.x"] == 1.0
    assert special.sum() == 1 and np.array_equal(table["rank"] == 7, special)
    assert table["design"][special].tolist() == ["feasible"]
    assert set(table["design"][~special]) == {""}
    assert np.array_equal(np.isnan(table["margin"]), ~special)


@pytest.mark.parametrize(
    ("thickness", "density", "verdict"),
    [
        (0.02, 7850.0, "feasible"),
        (0.002, 7850.0, "infeasible"),
        (0.002, 19300.0, "feasible"),
    ],
)
def test_designs_of_a_sweep_are_of_a_material(thickness, density, verdict):
    """The verdict is that of a design, with links that are too thin for their least masses."""
    options = {
        "bounds": {"coupler": (0.5, 5.0)},
        "density": density,
        "thickness": thickness,
    }
    model = "four_bar_antiparallelogram"
    table = balance.sweep(model, {"crank.mass": [1.0]}, quantities={"design": options})
    assert table["design"].tolist() == [verdict]
    assert balance.design(model, **options).verdict == verdict


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


def test_bars_follow_their_lengths():
    """``m = ρ l``, the centre in the middle, ``m l² / 12``, each as a relation of its own."""
    varied = {"q3.predecessor.origin.x": "0.75:0.85:3"}
    ends = {"crank": "q2", "coupler": "q3.predecessor", "rocker": "q3.successor"}
    by_hand = {}
    for link, end in ends.items():
        x, y = f"{end}.origin.x", f"{end}.origin.y"
        mass = f"1.5*hypot({x}, {y})"
        by_hand |= {
            f"{link}.mass": mass,
            f"{link}.com.x": f"{x}/2",
            f"{link}.com.y": f"{y}/2",
            f"{link}.com.z": "0",
            f"{link}.inertia.izz": f"{mass}*({x}**2 + {y}**2)/12",
            f"{link}.inertia.ixx": f"{mass}*{y}**2/12",
            f"{link}.inertia.iyy": f"{mass}*{x}**2/12",
            f"{link}.inertia.ixy": f"-{mass}*{x}*{y}/12",
            f"{link}.inertia.ixz": "0",
            f"{link}.inertia.iyz": "0",
        }
    by_length = {f"{link}.mass_per_length": "1.5" for link in ends}
    bars, hand = (
        balance.sweep(
            "four_bar_general", varied, relations=relations, quantities=["input_inertia"]
        )
        for relations in (by_length, by_hand)
    )
    assert not bars.reasons and bars.units["coupler.mass_per_length"] == "kg/m"
    assert np.ptp(bars["inertia_u1"]) > 0.01
    np.testing.assert_allclose(bars["inertia_u1"], hand["inertia_u1"], rtol=1e-9)


def test_numbers_with_units_are_those_in_si():
    """In grids, lists, samples, options and relations of bars."""
    with_units, plain = (
        balance.sweep(
            "four_bar_general",
            {
                "q4.origin.x": grid,
                "rocker.mass_per_length": bars,
                "q2.origin.x": {"uniform": span},
            },
            samples=2,
            quantities={"shaking": {"speed": speed, "samples": 24}},
        )
        for grid, bars, span, speed in (
            ("1050mm : 110 cm:3", ["500g/m", "2kg/m"], ["80mm", "0.12"], "300rpm"),
            ("1.05:1.1:3", [0.5, 2.0], [0.08, 0.12], 10.0 * np.pi),
        )
    )
    for name in plain:
        if plain[name].dtype.kind == "f":
            np.testing.assert_allclose(with_units[name], plain[name], rtol=1e-13)
    assert with_units["q4.origin.x"][-1] == 1.1 and len(plain) == 12


@pytest.mark.slow
def test_shaking_after_counterweights_is_that_of_the_written_file(tmp_path):
    """By Pinocchio, on the file that the counterweights of one geometry write."""
    links, turn = ["crank", "rocker"], {"speed": "300rpm"}
    table = balance.sweep(
        "four_bar_general",
        {"crank.mass": [1.0, 2.0]},
        balance="force",
        quantities={
            "counterweights": {"links": links},
            "shaking": turn,
            "shaking after counterweights": {},
            "input_inertia after counterweights": {},
        },
    )
    for row, mass in enumerate((1.0, 2.0)):
        heavy = ElementTree.fromstring(gallery_text("four_bar_general"))
        heavy.find("link[@name='crank']/inertial/mass").set("value", str(mass))
        space = balance.design_space(ElementTree.tostring(heavy), balance="force")
        path = tmp_path / "heavier.urdf"
        balance.counterweights(space, links).to_urdf(path, merge=True)
        about = (0.0, 0.0, 0.0)
        seen = balance.verify(path, speed=10.0 * np.pi, about=about)
        assert table["peak_moment_after"][row] == pytest.approx(seen.moment, rel=1e-4)
        assert table["peak_force_after"][row] == 0.0 < table["peak_force"][row]
        felt = input_inertia(balance.load(path))["u1"]
        assert table["inertia_u1_after"][row] == pytest.approx(felt, rel=1e-8)
    none = balance.sweep(
        "four_bar_general",
        {"crank.mass": [1.0]},
        balance="force",
        quantities={
            "counterweights": {"links": ["crank"]},
            "shaking after counterweights": turn,
        },
    )
    assert none["counterweights"][0] == "infeasible" and np.isnan(none["peak_moment_after"][0])
    assert none["reason"][0].startswith("counterweights: infeasible: ")


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "rusr", "six_bar_watt"])
def test_peaks_of_a_turn_by_close_samples(model):
    """Twenty samples a degree, of a spatial linkage with a narrow peak too."""
    linkage = kinematics.load(model)
    first = ElementTree.fromstring(gallery_text(model)).find("link/inertial/..")
    mass = float(first.find("inertial/mass").get("value"))
    table = balance.sweep(
        linkage, {f"{first.get('name')}.mass": [mass]}, quantities={"shaking": {"speed": 10.0}}
    )
    way, _ = revolve_crank(linkage, 10.0, steps=7200)
    wrench = balance.motion.shaking(linkage, way.q, way.qd, way.qdd)
    sizes = [np.linalg.norm(part, axis=1) for part in np.split(wrench, 2, axis=1)]
    for name, size in zip(("moment", "force"), sizes, strict=True):
        assert table[f"peak_{name}"][0] == pytest.approx(size.max(), rel=2e-4)
        mean = np.sqrt(np.trapezoid(size**2) / (size.size - 1))
        assert table[f"rms_{name}"][0] == pytest.approx(mean, rel=1e-4)


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
def test_matter_of_a_sweep_is_of_steel_unless_it_is_of_no_density():
    """Points are the limit of dense matter, and lighter."""
    added = []
    for density in ({}, {"density": "7.85g/cm3"}, {"density": "none"}):
        table = balance.sweep(
            "four_bar_general",
            {"q4.origin.x": [1.05]},
            quantities={"counterweights": {"links": ["crank", "rocker"], **density}},
            balance="force",
        )
        added.append(table["added_mass"][0])
    linkage = written("four_bar_general", **{"q4.origin.x": 1.05})
    matter = point_counterweights(
        balance.design_space(linkage, balance="force"), ["crank", "rocker"]
    )
    assert added[0] == added[1] > 1.01 * added[2]
    assert added[2] == pytest.approx(matter.added_mass, rel=1e-6)


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
