"""Every option of every command keeps the contract: exit codes, strict JSON, one line of error.

The options come from the parsers, so that a new one is tried as soon as it is there.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from fractions import Fraction
from itertools import chain

import numpy as np
import pytest

from balance.app.cli import (
    counterweights,
    design,
    discover,
    flex,
    formulas,
    identify,
    models,
    motion,
    new,
    paths,
    quiet,
    reduce,
    remedies,
    report,
    springs,
    sweep,
    synthesize,
    verify,
)
from balance.studies.runs.chunk_runs import run_chunks
from balance.support.json_text import json_text, plain_data
from kinematics import gallery
from tests.fuzz.good_words import GOOD, MASSES, POSITIONS, WITHOUT_MODEL, needed
from tests.fuzz.random_requests import asked, check, meant, run, strict, validator
from tests.fuzz.request_words import (
    WORDS,
    names_of,
    options,
    parsers,
)
from tests.fuzz.sweep_words import sweep_files
from tests.support.covering import ALL_CASES, number_of_cases
from tests.support.sidecar_text import PAIR

COMMANDS = {
    "new": new,
    "report": report,
    "design": design,
    "counterweights": counterweights,
    "reduce": reduce,
    "verify": verify,
    "identify": identify,
    "motion": motion,
    "remedies": remedies,
    "springs": springs,
    "paths": paths,
    "quiet": quiet,
    "synthesize": synthesize,
    "sweep": sweep,
    "discover": discover,
    "flex": flex,
    "formulas": formulas,
    "models": models,
}
MODELS = ("five_bar", "four_bar_kite_balanced", "hprs", "bennett")
# Models of options that few take: a crank that turns fully.
TAKERS = {
    (verb, "--speed"): "four_bar_kite_balanced"
    for verb in ("verify", "counterweights", "reduce", "sweep run")
}
CASES = [(verb, name) for verb, parser in parsers().items() for name in options(parser)]


def filled(words, model, folder):
    """Words with what they name in a model, whose motion is a table in a folder."""
    names = names_of(model)
    rows = [",".join(["time", *names.inputs])]
    rows += [
        ",".join([f"{0.01 * k:g}", *[f"{0.01 * k * k:g}"] * len(names.inputs)])
        for k in range(9)
    ]
    table, poses, loops, path = (
        folder / name for name in ("motion.csv", "poses.csv", "loops.yaml", "path.csv")
    )
    table.write_text("\n".join(rows), encoding="utf-8")
    poses.write_text("\n".join(row.partition(",")[2] for row in rows), encoding="utf-8")
    loads, torques = folder / "loads.csv", folder / "torques.csv"
    for file, heads in ((loads, ("fx", "fy", "fz", "mx", "my", "mz")), (torques, names.inputs)):
        lines = [",".join(["time", *heads])]
        lines += [
            ",".join(f"{x:.4f}" for x in (0.002 * k, *np.sin(k * np.arange(1, 9)[:size])))
            for k, size in ((k, len(heads)) for k in range(41))
        ]
        file.write_text("\n".join(lines), encoding="utf-8")
    dense, many = folder / "dense.csv", folder / "many.csv"
    time = 1e-3 * np.arange(401)
    swing = np.column_stack([time, *[0.2 * np.sin(20.0 * time)] * len(names.inputs)])
    for file, heads, columns in (
        (dense, ["time", *names.inputs], swing),
        (many, ["time", "fx", "mz"], np.column_stack([time, np.sin(900 * time), time % 0.1])),
    ):
        np.savetxt(file, columns, "%.5f", ",", header=",".join(heads), comments="")
    way = [f"{0.01 * k:g},{1e-4 * k * k:g}" for k in range(9)]
    path.write_text("\n".join(["time,x", *way]), encoding="utf-8")
    function = folder / "function.csv"
    function.write_text("crank,rocker\n0,0\n0.35,0.4\n0.8,1.0\n", encoding="utf-8")
    masses = folder / "masses.json"
    masses.write_text(json.dumps(MASSES), encoding="utf-8")
    loops.write_text(PAIR + "type: ['3d']\n", encoding="utf-8")
    files = sweep_files(words, folder)
    return [
        word.format(
            link=names.links[0],
            tool=names.links[-1],
            first=names.inputs[0],
            inputs=",".join(names.inputs),
            folder=folder,
            table=table,
            poses=poses,
            path=path,
            loops=loops,
            masses=masses,
            function=function,
            loads=loads,
            torques=torques,
            dense=dense,
            many=many,
            **files,
        )
        for word in words
    ]


def in_this_process(job, file, *, workers, **options):
    """A study without processes of its own; two options are about these."""
    return run_chunks(job, file, workers=0, **options)


@pytest.mark.table(3)
@pytest.mark.parametrize(("verb", "name"), CASES, ids=lambda word: word)
def test_every_option(verb, name, tmp_path, monkeypatch):
    """With what it wants, on a model that takes it; on two with ``ALL_CASES=1``."""
    if (verb, name) not in (("sweep run", "--workers"), ("sweep run", "--dask")):
        monkeypatch.setattr("balance.studies.runs.chunk_runs.run_chunks", in_this_process)
    if name == "--solids":
        pytest.importorskip("build123d")
    flag = options(parsers()[verb])[name].nargs == 0
    known = flag or (name in GOOD and name in WORDS)
    assert known or f"{verb} {name}" in GOOD, f"{name} has no words to be tried with"
    turn = CASES.index((verb, name)) % len(MODELS[1:])
    models = (
        ("",)
        if verb in WITHOUT_MODEL
        else (
            TAKERS.get((verb, name), MODELS[0]),
            MODELS[1:][turn],
        )
    )
    ends = set()
    for model in models:
        own = GOOD.get(f"{verb} {name}", GOOD.get(name, []))
        given = [name, *own, *needed(verb, [name, *own])]
        more = filled(given, model or MODELS[0], tmp_path)
        words = [*verb.split(), *filter(None, [model]), *more, *["--json"] * (name != "--json")]
        if verb == "verify" and name not in ("--trajectories", "--speed"):
            words += ["--trajectories", "1"]
        if verb == "paths" and name not in ("--length", "--through", "--change"):
            words += ["--length", "0.2"]
        if verb == "remedies" and name != "--only":
            words += ["--only", "own_masses"]
        done = asked(words)
        check(words, done)
        ends.add(done.code)
        if done.code in (0, 1, 4) and not ALL_CASES:
            break
    assert ends & {0, 1, 4} or name == "--loops", ends


@pytest.mark.table(3)
@pytest.mark.parametrize(
    "choice",
    [
        (verb, name, choice)
        for verb, name in CASES
        for choice in options(parsers()[verb])[name].choices or ()
    ],
    ids="-".join,
)
def test_every_choice(choice, tmp_path):
    verb, name, word = choice
    for model in MODELS[: 1 if verb in WITHOUT_MODEL else number_of_cases(1, 2)]:
        words = [*verb.split(), model, name, word, *needed(verb, [name]), "--json"]
        words = filled(words, model, tmp_path)
        if verb == "synthesize":
            # A stack meets two positions wherever it stands.
            pivot = [] if word == "stack" else ["--fixed", "0.2,-0.1"]
            words = [verb, *POSITIONS, *pivot, name, word, "--json"]
        words += ["--trajectories", "1"] * (verb == "verify")
        words += ["--only", "own_masses"] * (verb == "remedies")
        check(words, asked(words))


@pytest.mark.table(2)
@pytest.mark.parametrize("model", MODELS)
def test_kept_links_and_json(model):
    """What clashes with kept links has a certificate of its own, and JSON all the same."""
    for balance in ("dynamic", "force"):
        words = ["design", model, "--json", "--balance", balance]
        words += ["--keep", names_of(model).links[0]]
        assert check(words, asked(words)) in ("design: 0", "design: 1")


@pytest.mark.parametrize(
    "words",
    [["--inputs", "x\ny,"], ["--bounds", "x\ny"], ["x\ry", "z"], ["--motion=--"], ["--out=--"]],
)
def test_usage_is_told_in_two_lines(words):
    """Whatever is between the words: what is wrong, and where to look."""
    words = ["design", "five_bar", *words]
    assert check(words, asked(words)) == "design: 2"


@pytest.mark.slow
def test_random_requests():
    """A sample of ``python -m tests.fuzz.random_requests --cases 5000``."""
    ends, count = set(), number_of_cases(80, 150)
    for seed, words, end, wrong in run(range(500_000, 500_000 + count)):
        assert not wrong, f"seed {seed}: {words}: {wrong}"
        ends.add(end)
    assert {
        f"{verb}: {code}"
        for verb in ("report", "design", "verify", "motion")
        for code in (2, 3)
    } < ends
    assert len(ends) > 12


def test_the_check_of_requests_can_fail(capsys):
    """A wrong exit code, words beside the JSON, NaN, and a key too many are noticed."""
    words = ["design", "five_bar", "--json"]
    done = asked(words)
    found = strict(done.out)
    assert meant(words, found) == done.code == 1
    for wrong in (
        done._replace(code=0),
        done._replace(code=70),
        done._replace(out=done.out + "done\n"),
        done._replace(out=done.out.replace('"margin": 0.0', '"margin": NaN')),
        done._replace(out=done.out.replace('"keep"', '"kept"')),
        done._replace(err="x.py:3: RuntimeWarning: divide by zero\n"),
    ):
        assert wrong != done
        with pytest.raises((AssertionError, ValueError, Exception)):
            check(words, wrong)
    check(words, done)


@pytest.mark.table
@pytest.mark.parametrize(
    "error",
    [
        TypeError("no such\nthing"),
        MemoryError(),
        RecursionError("too deep"),
        KeyError("x"),
        ZeroDivisionError(),
        OSError(5, "broken"),
    ],
)
@pytest.mark.parametrize("verb", COMMANDS)
def test_what_nobody_foresaw_exits_with_70(verb, error, monkeypatch):
    """One line that names the error and the command, and nothing on standard output."""

    def broken(arguments):
        raise error

    first = {"flex": ["modes"], "sweep": ["show", "a.db"], "discover": ["show", "a.db"]}
    below = {
        "flex": (flex, "_modes"),
        "sweep": (sweep, "_show"),
        "discover": (discover, "_show"),
    }
    module, run_command = below.get(verb, (COMMANDS[verb], "_run"))
    monkeypatch.setattr(module, run_command, broken)
    model = ["five_bar"] * (verb not in WITHOUT_MODEL)
    words = [verb, *first.get(verb, model), "--json"]
    words += POSITIONS * (verb == "synthesize")
    words += needed(verb, []) if verb == "new" else []
    words += ["--links", "left_lower"] * (verb in ("counterweights", "reduce"))
    code, out, err = asked(words)
    assert (code, out) == (70, "")
    (line,) = err.splitlines()
    assert type(error).__name__ in line and f"balance {shlex.join(words)}" in line
    assert "please report it with the file" in line
    monkeypatch.setenv("BALANCE_DEBUG", "1")
    code, out, err = asked(words)
    assert (code, out, err.splitlines()[-1]) == (70, "", line) and "Traceback" in err


def test_what_fails_while_it_is_written_leaves_no_half(monkeypatch):
    monkeypatch.setattr(
        "balance.space.spaces.design_space.DesignSpace.to_dict",
        lambda *_: {"a": 1, "b": object()},
    )
    code, out, err = asked(["report", "five_bar", "--json"])
    assert (code, out, len(err.splitlines())) == (70, "", 1)


def test_an_interrupt_is_quiet(monkeypatch):
    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(COMMANDS["report"], "_run", interrupted)
    assert asked(["report", "five_bar"]) == (130, "", "")


def test_a_warning_of_a_library_is_one_line():
    """In a process of its own, where nothing turns warnings into errors."""
    code = (
        "import sys, numpy\n"
        "from balance.app.cli.main import main\n"
        "from balance.app.cli import models\n"
        "quiet = models._run\n"
        "def noisy(arguments):\n"
        "    numpy.array([1.0]) / numpy.array([0.0])\n"
        "    return quiet(arguments)\n"
        "models._run = noisy\n"
        "sys.exit(main(['models', '--json']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and json.loads(done.stdout)
    warning, *others = done.stderr.splitlines()
    assert warning == "RuntimeWarning: divide by zero encountered in divide"
    assert not any("Warning" in line for line in others)


def test_exit_codes_are_in_the_help():
    text = asked(["--help"]).out
    assert all(f"{code} " in text for code in (0, 1, 2, 3, 4, 70, 130))


def test_plain_data():
    data = {
        "a": np.arange(3),
        "b": np.float64(0.1),
        "c": np.bool_(True),
        "d": (1, (2.5, None)),
        "e": Fraction(1, 3),
        "f": np.array([[np.nan, np.inf]]),
        "g": np.int64(7),
        "h": -np.inf,
        "i": np.array(2.0),
        "j": np.str_("ä"),
        "k": True,
    }
    expected = {
        "a": [0, 1, 2],
        "b": 0.1,
        "c": True,
        "d": [1, [2.5, None]],
        "e": "1/3",
        "f": [[None, None]],
        "g": 7,
        "h": None,
        "i": 2.0,
        "j": "ä",
        "k": True,
    }
    assert plain_data(data) == expected and strict(json_text(data)) == expected
    assert json_text({"x": [0.1, "ä"]}) == json.dumps({"x": [0.1, "ä"]}, ensure_ascii=False)
    for wrong in ({1: 2}, {"a": {1, 2}}, [object()], 1j, np.array([1j])):
        with pytest.raises(TypeError):
            json_text(wrong)


def test_only_one_encoder():
    """Commands and pages write JSON by no other way."""
    balance = gallery()["five_bar"].parents[1] / "balance"
    groups = ("app", "masses", "motion", "support", "space/spaces", "space/interpretation")
    files = chain(*((balance / group).rglob("*.py") for group in groups))
    users = {path.name for path in files if "json.dump" in path.read_text(encoding="utf-8")}
    assert users == {"json_text.py", "save.py"}


def test_workers_have_one_rule():
    """Commands that go on with a file of results take one process per core, others this one."""
    with_workers = [known for known in map(options, parsers().values()) if "--workers" in known]
    assert len(with_workers) >= 3
    for known in with_workers:
        workers = known["--workers"]
        assert workers.type("0") == 0 and workers.type("1024") == 1024
        assert workers.default == (None if "--resume" in known else 0)
    assert len({known["--workers"].help.partition("(")[0] for known in with_workers}) == 1


@pytest.mark.slow
def test_schemas_are_valid():
    for verb in parsers():
        validator(verb).check_schema(validator(verb).schema)
