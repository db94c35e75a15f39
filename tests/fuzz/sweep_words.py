"""Studies, files of their results, and requests for them, good and bad."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import balance
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile

# The kite itself, general four-bars beside it, and one that does not close.
LENGTHS = (0.8, 0.9, 1.0, 1.1, 3.0)
STUDY = f"""
[model]
file = "four_bar_kite"
[parameters]
"rocker.length" = {list(LENGTHS)}
[run]
chunk_rows = 2
"""


def sweep_files(words: Sequence[str], folder: Path) -> dict[str, Path]:
    """The files named as ``{study}``, ``{results}`` or ``{search}``, written if words do."""
    study, results, search = (folder / n for n in ("study.toml", "results.db", "search.db"))
    study.write_text(STUDY, encoding="utf-8")
    if "{results}" in words:
        job = balance.studies.read_study(study).job()
        with ResultsFile.create(results, job) as file:
            run_chunks(job, file, workers=0)
    if "{search}" in words:
        job = DiscoveryJob("slider-crank", 30)
        with ResultsFile.create(search, job) as file:
            file.write_chunk(0, walks())
    return {"study": study, "results": results, "search": search}


@cache
def walks() -> Mapping[str, Any]:
    """What the walks of the search find; they fit into one chunk."""
    return DiscoveryJob("slider-crank", 30).compute(0)


def sweep_words(rng: random.Random, folder: Path, odd: Sequence[str]) -> list[str]:
    """A study, and a request for it or for a file of results that may not be there."""
    study, file = folder / rng.choice(("study.toml", "ä b.toml")), folder / "study.db"
    end = rng.choice(("0.9", "1.2", "nan", "-1", "1e400"))
    ranges = rng.choice(
        (
            f'"0.8:{end}:{rng.choice((1, 3, 0, 10**13))}"',
            "[0.8, 0.9]",
            "{uniform = [0.8, 1]}",
            f"[{end}]",
            '"x"',
        )
    )
    path = rng.choice(("rocker.length", "q4.origin.x", "ghost.length", "coupler.length"))
    lines = ["[model]", 'file = "four_bar_kite"', "[parameters]", f'"{path}" = {ranges}']
    lines += ["[sampling]", "count = 3"] * ("uniform" in ranges)
    lines += [rng.choice(odd)] * (rng.random() < 0.05)
    study.write_text("\n".join(lines), encoding="utf-8", errors="replace")
    run = ["run", str(study if rng.random() < 0.95 else folder), "--out", str(file)]
    run += ["--workers", rng.choice(("1", "1", "2", "0", "-1"))]
    run += ["--resume"] * (rng.random() < 0.5)
    if rng.random() < 0.3:
        run[1] = "four_bar_kite"
        run += ["--vary", f"{path}={rng.choice((f'0.8:{end}:3', f'0.8,{end}', '', 'x'))}"]
        best = rng.choice(("rank={0}/b.urdf", "max:kmax={0}/b.urdf", "ghost={0}/c", ""))
        run += ["--best", best.format(folder)]
        run += rng.choice(([], ["--counterweights", "crank"], ["--set", "run.chunk_rows=0"]))
    column = rng.choice(("rank", "row", "reason", path, "ghost", ""))
    show = ["show", str(rng.choice((file, study, folder)))]
    show += rng.choice(
        (
            [],
            ["--sort", column],
            ["--descending"],
            ["--count", "x"],
            ["--plot", f"{column},rank", "--out", str(folder / "a.svg")],
            ["--html", str(folder / "page.html")],
        )
    )
    out = folder / rng.choice(("a.csv", "a.parquet", "a.xls", "no/a.csv"))
    words = rng.choice((run, run, show, ["export", str(file), "--out", str(out)]))
    if words is not run and rng.random() < 0.5:
        file.write_bytes(b"") if rng.random() < 0.3 else sweep_file(folder, file)
    return ["sweep", *words]


def sweep_file(folder: Path, file: Path) -> None:
    """Put a file of results where a request looks for it."""
    sweep_files(["{results}"], folder)["results"].rename(file)
