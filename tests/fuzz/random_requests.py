"""Random requests to the command line: exit codes mean what they say, and JSON is strict.

``python -m tests.fuzz.random_requests --cases 5000 --seed 0`` runs as many as it is told; a
seed stands for the cases that follow it, so that ``--seed 4711 --cases 1`` is one case again.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import shlex
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

import balance
from kinematics import gallery
from tests.fuzz.fuzz import written
from tests.fuzz.good_words import POSITIONS, WITHOUT_MODEL, needed
from tests.fuzz.mutants import mutant
from tests.fuzz.request_words import (
    ODD,
    WORDS,
    Place,
    names_of,
    options,
    parsers,
)
from tests.fuzz.sweep_words import sweep_words
from tests.support.command_runs import Outcome, asked
from tests.support.small_linkages import small_linkage
from tests.support.time_limit import time_limit

LEVELS = ("estimated", "verified", "proved")
# Seconds after which a request hangs.
LIMIT = 600.0
FLEX = ("flex simulate", "flex modes", "flex simulate", "flex supports", "flex similar")
LATER = ("springs", "quiet", "identify", "formulas")
# Models that take long are asked seldom.
LARGE = (
    "delta",
    "stewart_6ups",
    "three_rsr",
    "three_rsr_rational",
    "four_bar_chain",
    "four_rrr_parallel",
    "eight_bar",
    "scissor_three_stage",
)


@cache
def validator(verb: str) -> Draft202012Validator:
    """The schema of what a command prints."""
    name = verb.partition(" ")[0]
    path = Path(balance.__file__).with_name("app") / "schemas" / f"{name}.schema.json"
    return Draft202012Validator(json.loads(path.read_text(encoding="utf-8")))


def strict(text: str) -> Any:
    """The one object of a JSON text.

    Raises:
        ValueError: it holds NaN or infinity, a key twice, or something else.
    """

    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no JSON")

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a key stands twice")
        return dict(pairs)

    return json.loads(text, parse_constant=refuse, object_pairs_hook=once)


def meant(words: list[str], found: dict[str, Any]) -> int:
    """The exit code that belongs to what was printed."""
    verb = words[0]
    if verb == "reduce":
        last = found["designs"][-1]["verdict"] if "designs" in found else found["verdict"]
        return {"optimal": 0, "infeasible": 1, "undecided": 4}[last]
    if verb in ("design", "counterweights", "remedies", "springs", "synthesize"):
        return {"feasible": 0, "partial": 0, "infeasible": 1, "undecided": 4}[found["verdict"]]
    if verb == "identify":
        return 1 if found.get("verdict") == "partly identified" else 0
    if verb == "verify":
        verdict = "undisturbed" if "undisturbed" in found else "balanced"
        return {True: 0, False: 1, None: 4}[found[verdict]]
    if verb == "motion":
        return 0 if all(pose["corrected"] is not None for pose in found["poses"]) else 1
    if verb == "formulas":
        return 0 if found["confirmed"] else 4
    if verb == "paths":
        if "factors" in found:
            return 1 if found["reason"] else 0
        solutions = [chart["solution"] for chart in found.get("charts", [])] or [found]
        return 0 if any(solution["paths"] for solution in solutions) else 1
    if verb == "quiet":
        return 1 if found["verdict"] == "infeasible" else 0
    if verb == "sweep" and found["what"] == "run":
        no_best = found["best"] is not None and found["best"]["row"] is None
        return 1 if no_best or not found["answered"] else 0
    if verb in ("new", "models", "flex", "sweep"):
        return 0
    if verb == "discover":
        if found["what"] == "walk":
            return 0 if found["outcome"] == "special" else 1
        if found["what"] != "export":
            return 0 if found["families"] else 1
        return {"feasible": 0, "infeasible": 1, "undecided": 4}[found["verdict"]]
    options = parsers()[verb].parse_args(words[1:])
    unsettled = any(notice["code"] == "not_settled" for notice in found["warnings"])
    unsure = (
        options.exact and found["exact"] is None,
        found["evidence"]["doubts"],
        unsettled and options.max_order is None,
        LEVELS.index(found["certainty"]) < LEVELS.index(options.certainty or LEVELS[0]),
    )
    return 4 if any(unsure) else 0


def consistent(words: list[str], found: dict[str, Any]) -> None:
    """What a report says fits what it holds."""
    if words[0] == "reduce":
        for one in found.get("designs", []):
            assert one["words"].startswith(one["verdict"])
            assert one["found"] is not None or one["verdict"] != "optimal"
            assert one["mass"] <= one["budget"] * (1.0 + 1e-6)
        if "designs" not in found:
            assert found["words"].startswith(found["verdict"])
            assert found["mass"] <= found["budget"] * (1.0 + 1e-6)
            assert found["bound"] <= found["total"] * (1.0 + 1e-9)
    elif words[0] in ("design", "counterweights"):
        assert (found["verdict"] == "infeasible") == bool(found["certificate"])
        assert found["words"].startswith(found["verdict"])
        if words[0] == "counterweights":
            assert (found["verdict"] == "feasible") == (found["value"] is not None)
            assert found["check"] is None or found["check"]["accepted"] is True
            return
        assert (found["verdict"] == "feasible") == bool(found["bodies"])
        assert found["residuals"] is None or found["residuals"]["accepted"] is True
        assert all(
            body["mass"] > 0.0 for body in found["bodies"] if body["name"] not in found["keep"]
        )
    elif words[0] == "verify" and "undisturbed" in found:
        assert found["undisturbed"] in (None, found["residual"] <= found["tolerance"])
    elif words[0] == "verify" and found["balanced"] is not None:
        parts = ("force",) if found["balance"] == "force" else ("force", "moment")
        largest = max(found["residual"][part] for part in parts)
        assert (largest <= found["tolerance"]) == found["balanced"]
    elif words[0] == "motion":
        assert found["reached"] == (meant(words, found) == 0)
        assert all(
            (pose["corrected"] is None) == (pose["reason"] is not None)
            for pose in found["poses"]
        )
    elif words[0] == "quiet":
        assert found["words"].startswith(found["verdict"])
        assert (found["exceeded"] is None) == (meant(words, found) == 0)
        kept = [
            law["figures"]["value"]
            for law in found["laws"]
            if law["exceeded"] is None and law["figures"]
        ]
        least = min(kept, default=math.inf)
        assert found["exceeded"] or found["frequencies"] or found["after"]["value"] <= least
    elif words[0] == "report":
        assert found["rank"] + found["nullity"] == found["parameters"]
        assert found["serial"] + found["parallel"] == found["nullity"]
        assert found["kmax"] is None or found["orders"][found["kmax"]]["rank"] == found["rank"]


def check(words: list[str], done: Outcome) -> str:
    """How a request ends.

    Raises:
        AssertionError: it does not keep the contract of the command line.
    """
    code, out, err = done
    assert code in (0, 1, 2, 3, 4), f"exit {code}: {err}"
    assert "Traceback" not in err and "Warning" not in err, err
    if code in (2, 3):
        assert out == "", out
        wrong, *where = err.splitlines()
        assert wrong.startswith("balance"), err
        missing = "which is not installed; install it with" in wrong
        assert len(where) == (code == 2 and not missing), err
        assert all(line.endswith(" --help lists what there is") for line in where), err
        return f"{words[0]}: {code}"
    if "--json" in words:
        found = strict(out)
        # ``reduce`` prints partial balance, ``verify --base`` the motion of a base.
        several = words[0] in ("reduce", "verify")
        kind = found["schema"].split(".")[1].split("/")[0] if several else words[0]
        validator(kind).validate(found)
        assert meant(words, found) == code, f"exit {code}, but {out[:300]}"
        consistent(words, found)
    assert out.strip() and out.endswith("\n")
    return f"{words[0]}: {code}"


def request(seed: int, folder: Path) -> list[str]:
    """The words of one request; everything follows from the seed."""
    rng = random.Random(seed)
    verb = rng.choice(
        (
            "report",
            "report",
            "verify",
            "design",
            "counterweights",
            "reduce",
            "motion",
            "motion",
            "remedies",
            "paths",
            *["models"] * (rng.random() < 0.1),
        )
    )
    # Chosen by the seed, so that the other requests stay as they were.
    verb = "synthesize" if seed % 13 == 5 else verb
    verb = FLEX[seed // 17 % len(FLEX)] if seed % 17 == 3 else verb
    verb = LATER[seed // 19 % len(LATER)] if seed % 19 == 7 else verb
    verb = "new" if seed % 23 == 9 else verb
    if seed % 17 == 11:
        return [*sweep_words(rng, folder, ODD), *["--json"] * (rng.random() < 0.75)]
    parser, words = parsers()[verb], verb.split()
    if verb not in WITHOUT_MODEL:
        words.append(_model(rng, folder))
    place = Place(names_of(words[-1]), folder, words[-1])
    if verb == "synthesize":
        words += [*POSITIONS, "--fixed", "0.2,-0.1"]
    known = options(parser)
    picked = rng.sample(sorted(known), min(len(known), rng.choice((0, 1, 1, 2, 2, 3, 4))))
    given = {"--trajectories", "--speed"} & set(picked)
    if verb == "verify" and not given and rng.random() < 0.9:
        words += ["--trajectories", "1"]
    if verb == "remedies" and "--only" not in picked:
        # All of them together take long.
        words += ["--only", rng.choice(("own_masses", "partial"))]
    if verb == "paths" and not {"--length", "--through", "--change"} & set(picked):
        words += ["--length", "0.2"]
    words += _needed_words(rng, place, verb, picked)
    for name in picked:
        # Pages and pictures take long.
        if name in ("--html", "--plot") and rng.random() < 0.6:
            continue
        for _ in range(rng.choice((1, 1, 1, 2)) if known[name].nargs != 0 else 1):
            maker = WORDS.get(f"{verb} {name}", WORDS.get(name))
            (word,) = maker(rng, place) if known[name].nargs != 0 else [None]
            joined = word is not None and (word.startswith("-") or rng.random() < 0.3)
            words += [f"{name}={word}"] if joined else [name, word][: 1 + (word is not None)]
    if rng.random() < 0.75 and "--json" not in words:
        words.append("--json")
    return words


def _needed_words(
    rng: random.Random, place: Place, verb: str, picked: Collection[str]
) -> list[str]:
    """What a command needs beside the options picked, for the model of the place."""
    on_links = verb.startswith("flex") or verb in ("counterweights", "reduce", "springs")
    names = {
        "link": rng.choice(place.names.links or ("ghost",)) if on_links else "",
        "table": WORDS["--csv"](rng, place)[0] if verb in ("reduce", "identify") else "",
        "loads": WORDS["--wrench"](rng, place)[0] if verb == "identify" else "",
        "tool": rng.choice(place.names.links or ("ghost",)) if verb == "springs" else "",
        "first": (*place.names.inputs, "ghost")[0],
        "folder": str(place.folder),
    }
    return [word.format(**names) for word in needed(verb, picked)]


def _model(rng: random.Random, folder: Path) -> str:
    """A model of the gallery, a small linkage, a mutant, or nothing that can be read."""
    kind = rng.random()
    if kind < 0.5:
        name = rng.choice(sorted(gallery()))
        return "four_bar_kite" if name in LARGE and rng.random() < 0.8 else name
    if kind < 0.8:
        return str(small_linkage(rng, folder / f"small_{rng.randrange(10**9)}.urdf"))
    if kind < 0.95:
        return str(written(mutant(rng.randrange(10**6)), folder))
    return rng.choice((*ODD, str(folder), str(folder / "none.urdf"), "ur5", "/"))


def run(seeds: range, limit: float = LIMIT):
    """Run requests; yields the seed, the words and how each ends, or what is wrong."""
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            names_of.cache_clear()
            words = request(seed, Path(folder))
            try:
                with time_limit(limit):
                    end, wrong = check(words, asked(words)), ""
            except Exception as error:
                end, wrong = "wrong", f"{type(error).__name__}: {str(error)[:1500]}"
        yield seed, words, end, wrong


def run_from_command_line(
    description: str | None, count: int, run: Callable[[range], Iterable[tuple[int, str, str]]]
) -> int:
    """Run the cases that the command line asks for, and print how they ended.

    Args:
        description: of the command.
        count: number of cases by default.
        run: yields seed, end, and what went wrong or nothing, of the cases of some seeds.

    Returns:
        The exit code: 1 if a case went wrong.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--cases", type=int, default=count)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    options = parser.parse_args()
    begin, counts, slowest = time.perf_counter(), Counter(), (0.0, -1)
    last = begin
    for seed, end, wrong in run(range(options.seed, options.seed + options.cases)):
        counts[end] += 1
        now = time.perf_counter()
        slowest, last = max(slowest, (now - last, seed)), now
        if wrong:
            print(f"seed {seed}: {wrong}", flush=True)
    print(
        f"{options.cases} requests from seed {options.seed} in {last - begin:.0f} s, "
        f"{counts['wrong']} wrong; slowest: seed {slowest[1]}, {slowest[0]:.1f} s"
    )
    print("  ".join(f"{name} ×{count}" for name, count in sorted(counts.items())))
    return 1 if counts["wrong"] else 0


def main() -> int:
    """Run cases from the command line."""
    return run_from_command_line(
        __doc__,
        500,
        lambda seeds: (
            (seed, end, wrong and f"balance {shlex.join(words)!r}\n  {wrong}")
            for seed, words, end, wrong in run(seeds)
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
