"""Files that the product writes appear whole, or not at all, and harm nothing."""

from __future__ import annotations

import os
import stat
import threading

import pytest

from balance.files import replacing, replacing_all
from kinematics.errors import FileError


def write(path, content=b"new"):
    with replacing(path) as file:
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
    with pytest.raises(KeyError), replacing(path) as file:
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
    replacing_all([(str(one), b"1"), (str(other), b"2")])
    assert (one.read_bytes(), other.read_bytes()) == (b"1", b"2")
    with pytest.raises(FileError):
        replacing_all([(str(one), b"3"), (str(tmp_path / "nowhere" / "file"), b"4")])
    assert one.read_bytes() == b"1" and sorted(tmp_path.iterdir()) == [one, other]
