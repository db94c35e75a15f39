"""Files that the product writes appear whole, or not at all, and harm nothing."""

from __future__ import annotations

import os
import stat
import sys
import threading
from argparse import ArgumentTypeError

import pytest

import kinematics
from balance.app.cli.main import main
from balance.app.cli.outputs import page_path
from balance.momentum import screw_figure
from balance.support.atomic_files import open_atomic, write_all_atomic
from kinematics.errors import FileError, LinkageError, PackageError, UsageError
from kinematics.loading.model_gallery import gallery


def write(path, content=b"new"):
    with open_atomic(path) as file:
        file.write(content)


def test_a_file_is_replaced_and_keeps_its_mode(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"old")
    path.chmod(0o600)
    write(path)
    assert path.read_bytes() == b"new" and stat.S_IMODE(path.stat().st_mode) == 0o600
    write(tmp_path / "other")
    assert sorted(os.listdir(tmp_path)) == ["file", "other"]


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "file").write_bytes(b"old")
    (tmp_path / "link").symlink_to("file")
    write(tmp_path / "link")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "file").read_bytes() == b"new"


def test_what_fails_half_way_leaves_the_old_file(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"old")
    with pytest.raises(KeyError), open_atomic(path) as file:
        file.write(b"half")
        raise KeyError
    assert path.read_bytes() == b"old" and os.listdir(tmp_path) == ["file"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_written_to_and_not_replaced(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    found = []
    reader = threading.Thread(target=lambda: found.append(path.read_bytes()))
    reader.start()
    write(path)
    reader.join(10)
    assert found == [b"new"] and stat.S_ISFIFO(path.stat().st_mode)


@pytest.mark.parametrize("name", ["", "missing/file"])
def test_what_cannot_be_written_is_one_line(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match="cannot be written"):
        write(name)
    assert os.listdir(tmp_path) == []


def test_of_several_files_all_appear_or_none(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    write_all_atomic([(str(one), b"1"), (str(other), b"2")])
    assert (one.read_bytes(), other.read_bytes()) == (b"1", b"2")
    with pytest.raises(FileError):
        write_all_atomic([(str(one), b"3"), (str(tmp_path / "nowhere" / "file"), b"4")])
    assert one.read_bytes() == b"1" and sorted(tmp_path.iterdir()) == [one, other]


# --- what a command may write ----------------------------------------------------------------


def model(folder):
    """A copy of a linkage, its name by other routes, and the paths of nothing yet."""
    path = folder / "robot.urdf"
    path.write_bytes(gallery()["four_bar_antiparallelogram"].read_bytes())
    (folder / "link.urdf").symlink_to("robot.urdf")
    os.link(path, folder / "same.urdf")
    return path


def refused(capsys, *words):
    """The line of a command that is told to write what it may not."""
    assert main([str(word) for word in words]) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    line, where = streams.err.splitlines()
    assert where == f"balance {words[0]} --help lists what there is"
    return line


@pytest.mark.table(1)
@pytest.mark.parametrize("name", ["robot.urdf", "link.urdf", "same.urdf", "../{}/robot.urdf"])
@pytest.mark.parametrize(
    ("verb", "option"), [("design", "--out"), ("report", "--write-closed")]
)
def test_a_model_is_not_written_over(verb, option, name, tmp_path, monkeypatch, capsys):
    """By its own path, a symbolic or a hard link, or a path from elsewhere."""
    path = model(tmp_path)
    before = path.read_bytes()
    monkeypatch.chdir(tmp_path)
    line = refused(capsys, verb, path, option, name.format(tmp_path.name))
    assert (
        f"{option} would replace a file that is read; give another path, or --overwrite" in line
    )
    assert path.read_bytes() == before
    assert main([verb, str(path), option, "other.urdf"]) == 0
    assert main([verb, "other.urdf", option, "other.urdf", "--overwrite"]) == 0


def test_what_else_is_read_is_not_written_over(tmp_path, capsys):
    """Loops, tables and a second model; under names that are those of pages and pictures."""
    path, page, image = model(tmp_path), tmp_path / "read.html", tmp_path / "read.svg"
    table = "time,u1\n" + "".join(f"{0.1 * k},{0.01 * k * k}\n" for k in range(9))
    for file in (page, image):
        file.write_text(table, encoding="utf-8")
    for words in (
        ("verify", path, "--csv", page, "--html", page),
        ("verify", path, "--csv", image, "--plot", image),
        ("motion", path, "--path", page, "--html", page),
        ("motion", path, "--path", image, "--plot", image),
        ("report", path, "--loops", page, "--html", page),
    ):
        assert "would replace a file that is read" in refused(capsys, *words), words
        assert page.read_text("utf-8") == image.read_text("utf-8") == table
    page.write_bytes(path.read_bytes())
    line = refused(capsys, "verify", path, "--against", page, "--html", page)
    assert "--html would replace" in line and page.read_bytes() == path.read_bytes()
    beside = tmp_path / "robot.yaml"
    beside.write_text("closed_loop: []\n", encoding="utf-8")
    assert "--out would replace" in refused(capsys, "design", path, "--out", beside)
    assert "both --html and --write-closed" in refused(
        capsys,
        "report",
        path,
        "--html",
        tmp_path / "a.html",
        "--write-closed",
        tmp_path / "a.html",
    )


def test_a_model_of_the_gallery_is_not_written_over(capsys):
    path = gallery()["four_bar_kite"]
    before = path.read_bytes()
    assert "--out would replace" in refused(capsys, "design", "four_bar_kite", "--out", path)
    assert path.read_bytes() == before


@pytest.mark.parametrize("verb", ["report", "design", "verify", "motion"])
@pytest.mark.parametrize("name", ["x.txt", "page", "x.html.gz", "html", ""])
def test_a_page_ends_in_html(verb, name, tmp_path, capsys):
    assert main([verb, "four_bar_kite", "--html", f"{tmp_path}/{name}"]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and "ends neither in .html nor in .htm" in streams.err
    assert len(streams.err.splitlines()) == 2 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["x.html", "X.HTM", "a b.Html"])
def test_pages_that_do(name, tmp_path, capsys):
    assert main(["report", "four_bar_kite", "--html", str(tmp_path / name)]) == 0
    assert [item.name for item in tmp_path.iterdir()] == [name]


@pytest.mark.skipif(not os.path.exists("/dev/stderr"), reason="no devices here")
def test_a_page_may_go_to_a_device():
    assert page_path("/dev/null") == "/dev/null"
    with pytest.raises(ArgumentTypeError):
        page_path("/dev")


def test_missing_packages_are_usage():
    error = PackageError("a picture", "Matplotlib", "pip install matplotlib")
    assert isinstance(error, UsageError) and isinstance(error, LinkageError)
    assert (error.package, error.command) == ("Matplotlib", "pip install matplotlib")
    assert str(error) == (
        "a picture needs Matplotlib, which is not installed; install it with "
        "'pip install matplotlib'"
    )


@pytest.mark.slow
def test_figures_say_what_to_install(monkeypatch):
    linkage = kinematics.load("four_bar_kite")
    assert screw_figure(linkage, [0.1]) is not None
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(PackageError, match="'pip install matplotlib'"):
        screw_figure(linkage, [0.1])
