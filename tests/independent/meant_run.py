"""Special linkages in so many digits, and general ones beside them: a long comparison.

    python -m tests.independent.meant_run --count 20 --digits 17 15 12 9 6
    python -m tests.independent.meant_run --count 20 --off 1e-12 1e-9 1e-6 1e-3

prints, for each family, number of digits and kind of frames, how many answers of ``report`` are
right, wrong with exit 0, or undecided (exit 4), and their levels. The truth is that of
`tests.independent.sixty_digits`, once for each family. With ``--design`` the verdicts of
``design`` are compared, which must be one for each linkage, in all numbers of digits.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path

from balance.app.cli.main import main
from tests.independent.meant_linkages import FAMILIES, meant_linkage, meant_text
from tests.independent.sixty_digits import true_ranks

PLANAR = ("kite", "parallelogram", "antiparallelogram", "slider_crank", "pantograph")
FRAMES = (("turned", "any"), ("axes", "any"), ("plain", "any"), ("turned", "xy"))


@cache
def truth(family: str, off: float) -> tuple[int, tuple[int, ...] | None]:
    """Mobility and ranks by order of a family; of one linkage, for all have the same."""
    mobility, ranks = true_ranks(meant_linkage(family, 1, off), family in PLANAR)
    return mobility, None if ranks is None else tuple(ranks)


def answer(path: Path, *options: str, verb: str = "report") -> tuple[int, dict]:
    """Exit code and object of a command with ``--json``."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(io.StringIO()):
        code = main([verb, str(path), "--json", *options])
    return code, json.loads(text.getvalue()) if text.getvalue() else {}


def _judge(family: str, off: float, path: Path) -> tuple[str, str]:
    """Judge the answer on one file."""
    code, report = answer(path)
    mobility, ranks = truth(family, off)
    if not report:
        return ("right" if ranks is None else f"exit {code}"), "refused"
    # Where modes meet inside the digits, all are listed, the one that is meant among them.
    answers = report.get("modes", [report])
    same = [
        item["certainty"]
        for item in answers
        if (item["mobility"], tuple(order["rank"] for order in item["orders"]))
        == (mobility, ranks)
    ]
    verdict, level = ("right", same[0]) if same else ("wrong", answers[0]["certainty"])
    return (verdict if code == 0 else f"exit {code}, {verdict}"), level


def _run() -> None:
    """Compare, and print a line for each family, number of digits and kind of frames."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--digits", type=int, nargs="+", default=[17, 15, 12, 9, 6])
    parser.add_argument("--off", type=float, nargs="+", default=[0.0])
    parser.add_argument("--families", nargs="+", default=list(FAMILIES))
    parser.add_argument("--design", action="store_true")
    choices = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for family in choices.families:
            for off in choices.off:
                designs: dict[int, set[str]] = {}
                for digits in choices.digits:
                    counts: Counter[str] = Counter()
                    levels: Counter[str] = Counter()
                    for seed in range(choices.first, choices.first + choices.count):
                        frames, plane = FRAMES[seed % len(FRAMES)]
                        linkage = meant_linkage(family, seed, off)
                        path = Path(folder) / f"{family}_{seed}.urdf"
                        path.write_text(meant_text(linkage, seed, digits, frames, plane))
                        verdict, level = _judge(family, off, path)
                        counts[verdict] += 1
                        levels[level] += 1
                        if choices.design:
                            code, design = answer(path, verb="design")
                            text = f"exit {code}, {design.get('verdict', 'refused')}"
                            designs.setdefault(seed, set()).add(text)
                        if verdict != "right":
                            print(f"# {family} {seed} {digits} {off:g}: {verdict}", flush=True)
                    print(
                        f"{family:20} off {off:<6g} {digits:2} digits: "
                        f"{dict(counts)}, {dict(levels)}",
                        flush=True,
                    )
                if choices.design:
                    verdicts = Counter("; ".join(sorted(x)) for x in designs.values())
                    print(f"{family:20} off {off:<6g} design: {dict(verdicts)}", flush=True)


if __name__ == "__main__":
    _run()
