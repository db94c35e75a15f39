"""Run the benchmarks: medians of interleaved batches, spreads, ratios, and the verdicts."""

from __future__ import annotations

import argparse
import json
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
HELPERS = {"__init__", "__main__", "against", "compiled", "geometry", "rows", "sampling"}
BASELINE = HERE / "baseline.json"
# A ratio that grew by more than this is a loss.
LOSS = 1.3


def main(argv: list[str] | None = None) -> int:
    """Run the benchmarks; the exit code is 1 if a claim does not hold, or a ratio grew."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", help="modules to run; all by default")
    parser.add_argument("--quick", action="store_true", help="few repetitions, to try it out")
    parser.add_argument("--markdown", action="store_true", help="print tables in Markdown")
    stored = parser.add_mutually_exclusive_group()
    stored.add_argument(
        "--check", action="store_true",
        help=f"compare ratios with {BASELINE.name} instead of with claims; run those in it",
    )  # fmt: skip
    stored.add_argument("--record", action="store_true", help=f"write them to {BASELINE.name}")
    options = parser.parse_args(argv)
    print(_machine())
    known = json.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.exists() else {}
    modules = sorted(path.stem for path in HERE.glob("*.py") if path.stem not in HELPERS)
    if options.check:
        modules = sorted({name.split(":")[0] for name in known})
    held, ratios = True, {}
    show = Markdown() if options.markdown else Text()
    for name in options.names or modules:
        module = import_module(f"benchmarks.{name}")
        show.claim(name, module.__doc__.strip())
        for cls in vars(module).values():
            if isinstance(cls, type) and cls.__module__ == module.__name__:
                held &= _run(cls, name, 5 if options.quick else 31, show, ratios)
        show.end()
    if options.record:
        text = json.dumps(dict(sorted((known | ratios).items())), indent=1) + "\n"
        BASELINE.write_text(text, encoding="utf-8")
    if options.check:
        held = _kept(known, ratios)
    return 0 if held else 1


def _kept(known: dict[str, float], ratios: dict[str, float]) -> bool:
    """Whether no ratio is much worse than the stored one; says which are."""
    lost = {
        name: ratio for name, ratio in ratios.items() if ratio > LOSS * known.get(name, ratio)
    }
    for name, ratio in lost.items():
        print(f"LOST: {name}: {ratio:.3g}, was {known[name]:.3g}")
    compared = len(ratios.keys() & known.keys())
    print(f"{compared} ratios compared with {BASELINE.name}, {len(lost)} lost more than 30 %")
    return not lost and compared > 0


def _machine() -> str:
    commit = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty"],
        capture_output=True, text=True, check=False,
    ).stdout.strip()  # fmt: skip
    return (
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, one BLAS thread, commit {commit or 'unknown'}"
    )


def _run(
    cls: type, module: str, repetitions: int, show: Text, ratios: dict[str, float]
) -> bool:
    """Run one class for all its parameters; whether all its claims hold."""
    held, rows = True, {}
    repetitions = min(repetitions, getattr(cls, "repetitions", repetitions))
    for params in cls.params:
        bench, label = cls(), " ".join(map(str, params))
        try:
            bench.setup(*params)
        except NotImplementedError as error:
            show.line(label, "left out", str(error))
            continue
        timed = [name for name in dir(cls) if name.startswith("time_")]
        claims = getattr(cls, "claims", ())
        wanted = {name for claim in claims for name in claim[:-1]} or set(timed)
        times = _times(bench, [name for name in timed if name in wanted], params, repetitions)
        for name, values in times.items():
            low, median, high = np.percentile(values, [10, 50, 90]) * 1e6
            show.line(label, name, f"{median:9.1f} µs   ({low:.1f} … {high:.1f})")
        tracked = [name for name in dir(cls) if name.startswith("track_")]
        found = times | {name: np.array(getattr(bench, name)(*params)) for name in tracked}
        for name in tracked:
            if name not in wanted:
                show.line(label, name, f"{found[name]:9.1e}")
        for claim in claims:
            held &= _holds(label, claim, found, show)
            if len(claim) == 3:
                ours, theirs = (found[name].min() for name in claim[:2])
                ratios[f"{module}:{label}: {claim[0]}/{claim[1]}"] = round(ours / theirs, 4)
        if hasattr(bench, "row"):
            rows[label] = bench.row(*params)
    show.table(rows, getattr(cls, "total", False))
    return held


def _holds(label: str, claim: tuple, found: dict[str, np.ndarray], show: Text) -> bool:
    """Whether a claim holds: of the ratio of two times, or of a time or tracked value."""
    *names, limit = claim
    if len(names) == 2:
        value = float(np.median(found[names[0]] / found[names[1]]))
        name = f"{_short(names[0])} / {_short(names[1])}"
    else:
        value, name = float(np.median(found[names[0]])), names[0]
    verdict = "holds" if value <= limit else "DOES NOT HOLD"
    show.line(label, name, f"{value:.3g}, at most {limit:.3g}: {verdict}")
    return value <= limit


def _short(name: str) -> str:
    return name.removeprefix("time_").removeprefix("track_")


class Text:
    """Lines as they come."""

    def claim(self, name: str, text: str) -> None:
        """What a module is about."""
        print(f"\n{text}")

    def line(self, label: str, name: str, value: str) -> None:
        """One figure, or one verdict."""
        print(f"  {label:<28} {name:<32} {value}", flush=True)

    def table(self, rows: dict[str, dict[str, object]], total: bool) -> None:
        """The rows that the parameters gave, under one head, and their sums if wanted."""
        if not rows:
            return
        head = list(next(iter(rows.values())))
        if total:
            sums = {name: sum(row[name] for row in rows.values()) for name in head}
            rows = {**rows, "total": sums}
        self.cells("", head, head)
        for label, row in rows.items():
            self.cells(label, [str(row[name]) for name in head], head)

    def cells(self, label: str, cells: list[str], head: list[str]) -> None:
        """One row of a table."""
        wide = (
            f"  {cell:>{max(5, len(name))}}" for cell, name in zip(cells, head, strict=True)
        )
        print(f"  {label:<28}{''.join(wide)}")

    def end(self) -> None:
        """After a module."""


class Markdown(Text):
    """Tables in Markdown."""

    def __init__(self) -> None:
        """No table yet."""
        self._open = False

    def claim(self, name: str, text: str) -> None:
        """A heading, and the claim."""
        print(f"\n### {name}\n\n{text}\n")

    def line(self, label: str, name: str, value: str) -> None:
        """One row of the table of times and verdicts."""
        if not self._open:
            print("| case | what | value |\n|---|---|---|")
            self._open = True
        print(f"| {label} | {name.removeprefix('time_')} | {value.strip()} |", flush=True)

    def cells(self, label: str, cells: list[str], head: list[str]) -> None:
        """One row of a table, the first with a rule below it."""
        if cells is head:
            self._open = False
            print()
        print(f"| {label} | {' | '.join(cells)} |")
        if cells is head:
            print("|---" * (len(head) + 1) + "|")

    def end(self) -> None:
        """The next table has a head of its own."""
        self._open = False


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
