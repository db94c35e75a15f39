"""Special linkages written with so many digits: the answer is that of what is meant.

The ranks are those of `tests.independent.sixty_digits`; ``python -m
tests.independent.meant_run`` compares as many linkages as it is told.
"""

import json
import re

import numpy as np
import pytest
from mpmath import mpf
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from balance.space.spaces.readings import deciding_digits
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from tests.independent.meant_linkages import (
    MeantJoint,
    MeantLinkage,
    meant_linkage,
    meant_text,
    unit,
)
from tests.independent.sixty_digits import true_ranks

# Mobility and ranks by order, of the special family and of general linkages beside it.
TRUE = {
    "kite": (1, [3, 6, 7], [3, 6, 7, 8]),
    "parallelogram": (1, [3, 4, 5], [3, 6, 7, 8]),
    "antiparallelogram": (1, [3, 6, 7], [3, 6, 7, 8]),
    "slider_crank": (1, [3, 6], [3, 6, 7]),
    "pantograph": (2, [6, 7, 8], [6, 10, 11]),
    "bennett": (1, [6, 10, 13], None),
    "spherical_opposite": (1, [6, 10, 13], [6, 11, 14, 15]),
}
FRAMES = (("turned", "any"), ("axes", "any"), ("plain", "any"), ("turned", "xy"))


def space_of(tmp_path, family, seed, digits, off=0.0, **options):
    """The certified design space of a linkage that is written with so many digits."""
    frames, plane = FRAMES[seed % len(FRAMES)]
    text = meant_text(meant_linkage(family, seed, off), seed, digits, frames, plane)
    path = tmp_path / f"{family}.urdf"
    path.write_text(text)
    return certify(design_space(kinematics.load(str(path), **options)))


def ranks(space):
    """Ranks by order."""
    return [order.rank for order in space.orders]


def codes(space):
    """Codes of the notices."""
    return {notice.code for notice in space.notices}


@pytest.mark.slow
def test_the_figures_are_those_of_sixty_digits():
    for family in ("parallelogram", "slider_crank"):
        mobility, special, general = TRUE[family]
        assert true_ranks(meant_linkage(family, 5), True) == (mobility, special)
        assert true_ranks(meant_linkage(family, 5, 1e-12), True) == (mobility, general)


@pytest.mark.table(1)
@pytest.mark.parametrize("digits", [17, 12, 9, 6])
@pytest.mark.parametrize("family", TRUE)
def test_special_linkages_are_read_as_meant(family, digits, tmp_path):
    mobility, special, _ = TRUE[family]
    for seed in (digits, digits + 1):
        space = space_of(tmp_path, family, seed, digits)
        assert (space.linkage.mobility, ranks(space)) == (mobility, special)
        assert space.level in ("proved", "verified") and not space.doubts


@pytest.mark.parametrize(
    ("family", "seed", "digits"),
    [
        ("kite", 7, 9),
        ("spherical_opposite", 12, 6),
        # Its axes were tilted by more than the digits of their directions, so that they meet.
        ("spherical_opposite", 3046, 9),
        # Open by 1e-11; its other assembly mode closes.
        ("antiparallelogram", 1051, 12),
    ],
)
def test_loops_of_few_digits_close_near_a_singular_pose_and_about_a_point(
    family, seed, digits, tmp_path
):
    space = space_of(tmp_path, family, seed, digits)
    assert (space.linkage.mobility, ranks(space)) == TRUE[family][:2]


@pytest.mark.parametrize("digits", [15, 6])
def test_flat_poses_on_the_way_leave_no_doubt(digits, tmp_path):
    """A pose that checks the answer is flat up to 1e-5: its momenta are 4e-6 of round-off."""
    space = space_of(tmp_path, "antiparallelogram", 1101, digits)
    assert ranks(space) == TRUE["antiparallelogram"][1] and space.certainty.level == "verified"


@pytest.mark.slow
@pytest.mark.parametrize("digits", [17, 9, 6])
@pytest.mark.parametrize("family", ["kite", "slider_crank", "bennett"])
def test_a_file_that_is_written_at_another_pose_has_the_same_answer(family, digits, tmp_path):
    mobility, special, _ = TRUE[family]
    text = meant_text(meant_linkage(family, 4, 0.0), 4, digits)
    first, second = tmp_path / "first.urdf", tmp_path / "second.urdf"
    first.write_text(text)
    (name,) = kinematics.load(str(first)).inputs
    for at in ({}, {name: 0.1}):
        linkage = kinematics.load(str(first), at=at)
        second.write_bytes(write_at_reference_pose(linkage).data)
        space = certify(design_space(kinematics.load(str(second))))
        assert (space.linkage.mobility, ranks(space)) == (mobility, special)
        assert not space.doubts


@pytest.mark.table(3)
@pytest.mark.parametrize("off", [1e-12, 1e-8, 1e-4])
@pytest.mark.parametrize("family", [name for name in TRUE if TRUE[name][2]])
def test_linkages_that_are_off_in_all_digits_are_general(family, off, tmp_path):
    space = space_of(tmp_path, family, 8, 17, off)
    assert ranks(space) == TRUE[family][2]
    assert space.level == "proved" and "special_as_meant" not in codes(space)


