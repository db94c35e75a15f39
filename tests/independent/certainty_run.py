"""Certainty of ``report`` on random linkages, hard and ordinary, beside an independent oracle.

    python -m tests.independent.certainty_run --count 1000 --seed 0 --table cases.jsonl
    python -m tests.independent.certainty_run --family yokes --seed 17 --count 1 --show

runs so many cases of each family in one process, adds a line for each to a file, which a later
run goes on with, and prints a table. The exit code is 1 if an answer is wrong under ``proved``
or ``verified``, or with exit 0.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from tests.independent.certainty_cases import FAMILIES, Case, certainty_case
from tests.independent.judging import SURE, Answer, ask, compare, level_of
from tests.independent.true_ranks import CLOSED, truth
from tests.support.time_limit import time_limit

# Seconds on the clock after which a case hangs, on a machine that others use too.
LIMIT = 1800
COLUMNS = (
    "cases",
    "regular",
    "right",
    "proved",
    "verified",
    "share",
    "sure, wrong",
    "exit 0, wrong",
    "exit 4, wrong",
    "exit 4",
    "refused",
    "crash",
    "s",
)
# Outcomes, the best first: a file with two readings is judged by the better.
OUTCOMES = ("right", "moved", "irregular", "open", "refused", "shaky", "wrong", "crash")


def judge_case(family: str, seed: int, folder: Path) -> dict:
    """Run a case through the product and compare; a line of the table file."""
    begin = time.process_time()
    case = certainty_case(family, seed)
    path = folder / f"{family}_{seed}.urdf"
    try:
        with time_limit(LIMIT):
            answer = ask(case.text, case.options, path)
    except Exception as error:
        where = traceback.format_exception(error)[-2].strip().splitlines()
        answer = Answer(-1, None, f"{error!r} in {' '.join(where)}")
    middle = time.process_time()
    outcome, detail = _judged(case, answer, seed, 1)
    if outcome == "wrong":
        # By the other prime, further orders, and more ways of opening.
        outcome, detail = _judged(case, answer, seed + 1, 3)
    level = level_of(answer)
    return {
        "family": family,
        "seed": seed,
        "outcome": outcome,
        "level": level,
        "code": answer.code,
        "note": case.note,
        "detail": detail,
        "seconds": [round(middle - begin, 3), round(time.process_time() - middle, 3)],
    }


def _judged(case: Case, answer: Answer, seed: int, effort: int) -> tuple[str, str]:
    """The best outcome of the readings of a file."""
    if answer.code == -1:
        return "crash", answer.text
    found = []
    for reading in case.readings:
        true = truth(reading, seed, effort, case.orders or CLOSED)
        outcome, detail = compare(true, answer, case.rounded)
        undecided = answer.code == 4 or answer.report is None
        if not case.decided and undecided and outcome in ("wrong", "refused"):
            outcome = "open"
        found.append((outcome, detail))
    return min(found, key=lambda pair: OUTCOMES.index(pair[0]))


def _counted(line: dict) -> Counter:
    """The columns in which a case counts."""
    outcome, level, code = line["outcome"], line["level"], line["code"]
    wrong = outcome in ("wrong", "shaky")
    sure = wrong and level in SURE
    return Counter(
        {
            "cases": 1,
            "s": sum(line["seconds"]),
            "exit 4": code == 4,
            "regular": outcome in ("right", "moved", "wrong", "refused"),
            "right": outcome in ("right", "moved"),
            "refused": outcome == "refused",
            level: outcome in ("right", "moved") and level in SURE,
            "sure, wrong": sure,
            "exit 0, wrong": wrong and not sure and code == 0,
            "exit 4, wrong": wrong and not sure and code == 4,
            "crash": outcome == "crash",
        }
    )


def table(lines: Iterable[dict]) -> list[str]:
    """The table: a row for each family, and one for all.

    Structures, and files of fewer than six digits left open, count as cases only; the share is
    that of ``proved`` and ``verified`` among the others.
    """
    rows: dict[str, Counter] = {}
    for line in lines:
        for row in (line["family"], "all"):
            rows.setdefault(row, Counter()).update(_counted(line))
    rows["all"] = rows.pop("all", Counter())
    widths = [max(6, len(name)) + 2 for name in COLUMNS]
    text = [
        f"{'':15}" + "".join(f"{name:>{w}}" for name, w in zip(COLUMNS, widths, strict=True))
    ]
    for row, counts in rows.items():
        sure = (counts["proved"] + counts["verified"]) / max(counts["regular"], 1)
        cells = [f"{sure:.1%}" if x == "share" else f"{counts[x]:.0f}" for x in COLUMNS]
        text.append(
            f"{row:15}" + "".join(f"{x:>{w}}" for x, w in zip(cells, widths, strict=True))
        )
    return text


def _fails(line: dict) -> bool:
    """Whether an answer is wrong and says nothing of it."""
    wrong = line["outcome"] in ("wrong", "shaky")
    return line["outcome"] == "crash" or (
        wrong and (line["code"] == 0 or line["level"] in SURE)
    )


def _reasons(lines: list[dict]) -> list[str]:
    """Why answers are neither proved nor verified, the most frequent reasons first."""
    counts = Counter(
        (x["family"], x["outcome"], x["code"], x["detail"][:120])
        for x in lines
        if x["level"] not in SURE and x["outcome"] not in ("irregular", "open")
    )
    return [f"{n:5} {' '.join(map(str, key))}" for key, n in counts.most_common(20)]


def main(words: list[str] | None = None) -> int:
    """Run cases from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="cases of each family")
    parser.add_argument("--family", nargs="+", choices=FAMILIES, default=list(FAMILIES))
    parser.add_argument("--seed", type=int, default=0, help="of the first case of a family")
    parser.add_argument("--table", type=Path, help="JSON lines, to go on with")
    parser.add_argument("--show", action="store_true", help="print the files and the truth")
    options = parser.parse_args(words)
    lines = []
    if options.table and options.table.exists():
        lines = [json.loads(x) for x in options.table.read_text().splitlines()]
    done = {(line["family"], line["seed"]) for line in lines}
    wanted = [
        (family, seed)
        for seed in range(options.seed, options.seed + options.count)
        for family in options.family
    ]
    begin, last = time.perf_counter(), 0.0
    with tempfile.TemporaryDirectory() as folder:
        for n, (family, seed) in enumerate(wanted, 1):
            if options.show:
                _show(certainty_case(family, seed), seed)
            if (family, seed) in done:
                continue
            lines.append(judge_case(family, seed, Path(folder)))
            if options.table:
                with options.table.open("a") as file:
                    file.write(json.dumps(lines[-1]) + "\n")
            if _fails(lines[-1]) or options.show:
                print(json.dumps(lines[-1]), flush=True)
            if (now := time.perf_counter()) > last + 10:
                last = now
                print(f"{n} of {len(wanted)}, {now - begin:.0f} s", file=sys.stderr, flush=True)
    lines = [x for x in lines if (x["family"], x["seed"]) in set(wanted)]
    print("\n".join([*table(lines), *_reasons(lines)]))
    return 1 if any(map(_fails, lines)) else 0


def _show(case: Case, seed: int) -> None:
    print(case.text, "options: ", *case.options)
    for reading in case.readings:
        print(truth(reading, seed, 1, case.orders or CLOSED))


if __name__ == "__main__":
    sys.exit(main())
