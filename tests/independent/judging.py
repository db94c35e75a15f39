"""One random linkage through the product, and its answer beside what is true."""

from __future__ import annotations

import io
import json
import logging
import re
import time
import traceback
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

from tests.independent.families import linkage
from tests.independent.plain_linkage import urdf
from tests.independent.true_ranks import Truth, truth
from tests.support.time_limit import time_limit

# Seconds after which a case hangs.
LIMIT = 300
# Warnings of the product that say that the answer is that of another pose, or other axes.
MOVED = {"left_singular_pose", "assembled"}
MENDED = {"closes_to_rounding", "inexact_closure", "rounded_angles"}
SURE = ("proved", "verified")


class Answer(NamedTuple):
    """What the product says: exit code, report, and the text beside it."""

    code: int
    report: dict | None
    text: str


class Verdict(NamedTuple):
    """What became of a case.

    Attributes:
        family, seed: of the case.
        outcome: right; moved, which is right at another pose than that of the file; refused,
            though the linkage is regular; irregular, whose loops do not close at higher
            orders, refused or left with a warning; shaky, the same, answered as estimated
            without one; wrong; crash.
        level: of certainty, if there is an answer.
        code: exit code.
        detail: both answers if they differ, or the reason of a refusal.
        seconds: of this process, for the truth and for the product.
    """

    family: str
    seed: int
    outcome: str
    level: str
    code: int
    detail: str
    seconds: tuple[float, float]

    @property
    def failed(self) -> bool:
        """Whether the product is at fault: wrong, and neither undecided nor refused."""
        return self.outcome == "crash" or (
            self.outcome == "wrong" and (self.code == 0 or self.level in SURE)
        )


def judge(family: str, seed: int, folder: Path) -> Verdict:
    """Run a case through the product and compare."""
    begin = time.process_time()
    case = linkage(family, seed)
    true = truth(case, seed)
    middle = time.process_time()
    try:
        with time_limit(LIMIT):
            answer = ask(urdf(case), case.options, folder / f"{family}_{seed}.urdf")
    except Exception as error:
        where = traceback.format_exception(error)[-2].strip().splitlines()
        spent = middle - begin, time.process_time() - middle
        text = f"{error!r} in {' '.join(where)}"
        return Verdict(family, seed, "crash", "", -1, text, spent)
    spent = middle - begin, time.process_time() - middle
    outcome, detail = compare(true, answer)
    if outcome == "wrong" and true.regular:
        # By the other prime, further orders, and more ways of opening.
        again = truth(case, seed + 1, 3)
        outcome, detail = compare(again, answer)
        if again != true:
            detail += f" (the first look gave {true})"
    level = level_of(answer)
    return Verdict(family, seed, outcome, level, answer.code, detail, spent)


def ask(text: str, options: list[str], path: Path) -> Answer:
    """The report of the product on a file."""
    from balance.app.cli.main import main

    if not logging.getLogger().handlers:
        logging.getLogger().addHandler(logging.NullHandler())
    path.write_text(text, encoding="utf-8")
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(["report", str(path), "--json", *options])
    path.unlink()
    text = out.getvalue()
    return Answer(code, json.loads(text) if text else None, err.getvalue())


def compare(true: Truth, answer: Answer, rounded: bool = False) -> tuple[str, str]:
    """Outcome and detail.

    Args:
        true: what is true.
        answer: of the product.
        rounded: whether the numbers of the file are rounded: its loops close to that only, and
            its pose is only next to a special one, so that an order may have more conditions.
    """
    report = answer.report
    if report is None:
        if answer.code != 3:
            return "crash", f"exit {answer.code} without an answer: {answer.text}"
        return ("refused" if true.regular else "irregular"), _reason(answer.text)
    if "modes" in report:
        return _compare_modes(true, report["modes"])
    codes = {warning["code"] for warning in report["warnings"]}
    if not true.regular:
        detail = f"answered: mobility {report['mobility']}, at first order {true.mobility}"
        if codes & (MOVED | MENDED) or answer.code == 4:
            return "irregular", detail
        if report["certainty"] not in SURE:
            return "shaky", detail
        return "wrong", f"{detail}; but the loops do not close at higher orders"
    later = rounded and _later(true, report)
    wrong = _differences(true, report, answer.code, bool(codes & MOVED) or later)
    if codes & MENDED and not rounded:
        wrong += [f"{code}, though the loops close" for code in sorted(codes & MENDED)]
    if wrong:
        return "wrong", f"{'; '.join(wrong)}; {report['evidence']['reason']}"
    return ("moved" if codes & MOVED else "right"), report["evidence"]["reason"]


def _compare_modes(true: Truth, modes: list[dict]) -> tuple[str, str]:
    """Whether a mode that is listed where motions meet is what is true."""
    if not true.regular:
        return "irregular", f"{len(modes)} modes, at first order {true.mobility}"
    size = true.parameters - true.rank
    integers = true.mobility, true.rank, size, true.serial, true.parallel
    names = "mobility", "rank", "nullity", "serial", "parallel"
    listed = [tuple(mode[name] for name in names) for mode in modes]
    if integers in listed:
        return "right", "a mode of those that are listed"
    return "wrong", f"modes {listed}, true {integers}"


def level_of(answer: Answer) -> str:
    """The level of certainty of an answer, the lowest of its modes; empty without one."""
    reports = (answer.report or {}).get("modes", [answer.report] if answer.report else [])
    levels = [report["certainty"] for report in reports]
    return min(levels, key=lambda level: level in SURE, default="")


def _later(true: Truth, report: dict) -> bool:
    """Whether no order has fewer conditions than the true pose, and the last has as many."""
    kmax = len(true.ranks) - 1
    found = [order["rank"] for order in report["orders"]]
    more = all(rank >= true.ranks[min(k, kmax)] for k, rank in enumerate(found))
    return more and report["rank"] == true.rank


def _single(names) -> list[str]:
    """Joints of one freedom; each language names those of others in its own way."""
    return sorted(name for name in names if re.fullmatch(r"j\d+", name))


def _differences(true: Truth, report: dict, code: int, moved: bool) -> list[str]:
    """Numbers that are wrong, with the true ones."""
    pairs = [
        ("planar", report["algebra"] == "planar", true.planar),
        ("mobility", report["mobility"], true.mobility),
        ("parameters", report["parameters"], true.parameters),
        ("rank", report["rank"], true.rank),
        ("nullity", report["nullity"], true.parameters - true.rank),
        ("serial", report["serial"], true.serial),
        ("parallel", report["parallel"], true.parallel),
        ("idle", _single(report["idle"]), _single(true.idle)),
        ("exit 4", bool(report["evidence"]["doubts"]), code == 4),
    ]
    if not moved:
        kmax = len(true.ranks) - 1
        found = [order["rank"] for order in report["orders"]]
        pairs.append(("orders", found, [true.ranks[min(k, kmax)] for k in range(len(found))]))
        nullities = [true.parameters - rank for rank in found]
        said = [order["nullity"] for order in report["orders"]]
        pairs.append(("nullity by order", said, nullities))
        if report["kmax"] is not None:
            pairs.append(("kmax", report["kmax"], kmax))
    return [f"{name} {said}, true {is_}" for name, said, is_ in pairs if said != is_]


def _reason(text: str) -> str:
    """A refusal without what differs from case to case."""
    text = text.strip().rpartition(".urdf: ")[2]
    text = re.sub(r"\bj\d+(\.\d)?(=\S+)?(, )?|[-+]?\d[\d.e-]*", "", text)
    return " ".join(text.split())[:100]
