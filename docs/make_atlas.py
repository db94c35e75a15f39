"""Make the atlas of special geometries: ``docs/atlas.md`` and its figures.

``python docs/make_atlas.py --work FOLDER`` searches every topology, keeps the results in
FOLDER, from which an interrupted run goes on, and writes ``docs/atlas.md`` and its figures.
Seeds are fixed, so that another run finds the same. What is known about who described a family
first is in `atlas_sources`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from atlas_figure import member_figure
from atlas_sources import FIRST, HEAD, SOURCES

from balance.app.answers.text.discovery import families_data, range_words
from balance.masses.designs.best_design import design
from balance.space.spaces.compute_space import design_space
from balance.studies.discovery.families import Family
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.search_results import (
    ExaminedFamily,
    SearchResults,
    examine,
    read_search,
)
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import Topology
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from balance.support.atomic_files import write_all_atomic
from kinematics.errors import LinkageError
from kinematics.wording import count_noun

DOCS = Path(__file__).parent
SEED = 1
# Random members that confirm the relations, and those that masses are looked for.
MEMBERS, TRIED = 100, 20
HEAVIEST = 1e4  # kg, of the coupler
# Part of the random members that are special if the relations describe the family.
CONFIRMED = 0.9


@dataclass(frozen=True)
class Chapter:
    """A topology of the atlas.

    Attributes:
        name: the topology.
        title: heading.
        starts: walks to any special geometry.
        buildable: walks to those that masses balance which can be built.
    """

    name: str
    title: str
    starts: int
    buildable: int


CHAPTERS = (
    Chapter("four-bar", "Four-bar", 300, 100),
    Chapter("slider-crank", "Slider-crank", 300, 100),
    Chapter("geared-five-bar", "Five-bar with two gears", 300, 100),
    Chapter("watt1", "Watt I", 1000, 200),
    Chapter("watt2", "Watt II", 1000, 200),
    Chapter("stephenson1", "Stephenson I", 1000, 200),
    Chapter("stephenson2", "Stephenson II", 1000, 200),
    Chapter("stephenson3", "Stephenson III", 1000, 200),
    Chapter("spherical-four-bar", "Spherical four-bar", 300, 0),
    Chapter("r-u-s-r", "Spatial four-bar R-U-S-R", 300, 0),
    Chapter("3-rsr", "3-RSR", 100, 0),
)


def search(folder: Path, job: DiscoveryJob, workers: int, kept: bool) -> SearchResults:
    """Run a search, or go on with its file, or take that as it is; return what it found."""
    kind = "buildable" if job.buildable else "any"
    path = folder / f"{job.name}_{kind}_{job.starts}.db"
    with ResultsFile.open(path) if kept else ResultsFile.resume(path, job) as file:
        if not kept:
            run_chunks(job, file, workers=workers)
        return read_search(file)


def families_of(searches: list[SearchResults]) -> list[tuple[SearchResults, Family]]:
    """List the families of several searches, each once."""
    chosen: dict[object, tuple[SearchResults, Family]] = {}
    for found in searches:
        for family in found.families:
            chosen.setdefault(family.members[0].key, (found, family))
    return list(chosen.values())


def coupler_of(graph: Topology) -> int:
    """Return the link that carries the load: off the ground, with the most joints."""
    ground = {x for _, a, b in graph.edges if 0 in (a, b) for x in (a, b)}
    free = [link for link in range(1, graph.links) if link not in ground]
    return max(free, key=lambda link: (len(graph.joints_of(link)), -link))


def least_mass(job: DiscoveryJob, found: ExaminedFamily) -> str:
    """Compute the least mass of the drawn member whose coupler has 1 kg, as words."""
    if not found.verdicts.get("feasible"):
        return ""
    coupler = f"link{coupler_of(job.topology)}"
    try:
        space = design_space(to_linkage(job.topology, job.structure, found.shown))
        best = design(space, "mass", bounds={coupler: (1.0, HEAVIEST)}, density=None)
    except LinkageError:
        return ""
    if best.z is None:
        return f"none with 1 kg on {coupler}"
    total = sum(body.mass for body in best.bodies)
    return f"{total:.3g} kg with 1 kg on {coupler}"


def first_described(graph: Topology, family: Family) -> str:
    """Say who described a family first, if that is known."""
    for name, relations, nullity, text in FIRST:
        if name == graph.name and nullity == family.nullity:
            sets = [
                {image_text(graph, order, r) for r in relations} for order in _orders(graph)
            ]
            if set(family.relations) in sets:
                return text
    return "not found in the sources that were searched"


def _orders(graph: Topology) -> list[tuple[int, ...]]:
    """List the symmetries of a graph, the identity first."""
    return [tuple(range(len(graph.edges))), *graph.symmetries()]


def image_text(graph: Topology, order: tuple[int, ...], relation: str) -> str:
    """Apply a symmetry to an equation of two lengths, and write it as relations are written."""
    pairs = []
    for side in relation.split(" = "):
        a, b = sorted(order[ord(letter) - 65] for letter in side)
        pairs.append((a, b))
    place = {(a, b): k for k, (a, b) in enumerate(_lengths(graph))}
    pairs.sort(key=lambda pair: place.get(pair, 0))
    return " = ".join("".join(chr(65 + k) for k in pair) for pair in pairs)


def _lengths(graph: Topology) -> list[tuple[int, int]]:
    """List the pairs of joints on one link, in the order of the relations."""
    return [pair for x in range(graph.links) for pair in combinations(graph.joints_of(x), 2)]


def chapter(
    entry: Chapter, folder: Path, workers: int, kept: bool = False
) -> tuple[str, dict[str, bytes]]:
    """Search one topology; return its text and figures."""
    jobs = [DiscoveryJob(entry.name, entry.starts, SEED)]
    if entry.buildable:
        jobs.append(DiscoveryJob(entry.name, entry.buildable, SEED, buildable=True))
    searches = [search(folder, job, workers, kept) for job in jobs]
    job, graph = jobs[0], jobs[0].topology
    lines = [f"## {entry.title}", "", *_facts(searches), ""]
    figures: dict[str, bytes] = {}
    listed = [
        examine(job, family, members=MEMBERS, tried=TRIED)
        for _, family in families_of(searches)
    ]
    for number, found in enumerate(filter(described, listed), 1):
        name = f"{entry.name.replace('-', '_')}_{number}.svg"
        figures[name] = member_figure(graph, job.structure, found.shown).encode()
        lines += [f"### {entry.title}, family {number}", ""]
        lines += [f"![A member of family {number} of {entry.title}](atlas/{name})", ""]
        lines += [*_family_lines(job, found), ""]
    others = [found.family for found in listed if not described(found)]
    if others:
        ends = ", ".join(f"{count_noun(len(f.members), 'walk')} to {f.nullity}" for f in others)
        lines += [f"No simple relations describe the ends of others, by nullity: {ends}.", ""]
    if not listed:
        lines += ["No family was found.", ""]
    print(f"{entry.title}: {count_noun(len(figures), 'family')}", flush=True)
    return "\n".join(lines), figures


def described(found: ExaminedFamily) -> bool:
    """Whether the relations describe a family: nearly all random members are special."""
    agreed, members = found.confirmation.agreed, found.confirmation.members
    return found.family.complete and members > 0 and agreed >= CONFIRMED * members


def _facts(searches: list[SearchResults]) -> list[str]:
    """Write the graph, and what became of the walks."""
    job = searches[0].job
    joints = ", ".join(
        f"{chr(65 + k)} {kind} {a}-{b}" for k, (kind, a, b) in enumerate(job.topology.edges)
    )
    lines = [
        f"Joints {joints}; link 0 is the ground. Most geometries have nullity {job.generic}."
    ]
    for found in searches:
        to = "to masses that can be built" if found.job.buildable else "to any special geometry"
        ends = ", ".join(f"{count} {name}" for name, count in found.outcomes.items())
        lines += ["", f"{sum(found.outcomes.values())} walks {to}: {ends}."]
    return lines


def _family_lines(job: DiscoveryJob, found: ExaminedFamily) -> list[str]:
    """Write one family as a table of two columns."""
    family = found.family
    data = {"families": [{}]}
    (entry,) = families_data(data, [found])["families"]
    good = found.verdicts.get("feasible", 0)
    rows = [
        ("relations", "<br>".join(family.relations)),
        ("nullity", f"{family.nullity}, {family.parallel} more than elsewhere"),
        ("codimension", str(family.codimension)),
        ("walks that ended in it", str(len(family.members))),
        (
            "random members that confirm it",
            f"{found.confirmation.agreed} of {found.confirmation.members}",
        ),
        ("masses", f"can be built for {good} of {TRIED} random members"),
        ("least mass", least_mass(job, found)),
        ("motion of the member drawn", range_words(entry["motion"])),
        ("first described by", first_described(job.topology, family)),
    ]
    return ["| | |", "|---|---|", *(f"| {label} | {text} |" for label, text in rows if text)]


def main() -> None:
    """Write the atlas."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", type=Path, required=True, help="folder of the searches")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of atlas.md")
    parser.add_argument("--workers", type=int, default=1, help="processes (0: this one alone)")
    parser.add_argument(
        "--kept",
        action="store_true",
        help="take the searches in the folder as they are, by whatever version",
    )
    parser.add_argument("--only", nargs="*", help="names of topologies; all by default")
    words = parser.parse_args()
    words.work.mkdir(parents=True, exist_ok=True)
    (words.out / "atlas").mkdir(parents=True, exist_ok=True)
    texts, figures = [HEAD], {}
    for entry in CHAPTERS:
        if not words.only or entry.name in words.only:
            text, drawn = chapter(entry, words.work, words.workers, words.kept)
            texts.append(text)
            figures |= drawn
    texts.append(SOURCES)
    contents = [(str(words.out / "atlas.md"), ("\n".join(texts)).encode())]
    contents += [(str(words.out / "atlas" / name), svg) for name, svg in figures.items()]
    write_all_atomic(contents)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
