"""Studies: what is refused and how, values by row, relations, chunks that are equal again."""

from __future__ import annotations

import pickle
import re
import tomllib
import warnings
from datetime import date
from pathlib import Path

import numpy as np
import pytest

import balance
from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.ranges import range_values, read_range
from balance.studies.sweeps.row_quantities import QUANTITIES
from balance.studies.sweeps.study import Study
from balance.support.expressions import ExpressionError, read_expression
from kinematics.errors import FileError, LinkageError, UsageError

PAGE = Path(__file__).resolve().parents[4] / "docs" / "sweeps.md"
X = {"q2.origin.x": "0.1:0.3:3"}
GENERAL = {"parameters": X}
# A value that TOML has and JSON has not.
DAY = date(2026, 1, 1)
BAD = {
    "unknown joint": ({"parameters": {"q9.origin.x": "0:1:3"}}, "q9.origin.x: names no joint"),
    "unknown number": ({"parameters": {"q2.size": "0:1:3"}}, "'q2' has the numbers origin.x"),
    "no length": ({"parameters": {"base.length": "1:2:2"}, "model": {"file": "four_rrr"}},
                  "link 'base' has 4 joints"),
    "negative length": ({"parameters": {"coupler.length": "-0.5:0.5:3"}},
                        "a length of -0.5 m is not positive; give lengths above 0"),
    "length of 0": ({"parameters": {"coupler.length": [0.1, 0.0]}},
                    "a length of 0 m is not positive"),
    "name of no file": ({"parameters": X, "model": {"file": "x" * 400}}, "File name too long"),
    "empty grid": ({"parameters": {"q2.origin.x": "0.1:0.3:0"}}, "is empty"),
    "empty list": ({"parameters": {"q2.origin.x": []}}, "the list is empty"),
    "empty interval": ({"parameters": {"q2.origin.x": {"uniform": [2, 1]}},
                        "sampling": {"count": 3}}, "is empty"),
    "NaN": ({"parameters": {"q2.origin.x": float("nan")}}, "nan is not finite"),
    "NaN in a grid": ({"parameters": {"q2.origin.x": "0:nan:3"}}, "nan is not finite"),
    "no range": ({"parameters": {"q2.origin.x": "0.1 to 0.3"}}, "is no grid"),
    "nothing varies": ({"parameters": {}}, "nothing varies"),
    "moves nothing": ({"parameters": X | {"free": "0:1:3"}}, "free: names no joint"),
    "mass of no use": ({"parameters": {"coupler.mass": [1.0, 2.0]}}, "changes masses"),
    "unused in effect": ({"parameters": {"free": "0:1:3"},
                          "relations": {"q2.origin.x": "0.1 + 0*free"}}, "moves nothing"),
    "circle": ({"parameters": X, "relations": {"q4.origin.x": "q4.origin.y",
                                               "q4.origin.y": "q4.origin.x"}},
               "relations go in a circle: "),
    "unknown name": ({"parameters": X, "relations": {"q4.origin.x": "2*zz"}},
                     "'zz' is neither"),
    "twice": ({"parameters": X, "relations": {"q2.origin.x": "1"}},
              "has a range in [parameters]"),
    "code": ({"parameters": X, "relations": {"q4.origin.x": "__import__('os').system('ls')"}},
             "is no arithmetic"),
    "quantity": ({"parameters": X, "compute": {"quantities": ["rnk"]}}, "no such quantity"),
    "option": ({"parameters": X, "compute": {"quantities": ["design"],
                                             "design": {"mimimise": "mass"}}},
               "no such option"),
    "link": ({"parameters": X, "compute": {"quantities": ["counterweights"],
                                           "counterweights": {"links": ["lid"]}}},
             "link 'lid'"),
    "motion": ({"parameters": X, "compute": {"quantities": ["shaking"]}}, "give either speed"),
    "constraint": ({"parameters": X, "constraints": {"grashoff": True}}, "no such constraint"),
    "no four-bar": ({"parameters": {"u2.origin.x": "0.8:0.9:2"}, "model": {"file": "five_bar"},
                     "constraints": {"grashof": True}}, "is no planar four-bar"),
    "target": ({"parameters": X, "constraints": {"reach": {"link": "coupler"}}}, "no meaning"),
    "too large": ({"parameters": X, "constraints": {"transmission": 10**400}}, "no meaning"),
    "samples": ({"parameters": {"q2.origin.x": {"normal": [0.1, 0.01]}}}, "but not how often"),
    "count alone": ({"parameters": X, "sampling": {"count": 5}}, "no parameter is sampled"),
    "table": ({"parameters": X, "paramters": {}}, "no such table"),
    "key": ({"parameters": X, "sampling": {"sede": 1}}, "no such key"),
    "column": ({"parameters": {"rank": "0.1:0.2:2"}, "relations": {"q2.origin.x": "rank"}},
               "is the name of a column"),
    "pose": (GENERAL | {"model": {"file": "four_bar_general", "at": "u1"}}, "at = 'u1' is no"),
    "day": (GENERAL | {"model": {"file": "four_bar_general", "at": {"u1": DAY}}},
            "is no table"),
    "bodies": (GENERAL | {"model": {"file": "four_bar_general", "bodies": DAY}}, "is no text"),
    "bounds": ({"parameters": X, "compute": {"quantities": ["design"],
                                             "design": {"bounds": "x"}}}, "bounds: 'x' has no"),
    "bound": ({"parameters": X, "compute": {"quantities": ["design"],
                                            "design": {"bounds": {"rocker": "x"}}}},
              "no meaning"),
    "aim": ({"parameters": X, "compute": {"quantities": ["design"],
                                          "design": {"minimise": ["mass"]}}}, "no meaning"),
    "kept": ({"parameters": X, "compute": {"quantities": ["design"],
                                           "design": {"keep": [DAY]}}}, "no meaning"),
    "region": ({"parameters": X, "compute": {
        "quantities": ["counterweights"],
        "counterweights": {"links": ["crank"], "regions": {"crank": {"x": 1}}}}}, "no meaning"),
    "large": ({"parameters": {"q2.origin.x": [10**400]}}, "is not finite"),
}  # fmt: skip


