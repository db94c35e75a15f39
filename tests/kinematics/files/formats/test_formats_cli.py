"""Commands on SDF and xacro files: reports, designs and closed poses, which are URDF."""

import json

import pytest

from balance.app.cli.main import main
from kinematics import gallery, load
from tests.support.sdf_text import sdf_of

MODEL = "four_bar_antiparallelogram"
XACRO = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '


@pytest.fixture(params=["sdf", "urdf.xacro"])
def model(request, tmp_path):
    """The same linkage in another format."""
    path = tmp_path / f"robot.{request.param}"
    text = gallery()[MODEL].read_text(encoding="utf-8")
    if request.param == "sdf":
        text = sdf_of(gallery()[MODEL], "world")
    else:
        mass = '<xacro:property name="zero" value="0"/>'
        head, _, rest = text.partition("<robot ")
        inside, end, rest = rest.partition(">")
        text = head + XACRO + inside + end + mass + rest.replace('xyz="0 ', 'xyz="${zero} ')
    path.write_text(text, encoding="utf-8")
    return path


def test_reports_agree(model, capsys):
    answers = []
    for file in (MODEL, model):
        assert main(["report", str(file), "--inputs", "u1", "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    for key in ("rank", "nullity", "mobility", "orders"):
        if key in answers[0]:
            assert answers[0][key] == answers[1][key], key
    assert set(answers[0]["bodies"]) == set(answers[1]["bodies"])


@pytest.mark.slow
def test_designs_are_written_as_urdf(model, caplog):
    out = model.with_name("out.urdf")
    words = ["design", str(model), "--inputs", "u1", "--minimise", "mass", "--out", str(out)]
    assert main([*words, "--bounds", "coupler=0.5:2"]) == 0
    assert "<robot" in out.read_text(encoding="utf-8") and "<sdf" not in out.read_text()
    assert load(out).mobility == 1
    (command,) = [r.getMessage() for r in caplog.records if "balance verify" in r.getMessage()]
    assert command.endswith(f"{out} --inputs u1")
    assert main(["verify", str(out), "--inputs", "u1"]) == 0


def test_closed_poses_are_written_as_urdf(model, capsys):
    out = model.with_name("closed.urdf")
    assert main(["report", str(model), "--write-closed", str(out)]) == 0
    assert load(out).mobility == 1 and "<loop" in out.read_text(encoding="utf-8")


def test_an_invalid_file_is_one_line(model, capsys):
    text = model.read_text(encoding="utf-8").replace('type="', 'type="x', 1)
    model.write_text(text, encoding="utf-8")
    assert main(["report", str(model), "--json"]) == 3
    told = capsys.readouterr()
    assert not told.out and len(told.err.splitlines()) == 1 and str(model) in told.err


@pytest.mark.parametrize("name", ["missing.sdf", "missing.xacro", "missing.world"])
def test_names_with_these_ends_are_paths(name, capsys):
    assert main(["report", name]) == 3
    assert "no such file; check the path" in capsys.readouterr().err