@pytest.mark.parametrize("family", ["kite", "parallelogram", "antiparallelogram"])
def test_planar_linkages_that_are_off_by_a_hundred_roundings_are_general(family, tmp_path):
    space = space_of(tmp_path, family, 8, 17, 2e-14)
    assert ranks(space) == TRUE[family][2] and "special_as_meant" not in codes(space)


def planar_linkage(name, seed):
    """A general planar linkage at random: an arm of three links, or a Watt six-bar."""
    rng = np.random.default_rng([seed, 9])
    z = (mpf(0), mpf(0), mpf(1))
    p = [(mpf(x), mpf(y), mpf(0)) for x, y in rng.uniform(-1, 1, (7, 2)).tolist()]
    pairs = {
        "arm": [(0, 1), (1, 2), (2, 3)],
        "watt": [(0, 1), (1, 2), (0, 3), (2, 4), (3, 5), (2, 3), (4, 5)],
    }[name]
    return MeantLinkage(
        name,
        tuple(
            MeantJoint("revolute" if k > 4 else "continuous", before, after, p[k], z, k > 4)
            for k, (before, after) in enumerate(pairs)
        ),
    )


@pytest.mark.table(3)
@pytest.mark.parametrize("digits", [17, 12, 6])
@pytest.mark.parametrize(
    ("name", "expected"), [("arm", [9]), ("watt", [3, 6, 9, 10, 11, 12, 13])]
)
def test_planar_linkages_in_oblique_planes_are_proved(name, expected, digits, tmp_path):
    path = tmp_path / "oblique.urdf"
    path.write_text(meant_text(planar_linkage(name, digits), digits, digits))
    space = certify(design_space(kinematics.load(str(path))))
    assert (ranks(space), space.level) == (expected, "proved")


def wedge(folder, rotation, digits, off=0.0):
    """Two bodies on three slides in an oblique plane, the last off the plane by an angle."""
    angles, out = (0.3, 1.4, 2.6), (0, 0, off)
    axes = [rotation.apply([np.cos(a), np.sin(a), z]) for a, z in zip(angles, out, strict=True)]
    lines = ["<robot name='wedge'><link name='base'/>"]
    lines += [
        f"<link name='{name}'><inertial><origin xyz='0.1 0.2 0.3'/><mass value='1'/><inertia "
        "ixx='0.2' iyy='0.25' izz='0.3' ixy='0.01' ixz='0' iyz='0'/></inertial></link>"
        for name in "ab"
    ]
    ends = (
        ("joint", "<parent link='base'/><child link='a'/>"),
        ("joint", "<parent link='a'/><child link='b'/>"),
        ("loop", "<predecessor link='b'/><successor link='base'/>"),
    )
    for k, (axis, (tag, links)) in enumerate(zip(axes, ends, strict=True)):
        text = " ".join(f"{x:.{digits}g}" for x in axis)
        lines.append(f"<{tag} name='s{k}' type='prismatic'>{links}<axis xyz='{text}'/></{tag}>")
    path = folder / "wedge.urdf"
    path.write_text("\n".join([*lines, "</robot>"]))
    return path


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("digits", [17, 12, 6])
def test_slides_in_an_oblique_plane_are_proved(digits, seed, tmp_path):
    # p_x, p_y and the moment of the momenta of two bodies that move on straight lines
    path = wedge(tmp_path, Rotation.random(random_state=seed), digits)
    space = certify(design_space(path))
    assert (space.linkage.mobility, space.rank, space.level) == (1, 3, "proved")


def test_slides_out_of_the_plane_by_more_than_the_digits_leave_a_doubt(tmp_path):
    space = certify(design_space(wedge(tmp_path, Rotation.random(random_state=0), 12, 1e-6)))
    assert space.level == "estimated"
    assert any("as written the loops do not move" in doubt for doubt in space.doubts)


def test_axes_tilted_by_more_than_the_digits_are_not_parallel(tmp_path):
    path = tmp_path / "tilted.urdf"
    linkage = planar_linkage("arm", 2)
    first, second, third = linkage.joints
    tilted = third._replace(axis=unit((mpf("1e-9"), mpf(0), mpf(1))))
    path.write_text(meant_text(linkage._replace(joints=(first, second, tilted)), 2, 17))
    space = certify(design_space(kinematics.load(str(path))))
    assert (ranks(space), space.level) != ([9], "proved")
    assert any("parallel to within 1e-09 rad only" in doubt for doubt in space.doubts)


def test_both_answers_are_told(tmp_path):
    space = space_of(tmp_path, "parallelogram", 2, 17)
    (text,) = (n.message for n in space.notices if n.code == "special_as_meant")
    assert text.startswith("as written (17 digits): 8 conditions; ")
    assert "5 are meant (--as-written for the other)" in text
    written = space_of(tmp_path, "parallelogram", 2, 17, angles="as_written")
    assert ranks(written) == [3, 6, 7, 8] and written.level == "proved"


