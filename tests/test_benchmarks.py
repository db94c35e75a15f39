"""Benchmarks run, and what they track is right; their times are not judged here."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from benchmarks.__main__ import HELPERS, _kept

ROOT = Path(__file__).parents[1]
MODULES = sorted(p.stem for p in (ROOT / "benchmarks").glob("*.py") if p.stem not in HELPERS)


def classes(name: str) -> list[type]:
    """The benchmark classes of a module."""
    module = import_module(f"benchmarks.{name}")
    found = [c for c in vars(module).values() if isinstance(c, type)]
    return [c for c in found if c.__module__ == module.__name__]


@pytest.mark.parametrize("name", MODULES)
def test_every_method_runs_for_its_first_parameters(name):
    for cls in classes(name):
        bench = cls()
        try:
            bench.setup(*cls.params[0])
        except NotImplementedError as error:
            pytest.skip(str(error))
        methods = [m for m in dir(cls) if m.startswith(("time_", "track_"))]
        assert methods
        for method in methods:
            tracked = getattr(bench, method)(*cls.params[0])
            if "exponent" in method or "excess" in method:
                continue  # figures of times
            limit = {claim[0]: claim[1] for claim in getattr(cls, "claims", ())}
            assert tracked is None or tracked <= limit.get(method, 1e-12)


def test_the_runner_prints_times_and_ratios():
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--quick", "kernel_costs_half_a_qr"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    assert "time_pivoted_qr" in done.stdout and "kernels / pivoted_qr" in done.stdout
    assert "one BLAS thread" in done.stdout


def test_a_lost_ratio_is_told_and_others_are_not(capsys):
    known = {"a": 1.0, "b": 0.5}
    assert _kept(known, {"a": 1.29, "c": 7.0})
    assert not _kept(known, {"a": 1.0, "b": 0.66})
    assert "LOST: b: 0.66, was 0.5" in capsys.readouterr().out
    assert not _kept(known, {}), "nothing was compared"


def test_tables_in_markdown():
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--quick", "--markdown", "kernel_costs_half_a_qr"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert "### kernel_costs_half_a_qr" in lines and "| case | what | value |" in lines
    assert {line.count("|") for line in lines if line.startswith("|")} == {4}
