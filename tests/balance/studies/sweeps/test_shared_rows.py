"""What rows of a sweep share: poses and motions where masses alone differ, and regular rows."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin
import pytest

import balance
import kinematics
from balance.masses.partial_balance.motion_loads import input_inertia
from balance.motion.verification import crank_revolution
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.trajectory import track
from balance.motion.verification.verify_motions import PinocchioModel
from balance.studies.sweeps import geometry, swept_motion
from kinematics.closure.assembly import assemble
from kinematics.closure.joint_positions import joint_positions
from kinematics.model.document.element import Document
from tests.support.sweep_topologies import gallery_text, write_numbers

pytestmark = pytest.mark.lanes


def written(model: str, **values: float) -> kinematics.Linkage:
    """A model with numbers written into its file, at the input positions of the model."""
    masses = {path: values.pop(path) for path in [*values] if path.endswith(".mass")}
    robot = ElementTree.fromstring(write_numbers(gallery_text(model), values))
    for path, mass in masses.items():
        robot.find(f"link[@name='{path[:-5]}']/inertial/mass").set("value", repr(mass))
    text = ElementTree.tostring(robot)
    inputs = dict.fromkeys(kinematics.load(model).inputs, 0.0)
    return kinematics.load(Document("written", text), at=inputs)


@pytest.fixture
def assembled(monkeypatch):
    """The linkages that a sweep assembles, in order."""
    made = []

    def counted(*args):
        made.append(assemble.assemble(*args))
        return made[-1]

    monkeypatch.setattr(geometry, "assemble", counted)
    return made


def test_rows_that_differ_in_masses_follow_one_motion(assembled, monkeypatch):
    """Forces of each row are those of its file, by Pinocchio."""
    turns, masses, samples = [], [0.4, 1.3, 2.9], 12
    monkeypatch.setattr(
        swept_motion,
        "revolve_crank",
        lambda linkage, *args, **options: (
            turns.append(linkage) or revolve_crank(linkage, *args, **options)
        ),
    )
    table = balance.sweep(
        "four_bar_general",
        {"crank.mass": masses, "q4.origin.x": [1.1, 1.2]},
        quantities={"shaking": {"speed": 10.0, "samples": samples}},
    )
    assert len(assembled) == 2 and len(turns) == 1 + 2  # one is that of the model
    for row in range(len(table)):
        values = {name: float(table[name][row]) for name in ("crank.mass", "q4.origin.x")}
        linkage = written("four_bar_general", **values)
        way, _ = revolve_crank(linkage, 10.0, steps=samples)
        wrench = PinocchioModel(linkage, mass_parameters(linkage)).reactions(way)
        for name, part in (("force", wrench[:, 3:]), ("moment", wrench[:, :3])):
            mean = np.sqrt(np.trapezoid(np.sum(part**2, axis=1)) / samples)
            assert table[f"rms_{name}"][row] == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "path", "values"),
    [
        ("four_bar_general", "q4.origin.x", [1.05, 1.1, 1.2]),
        ("rusr", "r4.origin.x", [1.08, 1.1]),
        ("five_bar", "u2.origin.x", [0.85, 0.9]),
    ],
)
def test_inertias_of_regular_rows_need_no_assembly(model, path, values, assembled):
    """The kinetic energy is by Pinocchio, the joint rates are by finite poses."""
    table = balance.sweep(model, {path: values}, quantities={"input_inertia": {}})
    assert not assembled and not table.reasons
    for row, value in enumerate(values):
        alone = balance.sweep(model, {path: [value]}, quantities={"input_inertia": {}})
        linkage, h = written(model, **{path: value}), 1e-4
        tree = PinocchioModel(linkage, mass_parameters(linkage)).model
        M = pin.crba(tree, tree.createData(), np.zeros(tree.nq))
        M = np.triu(M) + np.triu(M, 1).T
        for name, step in zip(linkage.inputs, h * np.eye(linkage.mobility), strict=True):
            ahead, behind = (joint_positions(linkage, sign * step) for sign in (1.0, -1.0))
            rates = (ahead - behind) / (2.0 * h)
            inertia = table[f"inertia_{name}"][row]
            assert inertia == pytest.approx(rates @ M @ rates, rel=1e-6)
            assert inertia == alone[f"inertia_{name}"][0]


def test_inertias_of_other_rows_are_those_of_assembled_linkages(assembled):
    """Close to a dead centre, at a mass that no body has, and overconstrained in space."""
    stretched = [1.1, 1.68]
    table = balance.sweep(
        "four_bar_general", {"q4.origin.x": stretched}, quantities={"input_inertia": {}}
    )
    for row, x in enumerate(stretched):
        alone = input_inertia(written("four_bar_general", **{"q4.origin.x": x}))
        assert table["inertia_u1"][row] == pytest.approx(alone["u1"], rel=1e-8)
    masses = balance.sweep(
        "four_bar_general", {"crank.mass": [1.0, -1.0]}, quantities={"input_inertia": {}}
    )
    assert masses["reason"][0] == "" and "link 'crank' cannot exist" in masses["reason"][1]
    assert np.isnan(masses["inertia_u1"][1])
    before, weights = len(assembled), [0.5, 2.0]
    spatial = balance.sweep(
        "bennett", {"crank.mass": weights}, quantities={"input_inertia": {}}
    )
    assert len(assembled) == before + 1
    for row, mass in enumerate(weights):
        alone = input_inertia(written("bennett", **{"crank.mass": mass}))
        assert spatial["inertia_u1"][row] == pytest.approx(alone["u1"], rel=1e-8)


def test_a_crank_that_stops_between_samples_is_followed_once(monkeypatch):
    """Its limit is far from all samples, which so do not hit a pose where branches meet."""
    linkage, followed = written("slider_crank", **{"q2.origin.x": 0.33}), []
    _, high = crank_revolution.crank_limits(linkage, "u1", np.ones(1))
    assert 0.05 < high / (2.0 * np.pi / 180) % 1.0 < 0.95
    monkeypatch.setattr(
        crank_revolution,
        "track",
        lambda *args, **options: followed.append(args) or track(*args, **options),
    )
    with pytest.raises(kinematics.errors.PoseError):
        revolve_crank(linkage, 10.0, steps=180, explain=False)
    assert len(followed) == 1


@pytest.mark.parametrize(
    "model", ["four_bar_kite", "slider_crank", "rusr", "five_bar", "six_bar_watt", "three_rsr"]
)
def test_clear_poses_have_the_freedoms_that_finite_poses_show(model, monkeypatch):
    """With every component tested along a generic direction, the linkage is the same."""
    known = kinematics.load(model)
    monkeypatch.setattr(assemble, "_is_clear", lambda *_: False)
    tested = kinematics.load(model)
    assert (known.mobility, known.inputs, known.idle) == (
        tested.mobility,
        tested.inputs,
        tested.idle,
    )
