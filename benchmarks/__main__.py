"""Run the benchmarks and print medians of interleaved batches, spreads, ratios and verdicts."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from time import perf_counter, process_time

for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402 - after the number of threads is fixed

from benchmarks.harness import table  # noqa: E402
from benchmarks.harness.show import Markdown, Text, seconds  # noqa: E402

HERE = Path(__file__).parent
CLAIMS = sorted(path.stem for path in (HERE / "claims").glob("[!_]*.py"))
BASELINE = HERE / "baseline.json"
# Growth of a ratio that counts as a regression.
LOSS = 1.3


def main(argv: list[str] | None = None) -> int:
    """Run the benchmarks; the exit code is 1 if a claim does not hold, or a ratio grew."""
    options = _options(argv)
    print(_machine())
    known = json.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.exists() else {}
    names = table.modules() if options.table else CLAIMS
    if options.check:
        names = sorted({name.split(":")[0] for name in known})
    clock = process_time if options.processor_time else perf_counter
    run = Run(5 if options.quick else 31, Markdown() if options.markdown else Text(), clock)
    for name in _select_claims(options.names) or names:
        run.module(name)
    if options.check:
        # Regressions are measured again and the better ratio is kept, to tolerate load from
        # other processes.
        for name in sorted({key.split(":")[0] for key in _lost(known, run.ratios)}):
            run.module(name)
        return 0 if _check_ratios(known, run.ratios) else 1
    if rows := table.answered(run.verdicts):
        run.show.claim("table", "Lines that must be reached, as ratios ours / theirs.")
        run.show.table(rows)
    if options.record:
        text = json.dumps(dict(sorted((known | run.ratios).items())), indent=1) + "\n"
        BASELINE.write_text(text, encoding="utf-8")
    return 0 if all(verdict.holds for verdict in run.verdicts.values()) else 1


def _options(argv: list[str] | None) -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    text = "claims to run, or a part of their names; all by default"
    parser.add_argument("names", nargs="*", help=text)
    parser.add_argument("--quick", action="store_true", help="few repetitions, to try it out")
    parser.add_argument("--markdown", action="store_true", help="print tables in Markdown")
    parser.add_argument("--table", action="store_true", help="run what the last table needs")
    parser.add_argument(
        "--processor-time",
        action="store_true",
        help="time of the processor, where other processes take their share of it; not for "
        "claims on several cores",
    )
    stored = parser.add_mutually_exclusive_group()
    stored.add_argument(
        "--check",
        action="store_true",
        help=f"compare ratios with {BASELINE.name} instead of with claims; run those in it",
    )
    stored.add_argument("--record", action="store_true", help=f"write them to {BASELINE.name}")
    return parser.parse_args(argv)


def _select_claims(words: list[str]) -> list[str]:
    """Select the claims with these names, or else with these words in their names."""
    parts = {word: [name for name in CLAIMS if word in name] for word in words}
    return [
        name for word in words for name in ([word] if word in CLAIMS else parts[word] or [word])
    ]


def _lost(known: dict[str, float], ratios: dict[str, float]) -> dict[str, float]:
    """Ratios that grew by more than `LOSS`."""
    return {
        name: ratio for name, ratio in ratios.items() if ratio > LOSS * known.get(name, ratio)
    }


def _check_ratios(known: dict[str, float], ratios: dict[str, float]) -> bool:
    """Print the ratios that grew by more than `LOSS`, and return whether there are none."""
    lost = _lost(known, ratios)
    for name, ratio in lost.items():
        print(f"LOST: {name}: {ratio:.3g}, was {known[name]:.3g}")
    compared = len(ratios.keys() & known.keys())
    print(f"{compared} ratios compared with {BASELINE.name}, {len(lost)} lost more than 30 %")
    return not lost and compared > 0


def _machine() -> str:
    """Describe the machine, the versions and the commit."""
    commit = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty"],
        capture_output=True,
        text=True,
        check=False,
    ).stdout.strip()
    return (
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, one BLAS thread, commit {commit or 'unknown'}"
    )


def classes(name: str) -> list[type]:
    """The benchmarks of a module: its public classes."""
    module = import_module(f"benchmarks.claims.{name}")
    found = [value for key, value in vars(module).items() if not key.startswith("_")]
    return [cls for cls in found if isinstance(cls, type) and cls.__module__ == module.__name__]


class Run:
    """A run of benchmarks, with the verdicts on claims and the ratios of times."""

    def __init__(
        self, repetitions: int, show: Text, clock: Callable[[], float] = perf_counter
    ) -> None:
        """Start a run without results."""
        self.repetitions, self.show, self.clock = repetitions, show, clock
        self.verdicts: dict[str, table.Verdict] = {}
        self.ratios: dict[str, float] = {}

    def module(self, name: str) -> None:
        """Run the classes of a module."""
        self.show.claim(name, import_module(f"benchmarks.claims.{name}").__doc__.strip())
        for cls in classes(name):
            self._class(cls, name)

    def _class(self, cls: type, module: str) -> None:
        """Run a class for all its parameters."""
        rows = []
        for params in cls.params:
            bench, label = cls(), " ".join(map(str, params))
            try:
                bench.setup(*params)
                found = self._measure(bench, label, params)
                for claim in getattr(cls, "claims", ()):
                    if found.keys() >= set(claim[:-1]):
                        self._judge(f"{module}:{label}", label, claim, found)
                if hasattr(bench, "row"):
                    rows.append((label, bench.row(*params)))
            except NotImplementedError as error:
                self.show.line(label, "left out", str(error))
        self.show.table(rows, getattr(cls, "total", False))

    def _measure(self, bench: object, label: str, params: tuple) -> dict[str, np.ndarray]:
        """Measure the seconds of the timed methods, and the tracked values."""
        claimed = {name for claim in getattr(bench, "claims", ()) for name in claim[:-1]}
        every = [name for name in dir(bench) if name.startswith("time_")]
        timed = [name for name in every if name in claimed] or every
        repetitions = min(self.repetitions, getattr(bench, "repetitions", self.repetitions))
        found = _time_methods(bench, timed, params, repetitions, self.clock)
        for name in (name for name in dir(bench) if name.startswith("track_")):
            try:
                found[name] = np.atleast_1d(getattr(bench, name)(*params))
            except NotImplementedError as error:
                self.show.line(label, name, f"left out: {error}")
        for name, values in found.items():
            if name in timed or values.size > 1:
                self.show.line(label, name, seconds(values))
            elif name not in claimed:
                self.show.line(label, name, f"{values[0]:9.1e}")
        return found

    def _judge(self, case: str, label: str, claim: tuple, found: dict[str, np.ndarray]) -> None:
        """Judge a claim on the ratio of two times, or on one time or tracked value."""
        *names, limit = claim
        values, name = found[names[0]], names[0]
        key = f"{case}: {'/'.join(names)}"
        if len(names) == 2:
            theirs = found[names[1]]
            ratio = float(f"{values.min() / theirs.min():.4g}")
            self.ratios[key] = min(ratio, self.ratios.get(key, ratio))
            values, name = values / theirs, " / ".join(map(_short, names))
        verdict = table.Verdict(float(np.median(values)), limit)
        self.verdicts[key] = verdict
        text = "holds" if verdict.holds else "DOES NOT HOLD"
        self.show.line(label, name, f"{verdict.value:.3g}, at most {limit:.3g}: {text}")


def _short(name: str) -> str:
    return name.removeprefix("time_").removeprefix("track_")


def _time_methods(
    bench: object,
    names: list[str],
    params: tuple,
    repetitions: int,
    clock: Callable[[], float],
) -> dict[str, np.ndarray]:
    """Measure seconds per call of each method, in interleaved batches."""
    calls = {}
    for name in names:
        method = getattr(bench, name)
        method(*params)
        start, count = clock(), 0
        while count < 5 and clock() - start < 0.01:
            method(*params)
            count += 1
        calls[name] = max(1, int(0.01 * count / (clock() - start)))
    times: dict[str, list[float]] = {name: [] for name in names}
    for _ in range(repetitions):
        for name in names:
            method = getattr(bench, name)
            start = clock()
            for _ in range(calls[name]):
                method(*params)
            times[name].append((clock() - start) / calls[name])
    return {name: np.array(values) for name, values in times.items()}


if __name__ == "__main__":
    sys.exit(main())
