"""Models that come through standard input or a pipe: the answers of their files, read once."""

import io
import json
import os
import subprocess
import sys
import threading

import pytest

import kinematics
from balance.app.cli.main import main
from kinematics import gallery
from kinematics.errors import FileError
from tests.support.rounded_four_bar import four_bar
from tests.support.sidecar_text import PAIR, bench, written
from tests.support.waiting import HANGS

MODEL = gallery()["four_bar_general"]
PARALLELOGRAM = gallery()["four_bar_antiparallelogram"]


class Once(io.BytesIO):
    """A stream that tells how often it was read to the end."""

    ends = 0

    def read(self, size=-1):
        found = super().read(size)
        self.ends += not super().read(1)
        return found


@pytest.fixture
def given(monkeypatch):
    """Put bytes on standard input; returns the stream."""

    def put(data):
        stream = Once(data)
        monkeypatch.setattr(sys, "stdin", type("Input", (), {"buffer": stream})())
        return stream

    return put


def answer(capsys, *words):
    """Exit code and JSON of a command, without what names its file."""
    code = main([*map(str, words), "--json"])
    report = json.loads(capsys.readouterr().out)
    for part in (report, report.get("against") or {}):
        part.pop("file", None)
    report.pop("next", None)
    report.pop("alternative", None)
    text = json.dumps({k: v for k, v in report.items() if k not in ("warnings", "source")})
    return code, text, [w["message"] for w in report.get("warnings", ())]


@pytest.mark.parametrize(
    "words",
    [
        ["report", "--explain"],
        ["design", "--minimise", "mass", "--keep", "crank"],
        ["verify", "--trajectories", "1"],
        ["motion", "--to", "u1=0.1"],
    ],
    ids=lambda words: words[0],
)
def test_every_verb_answers_as_for_the_file(words, given, capsys):
    stream = given(PARALLELOGRAM.read_bytes())
    code, text, told = answer(capsys, words[0], "-", *words[1:])
    assert stream.ends == 1
    assert (code, text, told) == answer(capsys, words[0], PARALLELOGRAM, *words[1:])


def test_both_readings_of_rounded_angles_take_one_reading_of_the_stream(
    given, tmp_path, capsys
):
    path = four_bar(tmp_path)
    stream = given(path.read_bytes())
    code, text, told = answer(capsys, "report", "-")
    assert stream.ends == 1
    other = answer(capsys, "report", path)
    assert (code, text) == other[:2]
    assert told == [message.replace(str(path), "<stdin>") for message in other[2]]
    assert "as written: loop 'q3': does not close" in told[0]


@pytest.mark.parametrize("way", ["argument", "module"])
def test_a_named_pipe(way, tmp_path, capsys):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(MODEL.read_bytes(),))
    writer.start()
    if way == "argument":
        code, text, _ = answer(capsys, "report", pipe)
        assert (code, text) == answer(capsys, "report", MODEL)[:2]
    else:
        linkage = kinematics.load(pipe)
        assert linkage.source == str(pipe) and linkage.mobility == 1
    writer.join(timeout=HANGS)
    assert not writer.is_alive()


@pytest.mark.slow
@pytest.mark.parametrize("word", ["-", "/dev/stdin"])
def test_a_process_is_given_a_pipe(word):
    done = subprocess.run(
        [sys.executable, "-m", "balance", "report", word],
        input=MODEL.read_bytes(),
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0 and b"8, complete at order 3" in done.stdout


def test_loops_are_in_the_file_that_is_named(given, tmp_path, capsys):
    path = written(tmp_path, bench(spins=[[0, 0, 1]]), PAIR)
    given(path.read_bytes())
    _, text, _ = answer(capsys, "report", "-", "--loops", tmp_path / "robot.yaml")
    assert text == answer(capsys, "report", path)[1]
    assert json.loads(text)["loops"] == 1


def test_no_file_is_looked_for_beside_a_pipe(tmp_path, capsys):
    path = written(tmp_path, bench(spins=[[0, 0, 1]]), PAIR)
    data = path.read_bytes()
    path.unlink()
    os.mkfifo(path)
    writer = threading.Thread(target=path.write_bytes, args=(data,))
    writer.start()
    assert kinematics.load(path).loops == ()
    writer.join(timeout=HANGS)


def test_files_are_written_from_what_was_read(given, tmp_path, capsys):
    out = tmp_path / "out.urdf"
    given(MODEL.read_bytes())
    assert main(["report", "-", "--write-closed", str(out)]) == 0
    assert out.read_bytes() == MODEL.read_bytes()
    given(PARALLELOGRAM.read_bytes())
    assert main(["design", "-", "--out", str(out)]) == 0
    designed = out.read_bytes()
    assert main(["design", str(PARALLELOGRAM), "--out", str(out)]) == 0
    assert designed == out.read_bytes() != PARALLELOGRAM.read_bytes()


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "empty file"),
        (b" " * (16 * 2**20 + 1), "larger than 16 MB"),
        (b"<robot", "not well-formed XML"),
        (b"<robot name='r'/>", "no <link>"),
    ],
    ids=["empty", "large", "cut", "bare"],
)
def test_what_is_no_linkage_is_refused_by_its_name(data, problem, given, capsys):
    given(data)
    assert main(["report", "-", "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and len(streams.err.splitlines()) == 1
    assert streams.err.startswith("balance: <stdin>: ") and problem in streams.err


def test_an_endless_stream_is_not_read_to_its_end():
    with open("/dev/zero", "rb") as endless:
        done = subprocess.run(
            [sys.executable, "-m", "balance", "report", "-"],
            stdin=endless,
            capture_output=True,
            text=True,
            timeout=HANGS,
            check=False,
        )
    assert done.returncode == 3 and "<stdin>: larger than 16 MB" in done.stderr


def test_no_standard_input(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(FileError, match="<stdin>: cannot be read .there is no standard input"):
        kinematics.load("-")


def test_one_stream_holds_one_model(given, tmp_path, capsys):
    stream = given(MODEL.read_bytes())
    assert main(["verify", "-", "--against", "-"]) == 2
    assert "--against: both models come from the same stream" in capsys.readouterr().err
    assert stream.ends == 0
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert main(["verify", str(pipe), "--against", str(pipe)]) == 2


def test_either_model_of_two_may_be_a_stream(given, capsys):
    words = ["--trajectories", "1"]
    expected = answer(capsys, "verify", MODEL, "--against", PARALLELOGRAM, *words)
    given(PARALLELOGRAM.read_bytes())
    assert answer(capsys, "verify", MODEL, "--against", "-", *words) == expected
    given(MODEL.read_bytes())
    assert answer(capsys, "verify", "-", "--against", PARALLELOGRAM, *words) == expected
