"""Profile our side of a benchmark, compiled functions included.

``python -m benchmarks.profiles NAME…`` runs the first timed method of the claims of each class,
or else its first timed method, under cProfile, and prints the functions with most own time, in
per cent of the whole. The profiler slows down Python more than compiled code, and does not see
other threads or processes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from cProfile import Profile
from pathlib import Path
from pstats import Stats
from time import perf_counter

from benchmarks.__main__ import classes

# Seconds of each profile.
SECONDS = 0.5
# Number of functions in a list.
MAX_FUNCTIONS = 8


def main(argv: list[str] | None = None) -> int:
    """Print a profile for each case."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.profiles", description=__doc__)
    parser.add_argument("names", nargs="+", help="names of claims")
    for name in parser.parse_args(argv).names:
        for cls in classes(name):
            for params in cls.params:
                _case(name, cls(), params)
    return 0


def _case(name: str, bench: object, params: tuple) -> None:
    """Profile one case."""
    claimed = [claim[0] for claim in getattr(bench, "claims", ())]
    timed = [method for method in (*claimed, *dir(bench)) if method.startswith("time_")]
    try:
        bench.setup(*params)
    except NotImplementedError:
        return
    if timed:
        print(f"{name}: {' '.join(map(str, params))}: {timed[0]}")
        _print(_profile(getattr(bench, timed[0]), params))


def _profile(call: Callable[..., None], params: tuple) -> Stats:
    call(*params)
    profile, start = Profile(), perf_counter()
    while perf_counter() - start < SECONDS:
        profile.runcall(call, *params)
    return Stats(profile)


def _print(stats: Stats) -> None:
    own = {where: entry[2] for where, entry in stats.stats.items()}
    for (file, line, name), seconds in sorted(own.items(), key=lambda item: -item[1])[
        :MAX_FUNCTIONS
    ]:
        place = f"{Path(file).parent.name}/{Path(file).name}:{line} " if line else ""
        print(f"  {100.0 * seconds / sum(own.values()):5.1f} %  {place}{name}")


if __name__ == "__main__":
    sys.exit(main())
