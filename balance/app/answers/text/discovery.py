"""Data and text of ``balance discover``: what a search did and found."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from balance.app.answers.answer import AnswerBody, Facts
from balance.space.requirements.requirement import read_requirements
from balance.studies.discovery.export import ExportedMember
from balance.studies.discovery.families import Family
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.motion_range import MotionRange
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.search_results import ExaminedFamily, SearchResults
from balance.studies.discovery.topologies import Topology
from balance.studies.runs.results_file import ResultsFile
from kinematics.wording import count_noun, number_text

SCHEMA = "balance.discover/1"
# Least width of the labels of facts.
LABELS = 13
# What a search counts in which no moments of inertia are.
MASSES = "; nullity counts masses and centres of mass"
Data = dict[str, Any]


def search_data(
    file: ResultsFile, search: SearchResults, seconds: float | None, what: str = "run"
) -> Data:
    """Collect the facts on a search.

    Args:
        search: what it has found so far.
        seconds: duration of this run; None if nothing was run.
    """
    data = {
        "schema": SCHEMA,
        "what": what,
        "file": file.path,
        "topology": search.job.name,
        "starts": file.rows,
        "walked": file.computed()[0],
        "seed": search.job.seed,
        "buildable": search.job.buildable,
        "near": bool(search.job.origin),
        "require": search.job.require,
        "nullity": search.job.generic - search.job.structure.uncounted,
        "outcomes": search.outcomes,
        "families": [_family_data(k, f, search.job) for k, f in enumerate(search.families, 1)],
    }
    if seconds is not None:
        data["seconds"] = seconds
    return data


def _family_data(number: int, family: Family, job: DiscoveryJob) -> Data:
    """Collect the facts on a family."""
    quantities = quantities_of(family.topology)
    words = [relation.words(quantities) for relation in family.members[0].relations]
    return {
        "family": number,
        "nullity": family.nullity - job.structure.uncounted,
        "parallel": family.parallel,
        "codimension": family.codimension,
        "relations": list(family.relations),
        "words": words,
        "implied": list(family.implied),
        "complete": family.complete,
        "members": len(family.members),
        "buildable": sum(member.margin > 0.0 for member in family.members),
        "starts": [member.start for member in family.members[:10]],
    }


def families_data(data: Data, examined: list[ExaminedFamily]) -> Data:
    """Add what random members show to the facts on a search.

    Args:
        data: from `search_data`.
        examined: the families, in the same order.
    """
    for entry, more in zip(data["families"], examined, strict=True):
        entry["confirmed"] = more.confirmation.agreed
        entry["tried"] = more.confirmation.members
        entry["serial"] = more.serial
        entry["verdicts"] = more.verdicts
        entry["motion"] = _range_data(more.motion)
        entry["exact"] = more.exact._asdict()
    return data


def _range_data(span: MotionRange | None) -> Data | None:
    """Collect the facts on a range of motion; None if there is none."""
    return None if span is None else asdict(span)


def exact_words(entry: Data) -> str:
    """Say what exact arithmetic says on the relations of a family.

    Args:
        entry: one of the families of `families_data`.
    """
    exact = entry["exact"]
    if exact["reason"]:
        return f"not decided: {exact['reason']}"
    if not exact["enough"]:
        return "these relations alone do not give this nullity"
    words = f"these relations give nullity {entry['nullity']} for general lengths"
    words += ", and no equality of lengths or angles can be left out" * exact["needed"]
    return words + f"; masses can be built {exact['buildable']}" * bool(exact["buildable"])


def range_words(motion: Data | None) -> str:
    """Say a range of motion in words.

    Args:
        motion: from `families_data`.
    """
    if motion is None:
        return "several degrees of freedom; no range was computed"
    if motion["full"]:
        return f"{motion['joint']} turns fully"
    low, high = (f"{number_text(motion[k], '.0f')}°".replace("-", "−") for k in ("low", "high"))
    size = f"{number_text(motion['high'] - motion['low'], '.0f')}°"
    ends = [end for end in motion["ends"] if end]
    kinds = " and ".join(dict.fromkeys(f"a {end}" for end in ends))
    until = f", to {kinds}" if kinds else ""
    return f"{motion['joint']} from {low} to {high} ({size}){until}"


def required_facts(require: str) -> list[tuple[str, str]]:
    """Say what a search requires, but for dynamic balance.

    Args:
        require: the requirements.
    """
    if require == "dynamic":
        return []
    masses = all(item.masses_alone for item in read_requirements(require))
    words = "force balance" if require == "force" else require
    return [("required", words + MASSES * masses)]


def search_body(data: Data, topology: Topology) -> AnswerBody:
    """Build what is printed on what a search has found.

    Args:
        data: from `search_data`.
    """
    count = ("families", str(len(data["families"]) or "none"))
    families = (line for entry in data["families"] for line in ("", *_family_lines(entry)))
    return [Facts([*search_facts(data, topology), count], LABELS), *families, ""]


def search_facts(data: Data, topology: Topology) -> list[tuple[str, str]]:
    """List the facts on a search: labels and values.

    Args:
        data: from `search_data`.
    """
    joints = ", ".join(
        f"{chr(65 + k)} {kind} {a}-{b}" for k, (kind, a, b) in enumerate(topology.edges)
    )
    outcomes = ", ".join(f"{count} {name}" for name, count in data["outcomes"].items())
    walked = f"{data['walked']} of {data['starts']}, seed {data['seed']}"
    pairs = [
        ("topology", data["topology"]),
        ("joints", f"{joints} (link 0 is the ground)"),
        ("walks", walked + ", to masses that can be built" * data["buildable"]),
        *required_facts(data["require"]),
        ("starts", "the model and changes of it" if data["near"] else "anywhere"),
        ("ends", outcomes or "none yet"),
        ("elsewhere", f"most geometries have nullity {data['nullity']}"),
    ]
    if "seconds" in data:
        pairs.append(("time", f"{data['seconds']:.1f} s"))
    return pairs


def _family_lines(entry: Data) -> list[str]:
    """Write one family."""
    head = (
        f"family {entry['family']}: nullity {entry['nullity']}, {entry['parallel']} more than "
        f"elsewhere; codimension {entry['codimension']}; "
        f"{count_noun(entry['members'], 'walk')}, {entry['buildable']} to masses that can be "
        "built"
    )
    lines = [head, *(f"  {relation}" for relation in entry["relations"])]
    lines += [f"  and so {relation}" for relation in entry["implied"]]
    if not entry["complete"]:
        missing = entry["codimension"] - len(entry["relations"])
        lines.append(f"  and {missing} that no simple relation explains")
    if "confirmed" in entry:
        lines.append(f"  confirmed by {entry['confirmed']} of {entry['tried']} random members")
        lines.append(f"  exact: {exact_words(entry)}")
        verdicts = ", ".join(f"{n} {name}" for name, n in entry["verdicts"].items())
        lines.append(f"  masses: {verdicts or 'not tried'}")
        which = "a member with masses" if "feasible" in entry["verdicts"] else "a member"
        lines.append(f"  motion of {which}: {range_words(entry['motion'])}")
    return lines


def member_data(number: int, path: str, member: ExportedMember) -> Data:
    """Collect the facts on an exported member."""
    certainty = getattr(member.space, "certainty", None)
    return {
        "schema": SCHEMA,
        "what": "export",
        "family": number,
        "out": path,
        "rational": member.rational,
        "nullity": member.space.nullity,
        "serial": member.space.serial_nullity,
        "certainty": "estimated" if certainty is None else str(certainty.level),
        "reason": "by floating point alone" if certainty is None else certainty.reason,
        "verdict": member.design.verdict,
        "words": member.design.words,
        "balanced": member.balanced,
    }


def member_body(data: Data) -> AnswerBody:
    """Build what is printed on an exported member.

    Args:
        data: from `member_data`.
    """
    verified = {None: "no masses to verify", True: "balanced", False: "not balanced"}
    kind = "rational coordinates" if data["rational"] else "coordinates that are not rational"
    serial = f"{data['serial']} serial + {data['nullity'] - data['serial']} parallel"
    pairs = [
        ("family", str(data["family"])),
        ("file", f"{data['out']}, {kind}"),
        ("design space", f"{data['nullity']}: {serial}"),
        ("certainty", f"{data['certainty']}: {data['reason']}"),
        ("masses", data["words"]),
        ("verified", verified[data["balanced"]]),
    ]
    return [Facts(pairs, LABELS), ""]
