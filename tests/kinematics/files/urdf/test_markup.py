"""The XML pass: truncation, entities, limits, and files that cannot be read."""

import os
import re

import pytest

from kinematics.files.formats.robot_files import read_robot
from tests.support.limited_process import run_limited
from tests.support.urdf_text import FOUR_BAR, refusal


def test_text_and_order_are_kept(robot):
    text = '<robot name="r"><link name="l"/><note> a<b/> b </note></robot>'
    tree = read_robot(robot(text)).tree
    assert tree.first("note").text == "a b"
    assert [item.tag for item in tree.walk()] == ["robot", "link", "note", "b"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_encodings(robot, encoding):
    text = FOUR_BAR.replace('"1.0"', f'"1.0" encoding="{encoding}"').replace("crank", "bièle")
    assert read_robot(robot(text.encode(encoding))).tree.every("link")[1].name == "bièle"


@pytest.mark.parametrize(
    "first", ["\n", " \t\r\n\n", "<!-- a\n b? -->\n", "\n<!--a--><!-- b -->"]
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "iso-8859-1"])
def test_blanks_and_comments_before_the_declaration(robot, first, encoding):
    """They mean nothing, and every element keeps its place in the file."""
    name = encoding.removesuffix("-sig")
    text = FOUR_BAR.replace('"1.0"', f'"1.0" encoding="{name}"').replace("crank", "bièle")
    plain, moved = (read_robot(robot((x + text).encode(encoding))).tree for x in ("", first))
    lines, size = len(re.findall("\r\n|\n", first)), len(first.encode(encoding))
    shift = size - 3 * (encoding == "utf-8-sig")
    for one, other in zip(plain.walk(), moved.walk(), strict=True):
        assert (one.tag, one.attributes) == (other.tag, other.attributes)
        assert other.line == one.line + lines
        assert other.span == (one.span[0] + shift, one.span[1] + shift)


READ = """
import sys
from kinematics.files.formats.robot_files import read_robot
read_robot(sys.argv[1])
"""


def test_many_comments_without_a_declaration_are_read_at_once(robot):
    """Two ways to end each comment would be 2^60 ways to read them; a limit ends such a run."""
    text = FOUR_BAR.partition("?>")[2].replace("<link", "<!-- a -->\n <link")
    path = robot(
        "<!-- license -->\n" + text.replace("</robot>", "<!-- b -->\n" * 60 + "</robot>")
    )
    assert run_limited(READ, str(path)).stdout == ""


@pytest.mark.parametrize("percent", range(10, 100))
def test_truncated(robot, percent):
    data = FOUR_BAR.encode()
    error = refusal(robot(data[: len(data) * percent // 100]))
    assert re.search(r"not well-formed XML at line \d+, column \d+", error.problem)
    assert "again" in error.remedy


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "empty file"),
        (b" \n\n ", "empty file"),
        (b"\x7fELF\x00\x01", "not well-formed"),
        (b"solid mesh", "line 1, column 1"),
        (b"<robot name='a'><link name='l'></robot>", "mismatched tag"),
        (FOUR_BAR.encode() + b"<robot/>", "junk after document element"),
        (b"<?xml version='1.0' encoding='klingon'?><robot/>", "XML"),
        (b"<?xml version='1.0' encoding='utf-7'?><robot/>", "XML"),
        (b"<?xml version='1.0' encoding='gb18030'?><robot/>", "XML"),
        (b"<robot name='\xff'/>", "not well-formed"),
        (b"<robot name='&lol;'/>", "undefined entity"),
        (b"<robot name='a' name='b'/>", "duplicate attribute"),
        (b"<sdf version='1.6'/>", "no <model>"),
        (b"<svg/>", "root element is not <robot>"),
        (b"<robot name='a'/>", "no <link>"),
    ],
)
def test_not_a_urdf_file(robot, data, problem):
    assert problem in refusal(robot(data)).problem


BOMB = "<!DOCTYPE robot [<!ENTITY a 'x'>{}]><robot name='&a9;'><link name='l'/></robot>"


@pytest.mark.parametrize(
    "text",
    [
        BOMB.format("".join(f"<!ENTITY a{i} '{f'&a{i - 1};' * 10}'>" for i in range(1, 10))),
        "<!DOCTYPE r [<!ENTITY x SYSTEM 'file:///etc/hostname'>]><robot name='a'>&x;</robot>",
        "<!DOCTYPE robot SYSTEM 'http://localhost/robot.dtd'><robot name='a'/>",
    ],
)
def test_entities_are_never_expanded(robot, text):
    error = refusal(robot(text))
    assert error.element.startswith("<!DOCTYPE>") and "DOCTYPE" in error.remedy


@pytest.mark.slow
def test_limits(robot):
    deep = "<robot name='a'>" + "<link name='l'>" * 300 + "</link>" * 300 + "</robot>"
    assert "200 levels deep" in refusal(robot(deep)).problem
    many = "<robot name='a'>" + "<material/>" * 100_000 + "</robot>"
    assert "more than 100000 elements" in refusal(robot(many)).problem
    wide = f"<robot name='a'><link name='{'l' * 100_001}'/></robot>"
    assert "100000 characters" in refusal(robot(wide)).problem
    long = refusal(robot(FOUR_BAR.replace('xyz="0 0 0"', f'xyz="{"9" * 90_000}"')))
    assert len(str(long)) < 500


def test_too_large(tmp_path):
    path = tmp_path / "large.urdf"
    with path.open("wb") as stream:
        stream.truncate(16 * 2**20 + 1)
    error = refusal(path)
    assert error.problem == "larger than 16 MB" and "meshes" in error.remedy


def test_files_that_cannot_be_read(tmp_path, robot):
    assert refusal(tmp_path / "missing.urdf").problem == "no such file"
    assert refusal(tmp_path).problem == "not a file"
    assert "cannot be read" in refusal("a\0b.urdf").problem
    assert "cannot be read" in refusal("a" * 5000).problem
    assert refusal(tmp_path / "a\nb.urdf").file.endswith("a b.urdf")
    pipe = tmp_path / "pipe.urdf"
    os.mkfifo(pipe)
    assert refusal(pipe).problem == "not a file"
    below = robot(FOUR_BAR) / "robot.urdf"
    assert "cannot be read" in refusal(below).problem