@pytest.mark.table
@pytest.mark.parametrize("case", BAD)
def test_bad_studies_are_refused_in_one_line(case: str):
    """What, where, and what to do."""
    tables, text = BAD[case]
    with pytest.raises(LinkageError) as caught:
        Study.from_tables({"model": {"file": "four_bar_general"}} | tables).job()
    message = str(caught.value)
    assert text in message and "\n" not in message and "; " in message
    assert message.startswith("study: [") and len(message) < 400


def test_too_many_geometries_need_a_word():
    grid = "0:1:1000000"
    tables = {
        "model": {"file": "four_bar_general"},
        "parameters": {"q2.origin.x": grid, "q2.origin.y": grid},
    }
    study = Study.from_tables(tables)
    with pytest.raises(UsageError, match=r"1e\+12 geometries .*--yes"):
        study.job()
    assert study.job(yes=True).rows == 10**12


@pytest.mark.lanes
def test_rows_far_away_are_computed_alone():
    """A chunk in the middle of a million million geometries."""
    grid = "0:1:1000000"
    tables = {
        "model": {"file": "four_bar_general"},
        "run": {"chunk_rows": 3},
        "parameters": {"q2.origin.x": grid, "q2.origin.y": grid},
    }
    study = Study.from_tables(tables)
    values = study.job(yes=True).compute(400_000_000)
    assert len(values["rank"]) == study.chunk_rows == 3


@pytest.mark.parametrize("text", ["[model", "[model]\nfile = 3\n", "\xff\xfe"])
def test_files_that_are_no_study(tmp_path: Path, text: str):
    file = tmp_path / "study.toml"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileError, match=r"study\.toml: "):
        balance.studies.read_study(file)
    with pytest.raises(FileError, match="no such file"):
        balance.studies.read_study(tmp_path / "none.toml")


@pytest.mark.lanes
def test_toml_paths_with_and_without_quotes(tmp_path: Path):
    rows = []
    for line in ('q2.origin.x = "0.1:0.3:3"', '"q2.origin.x" = "0.1:0.3:3"'):
        file = tmp_path / "study.toml"
        file.write_text(f'[model]\nfile = "four_bar_general"\n[parameters]\n{line}\n')
        rows.append(balance.studies.read_study(file).run()["q2.origin.x"].tolist())
    assert rows[0] == rows[1] == [0.1, 0.2, 0.3]


@pytest.mark.lanes
def test_the_page_says_what_happens():
    """Its study runs, and it names every quantity."""
    text = PAGE.read_text(encoding="utf-8")
    study = re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1]
    table = Study.from_tables(tomllib.loads(study)).run()
    assert len(table) == 200 and not table["q4.origin.x"].std() == 0.0
    assert np.allclose(table["q4.origin.x"], 1.0 + table["q2.origin.x"])
    for name in QUANTITIES:
        assert f"`{name}`" in text


