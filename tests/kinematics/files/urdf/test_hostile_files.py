"""Files of great size, and paths that are no files or change: one line, little memory."""

import os

import pytest

from kinematics import gallery
from kinematics.files.urdf import xml_tree as markup
from tests.support.limited_process import run_limited
from tests.support.refusals import said_of

TEXT = gallery()["four_bar_general"].read_text(encoding="utf-8")
# The peak of ``getrusage`` is no less than that of the process that forked: VmHWM is its own.
HEAVY = (
    "import re, sys\n"
    "from balance.app.cli.main import main\n"
    "code = main(['report', sys.argv[1], '--json'])\n"
    "peak = re.search(r'VmHWM:\\s*(\\d+)', open('/proc/self/status').read())\n"
    "print(code, int(peak[1]) // 1024)\n"
)
ROBOT = '<robot name="r"><link name="l0"/>'
LARGE = {
    "levels": ("<robot name='r'>" + "<a>" * 1_000_000, "more than 200 levels deep"),
    "closed levels": ("<a>" * 1_000_000 + "</a>" * 1_000_000, "more than 200 levels deep"),
    "elements": (ROBOT + "<a/>" * 1_000_000 + "</robot>", "more than 100000 elements"),
    "joints": (
        ROBOT
        + "".join(
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/>'
            f'<child link="l{i}"/><axis xyz="0 0 1"/></joint>'
            for i in range(1, 50_001)
        )
        + "</robot>",
        "more than 100000 elements",
    ),
    "moving joints": (
        ROBOT
        + "".join(
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/>'
            f'<child link="l{i}"/></joint>'
            for i in range(1, 1_100)
        )
        + "</robot>",
        "joint 'j1001' (line 1): joints and loops of more than 1000 degrees",
    ),
    "attributes": (
        "<robot " + " ".join(f'a{i}=""' for i in range(150_000)) + "/>",
        "a tag or a comment of more than 1 MB",
    ),
    "a word": ("<" + "x" * 15_000_000, "a tag or a comment of more than 1 MB"),
    "a comment": ("<!--" + "x" * 15_000_000, "a tag or a comment of more than 1 MB"),
    "a value": (f"<robot name='{'x' * 200_000}'/>", "a value of more than 100000 characters"),
    "text": (ROBOT + "x\n" * 7_000_000, "not well-formed XML"),
}


def heavily(path):
    """Exit code, megabytes and messages of a process that reads a file."""
    done = run_limited(HEAVY, str(path))
    code, megabytes = map(int, done.stdout.split())
    return code, megabytes, done.stderr


@pytest.mark.table(2)
@pytest.mark.parametrize("case", [*LARGE, "200 MB"])
def test_large_files_take_little(case, tmp_path):
    path = tmp_path / "large.urdf"
    text, problem = LARGE.get(case, ("", "larger than 16 MB"))
    path.write_text(text, encoding="utf-8")
    if case == "200 MB":
        os.truncate(path, 200 * 2**20)
    code, megabytes, line = heavily(path)
    assert code == 3 and len(line.splitlines()) == 1 and problem in line
    assert megabytes < 300


def test_no_regular_file(tmp_path, capsys):
    folder = tmp_path / "folder.urdf"
    folder.mkdir()
    (tmp_path / "zero.urdf").symlink_to("/dev/zero")
    (tmp_path / "circle.urdf").symlink_to("circle.urdf")
    for path in (folder, tmp_path / "zero.urdf"):
        assert said_of(path, capsys) == f"/{path.name}: not a file; give the path of a file"
    line = said_of(tmp_path / "circle.urdf", capsys)
    assert line.startswith("/circle.urdf: cannot be read (Too many levels of symbolic links)")
    assert said_of(tmp_path / "none.urdf", capsys) == (
        "/none.urdf: no such file; check the path"
    )


def test_a_pipe_that_takes_the_place_of_a_file(tmp_path, monkeypatch, capsys):
    """It is looked at again after it was opened, and nobody waits for it."""
    path, pipe = tmp_path / "robot.urdf", tmp_path / "pipe"
    path.write_text(TEXT, encoding="utf-8")
    os.mkfifo(pipe)
    opened = os.open
    monkeypatch.setattr(markup.os, "open", lambda _, flags: opened(pipe, flags))
    assert said_of(path, capsys) == "/robot.urdf: not a file; give the path of a file"


def test_no_permission(tmp_path, monkeypatch, capsys):
    path = tmp_path / "robot.urdf"
    path.write_text(TEXT, encoding="utf-8")
    path.chmod(0)
    if os.access(path, os.R_OK):

        def denied(*_):
            raise PermissionError(13, "Permission denied", str(path))

        monkeypatch.setattr(markup.os, "open", denied)
    line = said_of(path, capsys)
    assert line == "/robot.urdf: cannot be read (Permission denied); check the path"


@pytest.mark.parametrize("change", ["grows", "shrinks", "is written again"])
def test_a_file_that_changes_while_it_is_read(change, tmp_path, monkeypatch, capsys):
    path = tmp_path / "robot.urdf"
    path.write_text(TEXT, encoding="utf-8")
    os.utime(path, (1e9, 1e9))
    found = os.fstat

    def meddling(number):
        before = found(number)
        text = {"grows": TEXT + " ", "shrinks": TEXT[:-9]}.get(change, TEXT)
        path.write_text(text, encoding="utf-8")
        return before

    monkeypatch.setattr(markup.os, "fstat", meddling)
    line = said_of(path, capsys)
    assert line == "/robot.urdf: changed while it was read; read it again once it is written"
