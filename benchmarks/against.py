"""Compare the time of ``design_space`` with that of another commit, on the whole gallery.

``python -m benchmarks.against COMMIT [--limit 1.5]`` checks the commit out beside this tree,
runs both in processes of their own that take turns, and prints the ratio of the medians. The
exit code is 1 if the ratio of a model exceeds the limit.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent.parent
# Reads a model's name per line, and prints the median seconds of one call.
WORKER = """
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


def main(argv: list[str] | None = None) -> int:
    """Compare two trees; the exit code is 1 if a model takes too long."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit")
    parser.add_argument("--limit", type=float, default=1.5)
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as folder:
        old = Path(folder) / "old"
        _git("worktree", "add", "--detach", str(old), options.commit)
        try:
            names = sorted(path.stem for path in (old / "urdf_models").glob("*.urdf"))
            workers = [_worker(root) for root in (old, HERE)]
            return _compare(names, workers, options.rounds, options.limit)
        finally:
            _git("worktree", "remove", "--force", str(old))


def _git(*words: str) -> None:
    subprocess.run(["git", "-C", str(HERE), *words], check=True, capture_output=True)


def _worker(root: Path) -> subprocess.Popen[str]:
    """Start a process that times the code of one tree."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    return subprocess.Popen(
        [sys.executable, "-c", WORKER],
        cwd=root,
        env=os.environ | threads | {"PYTHONPATH": ""},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _compare(
    names: list[str], workers: list[subprocess.Popen[str]], rounds: int, limit: float
) -> int:
    """Print a line per model, and return the exit code."""
    held = True
    for name in names:
        times = np.array(
            [[_measure(worker, name) for worker in workers] for _ in range(rounds)]
        )
        before, after = np.median(times, axis=0) * 1e6
        held &= after <= limit * before
        print(f"  {name:<28} {before:9.1f} µs before, {after:9.1f} µs, {after / before:.2f}")
    print(f"at most {limit} times as long: {'holds' if held else 'DOES NOT HOLD'}")
    return 0 if held else 1


def _measure(worker: subprocess.Popen[str], name: str) -> float:
    assert worker.stdin and worker.stdout
    print(name, file=worker.stdin, flush=True)
    return float(worker.stdout.readline())


if __name__ == "__main__":
    sys.exit(main())
