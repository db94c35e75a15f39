"""Both readings of rounded angles in the report, and the errors of either."""

import json
import math
from importlib.resources import files

import pytest
from jsonschema import Draft202012Validator

import kinematics
from balance.app.cli.main import main
from kinematics.errors import OpenLoopError
from tests.support.chains import jointed, robot, written
from tests.support.rounded_four_bar import four_bar

RIGHT = "1.5707963267948966"


@pytest.mark.parametrize("options", [[], ["--nominal"]])
def test_a_rounded_four_bar_is_the_one_that_is_meant(options, tmp_path, capsys, caplog):
    path = str(four_bar(tmp_path))
    assert main(["report", path, "--json", *options]) == 0
    report = json.loads(capsys.readouterr().out)
    described = files("balance").joinpath("app", "schemas", "report.schema.json")
    schema = json.loads(described.read_text("utf-8"))
    Draft202012Validator(schema).validate(report)
    assert (report["algebra"], report["rank"], report["nullity"]) == ("planar", 8, 4)
    assert report["certainty"] == "proved"
    (warning,) = report["warnings"]
    assert f"rounded_angles: {warning['message']}" in caplog.messages
    message = warning["message"]
    assert warning["code"] == "rounded_angles"
    assert f"{path}: 4 angles look rounded, read as multiples of π/12, the default" in message
    assert "nominal: rank 8 of 12 planar parameters, nullity 4, mobility 1" in message
    assert "; as written: loop 'q3': does not close: " in message
    # 0.7 m and 0.3 m, tilted by 3.7e-6 rad, end 1.5e-6 m apart.
    assert "1.47e-06 m" in message


def test_a_rounded_four_bar_as_written_does_not_close(tmp_path, capsys):
    path = str(four_bar(tmp_path))
    assert main(["report", path, "--as-written"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and len(streams.err.splitlines()) == 1
    assert streams.err.startswith(f"balance: {path}: loop 'q3': does not close: ")
    assert "1.47e-06 m" in streams.err
    assert "; 4 angles look rounded, taken as written: 1.5708 in rpy of joint" in streams.err
    assert streams.err.endswith(
        "; nominal: rank 8 of 12 planar parameters, nullity 4, mobility 1, not balanced as "
        "given\n"
    )
    with pytest.raises(OpenLoopError) as caught:
        kinematics.load(path, angles="as_written")
    assert caught.value.distance == pytest.approx(0.4 * abs(math.cos(1.5708)), rel=1e-6)
    (note,) = caught.value.__notes__
    assert note.startswith("4 angles look rounded, taken as written: ")


def test_with_all_digits_both_readings_are_one(tmp_path, capsys):
    path = str(four_bar(tmp_path, RIGHT))
    for options in ([], ["--as-written"]):
        assert main(["report", path, "--json", *options]) == 0
        report = json.loads(capsys.readouterr().out)
        assert (report["rank"], report["warnings"]) == (8, [])


def test_a_file_that_is_open_either_way_says_so_in_one_line(tmp_path, capsys):
    path = four_bar(tmp_path)
    text = path.read_text(encoding="utf-8").replace("-0.2 0 -0.7", "4.8 0 -0.7")
    path.write_text(text, encoding="utf-8")
    assert main(["report", str(path)]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line.count("loop 'q3': does not close: its frames are 5 m") == 2
    assert "read as multiples of π/12, the default" in line and "; as written: " in line


def test_mistakes_of_the_user_are_not_blamed_on_angles(tmp_path, capsys):
    assert main(["report", str(four_bar(tmp_path)), "--inputs", "u9"]) == 3
    assert "angle" not in capsys.readouterr().err


def test_readings_exclude_each_other(capsys):
    assert main(["report", "four_bar_general", "--nominal", "--as-written"]) == 2
    assert "not allowed with" in capsys.readouterr().err


def test_a_planar_chain_is_spatial_as_written(tmp_path, capsys):
    """Both answers are given, the one that was asked for first."""
    parts = jointed(1, "1.5708 0 0"), jointed(2, "-1.5708 0 0", axis="0 -1 0")
    path = str(written(tmp_path, robot(*parts)))
    reports = []
    for options in ([], ["--as-written"]):
        assert main(["report", path, "--json", *options]) == 0
        reports.append(json.loads(capsys.readouterr().out))
    meant, literal = reports
    assert [(r["algebra"], r["rank"]) for r in reports] == [("planar", 6), ("spatial", 12)]
    answers = (
        "nominal: rank 6 of 8 planar parameters, nullity 2, mobility 2, not balanced as given",
        "as written: rank 12 of 20 spatial parameters, nullity 8, mobility 2, not balanced as "
        "given",
    )
    assert [w["code"] for w in meant["warnings"]] == ["rounded_angles"]
    assert meant["warnings"][0]["message"].endswith("; ".join(answers))
    # Floating point does not see one of the eight transfers past axes that are 4e-6 apart.
    codes = ["rounded_angles", "nearly_planar", "corrected"]
    assert [w["code"] for w in literal["warnings"]] == codes
    assert (literal["serial"], literal["certainty"]) == (8, "proved")
    assert literal["warnings"][0]["message"].endswith("; ".join(reversed(answers)))


def test_angles_that_change_nothing_are_said_to(tmp_path, capsys):
    """A serial spatial chain has the same conditions at any angles between its axes."""
    path = str(written(tmp_path, robot(*(jointed(i, "1.5708 0 0.3") for i in (1, 2)))))
    assert main(["report", path, "--json"]) == 0
    (warning,) = json.loads(capsys.readouterr().out)["warnings"]
    assert "; either way: rank 12 of 20 spatial parameters" in warning["message"]
    assert "as written:" not in warning["message"]
