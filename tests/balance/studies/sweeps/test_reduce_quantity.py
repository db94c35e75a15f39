"""The least shaking for a budget as a quantity of a sweep; materials and units of options."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import balance
from balance.masses.partial_balance.motion_loads import input_inertia
from balance.studies.sweeps.constraints import read_constraints
from balance.studies.sweeps.quantities import read_quantities
from kinematics.errors import FileError
from tests.support.sweep_topologies import gallery_text

MODEL, LINKS = "four_bar_general", ["crank", "rocker"]


def options_of(quantity: str, **options: object) -> dict[str, object]:
    """The options of a quantity as they are read from a study."""
    return dict(
        read_quantities({"quantities": [quantity], quantity: options}, "study")[quantity]
    )


def test_materials_and_units_are_numbers_in_si():
    """By hand: lead has 11340 kg/m³, 300 rpm are 10π rad/s, a pound is 0.45359237 kg."""
    matter = options_of(
        "reduce",
        links=LINKS,
        budget="1lb",
        density={"crank": "lead", "rocker": "7.85 g/cm3"},
        thickness="12mm",
        speed="300rpm",
        max_bearing={"q2": "2kN"},
        max_torque={"u1": "500 Nmm"},
        weight_moment="20cm",
    )
    wanted = {"budget": 0.45359237, "thickness": 0.012, "speed": 10.0 * np.pi}
    assert {name: matter[name] for name in wanted} == pytest.approx(wanted, rel=1e-12)
    assert matter["density"] == {"crank": 11340.0, "rocker": 7850.0}
    assert (matter["max_bearing"], matter["max_torque"]) == ({"q2": 2000.0}, {"u1": 0.5})
    assert matter["weight_moment"] == pytest.approx(0.2)
    assert options_of("design", density="Steel", within="30mm") == {
        "density": 7850.0,
        "within": 0.03,
    }
    assert options_of("counterweights", links=LINKS, density="none")["density"] == "none"
    turned = read_constraints({"transmission": "0.5rad"}, "study")["transmission"]
    assert np.radians(turned) == pytest.approx(0.5, rel=1e-12)
    reach = {"link": "coupler", "point": [0, 0, 0], "targets": [["120mm", 0.0, "1cm"]]}
    assert read_constraints({"reach": reach}, "study")["reach"]["targets"] == [
        [0.12, 0.0, 0.01]
    ]


@pytest.mark.parametrize(
    ("quantity", "options", "message"),
    [
        ("reduce", {"density": "steal"}, "no material that is known (did you mean 'steel'?)"),
        ("reduce", {"budget": "3m"}, "unit of length"),
        ("reduce", {"budget": [1.0]}, 'write "0.5kg", or a number in kg'),
        ("reduce", {"max_bearing": 20.0}, 'write {q2 = "200N"}'),
        ("reduce", {"masses": 3}, "no such option"),
        ("shaking after reduce", {}, 'reduce is not computed; add "reduce" to quantities'),
    ],
)
def test_wrong_options_are_told_in_one_line(quantity, options, message):
    with pytest.raises(FileError) as caught:
        options_of(quantity, **options)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_options_before_matter_is_added_name_those_after_it():
    table = {
        "quantities": ["reduce", "shaking after reduce"],
        "reduce": {"links": LINKS, "budget": 1.0},
        "shaking": {"speed": 5.0},
    }
    with pytest.raises(FileError, match=r'write \[compute\."shaking after reduce"\]$'):
        read_quantities(table, "study")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"budget": 0.5}, "no links to add matter to"),
        ({"links": LINKS}, "no budget of matter"),
        ({"links": ["crank", "ghost"], "budget": 0.5}, "ghost"),
        ({"links": LINKS, "budget": -1.0}, "give a mass from 0 up"),
        ({"links": LINKS, "budget": 1.0, "max_torque": {"q9": 1.0}}, "there is no input 'q9'"),
        ({"links": LINKS, "budget": 1.0, "minimise": "noise"}, "minimise 'noise'"),
        ({"links": LINKS, "budget": 1.0, "speed": 3.0, "poses": [[0.0], [1.0]]}, "give either"),
    ],
)
def test_what_the_model_does_not_have_is_refused(options, message):
    """Before anything is computed."""
    study = balance.studies.Study.from_tables(
        {
            "parameters": {"crank.mass": [1.0]},
            "compute": {"quantities": ["reduce"], "reduce": options},
        },
        balance.load(MODEL),
    )
    with pytest.raises(FileError, match=r"\[compute\] reduce") as caught:
        study.job()
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.slow
def test_shaking_after_reduce_is_that_of_the_written_file(tmp_path):
    """By Pinocchio, on the file that the verb writes of one geometry."""
    table = balance.sweep(
        MODEL,
        {"crank.mass": [1.0, 2.0]},
        quantities={
            "reduce": {"links": LINKS, "budget": "600g", "speed": "300rpm"},
            "shaking after reduce": {},
            "input_inertia after reduce": {},
        },
    )
    assert not table.reasons
    for row, mass in enumerate((1.0, 2.0)):
        heavy = ElementTree.fromstring(gallery_text(MODEL))
        heavy.find("link[@name='crank']/inertial/mass").set("value", str(mass))
        path = tmp_path / "given.urdf"
        path.write_bytes(ElementTree.tostring(heavy))
        turn = balance.motion.one_turn(path, "300rpm")
        answer = balance.partial(path, LINKS, 0.6, motions=turn)
        assert table["reduce"][row] == "optimal"
        assert table["budget_used"][row] == pytest.approx(answer.mass, rel=1e-6)
        assert 0.0 < table["share_left"][row] < 0.99
        assert table["share_left"][row] == pytest.approx(answer.share, rel=1e-6)
        lighter = tmp_path / "reduced.urdf"
        answer.to_urdf(lighter, merge=True)
        seen = balance.verify(lighter, speed="300rpm", about=(0.0, 0.0, 0.0))
        assert table["peak_force_reduced"][row] == pytest.approx(seen.force, rel=2e-4)
        assert table["peak_moment_reduced"][row] == pytest.approx(seen.moment, rel=2e-4)
        felt = input_inertia(balance.load(lighter))["u1"]
        assert table["inertia_u1_reduced"][row] == pytest.approx(felt, rel=1e-6)


@pytest.mark.slow
def test_caps_that_cannot_be_kept_are_the_reason():
    """A bearing carries more than nothing; the shaking of the file is still there."""
    table = balance.sweep(
        MODEL,
        {"crank.mass": [1.0]},
        quantities={
            "reduce": {
                "links": ["rocker"],
                "budget": 0.1,
                "max_bearing": {"u1": "1mN"},
                "speed": 9.0,
            },
            "shaking after reduce": {},
            "shaking": {"speed": 9.0},
        },
    )
    assert table["reduce"].tolist() == ["infeasible"] and np.isnan(table["budget_used"][0])
    assert np.isnan(table["peak_force_reduced"][0]) and table["peak_force"][0] > 0.0
    assert table["reason"][0].startswith("reduce: infeasible: no matter within … kg")
