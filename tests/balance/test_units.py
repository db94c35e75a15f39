"""Numbers with units: figures of the SI brochure, and commands that read them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import balance
from balance.support.units import UNITS, read_quantity
from kinematics.errors import UsageError
from tests.support.command_runs import asked


@pytest.mark.parametrize(("text", "quantity", "value"), [
    ("30deg", "angle", math.pi / 6), ("30°", "angle", math.pi / 6), ("-0.5 rad", "angle", -0.5),
    ("12mm", "length", 0.012), ("1 in", "length", 0.0254), ("2e3 mm", "length", 2.0),
    ("2g", "mass", 0.002), ("1 lb", "mass", 0.45359237), ("0.5", "mass", 0.5),
    ("7.85g/cm3", "density", 7850.0), ("7.85 g/cm³", "density", 7850.0),
    ("2.7kg/dm^3", "density", 2700.0), ("120 kg mm²", "inertia", 1.2e-4),
    ("60rpm", "angular velocity", 2 * math.pi), ("1Hz", "angular velocity", 2 * math.pi),
    ("360deg/s", "angular velocity", 2 * math.pi), ("5 kN", "force", 5e3),
    ("30 N mm", "torque", 0.03), ("250ms", "time", 0.25), ("1e-3", "time", 1e-3),
])  # fmt: skip
def test_quantities(text, quantity, value):
    assert read_quantity(text, quantity) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "quantities", "said"),
    [
        ("2g", ("length",), "'g' is a unit of mass: write length in m, mm"),
        ("2 furlongs", ("length",), "no unit that is known"),
        ("mm", ("length",), "not a number"),
        ("2mm3", ("length", "angle"), "write length or angle in"),
        ("", ("mass",), "not a number"),
    ],
)
def test_what_is_no_quantity(text, quantities, said):
    with pytest.raises(UsageError, match=said):
        read_quantity(text, *quantities)


def test_units_of_all_quantities_differ():
    """No text is a unit of two of them, so that one of two quantities has one meaning."""
    names = [name for units in UNITS.values() for name in units]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    ("words", "plain", "units"),
    [
        (
            "design four_bar_kite",
            "--density 7850 --thickness 0.01",
            "--density 7.85g/cm3 --thickness 10mm",
        ),
        (
            "design four_bar_kite --minimise mass",
            "--bounds coupler=0.001:1.5",
            "--bounds coupler=1g:1.5kg",
        ),
        ("report four_bar_kite", "--at u1=0.5", "--at u1=500e-3rad"),
        (
            "counterweights four_bar_general --balance force --links crank,rocker",
            "--region crank=ball(0,0,0,0.25)",
            "--region crank=ball(0,0,0,250mm)",
        ),
    ],
)
def test_commands_read_units(words, plain, units):
    """Beside the text of a region, which is that of the request."""
    answers = [asked([*words.split(), *more.split(), "--json"]) for more in (plain, units)]
    data = [json.loads(answer.out) for answer in answers]
    for answer in data:
        answer.pop("regions", None)
    assert data[0] == data[1] and answers[0].code == answers[1].code == 0


def test_heads_of_columns_have_units(tmp_path):
    """A table in degrees and milliseconds, and the same in radians and seconds."""
    loads = []
    for head, angle, time in (
        ("time,u1", 1.0, 1.0),
        ("time [ms],u1 [deg]", 180.0 / math.pi, 1e3),
    ):
        rows = "".join(
            f"{0.01 * k * time!r},{0.4 * math.sin(0.06 * k) ** 2 * angle!r}\n"
            for k in range(60)
        )
        path = tmp_path / "motion.csv"
        path.write_text(f"{head}\n{rows}", encoding="utf-8")
        code, out, _ = asked(["verify", "slider_crank", "--csv", str(path), "--json"])
        assert code == 1
        loads.append(json.loads(out)["shaking"]["force"])
    assert loads[0] > 1.0 and loads[1] == pytest.approx(loads[0], rel=1e-6)


def test_a_thickness_may_have_a_unit():
    """The plates of a design are so thick: their sizes are printed in millimetres."""
    flat, general = "four_bar_antiparallelogram", "four_bar_general"
    design = balance.design(flat, bounds={"coupler": (0.5, 2.0)}, thickness="20 mm")
    for body in design.to_dict()["bodies"]:
        assert min(body["solid"]["sizes_mm"]) == pytest.approx(20.0)
    for make, words in (
        (balance.counterweights, {"balance": "force"}),
        (balance.partial, {"budget": 0.2}),
        (balance.pareto, {"n": 2}),
    ):
        made = [
            make(general, ["crank", "rocker"], thickness=text, **words)
            for text in ("2cm", 0.02, 0.01)
        ]
        z = [x.designs[-1].z if make is balance.pareto else x.z for x in made]
        assert np.array_equal(z[0], z[1]) and not np.allclose(z[1], z[2], rtol=1e-6)
    with pytest.raises(UsageError, match="'g' is a unit of mass: write length"):
        balance.design(flat, thickness="20 g")


@pytest.mark.slow
def test_the_thickness_of_synthesised_plates_may_have_a_unit():
    places = [(0.0, 0.0, 0.0), (0.1, 0.05, 0.3), (0.2, 0.0, 0.6)]
    made = balance.synthesize(places, kind="four-bar", thickness="20mm")
    assert made.to_dict()["thickness"] == 0.02
