"""Read mutants of other formats, and of the dialects of URDF, from the command line.

``python -m tests.fuzz.fuzz_formats sdf --cases 20000 --seed 0`` runs as many cases as it is
told; formats are ``dialects``, ``mjcf`` and ``sdf``. URDF itself has `tests/fuzz/fuzz.py`. A
case that ends the process is the last in ``--log``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from tests.fuzz.format_judges import JUDGES
from tests.support.time_limit import time_limit

# Seconds after which a case hangs.
LIMIT = 300.0


def run(name: str, seeds: Iterable[int], log: Path | None = None) -> tuple[Counter, list[str]]:
    """Read the mutants of some seeds.

    Args:
        name: of the format.
        seeds: one for each case.
        log: file that gets the seed of the case that runs.

    Returns:
        How many ended in which way, and a line for each that ended wrongly.
    """
    counts: Counter = Counter()
    wrong = []
    for seed in seeds:
        if log:
            log.write_text(str(seed))
        try:
            with time_limit(LIMIT):
                counts[JUDGES[name](seed)] += 1
        except Exception as error:
            wrong.append(f"seed {seed}: {type(error).__name__}: {error}")
    return counts, wrong


def main() -> int:
    """Run the cases of the command line; print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("format", choices=sorted(JUDGES))
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--log", type=Path)
    options = parser.parse_args()
    begin = time.perf_counter()
    seeds = range(options.seed, options.seed + options.cases)
    counts, wrong = run(options.format, seeds, options.log)
    print(*wrong[:50], sep="\n")
    print(f"{len(seeds)} cases in {time.perf_counter() - begin:.0f} s: {dict(counts)}")
    print(f"{len(wrong)} found")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
