"""Links that are alike: those of equal legs, whatever their names and places."""

from __future__ import annotations

import re

import pytest

import balance
from balance.masses.counterweights.alike_links import alike_links
from tests.support.source_files import ROOT

MACHINES = ROOT / "docs" / "machines"


def names_alike(linkage):
    """Names of the bodies of each class."""
    return [{linkage.body_names[b] for b in alike} for alike in alike_links(linkage)]


@pytest.mark.parametrize(
    ("file", "starts"),
    [
        ("clavel_delta.urdf", ["arm", "rod", "plate"]),
        ("dual_v.urdf", ["lower", "upper", "platform"]),
        ("stewart.urdf", ["lower", "upper", "platform"]),
    ],
)
def test_legs_that_one_drawing_repeats_are_alike(file, starts):
    """All legs of these machines are made from one drawing, turned about the vertical."""
    linkage = balance.load(MACHINES / file)
    classes = names_alike(linkage)
    want = [{name for name in linkage.body_names if name.startswith(start)} for start in starts]
    assert sorted(map(sorted, classes)) == sorted(map(sorted, want))


def test_classes_know_no_names_and_no_order_of_the_file(tmp_path):
    text = (MACHINES / "dual_v.urdf").read_text("utf-8")
    swapped = re.sub(r"(lower|upper)([12])\b", lambda m: f"{m[1]}{3 - int(m[2])}x", text)
    path = tmp_path / "renamed.urdf"
    path.write_text(swapped, "utf-8")
    sizes = [len(alike) for alike in names_alike(balance.load(path))]
    assert sorted(sizes) == [1, 4, 4]


def test_a_heavier_link_tells_its_leg_from_the_others(tmp_path):
    """Neighbours of a link that is unlike others are unlike theirs."""
    text = (MACHINES / "dual_v.urdf").read_text("utf-8")
    first = text.index('<link name="upper1"')
    changed = re.sub(r'mass value="([\d.]+)"', r'mass value="\g<1>9"', text[first:], count=1)
    path = tmp_path / "heavier.urdf"
    path.write_text(text[:first] + changed, "utf-8")
    classes = names_alike(balance.load(path))
    assert {"upper1"} in classes and {"lower1"} in classes
    assert {"upper2", "upper3", "upper4"} in classes and {
        "lower2",
        "lower3",
        "lower4",
    } in classes


def test_equal_legs_get_matter_together():
    """Rods together take less than one alone, and both are named, the fewer links first."""
    space = balance.design_space(MACHINES / "clavel_delta.urdf", balance="force")
    answer = balance.counterweights(space, ["arm1", "arm2", "arm3"])
    rods = tuple(name for name in space.bodies if name.startswith("rod"))
    changes = {change.links: change.mass for change in answer.relaxations}
    assert {*changes} == {rods, rods[:1]} and changes[rods] < changes[rods[:1]]
    for links, mass in changes.items():
        whole = balance.counterweights(space, ["arm1", "arm2", "arm3", *links])
        assert whole.added_mass == pytest.approx(mass, rel=1e-4)


def test_no_more_further_links_are_named_than_are_needed():
    """Without any of them nothing balances, and the machine with them takes what is said."""
    space = balance.design_space("delta", balance="force")
    answer = balance.counterweights(space, ["arm1", "arm2", "arm3"])
    fewest = answer.relaxations[0]
    assert fewest.factor is None and len(fewest.links) < len(space.bodies) - 3
    links = ["arm1", "arm2", "arm3", *fewest.links]
    whole = balance.counterweights(space, links, relax=False)
    assert whole.added_mass == pytest.approx(fewest.mass, rel=1e-4)
    for link in fewest.links:
        less = [name for name in links if name != link]
        assert balance.counterweights(space, less, relax=False).verdict == "infeasible"


@pytest.mark.parametrize(("moment", "alike"), [("0.003", True), ("0.009", False)])
def test_moments_of_inertia_tell_links_of_a_plane_apart(moment, alike):
    """Those normal to the plane: the second moment of mass along the axes stays the same."""
    inertial = (
        '<inertial><origin xyz="0 0.25 0"/><mass value="0.5"/>'
        '<inertia ixx="{0}" iyy="{0}" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    sketch = balance.studies.linkage_from_sketch(
        "A=0,0; B=0,0.5; C=1,0.5; D=1,0", "crank=A,B; coupler=B,C; rocker=D,C"
    )
    text = sketch.to_urdf().decode()
    # Ixx + Iyy - Izz, twice the second moment along z, is 0.001 in both.
    thick = f"{(float(moment) + 0.001) / 2:.6g}"
    for link, izz, across in (("crank", "0.003", "0.002"), ("rocker", moment, thick)):
        text = text.replace(
            f'<link name="{link}"/>',
            f'<link name="{link}">{inertial.format(across, izz)}</link>',
        )
    assert text.count("<inertial>") == 2
    classes = names_alike(balance.load(text.encode()))
    assert ({"crank", "rocker"} in classes) is alike
