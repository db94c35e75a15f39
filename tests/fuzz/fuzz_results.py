"""Requests with damaged files of results, changed studies and random topologies.

``python -m tests.fuzz.fuzz_results --cases 50000 --seed 0`` runs as many as it is told, in this
process; a seed stands for the case that follows it.
"""

from __future__ import annotations

import random
import shlex
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from balance.studies.runs import chunk_runs
from balance.studies.runs.results_file import ResultsFile
from tests.fuzz.random_requests import check, run_from_command_line
from tests.fuzz.results_mutants import SEARCH, write_mutant
from tests.fuzz.study_mutants import random_topology, study_text
from tests.fuzz.sweep_words import STUDY
from tests.support.command_runs import asked
from tests.support.time_limit import time_limit

# Seconds after which a case hangs.
LIMIT = 120.0
# Chunks that a run computes: a changed study may have millions of them.
CHUNKS = 2
MODELS = ("slider_crank", "five_bar", "four_bar_kite", "rusr", "scissor_single", "ghost", "")
COLUMNS = ("rank", "row", "reason", "rocker.length", "closed", "outcome", "margin", "ghost", "")


def words_of(seed: int, folder: Path) -> tuple[list[str], str]:
    """The words of one request, and what was damaged; everything follows from the seed."""
    rng = random.Random(seed)
    kind = rng.choice(("results", "results", "results", "study", "study", "topology"))
    if kind == "results":
        return _results_words(rng, folder)
    if kind == "study":
        path = folder / "study.toml"
        path.write_bytes(study_text(rng))
        words = ["sweep", "run", str(path), "--workers", "1"]
        return words, path.read_text(encoding="utf-8", errors="replace")
    return _topology_words(rng, folder), ""


def _results_words(rng: random.Random, folder: Path) -> tuple[list[str], str]:
    """A request for a damaged file: by the verb it is for, or by the other one."""
    kind, path = rng.choice(("sweep", "search")), folder / "results.db"
    damages = write_mutant(rng, path, kind)
    file, column = str(path), rng.choice(COLUMNS)
    shown = rng.choice(
        (
            [],
            [],
            ["--sort", column],
            ["--sort", column, "--descending"],
            ["--html", str(folder / "page.html")],
            ["--plot", f"{column},{rng.choice(COLUMNS)}", "--out", str(folder / "a.svg")],
        )
    )
    study = folder / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    sweep = (
        ["sweep", "show", file, *shown],
        ["sweep", "show", file, *shown],
        ["sweep", "export", file, "--out", str(folder / rng.choice(("a.csv", "a.parquet")))],
        ["sweep", "run", str(study), "--out", file, "--resume", "--workers", "1"],
    )
    page = ["--html", str(folder / "page.html")] if rng.random() < 0.1 else []
    show = ["discover", "show", file, "--members", "2", "--tried", rng.choice("001"), *page]
    search = (
        show,
        show,
        ["discover", "export", file, "--family", "1", "--out", str(folder / "a.urdf")],
        [
            "discover",
            "run",
            "--topology",
            SEARCH.name,
            "--starts",
            str(SEARCH.starts),
            "--out",
            file,
            "--resume",
            "--workers",
            "0",
        ],
    )
    own, other = (sweep, search) if kind == "sweep" else (search, sweep)
    return rng.choice(own if rng.random() < 0.85 else other), "; ".join(damages)


def _topology_words(rng: random.Random, folder: Path) -> list[str]:
    """A request with a random topology, or the topology of a model."""
    topology = random_topology(rng)
    buildable = ["--buildable"] * (rng.random() < 0.2)
    if rng.random() < 0.5:
        return ["discover", "walk", f"--topology={topology}", "--start", "0", *buildable]
    given = rng.choice((["--model", rng.choice(MODELS)], *[[f"--topology={topology}"]] * 3))
    return [
        "discover",
        "run",
        *given,
        "--starts",
        "1",
        "--workers",
        "0",
        "--out",
        str(folder / "search.db"),
        *buildable,
    ]


@contextmanager
def in_this_process() -> Iterator[None]:
    """Compute the first chunks of every run in this process."""
    original, pending = chunk_runs.run_chunks, ResultsFile.pending

    def run_here(*arguments: Any, **options: Any) -> Any:
        return original(*arguments, **options | {"workers": 0})

    chunk_runs.run_chunks = run_here
    ResultsFile.pending = lambda file: islice(pending(file), CHUNKS)
    try:
        yield
    finally:
        chunk_runs.run_chunks, ResultsFile.pending = original, pending


def run(seeds: Iterable[int], limit: float = LIMIT) -> Iterator[tuple[int, str, str]]:
    """Run the cases of some seeds: the seed, how it ends, and what is wrong."""
    for seed in seeds:
        with tempfile.TemporaryDirectory() as name, in_this_process():
            words, damage = words_of(seed, Path(name))
            words += ["--json"] * (seed % 3 > 0)
            try:
                with time_limit(limit):
                    done = asked(words)
                    check(words, done)
                end, wrong = f"{words[0]} {words[1]}: {done.code}", ""
            except Exception as error:
                told = f"balance {shlex.join(words)}\n  {damage[:2000]!r}"
                end, wrong = "wrong", f"{told}\n  {type(error).__name__}: {str(error)[:1500]}"
        yield seed, end, wrong


def main() -> int:
    """Run cases from the command line."""
    return run_from_command_line(__doc__, 1000, run)


if __name__ == "__main__":
    sys.exit(main())
