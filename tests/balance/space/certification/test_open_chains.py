"""Open chains whose axes are parallel by a sum of two angles: no word about loops."""

from __future__ import annotations

import pytest

from balance import certify, design_space
from balance.space.certification import certify_space
from kinematics import load
from tests.independent.reference import load as load_reference
from tests.independent.reference import rank_over_poses

BODY = (
    '<inertial><origin xyz="0.1 0.2 0.3"/><mass value="1"/>'
    '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial>'
)


def arm(folder, words, third="", direction="0 1 0"):
    """Two joints, in frames turned by two angles if there are any, and maybe a third one."""
    first, second = (f'rpy="0 0 {word}"' if word else "" for word in words)
    path = folder / "arm.urdf"
    parent, bend = "a", ""
    if first:
        parent = "b"
        bend = (
            '<link name="b"/><joint name="bend" type="fixed"><parent link="a"/>'
            f'<child link="b"/><origin xyz="0.1 0.2 0.3" {first}/></joint>'
        )
    path.write_text(
        f'<robot name="arm"><link name="base"/><link name="a">{BODY}</link>'
        f'<link name="c">{BODY}</link><joint name="first" type="continuous">'
        f'<parent link="base"/><child link="a"/><axis xyz="1 0 0"/></joint>{bend}'
        f'<joint name="second" type="continuous"><parent link="{parent}"/><child link="c"/>'
        f'<origin xyz="0.3 0.1 0.2" {second}/><axis xyz="{direction}"/></joint>'
        f"{third}</robot>"
    )
    return path


THIRD = (
    f'<link name="d">{BODY}</link><joint name="third" type="continuous"><parent link="c"/>'
    '<child link="d"/><origin xyz="0.3 0.1 0.2"/><axis xyz="0 0 1"/></joint>'
)
# Their sum is π/2 in double precision, and not in decimals.
PARALLEL = "0.3", "1.2707963267948966"


def told(space):
    """All that an answer says of itself."""
    notices = [notice.message for notice in space.notices]
    readings = [reading.words for reading in space.readings]
    return " ".join((space.certainty.reason, *space.doubts, *notices, *readings))


def parallel_arm(folder, third):
    """The arm with the second axis along the first, without angles."""
    path = arm(folder, ("", ""), third, "-1 0 0")
    return load_reference(path, ("first", "second", "third")[: 3 if third else 2])


@pytest.mark.parametrize("third", ["", THIRD])
def test_an_open_chain_is_not_said_to_have_loops(tmp_path, third):
    special = rank_over_poses(parallel_arm(tmp_path, third), spatial=bool(third)).rank
    path = str(arm(tmp_path, PARALLEL, third))
    space = certify(design_space(load(path)))
    assert (space.rank, space.level) == (special, "proved")
    text = told(space)
    assert "as written" in text and "close" not in text and "loop" not in text
    as_written = certify(design_space(load(path, angles="as_written")))
    assert as_written.rank > special or as_written.doubts
    assert "close" not in told(as_written)


def test_where_replaced_numbers_decide_the_reason_speaks_of_them(tmp_path, monkeypatch):
    """As if a special geometry rested on angles that have no rational rotation."""
    monkeypatch.setattr(certify_space, "rests_on_replaced", lambda *_: True)
    monkeypatch.setattr(certify_space, "is_general_as_written", lambda *_: False)
    space = design_space(load(str(arm(tmp_path, PARALLEL, THIRD)), angles="as_written"))
    reason = certify(space).certainty.reason
    assert "replaced numbers may lose a special geometry" in reason
    assert "close" not in reason