@pytest.mark.slow
@pytest.mark.lanes
def test_values_of_a_row_follow_from_its_number():
    """Whatever rows are computed together; and a stream is that of its parameter alone."""
    ranges = {
        "a": read_range("0:1:3"),
        "b": read_range([5, 7]),
        "c": read_range({"uniform": [2, 3]}),
        "d": read_range({"normal": [1, 0.5]}),
        "e": read_range({"sobol": [0, 1]}),
        "f": read_range({"sobol": [-1, 1]}),
    }
    whole = range_values(ranges, 7, 3, 0, 42)
    for start, stop in ((0, 5), (5, 6), (6, 31), (31, 42)):
        part = range_values(ranges, 7, 3, start, stop)
        assert all(np.array_equal(part[name], whole[name][start:stop]) for name in ranges)
    alone = range_values({"c": ranges["c"]}, 42, 3, 0, 42)
    assert np.array_equal(alone["c"], whole["c"])
    other = range_values(ranges, 7, 4, 0, 42)
    assert not any(np.array_equal(other[name], whole[name]) for name in "cdef")
    assert whole["a"].tolist() == [0.0] * 14 + [0.5] * 14 + [1.0] * 14
    assert whole["b"].tolist() == ([5.0] * 7 + [7.0] * 7) * 3


@pytest.mark.slow
def test_samples_have_the_distribution_that_is_asked():
    ranges = {
        "u": read_range({"uniform": [2, 4]}),
        "n": read_range({"normal": [1, 0.5]}),
        "s": read_range({"sobol": [2, 4]}),
    }
    found = range_values(ranges, 2**14, 0, 0, 2**14)
    assert found["u"].min() >= 2.0 and found["u"].max() < 4.0
    assert found["u"].mean() == pytest.approx(3.0, abs=0.02)
    assert (found["n"].mean(), found["n"].std()) == pytest.approx((1.0, 0.5), abs=0.02)
    # Far more even than random numbers.
    counts, _ = np.histogram(found["s"], bins=64, range=(2.0, 4.0))
    assert np.ptp(counts) <= 2


@pytest.mark.parametrize(
    ("given", "parts"),
    [
        ("90%:110%:5", [0.9, 0.95, 1.0, 1.05, 1.1]),
        (["50 %", "112.5%"], [0.5, 1.125]),
        ({"uniform": ["90%", "110%"]}, [0.9, 1.1]),
    ],
)
def test_percentages_are_those_of_the_model(given, parts):
    """The rocker of the file has its joints at 0, 0 and -0.2, 0.7."""
    length = np.hypot(0.2, 0.7)
    tables = {"model": {"file": "four_bar_general"}, "parameters": {"rocker.length": given}}
    if isinstance(given, dict):
        tables["sampling"] = {"count": 2}
    numbers = Study.from_tables(tables).parameters["rocker.length"]
    if numbers.kind == "grid":
        values = np.linspace(*numbers.numbers[:2], int(numbers.numbers[2]))
    else:
        values = np.array(numbers.numbers)
    assert values == pytest.approx(length * np.array(parts), rel=1e-12)


def test_a_percentage_needs_a_value_in_the_model():
    tables = {"model": {"file": "four_bar_general"}, "parameters": {"a": "90%:110%:5"}}
    with pytest.raises(FileError, match=r"\[parameters\] a: names no joint, loop or link"):
        Study.from_tables(tables)


@pytest.mark.parametrize("grid", ["0.9:1.3:9", "0.1:0.4:31", "-0.3:0.3:7", "1e-3:5e-3:5"])
def test_grids_have_the_decimals_that_one_would_write(grid: str):
    first, last, count = grid.split(":")
    found = range_values({"a": read_range(grid)}, 1, 0, 0, int(count))["a"]
    assert (found[0], found[-1]) == (float(first), float(last))
    assert all(x == float(f"{x:.12g}") for x in found)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*a.x + b", 7.0),
        ("-a.x**2", -9.0),
        ("hypot(a.x, 4)", 5.0),
        ("min(a.x, b)/b", 1.0),
        ("sin(pi/2)*a.x", 3.0),
        ("1/(b-1)", np.inf),
        ("sqrt(-b)", np.nan),
        ("asin(b)*2", np.pi),
    ],
)
def test_expressions_are_arithmetic(text: str, value: float):
    found = read_expression(text)({"a.x": np.array([3.0]), "b": np.array([1.0])})
    assert found == pytest.approx(np.array([value]), nan_ok=True)


@pytest.mark.parametrize(
    "text",
    ["a if b else c", "[1, 2]", "a[0]", "lambda: 1", "open('x')", "a.b.__class__()", "f'{a}'",
     "a := 1", "1 < 2", "'x'", "True", "", "(" * 300, "+".join("a" * 2000), "sin(a, b)",
     "().__class__", "a @ b", "not a", "1j"],
)  # fmt: skip
def test_everything_else_is_no_expression(text: str):
    with pytest.raises(ExpressionError):
        read_expression(text)


