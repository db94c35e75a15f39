"""The command line keeps its contract: keys, exit codes, and what goes to which stream."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import balance
import kinematics
from balance.app.answers.data import Report, report_data
from balance.app.cli.main import main
from balance.space.certification import replaced_numbers
from balance.space.spaces import compute_space
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from kinematics import gallery
from tests.support.covering import spread
from tests.support.figures import FIGURES, Figure
from tests.support.laws import known

# Lists of files that are opened, while a test looks.
OPENED: list[list[str]] = []
sys.addaudithook(
    lambda event, arguments: (
        OPENED[-1].append(str(arguments[0])) if event == "open" and OPENED else None
    )
)

KEYS = (
    "schema verdict sentence next alternative model at algebra balance bodies parameters "
    "joints loops mobility inputs idle motion orders poses kmax rank nullity serial parallel "
    "certainty evidence requirements gravity readings exact transfers freedoms decoupled "
    "pure_inertia margin singular_values basis as_given warnings"
).split()


def words(figure: Figure) -> list[str]:
    """The command that asks for one row of the table."""
    motion = [word for relation in figure.motion for word in ("--motion", relation)]
    spatial = ["--spatial"] if figure.spatial else []
    return ["report", figure.model, "--balance", figure.balance, *motion, *spatial, "--json"]


def data_of(space):
    """What the command prints of a space without further options."""
    return report_data(Report(space, change=distance_to_rank_drop(space)))


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """One command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "balance", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.table
@pytest.mark.parametrize("model", spread(list(kinematics.gallery()), 3))
def test_a_report_reads_its_file_once_and_computes_its_space_once(model, monkeypatch, capsys):
    """Opened files are counted by the system, spaces by the geometry they belong to."""
    path = str(kinematics.gallery()[model])
    opened, computed = [], []
    original = compute_space.design_space

    def counting(linkage, *arguments, **options):
        computed.append(b"".join(joint.screw.tobytes() for joint in linkage.joints))
        return original(linkage, *arguments, **options)

    monkeypatch.setattr(compute_space, "design_space", counting)
    monkeypatch.setattr(replaced_numbers, "design_space", counting)
    OPENED.append(opened)
    try:
        assert main(["report", model, "--json"]) == 0
    finally:
        OPENED.pop()
    assert json.loads(capsys.readouterr().out)["model"]
    assert opened.count(path) == 1 and len(computed) == len(set(computed)) >= 1


@pytest.mark.table(3)
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_every_figure_comes_out_of_the_command(figure, capsys):
    assert main(words(figure)) == 0
    report = json.loads(capsys.readouterr().out)
    assert list(report) == KEYS
    assert report == data_of(known(figure)) | {
        key: report[key] for key in ("next", "alternative")
    }
    assert report["schema"] == "balance.report/1"
    assert report["model"] == figure.model
    assert report["parameters"] == figure.parameters
    assert [order["rank"] for order in report["orders"]] == list(figure.ranks)
    assert [order["order"] for order in report["orders"]] == list(range(len(figure.ranks)))
    assert all(o["rank"] + o["nullity"] == figure.parameters for o in report["orders"])
    assert (report["kmax"], report["rank"]) == (figure.kmax, figure.ranks[-1])
    assert report["nullity"] == figure.nullity
    assert (report["serial"], report["parallel"]) == (figure.serial, figure.parallel)
    assert report["transfers"] is report["freedoms"] is None
    assert report["margin"]["kept"] > figure.kept > 1e-12 > report["margin"]["dropped"]
    assert report["motion"] == list(figure.motion)


