"""Fronts of designs, an arm on a pick-and-place cycle, and a published slider-crank."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import balance
import kinematics
from balance import design, design_space, pareto, partial
from balance.app.answers.html.partial_balance import front_picture
from balance.app.cli.main import main as command
from balance.masses import ElasticFrame
from balance.motion.verification.given_motions import from_csv
from balance.motion.verification.trajectory import random_motions
from kinematics.errors import LinkageError, UsageError
from tests.support.pick_and_place import robot_arm, write_cycle

SCHEMA = Path(balance.__file__).with_name("app") / "schemas" / "reduce.schema.json"


@pytest.fixture(params=["ur5", "arm"])
def robot_on_a_cycle(request, tmp_path):
    """A robot with six joints, and its cycle."""
    if request.param == "ur5":
        try:
            space = design_space("ur5", max_order=0)
        except LinkageError:
            pytest.skip("example-robot-data is not installed")
    else:
        space = design_space(robot_arm(tmp_path), max_order=0)
    path = write_cycle(tmp_path / "cycle.csv", space.linkage.inputs)
    return space, from_csv(space.linkage, path)


@pytest.mark.slow
def test_a_robot_on_a_pick_and_place_cycle(robot_on_a_cycle):
    """Each of twelve designs is optimal, and each kilogram helps."""
    space, way = robot_on_a_cycle
    steps = []
    front = pareto(
        space,
        space.bodies[:3],
        12,
        8.0,
        motions=[way],
        progress=lambda done, count: steps.append((done, count)),
    )
    assert steps[-1] == (13, 13) and len(steps) == 13
    shares = [one.share for one in front.designs]
    assert shares[0] == 1.0 and np.all(np.diff(shares) < 0.0)
    # The front is convex: the first kilogram helps most.
    assert np.all(np.diff(shares, 2) > -1e-9)
    assert {one.verdict for one in front.designs} == {"optimal"}
    assert [one.budget for one in front.designs] == pytest.approx(np.linspace(0, 8, 12))


@pytest.mark.slow
def test_the_data_fulfil_their_schema():
    check = Draft202012Validator(json.loads(SCHEMA.read_text("utf-8")))
    check.check_schema(check.schema)
    frame = ElasticFrame(30.0, 2.0, 5e4, 60.0)
    for front in (
        pareto("slider_crank", ["crank"], 3, 1.0, frame=frame),
        pareto(design_space("slider_crank", balance="force"), ["crank"], 2, 1.0),
        pareto("slider_crank", ["crank"], 2, 1.0, max_bearing={"q2": 1.0}),
    ):
        check.validate(json.loads(json.dumps(front.to_dict(), allow_nan=False)))


@pytest.mark.slow
def test_a_front_without_a_budget_ends_at_the_least_shaking():
    add = ["crank", "coupler", "slider"]
    front = pareto("slider_crank", add, 4, regions=dict.fromkeys(add, "ball(0,0,0,1)"))
    assert front.designs[-1].share < 1e-9 < 1e-4 < front.designs[-2].share
    assert front_picture(front)[:4] == b"\x89PNG"
    assert "vibration" in repr(
        pareto("slider_crank", add, 2, 1.0, frame=ElasticFrame(9, 1, 9, 1))
    )


@pytest.mark.slow
def test_a_front_without_a_budget_has_its_designs_where_the_curve_bends():
    """The largest step in mass times shaking is smaller than with equally spaced masses."""
    space = design_space("four_bar_general", max_order=0)
    ways = list(random_motions(space.linkage, 1, 40))
    front = pareto(space, ["crank", "rocker"], 7, density=None, motions=ways)
    masses = [design.mass for design in front.designs]
    values = [design.shaking.objective for design in front.designs]
    assert masses == sorted(masses) and values == sorted(values, reverse=True)
    assert masses[0] == 0.0 and len(masses) == 7
    rectangles = -np.diff(masses) * np.diff(values)
    equal = np.linspace(0.0, masses[-1], 7)
    spaced = -np.diff(equal) * np.diff(np.interp(equal, masses, values))
    assert rectangles.max() < spaced.max()


def test_fronts_need_two_ends():
    with pytest.raises(UsageError, match="1 designs"):
        pareto("slider_crank", ["crank"], 1)


# --- the command ---------------------------------------------------------------------------


def run(capsys, *words):
    """Exit code, and what the command prints."""
    code = command(["reduce", "slider_crank", "--links", "crank,coupler", *words])
    return code, *capsys.readouterr()


@pytest.mark.slow
def test_the_command_prints_and_writes_what_the_function_finds(tmp_path, capsys):
    out, plot, way = tmp_path / "out.urdf", tmp_path / "front.svg", tmp_path / "way.csv"
    t = np.linspace(0.0, 1.0, 40)
    rows = "\n".join(f"{a!r},{float(0.4 * np.sin(6.28 * a))!r}" for a in t.tolist())
    way.write_text(f"time,u1\n{rows}\n")
    code, text, _ = run(
        capsys,
        "--pareto",
        "3",
        "--budget",
        "0.6",
        "--csv",
        str(way),
        "--plot",
        str(plot),
        "--out",
        str(out),
        "--json",
    )
    assert code == 0
    data = json.loads(text)
    linkage = kinematics.load("slider_crank")
    found = partial(linkage, ["crank", "coupler"], 0.6, motions=[from_csv(linkage, way)])
    assert data["designs"][-1]["found"]["objective"] == pytest.approx(found.shaking.objective)
    assert plot.read_bytes().startswith(b"<?xml")
    after = kinematics.load(out)
    assert sum(body.inertia[0] for body in after.bodies) == pytest.approx(
        sum(body.inertia[0] for body in linkage.bodies) + 0.6
    )
    z = np.array([body.inertia for body in after.bodies])
    assert np.abs(z - found.z).max() < 1e-6 * np.abs(found.z).max()
    code, text, _ = run(capsys, "--budget", "0.6", "--csv", str(way))
    assert code == 0 and "optimal: 0.6 kg leave" in text and "peak torque" in text


@pytest.mark.table(3)
@pytest.mark.parametrize(
    ("words", "code"),
    [
        ([], 2),
        (["--budget", "-1"], 2),
        (["--budget", "nan"], 2),
        (["--pareto", "1"], 2),
        (["--budget", "1", "--frame", "1,2,3"], 2),
        (["--budget", "1", "--frame", "1,2,0,1"], 2),
        (["--budget", "1", "--max-torque", "3"], 2),
        (["--budget", "1", "--max-torque", "q2=3"], 2),
        (["--budget", "1", "--max-torque", "u1=3", "--max-torque", "u1=4"], 2),
        (["--budget", "1", "--weight-moment", "0"], 2),
        (["--budget", "1", "--keep", "crank"], 2),
        (["--budget", "1", "--minimise", "mass"], 2),
        (["--budget", "1", "--region", "base=ball(0,0,0,1)"], 3),
        (["--budget", "1", "--region", "crank=ball(0,0,0,nan)"], 2),
        (["--budget", "1", "--region", "crank=box(1:0,0:1,0:1)"], 2),
        (["--budget", "1", "--csv", "none.csv"], 3),
        (["--budget", "1", "--points", "--max-bearing", "q2=1"], 1),
    ],
)
def test_exit_codes(words, code, tmp_path, capsys):
    """One line on standard error, nothing on the other, no file, if the request is wrong."""
    out = tmp_path / "out.urdf"
    found, text, error = run(capsys, *words, "--json", "--out", str(out))
    assert found == code and not out.exists()
    if code > 1:
        assert text == "" and error.startswith("balance")
        assert len(error.splitlines()) == (2 if code == 2 else 1)
    else:
        assert json.loads(text)["designs"][0]["verdict"] == "infeasible"


# --- EXUDYN's example of a slider-crank on an elastic frame ---------------------------------

# geneticOptimizationSliderCrank.py: masses are given, centres s1, s2 along the links are
# found; its search prints these, with a vibration of 3.431258e-5 m.
L1, L2, MASSES = 0.1, 0.3, {"crank": 0.4, "rod": 0.2, "slider": 0.1}
PRINTED = -0.07497827333782427, -0.14943029494085874


def exudyn(folder, s1, s2):
    """The linkage of the example, turned by 40 degrees out of its dead centre; its path."""
    theta = np.radians(40.0)
    phi = np.arcsin(-L1 * np.sin(theta) / L2)

    def link(name, at, moment):
        return (
            f'<link name="{name}"><inertial><origin xyz="{at!r} 0 0"/>'
            f'<mass value="{MASSES[name]}"/><inertia ixx="{moment / 2!r}" '
            f'iyy="{moment / 2!r}" izz="{moment!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(name, kind, parent, child, at, turn, axis, more=""):
        return (
            f'<joint name="{name}" type="{kind}"{more}><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{at}" rpy="0 0 {float(turn)!r}"/>'
            f'<axis xyz="{axis}"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )

    x = float(L1 * np.cos(theta) + L2 * np.cos(phi))
    text = (
        '<robot name="slider_crank_on_frame"><link name="base"/>'
        + link("crank", s1, 0.4 / 12 * L1**2)
        + link("rod", s2, 0.2 / 12 * L2**2)
        + link("slider", 0.0, 0.001 * 0.1)
        + joint(
            "u", "continuous", "base", "crank", "0 0 0", theta, "0 0 1", ' independent="true"'
        )
        + joint("pin", "continuous", "crank", "rod", f"{L1} 0 0", phi - theta, "0 0 1")
        + joint("slide", "prismatic", "base", "slider", f"{x!r} 0 0", 0.0, "1 0 0")
        + '<loop name="end" type="revolute"><predecessor link="rod">'
        f'<origin xyz="{L2} 0 0"/></predecessor><successor link="slider"/>'
        '<axis xyz="0 0 1"/></loop></robot>'
    )
    path = folder / "exudyn.urdf"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.slow
def test_the_slider_crank_of_exudyn_is_balanced_in_one_solve(tmp_path):
    """Exactly where the closed form says: s1 = -L1 (m2 + m3)/m1, s2 = -L2 m3/m2."""
    space = design_space(exudyn(tmp_path, 0.05, 0.15), balance="force")
    bounds = {name: (MASSES[name],) * 2 for name in ("crank", "rod")}
    found = design(space, keep=["slider"], bounds=bounds, within=5.0)
    s1, s2 = (body.link_com[0] for body in found.bodies[:2])
    assert (s1, s2) == pytest.approx((-0.075, -0.15), abs=1e-12)
    assert max(abs(s1 - PRINTED[0]), abs(s2 - PRINTED[1])) > 1e-5
    assert balance.verify(space.linkage, found.z, balance="force").force_residual < 1e-12


@pytest.mark.slow
def test_its_frame_vibrates_as_much_as_the_search_leaves(tmp_path):
    """At the printed centres the frame still moves; with added matter it need not."""
    frame = ElasticFrame(2.0, 1.0, 5000.0, 50.0)
    printed = design_space(exudyn(tmp_path, *PRINTED), balance="force", max_order=0)
    left = partial(printed, ["crank"], 0.0, frame=frame).given
    assert left.vibration > 0.0
    space = design_space(exudyn(tmp_path, 0.05, 0.15), balance="force", max_order=0)
    regions = {"crank": "ball(0,0,0,0.1)", "rod": "ball(0,0,0,0.15)"}
    found = partial(space, ["crank", "rod"], 50.0, regions=regions, frame=frame)
    assert found.shaking.vibration < 1e-9 * found.given.vibration
    assert found.shaking.vibration < 1e-3 * left.vibration
