"""Linkages on which floating point alone decides wrongly: small angles, long chains of orders.

The true ranks come from series modulo a prime and from random rational poses, by programs that
share no code with the product (``tests/independent`` holds one of them).
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from tests.independent.checker import check
from tests.support.proofs import proof_of, sealed
from tests.support.urdf_text import INERTIAL, saved

FOLDER = Path(__file__).parents[3] / "data" / "near_special"
RESTRICTED = (
    "--inputs j0,j4,j8,j12,j13 --motion j12=0 --motion j0=j13 --motion j4=-j13 --motion j8=-j13"
)
# Ranks by order, serial and parallel part.
TRUE = {
    "parallelogram_off_1e-6": ([3, 6, 7, 8], 4, 0),
    "pl_gen_324": ([6, 13, 20, 25, 27, 29, 31], 17, 0),
    "sp_mix_36": ([6, 12, 18, 21, 24, 25], 42, 3),
    "pl_grid_1921": (
        [12, 18, 21, 24, 25, 28, 28, 30, 30, 31, 31, 32, 32, 33, 33, 34, 34, 35],
        17,
        0,
    ),
    "pl_grid_2139": ([15, 34, 41, 44, 44, 45], 23, 0),
    f"mo_gen_33 {RESTRICTED}": (
        [3, 6, 9, 12, 15, 18, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29],
        28,
        3,
    ),
    "sp_mix_384": ([11, 19, 25, 31, 37, 43, 46, 49, 52, 55, 58, 61, 64, 67, 70, 73, 75], 51, 4),
    "arm_gen_100000": ([6, 10, 11], None, None),
    "min_arm": ([15, 19], 11, 0),
    "rssr_tilt_1e-4": ([10, 17, 18], 12, 0),
    "m_sarrus_2_5": ([6, 12, 16, 18], 29, 3),
    "tilt_1e-10 --as-written --spatial": ([11, 17, 20], 10, 0),
    "fewer_rows --as-written --spatial": ([17, 30, 33], 17, 0),
    "two_dead_centres": ([3, 3, 3, 6, 6, 6, 6, 8], 3, 1),
}


def report(words, capsys):
    """The report of a file as data; the exit code says that it is sure."""
    name, *options = words.split()
    assert main(["report", str(FOLDER / f"{name}.urdf"), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.slow
@pytest.mark.table(3)
@pytest.mark.parametrize("words", TRUE)
def test_the_true_integers_are_reported(words, capsys):
    ranks, serial, parallel = TRUE[words]
    found = report(words, capsys)
    assert [order["rank"] for order in found["orders"]] == ranks
    assert (found["rank"], found["kmax"]) == (ranks[-1], len(ranks) - 1)
    assert found["rank"] + found["nullity"] == found["parameters"]
    assert found["certainty"] in ("proved", "verified") and not found["evidence"]["doubts"]
    if serial is not None:
        assert (found["serial"], found["parallel"]) == (serial, parallel)
    if found["parallel"] == 0:
        assert found["certainty"] == "proved"


@pytest.mark.table(1)
@pytest.mark.parametrize("rpy", ["0 0 0.3", "1.5707963267948966 0 0", "0 2.0943951023931953 0"])
@pytest.mark.parametrize("name", ["parallelogram_off_1e-6", "rssr_tilt_1e-4", "m_sarrus_2_5"])
def test_a_linkage_that_is_turned_as_a_whole_has_the_same_integers(name, rpy, tmp_path, capsys):
    """Its angle is replaced in exact arithmetic, but nothing rests on it."""
    text = (FOLDER / f"{name}.urdf").read_text()
    text = text.replace("00001", "00000001")  # of a parallelogram: off by 1e-9 m
    carried = re.findall(r'<child link="(.*?)"', text)
    (root,) = (link for link in re.findall(r'<link name="(.*?)"', text) if link not in carried)
    turned = (
        f'<link name="world"/><joint name="turn" type="fixed"><origin rpy="{rpy}"/>'
        f'<parent link="world"/><child link="{root}"/></joint></robot>'
    )
    path = tmp_path / "turned.urdf"
    path.write_text(text.replace("</robot>", turned))
    assert main(["report", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    ranks, serial, parallel = TRUE[name]
    assert [order["rank"] for order in found["orders"]] == ranks
    assert (found["serial"], found["parallel"]) == (serial, parallel)


@pytest.mark.slow
def test_a_loop_that_was_open_elsewhere_does_not_hide_conditions(tmp_path, capsys):
    """A four-bar is closed by Newton's method beside a Sarrus linkage tilted by 1e-9 rad."""
    parts = [f'<link name="F{i}">{INERTIAL}</link>' for i in (1, 2, 3)]
    joints = ("f1", "L0", "F1", 0), ("f2", "F1", "F2", 0.5), ("f4", "L0", "F3", 1.4)
    parts += [
        f'<joint name="{name}" type="continuous"><origin xyz="{x} 0 0"/>'
        f'<parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/></joint>'
        for name, parent, child, x in joints
    ]
    ends = [
        f'<{role} link="{link}"><origin xyz="{place} 0"/></{role}>'
        for role, link, place in (
            ("predecessor", "F2", "0.45 0.9"),
            ("successor", "F3", "-0.5 0.8"),
        )
    ]
    parts.append(f'<loop name="fk" type="revolute">{"".join(ends)}<axis xyz="0 0 1"/></loop>')
    text = (FOLDER / "m_sarrus_2_5.urdf").read_text()
    path = tmp_path / "two.urdf"
    path.write_text(text.replace("</robot>", "".join(parts) + "</robot>"))
    assert main(["report", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    # The ranks of both linkages, added up: 5 10 11 12 are those of the four-bar in space.
    assert [order["rank"] for order in found["orders"]] == [11, 22, 27, 30]
    assert "assembled" in {warning["code"] for warning in found["warnings"]}


def test_axes_parallel_to_within_rounding_are_in_doubt_under_a_motion_too(tmp_path, capsys):
    """With axes of irrational lengths there are no exact ranks to tell."""
    path = tmp_path / "arm.urdf"
    path.write_text((FOLDER / "min_arm.urdf").read_text().replace("0.00001", "0.000000000001"))
    for options in ((), ("--motion", "j2=j1")):
        assert main(["report", str(path), "--json", *options]) == 4
        found = json.loads(capsys.readouterr().out)
        assert found["certainty"] == "estimated"
        assert "parallel" in found["evidence"]["doubts"][0]


def test_what_exact_arithmetic_corrects_is_told(capsys):
    found = report("parallelogram_off_1e-6", capsys)
    assert [order["rank"] for order in found["orders"]] == [3, 6, 7, 8]
    (told,) = (w["message"] for w in found["warnings"] if w["code"] == "corrected")
    assert "ranks by order 3 6 7 8; these are of the numbers as written" in told


def test_transfers_in_words_are_the_exact_ones(capsys):
    """Nothing couples the joints of an open arm; a mass passes the ball joint of the other."""
    arm = report("min_arm --explain", capsys)
    assert arm["freedoms"] == [] and sum(t["dimension"] for t in arm["transfers"]) == 11
    loop = report("rssr_tilt_1e-4 --explain", capsys)
    assert loop["freedoms"] == [] and all(t["dimension"] for t in loop["transfers"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["min_arm", "parallelogram_off_1e-6", "m_sarrus_2_5"])
def test_the_basis_belongs_to_the_integers(name):
    """It has as many independent columns, and they fulfil the conditions to round-off."""
    space = certify(design_space(kinematics.load(FOLDER / f"{name}.urdf")))
    basis = space.decision.basis
    assert basis.shape[1] == space.nullity
    assert np.abs(basis.T @ basis - np.eye(space.nullity)).max() < 1e-12
    assert space.certainty.poses > 0 and space.certainty.residual < 1e-11


def test_a_mobility_is_that_of_the_small_loop(capsys):
    assert report("arm_gen_100000", capsys)["mobility"] == 2


def test_a_joint_that_moves_with_a_high_power_of_the_input_is_not_at_rest(capsys):
    """``4.5 sin u - 0.9 sin 2u + 0.1 sin 3u - 3u`` is of order 7 in u, its cosine of 14."""
    found = report("three_yokes", capsys)
    assert [order["rank"] for order in found["orders"]] == [3] * 13 + [5]
    assert (found["serial"], found["parallel"]) == (3, 0)


def test_bounds_of_a_force_balance_are_infeasible(capsys):
    words = "--balance force --keep L1 --bounds L3=0.1:2 --bounds L4=0:1 --json".split()
    assert main(["design", str(FOLDER / "de_fb_304.urdf"), *words]) == 1
    assert json.loads(capsys.readouterr().out)["verdict"] == "infeasible"


@pytest.mark.parametrize("order", [4, 6, 7, 8])
def test_a_pose_is_the_same_by_every_order(order, capsys):
    words = ["--tool", "plat", "--along", "ry,y", "--order", str(order), "--json"]
    goal = "--to=plat.ry=-0.0500755,plat.y=-0.0455308"
    assert main(["motion", str(FOLDER / "rrr_platform_p120.urdf"), *words, goal]) == 0
    assert json.loads(capsys.readouterr().out)["poses"]


def braced(tmp_path):
    """A general four-bar whose coupler carries a triangle of three bars that cannot move."""
    points = {"a": (0, 0), "b": (0.3, 0.1), "c": (0.7, 0.9), "d": (0, 1.1)}
    parts = [f'<link name="{name}">{INERTIAL}</link>' for name in ("ab", "bc", "dc", "e", "f")]

    def revolute(name, parent, child, x, y):
        return (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/></joint>'
        )

    def closed(name, one, other, here, there):
        places = [f'<origin xyz="{x} {y} 0"/>' for x, y in (here, there)]
        return (
            f'<loop name="{name}" type="revolute"><predecessor link="{one}">{places[0]}'
            f'</predecessor><successor link="{other}">{places[1]}</successor>'
            '<axis xyz="0 0 1"/></loop>'
        )

    parts += [
        revolute("a", "base", "ab", *points["a"]),
        revolute("b", "ab", "bc", *points["b"]),
        revolute("d", "base", "dc", *points["d"]),
        closed("c", "bc", "dc", (0.4, 0.8), (0.7, -0.2)),
        revolute("p", "bc", "e", 0.1, 0.1),
        revolute("q", "bc", "f", 0.5, 0.1),
        closed("r", "e", "f", (0.3, 0.4), (-0.1, 0.4)),
    ]
    return saved(tmp_path, '<link name="base"/>', *parts)


def test_joints_that_cannot_move_are_proved_to_rest(tmp_path):
    """Locked, they leave a four-bar whose loop is as regular; the checker says so too."""
    space = certify(design_space(kinematics.load(braced(tmp_path))))
    assert set(space.idle) == {"p", "q", "r"}
    # The triangle is one body with the coupler: two bodies more, and all they hold is free.
    assert ([order.rank for order in space.orders], space.nullity) == ([3, 6, 7, 8], 12)
    assert space.certainty.level == "proved"
    proof = proof_of(space)
    check(proof)
    assert len(proof["idle"]) == 3
    for joint in range(len(proof["chain"]["parent"])):
        if joint not in proof["idle"]:
            with pytest.raises(ValueError, match="idle|lead|dependent|rows"):
                check(sealed(proof | {"idle": [*proof["idle"], joint]}))
