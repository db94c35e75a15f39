"""New masses in the text of a URDF file: where they go, and that nothing else changes."""

from __future__ import annotations

import re

import numpy as np
import pytest
import yourdfpy

import kinematics
from balance.masses.designs.write_urdf import replace_inertials
from balance.support.atomic_files import open_atomic
from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.read import read_loaded_model
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.loading.model_gallery import gallery
from tests.support.laws import point_masses, sums
from tests.support.sidecar_text import PAIR, bench, written
from tests.support.urdf_text import (
    EYE,
    FOUR_BAR,
    along,
    inertial_of,
    joint,
    link,
    loop,
    pose_of,
    saved,
)

ELEMENT = "<inertial>\n  <mass/>\n</inertial>"
ANY = re.compile(rb"[\r\n]*[ \t]*<inertial\b[^>]*(?:/>|>.*?</inertial\s*>)", re.DOTALL)
BODIES = ("crank", "coupler", "rocker")
# A link before and after, at the margin of a robot; and what it is about.
LAYOUTS = {
    "one tag": (
        '\n  <link name="crank"/>',
        '\n  <link name="crank">\n    <inertial>\n      <mass/>\n    </inertial>\n  </link>',
    ),
    "two tags": (
        '\n  <link name="crank"></link >',
        '\n  <link name="crank"><inertial><mass/></inertial></link >',
    ),
    "nothing but a comment": (
        '\n\t<link name="crank">\n\t\t<!-- </link> /> -->\n\t</link>',
        '\n\t<link name="crank">\n\t\t<!-- </link> /> -->\n\t\t<inertial>\n\t\t\t<mass/>'
        "\n\t\t</inertial>\n\t</link>",
    ),
    "another child": (
        '\r\n  <link name="crank" >\r\n      <visual/>\r\n  </link>',
        '\r\n  <link name="crank" >\r\n      <inertial>\r\n        <mass/>\r\n      </inertial>'
        "\r\n      <visual/>\r\n  </link>",
    ),
    "an old one": (
        '\n <link\n name="crank"><visual/>\n <inertial a=">"><!-- > --><mass value="3"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial\n> <!-- c -->\n</link>',
        '\n <link\n name="crank"><visual/>\n <inertial>\n   <mass/>\n </inertial> <!-- c -->'
        "\n</link>",
    ),
    "an empty old one": (
        '<link name="crank"><inertial/></link>',
        '<link name="crank"><inertial><mass/></inertial></link>',
    ),
    "no line breaks": (
        '<link name="crank"/><!--  --> ',
        '<link name="crank"><inertial><mass/></inertial></link><!--  --> ',
    ),
}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-be", "utf-16-le", "iso-8859-1", "cp1252")


def element_of(mass, inertia, origin):
    """``<inertial>`` by the route of the tests, on one line."""
    return link("x", mass, inertia, origin).partition(">")[2].removesuffix("</link>")


def redrawn(draft, seed):
    """For each body a random cloud: its element in the link frame, and its parameters."""
    rng = np.random.default_rng(seed)
    elements, expected = {}, []
    for body in draft.bodies:
        masses, points = point_masses(rng)
        elements[body.name] = element_of(**inertial_of(rng, masses, points))
        R, d = body.frame[:3, :3], body.frame[:3, 3]
        expected.append(sums(masses, points @ R.T + d))
    return elements, np.array(expected)


def close(bodies, expected):
    found = np.array([body.inertia for body in bodies])
    for mine, theirs in zip(found, expected, strict=True):
        assert np.abs(mine - theirs).max() < 1e-12 * np.abs(theirs).max()


@pytest.fixture
def robot(tmp_path):
    """Write a text or bytes to a file and return the draft of it."""

    def read_text(text, **options):
        path = tmp_path / "robot.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_unassembled(path, None, ReadOptions(**options))

    return read_text


@pytest.mark.parametrize("case", LAYOUTS)
def test_where_it_goes(robot, case):
    before, after = LAYOUTS[case]
    start = '<?xml version="1.0"?><robot name="r"><link name="base"/>'
    rest = joint("j", "revolute", "base", "crank", axis=[0, 0, 1]) + "</robot>\n\n<!-- e -->"
    draft = robot(start + before + rest, bodies="all")
    assert replace_inertials(draft, {"crank": ELEMENT}) == (start + after + rest).encode()


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_encodings_keep_their_bytes(robot, encoding):
    declared = f'encoding="{encoding}"' if encoding in ENCODINGS[-2:] else ""
    text = FOUR_BAR.replace('version="1.0"', f'version="1.0" {declared}')
    text = text.replace("a comment", "ü, ä \r\n and §").replace("crank", "bièle")
    elements = dict.fromkeys(("bièle", "rocker"), ELEMENT)
    expected = replace_inertials(robot(text.replace(declared, "").encode()), elements).decode()
    data = text.encode(encoding)
    found = replace_inertials(robot(data), elements)
    assert found.decode(encoding).replace(declared, "") == expected
    assert found[:2] == data[:2]
    assert expected.count("<inertial>") == 3 and expected.count("<mass/>") == 2


@pytest.mark.table
@pytest.mark.parametrize("model", gallery())
def test_what_is_read_again_is_what_was_meant(model, tmp_path):
    draft = read_unassembled(gallery()[model])
    elements, expected = redrawn(draft, len(model))
    path = tmp_path / "out.urdf"
    path.write_bytes(replace_inertials(draft, elements))
    close(read_unassembled(path).bodies, expected)
    rest = ANY.sub(b"", path.read_bytes())
    assert rest == ANY.sub(b"", gallery()[model].read_bytes())


