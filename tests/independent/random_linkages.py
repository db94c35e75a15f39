"""Random linkages through the product, beside integers that share no code with it.

``python -m tests.independent.random_linkages --cases 5000 --seed 0 --jobs 2`` runs the cases
of all families in turn; ``--family F --seed S --cases 1 --show`` is one of them again.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from tests.independent.families import FAMILIES, linkage
from tests.independent.judging import SURE, Verdict, judge
from tests.independent.plain_linkage import urdf
from tests.independent.true_ranks import truth

COLUMNS = (
    "cases",
    "regular",
    "right",
    "moved",
    "proved",
    "verified",
    "estimated",
    "sure, wrong",
    "exit 0, wrong",
    "exit 4, wrong",
    "exit 4",
    "refused",
    "irregular",
    "shaky",
    "crash",
    "s",
)


def cases(count: int, seed: int, family: str | None = None) -> list[tuple[str, int]]:
    """Families and seeds: the families in turn, or one."""
    names = [family] if family else list(FAMILIES)
    return [(names[k % len(names)], seed + k // len(names)) for k in range(count)]


def _judged(folder: Path, case: tuple[str, int]) -> Verdict:
    return judge(*case, folder)


def _counted(verdict: Verdict) -> Counter:
    """The columns of the table that a case counts in."""
    regular = verdict.outcome in ("right", "moved", "wrong", "refused")
    wrong = verdict.outcome == "wrong"
    sure = wrong and verdict.level in SURE
    return Counter(
        {
            "cases": 1,
            "regular": regular,
            "s": sum(verdict.seconds),
            verdict.outcome: verdict.outcome in COLUMNS,
            verdict.level or "none": verdict.outcome in ("right", "moved", "wrong"),
            "sure, wrong": sure,
            "exit 0, wrong": wrong and not sure and verdict.code == 0,
            "exit 4, wrong": wrong and not sure and verdict.code == 4,
            "exit 4": verdict.code == 4,
        }
    )


def _show(verdicts: list[Verdict]) -> None:
    """The table, the reasons of what is unsure or refused, and what failed."""
    table: dict[str, Counter] = {}
    for verdict in verdicts:
        for row in (verdict.family, "all"):
            table.setdefault(row, Counter()).update(_counted(verdict))
    table["all"] = table.pop("all")
    print(f"{'':16}" + "".join(f"{name:>{max(7, len(name) + 2)}}" for name in COLUMNS))
    for row, counts in table.items():
        print(
            f"{row:16}"
            + "".join(f"{counts[name]:>{max(7, len(name) + 2)}.0f}" for name in COLUMNS)
        )
    whole = table["all"]
    share = sum(whole[level] for level in SURE) / max(whole["regular"], 1)
    print(
        f"proved or verified: {share:.1%} of the regular; "
        f"{whole['s'] / whole['cases']:.2f} s a case, of which the truth "
        f"{sum(v.seconds[0] for v in verdicts) / len(verdicts):.2f} s"
    )
    reasons = Counter(
        (v.outcome, v.level, v.detail)
        for v in verdicts
        if v.outcome in ("refused", "irregular", "shaky") or v.level == "estimated"
    )
    for (outcome, level, detail), count in reasons.most_common(25):
        print(f"{count:6} {outcome} {level}: {detail[:150]}")


def _told(verdict: Verdict) -> str:
    return (
        f"--family {verdict.family} --seed {verdict.seed}: {verdict.outcome}, "
        f"exit {verdict.code} {verdict.level}: {verdict.detail}"
    )


def main() -> int:
    """Run cases from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=900)
    parser.add_argument("--seed", type=int, default=0, help="of the first case of a family")
    parser.add_argument("--family", choices=sorted(FAMILIES))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--show", action="store_true", help="print the files and the truth")
    options = parser.parse_args()
    wanted, verdicts = cases(options.cases, options.seed, options.family), []
    if options.show:
        for family, seed in wanted:
            case = linkage(family, seed)
            print(urdf(case), "options: ", *case.options)
            print(truth(case, seed))
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        work = partial(_judged, Path(folder))
        if options.jobs == 1:
            found = map(work, wanted)
        else:
            pool = get_context("spawn").Pool(options.jobs)
            found = pool.imap_unordered(work, wanted, chunksize=4)
        for n, verdict in enumerate(found, 1):
            verdicts.append(verdict)
            if verdict.failed or verdict.outcome == "shaky":
                print(_told(verdict), flush=True)
            if n % 100 == 0:
                print(
                    f"{n} of {len(wanted)}, {time.perf_counter() - begin:.0f} s",
                    file=sys.stderr,
                    flush=True,
                )
    _show(verdicts)
    return 1 if any(verdict.failed for verdict in verdicts) else 0


if __name__ == "__main__":
    sys.exit(main())