@pytest.mark.slow
@pytest.mark.lanes
def test_a_chunk_is_the_same_again_and_in_other_processes():
    tables = {
        "model": {"file": "four_bar_general"},
        "sampling": {"count": 300, "seed": 5},
        "parameters": {
            "q2.origin.x": {"uniform": [0.05, 0.3]},
            "coupler.length": {"sobol": [0.6, 1.3]},
        },
        "run": {"chunk_rows": 100},
    }
    job = Study.from_tables(tables).job()
    sent = pickle.dumps(job)
    assert len(sent) < 20_000
    for other in (pickle.loads(sent), SweepJob.from_description(job.description)):
        assert other.digest == job.digest
        first, again = job.compute(1), other.compute(1)
        assert list(first) == [column.name for column in job.columns]
        for name, column in first.items():
            assert np.asarray(column).tobytes() == np.asarray(again[name]).tobytes(), name
    whole = Study.from_tables(tables).run()
    spread = Study.from_tables(tables).run(workers=2)
    for name in whole:
        texts = name in ("reason", "unsure")
        assert np.array_equal(whole[name], spread[name], equal_nan=not texts)
    with pytest.raises(ValueError, match="no chunk 3"):
        job.compute(3)


def test_the_digest_is_that_of_what_decides_the_results():
    tables = {"model": {"file": "four_bar_general"}, "parameters": X}
    digests = {
        Study.from_tables(tables | more).job().digest
        for more in (
            {},
            {"model": {"file": "four_bar_kite"}},
            {"compute": {"balance": "force"}},
            {"parameters": {"q2.origin.x": "0.1:0.3:4"}},
        )
    }
    assert len(digests) == 4


@pytest.mark.lanes
def test_one_parameter_moves_a_joint_and_everything_beyond_it():
    """Lengths, relations and origins are three ways to say the same."""
    by_length = balance.sweep("four_bar_general", {"crank.length": [0.4]})
    unit = np.array([0.1, 0.3]) / np.hypot(0.1, 0.3) * 0.4
    by_origin = balance.sweep(
        "four_bar_general",
        {"q2.origin.x": [unit[0]]},
        relations={"q2.origin.y": "3*q2.origin.x"},
    )
    by_name = balance.sweep(
        "four_bar_general",
        {"r": [0.4]},
        relations={"q2.origin.x": "r/sqrt(10)", "q2.origin.y": "3*r/sqrt(10)"},
    )
    kept = [table["kept_pivot"][0] for table in (by_length, by_origin, by_name)]
    assert kept == pytest.approx([kept[0]] * 3, rel=1e-9)
    assert by_name["q2.origin.x"][0] == pytest.approx(unit[0])


@pytest.mark.lanes
@pytest.mark.slow
def test_geometries_that_do_not_assemble_stay_with_their_reason():
    """By the triangle inequality: the longest link is longer than the three others."""
    table = balance.sweep("four_bar_general", {"coupler.length": "0.5:4.0:36"})
    others = np.hypot(0.1, 0.3) + np.hypot(0.2, 0.7) + 1.1
    fits = table["coupler.length"] < others
    assert np.array_equal(table["closed"] > 0, fits)
    assert set(table["reason"][~fits]) == {"its loops do not close"}
    assert dict(table.reasons) == {"its loops do not close": int((~fits).sum())}
    assert set(table["rank"][~fits]) == {-1} and set(table["rank"][fits]) == {8}
    here = balance.sweep(
        "four_bar_general", {"coupler.length": "0.5:4.0:36"}, constraints={"assembles": "here"}
    )
    assert here.reasons["its loops close only with the inputs elsewhere"] == np.sum(
        table["closed"] == 2
    )


@pytest.mark.slow
@pytest.mark.lanes
def test_reach_is_that_of_two_circles():
    """The tip of a crank reaches targets on its circle and no others."""
    table = balance.sweep(
        "four_bar_general",
        {"crank.length": "0.25:0.35:11"},
        constraints={
            "reach": {
                "link": "crank",
                "point": ["crank.length", 0, 0],
                "targets": [[0.3, 0.0, 0.0]],
            }
        },
    )
    fits = np.abs(table["crank.length"] - 0.3) < 1e-12
    assert np.array_equal(table["reason"] == "", fits) and fits.sum() == 1


@pytest.mark.lanes
def test_tables_are_read_only_and_short_to_print():
    table = balance.sweep("four_bar_general", X)
    assert len(table) == 3 and repr(table).startswith("SweepTable: 3 geometries")
    assert table.units["q2.origin.x"] == "m"
    with pytest.raises(ValueError, match="read-only"):
        table["rank"][0] = 1
    pandas = pytest.importorskip("pandas")
    assert isinstance(table.to_pandas(), pandas.DataFrame)


@pytest.mark.lanes
def test_masses_of_any_size_give_rows_without_a_warning(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        '[model]\nfile = "four_bar_general"\n[parameters]\n"rocker.mass" = [1.0, 1e300]\n'
        '[compute]\nquantities = ["distance", "design"]\n',
        encoding="utf-8",
    )
    study = balance.studies.read_study(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(study.job().compute(0)["distance"]) == 2