WELDED = FOUR_BAR.replace(
    '<link name="rocker">',
    link("tool", 2.0, np.eye(3), along([1.0, 2.0, 3.0]))
    + link("bolt")
    + link("stand", 5.0, np.eye(3))
    + joint("weld", "fixed", "rocker", "tool", pose_of([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]))
    + joint("screwed", "fixed", "tool", "bolt", EYE)
    + joint("standing", "fixed", "base", "stand", EYE)
    + '<link name="rocker">',
)


def test_links_that_are_one_body(robot, tmp_path):
    """The topmost link holds all of it; the ground and links without a body stay."""
    draft = robot(WELDED)
    elements, expected = redrawn(draft, 3)
    assert set(elements) == set(BODIES)
    one = replace_inertials(draft, {"crank": elements["crank"]})
    new = robot(replace_inertials(draft, elements))
    close(new.bodies, expected)
    held = [x.name for x in new.tree.every("link") if x.first("inertial")]
    assert held == ["crank", "coupler", "stand", "rocker"]
    close(robot(one).bodies, [expected[0], *(body.inertia for body in draft.bodies[1:])])


def test_masses_are_in_the_frames_that_were_read(robot):
    """Those of rounded angles as they are meant, or as they are written."""
    text = FOUR_BAR.replace('rpy="0 0 1.5"', 'rpy="1.5708 0 0"')
    drafts = {angles: robot(text, angles=angles) for angles in ("nominal", "as_written")}
    for angles, draft in drafts.items():
        robot(text)
        elements, expected = redrawn(draft, 4)
        data = replace_inertials(draft, elements)
        close(robot(data, angles=angles).bodies, expected)
        (other,) = drafts.keys() - {angles}
        with pytest.raises(AssertionError):
            close(robot(data, angles=other).bodies, expected)


def test_what_is_taken_away_leaves_no_empty_line(robot):
    before = '\r\n  <link name="tool">\r\n    <inertial/>\r\n    <visual/>\r\n  </link>'
    after = before.replace("\r\n    <inertial/>", "")
    weld = joint("weld", "fixed", "rocker", "tool")
    text = FOUR_BAR.replace("</robot>", f"{before}{weld}</robot>")
    draft = robot(text)
    found = replace_inertials(draft, {"rocker": ELEMENT}).decode()
    assert after in found and before not in found
    assert before in replace_inertials(draft, {"crank": ELEMENT}).decode()


def test_loops_beside_the_file(tmp_path):
    """They are open in the file: bodies carry their masses to where they close."""
    path = written(tmp_path, bench(), PAIR + "type: ['3d']\n")
    linkage = kinematics.load(path)
    assert "assembled" in [notice.code for notice in linkage.notices]
    elements, expected = redrawn(linkage, 5)
    data = replace_inertials(linkage, elements)
    with open_atomic(path) as file:
        file.write(data)
    again = kinematics.load(path)
    assert len(again.loops) == 1
    close(again.bodies, expected)
    assert b"tip_a" in data and data.count(b"<inertial>") == 3


def test_what_cannot_be_written(robot, tmp_path):
    draft = robot(FOUR_BAR)
    path = tmp_path / "robot.urdf"
    path.write_text(FOUR_BAR.replace('"rocker"', '"lever"'))
    with pytest.raises(FileError, match="has other links than when it was read; start again"):
        replace_inertials(draft, {"crank": ELEMENT})
    path.unlink()
    with pytest.raises(FileError, match="no such file"):
        replace_inertials(draft, {"crank": ELEMENT})
    path.write_text(FOUR_BAR)
    model = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=False)
    with pytest.raises(FileError, match="a model in memory, .*; load .* the path"):
        replace_inertials(read_loaded_model(model), {"crank": ELEMENT})


def test_links_that_a_loop_welds_share_the_masses_of_their_body(tmp_path):
    """Two halves of a coupler: the first gets all masses, also those that a part brings."""
    bars = [
        *(link(name, 2.0, np.eye(3), along([0.3, 0.1, 0.2])) for name in "abcdp"),
        joint("j1", "revolute", "base", "a", axis=[0, 0, 1]),
        joint("j2", "revolute", "a", "c", along([0.0, 1.0, 0.0]), [0, 0, 1]),
        joint("j3", "revolute", "base", "b", along([2.0, 0.0, 0.0]), [0, 0, 1]),
        joint("j4", "revolute", "b", "d", along([0.2, 1.2, 0.0]), [0, 0, 1]),
        joint("held", "fixed", "d", "p", along([0.0, 0.5, 0.0])),
        loop("halves", "fixed", ("c", "d"), (along([1.0, 0.1, 0.0]), along([-1.2, -0.1, 0.0]))),
    ]
    linkage = kinematics.load(saved(tmp_path, link("base"), *bars))
    assert [body.name for body in linkage.bodies] == ["a", "c", "b"]
    assert linkage.bodies[1].inertia[0] == 6.0
    elements, expected = redrawn(linkage, 3)
    out = tmp_path / "out.urdf"
    out.write_bytes(replace_inertials(linkage, elements))
    close(kinematics.load(out).bodies, expected)
    kept = {name: element for name, element in elements.items() if name != "c"}
    out.write_bytes(replace_inertials(linkage, kept))
    again = kinematics.load(out).bodies
    close([again[1]], [linkage.bodies[1].inertia])
