"""Benchmarks run, and what they track is right; their times are not judged here."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from benchmarks import __main__ as runner
from benchmarks import profiles
from benchmarks.harness import table
from tests.support.covering import ALL_CASES

ROOT = Path(__file__).parents[2]
# What is tracked of times.
OF_TIMES = ("exponent", "share")

# exudyn deprecates functions, also those that it calls itself.
OF_EXUDYN = pytest.mark.filterwarnings("ignore::DeprecationWarning")

RUN = ["--quick", "kernel_costs_less_than_a_qr"]


def claims() -> dict[str, float]:
    """The limit of every claim of every benchmark, by its name in a run."""
    found = [
        (f"{name}:{' '.join(map(str, params))}: {'/'.join(claim[:-1])}", claim[-1])
        for name in runner.CLAIMS
        for cls in runner.classes(name)
        for params in cls.params
        for claim in getattr(cls, "claims", ())
    ]
    assert not [name for name, count in Counter(name for name, _ in found).items() if count > 1]
    return dict(found)


@pytest.mark.bench
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=OF_EXUDYN) if name == "flexible_four_bar_is_quick" else name
        for name in runner.CLAIMS
    ],
)
def test_every_method_runs_for_its_first_parameters(name):
    """Those that take long run with ``ALL_CASES=1`` only."""
    left_out = []
    for cls in runner.classes(name):
        if getattr(cls, "slow", False) and not ALL_CASES:
            left_out.append(f"{cls.__name__} takes long")
            continue
        bench = cls()
        if hasattr(bench, "runs"):
            bench.runs = 1
        try:
            bench.setup(*cls.params[0])
        except NotImplementedError as error:
            left_out.append(str(error))
            continue
        methods = [m for m in dir(cls) if m.startswith(("time_", "track_"))]
        assert methods
        limit = {c[0]: c[1] for c in getattr(cls, "claims", ()) if len(c) == 2}
        for method in methods:
            tracked = getattr(bench, method)(*cls.params[0])
            timed = np.ndim(tracked) > 0 or any(word in method for word in OF_TIMES)
            if tracked is not None and not timed:
                assert tracked <= limit.get(method, 1e-12), method
    if left_out:
        pytest.skip("; ".join(left_out))


@pytest.mark.bench
def test_the_runner_prints_times_and_ratios(capsys):
    assert runner.main(RUN) in (0, 1)
    printed = capsys.readouterr().out
    assert "time_pivoted_qr" in printed and "kernels / pivoted_qr" in printed
    assert "one BLAS thread" in printed


def test_every_line_that_must_be_reached_is_answered_by_claims_of_one_limit():
    found = claims()
    for line in table.LINES:
        limits = {found.get(claim) for claim in line.claims}
        assert len(limits) == 1 and None not in limits, line.job
        assert line.aim <= limits.pop(), line.job


def test_a_lost_ratio_is_told_and_others_are_not(capsys):
    known = {"a": 1.0, "b": 0.5}
    assert runner._check_ratios(known, {"a": 1.29, "c": 7.0})
    assert not runner._check_ratios(known, {"a": 1.0, "b": 0.66})
    assert "LOST: b: 0.66, was 0.5" in capsys.readouterr().out
    assert not runner._check_ratios(known, {}), "nothing was compared"


class Stub:
    """Times and errors as they are given."""

    params = (("case",), ("missing",))
    claims = (("time_ours", "time_theirs", 2.0), ("track_error", 1e-9), ("track_peer", 1.0))

    def setup(self, name):
        if name == "missing":
            raise NotImplementedError("a library is missing")

    def time_ours(self, name):
        """Nothing."""

    def time_theirs(self, name):
        """Nothing."""

    def track_error(self, name):
        return 1e-12

    def track_peer(self, name):
        raise NotImplementedError("a peer is missing")

    def row(self, name):
        return {"name": name}


@pytest.fixture
def stub(monkeypatch, tmp_path):
    """A module with this benchmark, a line for it, and a baseline; the ratio is that given."""
    module = ModuleType("benchmarks.claims.stub", "Claim: nothing takes no time.")
    module.Stub = type("Stub", (Stub,), {"__module__": module.__name__})
    monkeypatch.setitem(sys.modules, module.__name__, module)
    line = table.Line("a job", "a peer", ("stub:case: time_ours/time_theirs",), 1.0)
    monkeypatch.setattr(table, "LINES", (line, line._replace(claims=("stub:case: other",))))
    monkeypatch.setattr(runner, "BASELINE", tmp_path / "baseline.json")
    runner.BASELINE.write_text(json.dumps({line.claims[0]: 1.0}))

    def at(*ratios):
        left = [{"time_ours": np.full(5, ratio), "time_theirs": np.ones(5)} for ratio in ratios]
        take = iter(left)
        monkeypatch.setattr(runner, "_time_methods", lambda *_: dict(next(take, left[-1])))

    return at


@pytest.mark.parametrize(("ratio", "held", "kept"), [(0.9, 0, 0), (1.9, 0, 1), (2.1, 1, 1)])
def test_a_run_fails_on_a_claim_and_a_check_on_a_loss(stub, capsys, ratio, held, kept):
    stub(ratio)
    assert runner.main(["stub"]) == held
    told = capsys.readouterr().out
    assert ("DOES NOT HOLD" in told) == bool(held)
    assert runner.main(["--check"]) == kept, "it runs what the baseline has"
    assert ("LOST: stub:case: time_ours/time_theirs" in capsys.readouterr().out) == bool(kept)
    assert runner.main(["--record", "stub"]) == held
    assert runner.main(["--check"]) == 0, "against what was recorded"


@pytest.mark.parametrize("second", [0.9, 1.8])
def test_what_was_slow_once_is_run_again(stub, capsys, second):
    stub(1.9, second)
    lost = second > 1.3
    assert runner.main(["--check"]) == lost
    assert ("time_ours/time_theirs: 1.8, was 1" in capsys.readouterr().out) == lost


def test_a_run_ends_with_the_lines_that_it_answers(stub, capsys):
    stub(0.9)
    runner.main(["--table"])
    *_, head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["against", "ours", "must", "aim", "verdict"]
    assert row.split() == "a job a peer 0.9 2 1 holds, and the aim".split()
    stub(3.0)
    runner.main(["--table", "--markdown"])
    *_, rule, row = capsys.readouterr().out.splitlines()
    assert rule == "|---" * 6 + "|" and row == "| a job | a peer | 3 | 2 | 1 | DOES NOT HOLD |"


def test_what_is_missing_is_left_out_in_one_line(stub, capsys):
    stub(0.9)
    assert runner.main(["stub"]) == 0
    told = [line.split() for line in capsys.readouterr().out.splitlines() if "left out" in line]
    assert told == [
        ["case", "track_peer", "left", "out:", "a", "peer", "is", "missing"],
        ["missing", "left", "out", "a", "library", "is", "missing"],
    ]


def test_a_profile_names_the_functions_that_take_most(capsys, monkeypatch):
    monkeypatch.setattr(profiles, "SECONDS", 0.01)
    assert profiles.main(["answer_costs_few_qr"]) == 0
    head, *listed = capsys.readouterr().out.splitlines()
    assert head == "answer_costs_few_qr: four_bar_general 4: time_design_space"
    shares = [float(line.split()[0]) for line in listed[: profiles.MAX_FUNCTIONS]]
    assert shares == sorted(shares, reverse=True) and 0.0 < sum(shares) <= 100.5
    assert any(re.search(r"(conditions|spaces|transfers)/\w+\.py:", line) for line in listed)


@pytest.mark.bench
def test_tables_in_markdown():
    """In a process of its own, as the documents have it."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--markdown", *RUN],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stdout.splitlines()
    assert "### kernel_costs_less_than_a_qr" in lines and "| case | what | value |" in lines
    assert {line.count("|") for line in lines if line.startswith("|")} == {4}


@pytest.mark.bench
def test_the_benchmark_of_proofs_finds_the_checker():
    """Also in a process whose path does not hold the tests, as those of benchmarks are."""
    code = (
        "from benchmarks.claims.proofs_are_quick import ProofsAreQuick as Proofs; "
        "run = Proofs(); run.setup('four_bar_general'); "
        "assert run.track_refused('four_bar_general') == 0"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
