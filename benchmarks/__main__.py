"""Run the benchmarks: medians of interleaved batches, spreads, ratios, and the verdicts."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from time import perf_counter

for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402 - after the number of threads is fixed

HERE = Path(__file__).parent
HELPERS = {"__init__", "__main__", "against", "geometry"}


def main(argv: list[str] | None = None) -> int:
    """Run the benchmarks; the exit code is 1 if a claim does not hold."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", help="modules to run; all by default")
    parser.add_argument("--quick", action="store_true", help="few repetitions, to try it out")
    options = parser.parse_args(argv)
    print(_machine())
    modules = sorted(path.stem for path in HERE.glob("*.py") if path.stem not in HELPERS)
    held = True
    for name in options.names or modules:
        module = import_module(f"benchmarks.{name}")
        print(f"\n{module.__doc__.strip()}")
        for cls in vars(module).values():
            if isinstance(cls, type) and cls.__module__ == module.__name__:
                held &= _run(cls, 5 if options.quick else 31)
    return 0 if held else 1


def _machine() -> str:
    commit = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty"],
        capture_output=True, text=True, check=False,
    ).stdout.strip()  # fmt: skip
    return (
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, one BLAS thread, commit {commit or 'unknown'}"
    )


def _run(cls: type, repetitions: int) -> bool:
    """Run one class for all its parameters; whether all its claims hold."""
    held, rows = True, {}
    repetitions = min(repetitions, getattr(cls, "repetitions", repetitions))
    for params in cls.params:
        bench = cls()
        bench.setup(*params)
        label = " ".join(map(str, params))
        timed = [name for name in dir(cls) if name.startswith("time_")]
        claims = getattr(cls, "claims", ())
        wanted = {name for claim in claims for name in claim[:-1]} or set(timed)
        times = _times(bench, [name for name in timed if name in wanted], params, repetitions)
        for name, values in times.items():
            low, median, high = np.percentile(values, [10, 50, 90]) * 1e6
            print(f"  {label:<28} {name:<20} {median:9.1f} µs   ({low:.1f} … {high:.1f})")
        tracked = [name for name in dir(cls) if name.startswith("track_")]
        found = times | {name: np.array(getattr(bench, name)(*params)) for name in tracked}
        for name in tracked:
            if name not in wanted:
                print(f"  {label:<28} {name:<20} {found[name]:9.1e}")
        for claim in claims:
            held &= _holds(label, claim, found)
        if hasattr(bench, "row"):
            rows[label] = bench.row(*params)
    _print_table(rows, getattr(cls, "total", False))
    return held


def _holds(label: str, claim: tuple, found: dict[str, np.ndarray]) -> bool:
    """Whether a claim holds: of the ratio of two times, or of a time or tracked value."""
    *names, limit = claim
    if len(names) == 2:
        value = float(np.median(found[names[0]] / found[names[1]]))
        text = f"ratio {value:.2f}, at most {limit}"
    else:
        value = float(np.median(found[names[0]]))
        text = f"{names[0]} {value:.3g}, at most {limit}"
    print(f"  {label:<28} {text}: {'holds' if value <= limit else 'DOES NOT HOLD'}")
    return value <= limit


def _print_table(rows: dict[str, dict[str, int]], total: bool) -> None:
    """Print the rows that the parameters gave, under one head, and their sums if wanted."""
    if not rows:
        return
    head = list(next(iter(rows.values())))
    if total:
        sums = {name: sum(row[name] for row in rows.values()) for name in head}
        rows = {**rows, "total": sums}
    print("  " + " " * 28 + "".join(f"  {name:>5}" for name in head))
    for label, row in rows.items():
        cells = "".join(f"  {row[name]:>{max(5, len(name))}}" for name in head)
        print(f"  {label:<28}{cells}")


def _times(
    bench: object, names: list[str], params: tuple, repetitions: int
) -> dict[str, np.ndarray]:
    """Seconds per call of each method, in batches that take turns."""
    calls = {}
    for name in names:
        method = getattr(bench, name)
        method(*params)
        start = perf_counter()
        for _ in range(5):
            method(*params)
        calls[name] = max(1, int(0.01 / ((perf_counter() - start) / 5)))
    times: dict[str, list[float]] = {name: [] for name in names}
    for _ in range(repetitions):
        for name in names:
            method = getattr(bench, name)
            start = perf_counter()
            for _ in range(calls[name]):
                method(*params)
            times[name].append((perf_counter() - start) / calls[name])
    return {name: np.array(values) for name, values in times.items()}


if __name__ == "__main__":
    sys.exit(main())
