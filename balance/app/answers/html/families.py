"""HTML page of the families that a search has found: a table, and a moving member of each."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from balance.app.answers.html.render import facts_list, html_table, model_section, render_page
from balance.app.answers.html.scene import scene
from balance.app.answers.text.discovery import exact_words, range_words, search_facts
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.search_results import ExaminedFamily
from balance.studies.discovery.to_linkage import to_linkage
from kinematics.errors import LinkageError
from kinematics.model.linkage import Linkage
from kinematics.wording import count_noun

HEAD = (
    "Family",
    "Relations",
    "Walks",
    "Nullity",
    "Codimension",
    "Members",
    "Masses",
    "Motion of the member drawn",
)


def families_page(
    job: DiscoveryJob, data: dict[str, Any], examined: Sequence[ExaminedFamily]
) -> str:
    """Render the families of a search as one HTML file.

    Args:
        data: what ``discover show --json`` prints; the element ``report`` holds it.
        examined: the families, in the same order.

    Returns:
        The text of the file.
    """
    scenes = [scene(_linkage(job, family)) for family in examined]
    count = count_noun(len(examined), "family") if examined else "no family"
    return render_page(
        "families.html",
        title=f"Special geometries: {data['topology']}",
        summary=f"Geometries of this topology whose design space is larger than elsewhere: "
        f"{count} found.",
        report=data,
        data={"scenes": scenes},
        scripts=["families"],
        facts=facts_list(search_facts(data, job.topology)),
        families=html_table(HEAD, [_row(entry) for entry in data["families"]], (2, 3, 4)),
        models="\n".join(_model(entry) for entry in data["families"]),
    )


def _linkage(job: DiscoveryJob, family: ExaminedFamily) -> Linkage:
    """Build the member to draw, driven by the joint of its range of motion if that works."""
    if family.motion is not None:
        try:
            return to_linkage(
                job.topology, job.structure, family.shown, inputs=[family.motion.joint]
            )
        except LinkageError:
            pass
    return to_linkage(job.topology, job.structure, family.shown)


def _row(entry: dict[str, Any]) -> list[str]:
    """Render the cells of one family."""
    pairs = zip(entry["relations"], entry["words"], strict=True)
    relations = [f"<b>{escape(text)}</b>: {escape(words)}" for text, words in pairs]
    relations += [f"and so {escape(text)}" for text in entry["implied"]]
    missing = entry["codimension"] - len(entry["relations"])
    if missing > 0:
        relations.append(f"and {missing} that no simple relation explains")
    items = "".join(f"<li>{line}</li>" for line in relations)
    return [
        str(entry["family"]),
        f"<ul>{items}</ul>",
        str(entry["members"]),
        f"{entry['nullity']} ({entry['nullity'] - entry['parallel']} elsewhere)",
        str(entry["codimension"]),
        f"{entry['confirmed']} of {entry['tried']} random ones confirm it; exact: "
        + escape(exact_words(entry)),
        escape(_verdict(entry["verdicts"])),
        escape(range_words(entry["motion"])),
    ]


def _verdict(verdicts: dict[str, int]) -> str:
    """Say for how many of the members tried masses can be built."""
    tried = sum(verdicts.values())
    if not tried:
        return "not tried"
    good = verdicts.get("feasible", 0)
    others = [
        f"{n} {name}" for name, n in verdicts.items() if name not in ("feasible", "infeasible")
    ]
    said = "buildable: " if good else "none buildable: "
    return f"{said}{good} of {tried} members" + "".join(f", {text}" for text in others)


def _model(entry: dict[str, Any]) -> str:
    """Render the places for the drawing and the sliders of one family."""
    label, text = f"Family {entry['family']}", escape(", ".join(entry["relations"]))
    note = f'<p class="note">{text}</p>\n'
    return model_section(entry["family"] - 1, label, f"A member of {label}", note)
