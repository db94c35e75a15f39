"""Benchmarks run, and what they track is right; their times are not judged here."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HELPERS = {"__init__", "__main__", "against", "geometry"}
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
        bench.setup(*cls.params[0])
        methods = [m for m in dir(cls) if m.startswith(("time_", "track_"))]
        assert methods
        for method in methods:
            tracked = getattr(bench, method)(*cls.params[0])
            assert tracked is None or tracked < 1e-12


def test_the_runner_prints_times_and_ratios():
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--quick", "kernel_costs_half_a_qr"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    assert "time_pivoted_qr" in done.stdout and "ratio" in done.stdout
    assert "one BLAS thread" in done.stdout