def test_facts_of_the_spatial_mechanism(capsys):
    assert main(["report", "three_rsr", "--motion", "u2=u3", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["algebra"] == "spatial"
    assert (report["joints"], report["loops"], report["mobility"]) == (15, 2, 3)
    assert report["inputs"] == ["u1", "u2", "u3"]
    assert len(report["idle"]) == 2
    assert report["as_given"]["balanced"] is True
    assert [warning["code"] for warning in report["warnings"]] == ["massless"]


def test_plain_text_when_the_output_is_no_terminal(capsys):
    assert main(["report", "four_bar_kite"]) == 0
    out = capsys.readouterr().out
    assert "5 of 12 dimensions" in out
    assert out.splitlines()[-3:] == [
        "       0       3       9",
        "       1       6       6",
        "       2       7       5",
    ]


def test_a_table_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    assert main(["report", "four_bar_kite"]) == 0
    out = capsys.readouterr().out
    assert "nullity" in out and "┃" in out and out.startswith("Can it balance? ")


def test_max_order_computes_exactly_those_orders(capsys):
    for last, ranks in ((0, [3]), (1, [3, 6]), (5, [3, 6, 7, 8, 8, 8])):
        assert main(["report", "four_bar_general", "--max-order", str(last), "--json"]) == 0
        report = json.loads(capsys.readouterr().out)
        assert [order["rank"] for order in report["orders"]] == ranks
        codes = [warning["code"] for warning in report["warnings"]]
        assert codes == (["not_settled"] if last < 3 else [])


def test_inputs_of_the_user(capsys):
    assert main(["report", "four_bar_general", "--inputs", "q4", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["inputs"] == ["q4"]
    assert report["rank"] == 8


def test_models_are_listed_with_a_line_each(capsys):
    assert main(["models"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(gallery())
    assert all(len(line.split()) >= 3 for line in lines)
    assert main(["models", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)["models"]) == set(gallery())


@pytest.mark.parametrize(
    "arguments",
    [
        ["report"],
        ["nonsense"],
        ["report", "four_bar_kite", "--balance", "static"],
        ["report", "four_bar_kite", "--max-order", "-1"],
        ["report", "four_bar_kite", "--max-order", "two"],
        ["report", "four_bar_kite", "--inputs", "u1,,q2"],
        ["report", "four_bar_kite", "--colour"],
    ],
)
def test_usage_errors_exit_with_2(arguments, capsys):
    assert main(arguments) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    wrong, where = streams.err.splitlines()
    assert ": error: " in wrong and where.endswith(" --help lists what there is")


def opened(text: str) -> str:
    """The kite with a rocker too long by 5 m, which nothing closes."""
    head, loop = text.split("<loop", 1)
    start = loop.index('xyz="') + 5
    x, _, rest = loop[start:].partition(" ")
    return f"{head}<loop{loop[:start]}{float(x) + 5.0!r} {rest}"


def replaced(old: str, new: str):
    """A change of the first occurrence of a text."""
    return lambda text: text.replace(old, new, 1)


BAD = {
    "missing": (None, ["no such file"]),
    "not_xml": (lambda text: "links and joints", ["not well-formed", "line 1"]),
    "not_urdf": (lambda text: "<svg><path/></svg>", ["svg", "robot"]),
    "doctype": (replaced("<!--", '<!DOCTYPE robot [<!ENTITY a "b">]><!--'), ["DOCTYPE"]),
    "truncated": (lambda text: text[: len(text) // 2], ["line"]),
    "nan": (replaced('mass value="', 'mass value="nan'), ["mass", "nan"]),
    "zero_axis": (replaced('axis xyz="0 0 1"', 'axis xyz="0 0 0"'), ["axis"]),
    "duplicate": (replaced('"rocker"', '"crank"'), ["crank"]),
    "two_parents": (replaced('child link="rocker"', 'child link="coupler"'), ["coupler"]),
    "unknown_link": (replaced('successor link="rocker"', 'successor link="ghost"'), ["ghost"]),
    "open_loop": (opened, ["does not close", "5 m", "q3"]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_get_one_clear_line(case, tmp_path, capsys):
    change, fragments = BAD[case]
    path = tmp_path / f"{case}.urdf"
    if change is not None:
        original = gallery()["four_bar_kite"].read_text(encoding="utf-8")
        changed = change(original)
        assert changed != original
        path.write_text(changed, encoding="utf-8")
    assert main(["report", str(path), "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == ""
    assert len(streams.err.splitlines()) == 1
    assert str(path) in streams.err
    for fragment in fragments:
        assert fragment in streams.err


@pytest.mark.parametrize(
    ("arguments", "fragments"),
    [
        (["--motion", "q2=0"], ["'q2' is not an input", "u1"]),
        (["--motion", "u1=0"], ["leaves no input to move"]),
        (["--motion", "u1"], ["="]),
        (["--inputs", "u1,q2"], ["q2", "depends"]),
        (["--inputs", "u9"], ["u9", "no such joint", "u1"]),
    ],
)
def test_bad_requests_get_one_clear_line(arguments, fragments, capsys):
    assert main(["report", "four_bar_kite", *arguments, "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == ""
    assert len(streams.err.splitlines()) == 1
    for fragment in fragments:
        assert fragment in streams.err


def test_what_the_guard_refuses_loads_nothing_heavy(tmp_path):
    path = tmp_path / "bad.urdf"
    path.write_text('<?xml version="1.0"?><!DOCTYPE robot><robot name="r"/>', encoding="utf-8")
    code = (
        "import sys; from balance.app.cli.main import main; code = main(sys.argv[1:]); "
        "print([m for m in ('numpy', 'numba', 'yourdfpy', 'rich') if m in sys.modules]); "
        "sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "report", str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (3, "[]\n")


@pytest.mark.parametrize(
    "words", [["--help"], ["report", "--help"], ["--version"], ["models"], ["no-such"]], ids=str
)
def test_words_alone_load_nothing_heavy(words):
    """What is answered from the words of the command, or from the heads of files."""
    code = (
        "import sys; from balance.app.cli.main import main; code = main(sys.argv[1:]); "
        "heavy = {'numpy', 'numba', 'scipy', 'rich', 'yaml', 'yourdfpy'}; "
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr); sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == (2 if words == ["no-such"] else 0)
    assert done.stderr.splitlines()[-1] == "[]"


def test_the_version_is_that_of_the_package():
    done = run("--version")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"balance {balance.__version__}\n"
    assert balance.__version__ == kinematics.__version__ == version("screwbalance")


def test_the_module_runs_as_a_command():
    done = run("report", str(Path("no") / "such.urdf"))
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.startswith("balance: ") and len(done.stderr.splitlines()) == 1


def test_plain_serial_robots_work_too(capsys):
    assert main(["report", "hprs", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["loops"], report["mobility"]) == (0, 6)


BARE = (
    '<robot name="bare"><link name="base"/><link name="arm"/>'
    '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)


def test_a_file_without_masses(tmp_path, capsys):
    """A report needs none, and does not call them balanced; simulation needs them."""
    path = tmp_path / "bare.urdf"
    path.write_text(BARE)
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["bodies"] == ["arm"]
    assert report["as_given"] == {"balanced": None, "residual": None}
    assert [warning["code"] for warning in report["warnings"]] == ["no_masses"]
    assert main(["report", str(path)]) == 0
    assert "as given      no masses" in capsys.readouterr().out
    assert main(["verify", str(path), "--json"]) == 3
    said = capsys.readouterr()
    assert said.out == "" and "no moving link has a mass; give the links" in said.err


def test_impossible_inertias_are_remarked_once(tmp_path, capsys):
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="5"/></inertial>'
    path = tmp_path / "bare.urdf"
    path.write_text(BARE.replace('<link name="arm"/>', f'<link name="arm">{inertial}</link>'))
    assert main(["report", str(path), "--json"]) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert [warning["code"] for warning in warnings] == ["unphysical"]
