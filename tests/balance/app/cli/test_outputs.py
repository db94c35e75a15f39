"""The writing of output files: what an answer makes, all of it or none."""

from __future__ import annotations

from argparse import Namespace

import pytest

from balance.app.answers.answer import Answer
from balance.app.cli.outputs import write_outputs
from kinematics.errors import FileError, UsageError


def answer(**files):
    """An answer with these files alone."""
    return Answer(0, dict, list, files=lambda: files)


def refuse():
    raise AssertionError("made for nothing")


def test_only_files_that_are_asked_for_are_made(tmp_path):
    path = tmp_path / "a.html"
    asked = Namespace(html=str(path), out=None, overwrite=False)
    write_outputs(asked, answer(html=lambda: "ü", out=refuse))
    assert path.read_bytes() == "ü".encode()
    write_outputs(Namespace(html=None, overwrite=False), Answer(0, dict, list, files=refuse))


def test_a_file_that_an_answer_cannot_make_is_not_written(tmp_path):
    asked = Namespace(out=str(tmp_path / "a.urdf"), overwrite=False)
    write_outputs(asked, answer(html=refuse))
    assert not list(tmp_path.iterdir())


def test_all_files_or_none(tmp_path):
    asked = Namespace(
        html=str(tmp_path / "a.html"), plot=str(tmp_path / "none" / "a.png"), overwrite=False
    )
    with pytest.raises(FileError, match="cannot be written"):
        write_outputs(asked, answer(html=lambda: "page", plot=lambda: b"picture"))
    assert not list(tmp_path.iterdir())


def test_a_folder_is_made_for_many_files_and_removed_if_one_fails(tmp_path):
    folder = tmp_path / "made"
    asked = Namespace(out=str(folder), html=str(tmp_path / "none" / "a.html"), overwrite=False)
    files = answer(out=lambda: {"a.urdf": b"1", "b.csv": b"2"}, html=lambda: "page")
    with pytest.raises(FileError):
        write_outputs(asked, files)
    assert not list(tmp_path.iterdir())
    asked.html = None
    write_outputs(asked, files)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == {
        "a.urdf": b"1",
        "b.csv": b"2",
    }


def test_a_file_of_a_folder_does_not_replace_one_that_is_read(tmp_path):
    model = tmp_path / "a.urdf"
    model.write_bytes(b"model")
    asked = Namespace(model=str(model), out=str(tmp_path), overwrite=False)
    files = answer(out=lambda: {"a.urdf": b"1"})
    with pytest.raises(UsageError, match=r"--out \(a.urdf\) would replace"):
        write_outputs(asked, files)
    assert model.read_bytes() == b"model"
    asked.overwrite = True
    write_outputs(asked, files)
    assert model.read_bytes() == b"1"
