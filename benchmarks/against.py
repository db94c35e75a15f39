"""Compare the time of ``design_space`` with that of another commit, on the whole gallery.

``python -m benchmarks.against COMMIT [--limit 1.5]`` checks the commit out beside this tree,
runs both in processes of their own that take turns, and prints the ratio of the medians. The
exit code is 1 if the ratio of a model exceeds the limit. ``--sweeps`` compares the processor
time of one geometry of the sweeps in `benchmarks.inputs.sweeps` instead.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.inputs.sweeps import CASES

HERE = Path(__file__).resolve().parent.parent
# Reads a model's name per line, and prints the median seconds of one call.
SPACES = """
import sys
from dataclasses import replace
from time import perf_counter
from kinematics import load
from balance import design_space

known = {}
for line in sys.stdin:
    name = line.strip()
    if name not in known:
        known[name] = load(name)
        design_space(known[name])
    times = []
    for _ in range(20):
        # A new linkage object, so that no cached result of an earlier call is used.
        fresh = replace(known[name], chain=replace(known[name].chain))
        start = perf_counter()
        design_space(fresh)
        times.append(perf_counter() - start)
    print(sorted(times)[10], flush=True)
"""
# Reads a sweep per line, and prints the seconds of one geometry: those of 14 rows without those
# of 2, which the study itself costs. No geometry is computed twice. The first sweeps had point
# masses alone, and no option for them.
SWEEPS = """
import json, sys
from time import process_time
import balance
from kinematics.errors import LinkageError

calls = 0

def run(rows, case):
    global calls
    model, path, (low, high), quantities, kind, answered = case
    calls += 1
    step = (high - low) / (rows + 1)
    values = [low + step * (k + 0.618 * calls % 1.0) for k in range(rows)]
    try:
        return balance.sweep(model, {path: values}, quantities=quantities, balance=kind)
    except LinkageError:
        plain = {name: {**options} for name, options in quantities.items()}
        plain["counterweights"].pop("density")
        return balance.sweep(model, {path: values}, quantities=plain, balance=kind)

known = set()
for line in sys.stdin:
    case = json.loads(line)
    if line not in known:
        known.add(line)
        reasons = run(2, case).reasons
        assert bool(reasons) != case[-1], (line, reasons)
    times = []
    for rows in (2, 14):
        start = process_time()
        run(rows, case)
        times.append(process_time() - start)
    print((times[1] - times[0]) / 12, flush=True)
"""


def main(argv: list[str] | None = None) -> int:
    """Compare two trees; the exit code is 1 if a model takes too long."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit")
    parser.add_argument("--limit", type=float, default=1.5)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--sweeps", action="store_true", help="a geometry of a sweep")
    options = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as folder:
        old = Path(folder) / "old"
        _git("worktree", "add", "--detach", str(old), options.commit)
        try:
            requests = {name: json.dumps(case) for name, case in CASES.items()}
            if not options.sweeps:
                models = sorted(path.stem for path in (old / "urdf_models").glob("*.urdf"))
                requests = {name: name for name in models}
            text = SWEEPS if options.sweeps else SPACES
            workers = [_worker(root, text) for root in (old, HERE)]
            return _compare(requests, workers, options.rounds, options.limit)
        finally:
            _git("worktree", "remove", "--force", str(old))


def _git(*words: str) -> None:
    subprocess.run(["git", "-C", str(HERE), *words], check=True, capture_output=True)


def _worker(root: Path, text: str) -> subprocess.Popen[str]:
    """Start a process that times the code of one tree."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    return subprocess.Popen(
        [sys.executable, "-c", text],
        cwd=root,
        env=os.environ | threads | {"PYTHONPATH": ""},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _compare(
    requests: dict[str, str],
    workers: list[subprocess.Popen[str]],
    rounds: int,
    limit: float,
) -> int:
    """Print a line per request, and return the exit code."""
    held = True
    for name, request in requests.items():
        times = np.array(
            [[_measure(worker, request) for worker in workers] for _ in range(rounds)]
        )
        before, after = np.median(times, axis=0) * 1e6
        held &= after <= limit * before
        print(f"  {name:<28} {before:9.1f} µs before, {after:9.1f} µs, {after / before:.2f}")
    print(f"at most {limit} times as long: {'holds' if held else 'DOES NOT HOLD'}")
    return 0 if held else 1


def _measure(worker: subprocess.Popen[str], request: str) -> float:
    assert worker.stdin and worker.stdout
    print(request, file=worker.stdin, flush=True)
    return float(worker.stdout.readline())


if __name__ == "__main__":
    sys.exit(main())
