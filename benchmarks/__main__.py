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
HELPERS = {"__init__", "__main__", "geometry"}


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
    held = True
    for params in cls.params:
        bench = cls()
        bench.setup(*params)
        label = " ".join(map(str, params))
        timed = [name for name in dir(cls) if name.startswith("time_")]
        claims = getattr(cls, "claims", ())
        wanted = {name for claim in claims for name in claim[:2]} or set(timed)
        times = _times(bench, [name for name in timed if name in wanted], params, repetitions)
        for name, values in times.items():
            low, median, high = np.percentile(values, [10, 50, 90]) * 1e6
            print(f"  {label:<28} {name:<20} {median:9.1f} µs   ({low:.1f} … {high:.1f})")
        for name in (n for n in dir(cls) if n.startswith("track_")):
            print(f"  {label:<28} {name:<20} {getattr(bench, name)(*params):9.1e}")
        for ours, theirs, limit in claims:
            ratio = float(np.median(times[ours] / times[theirs]))
            verdict = "holds" if ratio <= limit else "DOES NOT HOLD"
            print(f"  {label:<28} ratio {ratio:.2f}, at most {limit}: {verdict}")
            held &= ratio <= limit
    return held


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
