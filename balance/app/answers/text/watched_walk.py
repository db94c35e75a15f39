"""Data and text of ``balance discover walk``: the steps of one walk."""

from __future__ import annotations

from itertools import zip_longest
from typing import Any

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.app.answers.text.discovery import LABELS, SCHEMA, required_facts
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.watch import WatchedWalk
from kinematics.wording import size_text

Data = dict[str, Any]

BUILDABLE = ", to masses that can be built"


def walk_data(walk: WatchedWalk) -> Data:
    """Collect the facts on a walk."""
    quantities = quantities_of(walk.job.topology)
    return {
        "schema": SCHEMA,
        "what": "walk",
        "topology": walk.job.name,
        "seed": walk.job.seed,
        "buildable": walk.job.buildable,
        "require": walk.job.require,
        "start": walk.start,
        "outcome": walk.outcome,
        "generic": walk.job.generic - walk.job.structure.uncounted,
        "nullity": max(walk.nullity - walk.job.structure.uncounted, -1),
        "codimension": walk.codimension,
        "relations": [relation.text(quantities) for relation in walk.relations],
        "words": [relation.words(quantities) for relation in walk.relations],
        "polished": walk.polished,
        "ratios": walk.ratios.tolist(),
        "falling": walk.falling.tolist(),
        "points": walk.geometry.points.tolist(),
        "axes": walk.geometry.axes.tolist(),
    }


def walk_facts(data: Data) -> list[tuple[str, str]]:
    """List the facts on a walk: labels and values.

    Args:
        data: from `walk_data`.
    """
    end = data["outcome"]
    if end == "special":
        end = (
            f"special: nullity {data['nullity']} instead of {data['generic']}, "
            f"codimension {data['codimension']}"
        )
    steps = len(data["ratios"]) - 1 - data["polished"]
    start = f"{data['start']}, seed {data['seed']}" + BUILDABLE * data["buildable"]
    pairs = [
        ("topology", data["topology"]),
        ("start", start),
        *required_facts(data["require"]),
        ("steps", f"{steps}{', and the polished end' if data['polished'] else ''}"),
        ("end", end),
    ]
    told = zip(data["relations"], data["words"], strict=True)
    return pairs + [("relation", f"{text}: {words}") for text, words in told]


def walk_body(data: Data) -> AnswerBody:
    """Build what is printed on a walk: its facts, and the singular value of each step.

    Args:
        data: from `walk_data`.
    """
    columns = [
        ["step", *map(str, range(len(data["ratios"])))],
        ["s_min/s_max", *(size_text(ratio, ".2e") for ratio in data["ratios"])],
    ]
    if data["polished"]:
        columns[0][-1] = "polished"
    if data["buildable"]:
        columns.append(["momentum", *(size_text(size, ".2e") for size in data["falling"])])
    rows = list(zip_longest(*columns, fillvalue=""))
    return [Facts(walk_facts(data), LABELS), "", AnswerTable(rows, "><", least=8), ""]