KITE = {
    "o": (0.0, 0.0),
    "a": (0.8660254, 0.5),
    "c": (3.2345678, 0.0),
    "b": (0.8660254, -0.5),
}


def kite_text(error):
    """A kite in numbers of seven digits, one of which is off."""
    (ax, ay), (bx, by), (cx, _) = KITE["a"], KITE["b"], KITE["c"]
    by = round(by + error, 7)
    return re.sub(
        r"\n *",
        "\n",
        f"""<robot name="kite"><link name="base"/>
    <link name="L1"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1"
    iyz="0" izz="1"/></inertial></link>
    <link name="L2"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1"
    iyz="0" izz="1"/></inertial></link>
    <link name="L3"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1"
    iyz="0" izz="1"/></inertial></link>
    <joint name="j1" type="continuous"><parent link="base"/><child link="L1"/>
    <axis xyz="0 0 1"/></joint>
    <joint name="j2" type="continuous"><origin xyz="{ax} {ay} 0"/><parent link="L1"/>
    <child link="L2"/><axis xyz="0 0 1"/></joint>
    <joint name="j4" type="continuous"><origin xyz="{bx} {by} 0"/><parent link="base"/>
    <child link="L3"/><axis xyz="0 0 1"/></joint>
    <loop name="j3" type="revolute"><predecessor link="L2">
    <origin xyz="{round(cx - ax, 7)} {-ay} 0"/></predecessor><successor link="L3">
    <origin xyz="{round(cx - bx, 7)} {-by} 0"/></successor><axis xyz="0 0 1"/></loop>
    </robot>""",
    )


def test_a_kite_that_is_off_by_more_than_its_digits_is_general_and_told_to_be_near(
    tmp_path, capsys
):
    path = tmp_path / "kite.urdf"
    path.write_text(kite_text(1e-6))
    assert main(["report", str(path), "--json"]) == 0
    captured = capsys.readouterr()
    report = json.loads(captured.out)
    assert [order["rank"] for order in report["orders"]] == [3, 6, 7, 8]
    (notice,) = (n for n in report["warnings"] if n["code"] == "near_special")
    assert "with 7 conditions" in notice["message"]
    assert "a file with 9 digits would decide" in notice["message"]
    (reading,) = report["readings"]
    assert (reading["held"], reading["digits"], reading["deciding_digits"]) == (
        "as_written",
        8,
        9,
    )
    assert (reading["conditions_as_written"], reading["conditions_as_special"]) == (8, 7)
    assert reading["relations"] == ["kite j1 j2 j3 j4"] and 1 < reading["nearness"] < 30


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", [1, 3, 6])
@pytest.mark.parametrize("family", ["kite", "parallelogram"])
def test_a_file_with_the_digits_that_would_decide_decides(family, seed, tmp_path):
    """With those, one that is off is general without a remark, and one that is not special."""
    _, special, general = TRUE[family]
    (reading,) = space_of(tmp_path, family, seed, 7, 1e-6).readings
    assert reading.deciding in (8, 9, 10)
    assert (reading.written, reading.special) == (general[-1], special[-1])
    off = space_of(tmp_path, family, seed, reading.deciding, 1e-6)
    assert ranks(off) == general and not off.readings and "near_special" not in codes(off)
    meant = space_of(tmp_path, family, seed, reading.deciding)
    assert ranks(meant) == special


def test_digits_that_would_decide_are_those_of_a_double_at_most():
    assert deciding_digits(7, 2.0) == 9 and deciding_digits(7, 4.0) == 8
    assert deciding_digits(16, 0.5) is None and deciding_digits(17, 0.5) is None
    assert deciding_digits(9, 0.0) is None


@pytest.mark.table(1)
@pytest.mark.parametrize(("seed", "modes"), [(88, 1), (136, 2)])
def test_kites_of_six_digits_with_short_angles_or_nearly_folded(seed, modes, tmp_path, capsys):
    """1.8328 is no 3.142 × 7/12 there; 1e-3 from the folded pose both modes are listed."""
    frames, plane = FRAMES[seed % len(FRAMES)]
    path = tmp_path / "kite.urdf"
    path.write_text(meant_text(meant_linkage("kite", seed), seed, 6, frames, plane))
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    found = report.get("modes", [report])
    assert len(found) == modes
    assert [1, [3, 6, 7]] in [
        [mode["mobility"], [order["rank"] for order in mode["orders"]]] for mode in found
    ]


def test_design_says_which_reading_it_holds(tmp_path, capsys):
    path = tmp_path / "kite.urdf"
    path.write_text(kite_text(1e-6))
    assert main(["design", str(path)]) == 1
    assert (
        "reading       as written, held here: 8 conditions; if rounded: 7 conditions "
        "(kite j1 j2 j3 j4); a file with 9 digits would decide"
    ) in capsys.readouterr().out
    main(["design", str(path), "--json"])
    design = json.loads(capsys.readouterr().out)
    assert design["readings"][0]["held"] == "as_written"
    path.write_text(meant_text(meant_linkage("kite", 7), 7, 6))
    main(["design", str(path)])
    assert "reading       as meant, held here: 7 conditions" in capsys.readouterr().out
