"""Remedy: a relation between inputs, under which the linkage balances with fewer freedoms."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.constraints.relation_candidates import LARGEST, count_candidates
from balance.masses.remedies.constraints.relation_search import (
    InputRelation,
    free_inputs,
    search_relations,
)
from balance.masses.remedies.constraints.relation_words import inertia_needs, turning_ratios
from balance.masses.remedies.judge import judge, verify_file
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from kinematics.files.urdf.edit_xml import Splice, Text
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import element_lines, number_words

KEY = "input_relation"
# Most inputs whose relations are tried unasked.
MOST_INPUTS = 6
# Most relations that are judged: each takes a search for least matter.
MOST_JUDGED = 3


def apply_input_relation(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by relations between its inputs, ``a u_i = b u_j`` with |a|, |b| ≤ 3.

    Relations of two inputs become mimic joints in the file. Others need a gear or a slider; the
    file is that of the linkage, and the relation is an option of the command.

    Yields:
        A result for each of the first relations that leave the most freedoms; those that
        balance the masses of the file come first.
    """
    if request.freedoms < 2:
        yield refused(KEY, "the linkage has one freedom: a relation would leave none")
        return
    if feasible(request.space).verdict == "feasible":
        yield refused(KEY, "no relation is needed: masses of its own links balance the linkage")
        return
    names, _ = free_inputs(request)
    if len(names) > MOST_INPUTS and KEY not in request.only:
        count = count_candidates(len(names))
        parameters = request.space.rank + request.space.nullity
        reason = (
            f"{count} relations of {len(names)} inputs are too many to try unasked, each a "
            f"design space of {parameters} parameters: --only {KEY} tries them"
        )
        yield refused(KEY, reason)
        return
    search = search_relations(request)
    if not search.balanced:
        verdict = "undecided" if search.undecided else "infeasible"
        doubt = f"; {search.undecided} undecided" if search.undecided else ""
        reason = (
            f"no masses whatever under any of {search.tried} relations with whole numbers up "
            f"to {LARGEST}{doubt}"
        )
        yield replace(refused(KEY, reason), verdict=verdict)  # type: ignore[arg-type]
        return
    for relation in search.balanced[:MOST_JUDGED]:
        others = [
            alternative.words for alternative in search.balanced if alternative is not relation
        ]
        yield _judge(request, relation, others)


def _judge(
    request: RemedyRequest, relation: InputRelation, others: list[tuple[str, ...]]
) -> AppliedRemedy:
    """Judge the linkage under one relation."""
    needs = [str(need) for need in inertia_needs(relation.space)]
    ratios = turning_ratios(relation.space)
    driven = _driven(request, relation)
    details = {
        "relations": list(relation.words),
        "built_as": "mimic" if driven is not None else "gear or slider",
        "motion": [] if driven is not None else list(relation.words),
        "needs": needs,
        "turning_ratios": ratios,
        "other_relations": [list(words) for words in others],
    }
    words = ", ".join(relation.words)
    if ratios is not None:
        turning = ", ".join(f"{name} {x:g}" for name, x in ratios.items())
        words += f" (angular velocities: {turning})"
    inputs = tuple(x for x in request.linkage.inputs if x not in (driven or {}))
    base = request.base if driven is None else _with_mimics(request.base, driven)
    motion = relation.words if driven is None else ()
    if relation.space.as_given.balanced:
        blank = AppliedRemedy(KEY, words, "undecided", "", details=details)
        result = verify_file(request, blank, base.data, (*request.motion, *motion), inputs)
    else:
        result = judge(request, Variant(
            KEY, words, base, request.links, motion=motion, inputs=inputs, details=details
        ))  # fmt: skip
    asks = f"; needs {', '.join(needs)}" if needs else ""
    if driven is None:
        options = " ".join(f"--motion {x}" for x in relation.words)
        asks += f"; a gear or slider must hold it: {options}"
    return replace(result, reason=result.reason + asks)


def _driven(
    request: RemedyRequest, relation: InputRelation
) -> dict[str, tuple[str, float]] | None:
    """Find the joint and the ratio that each driven input follows.

    Returns:
        By name of the driven input; None if a relation has more than two terms, or an input
        is no joint of its own in the file.
    """
    rows = relation.candidate.rows
    if any(sum(map(bool, row)) > 2 for row in rows):
        return None
    # Each row is solved for the input that no other row has; the others are free.
    driven = [next(k for k, x in enumerate(row) if x and sum(bool(r[k]) for r in rows) == 1)
              for row in rows]  # fmt: skip
    rest = next(k for k in range(len(relation.names)) if k not in driven)
    sources = {}
    for row, i in zip(rows, driven, strict=True):
        source = next((k for k, x in enumerate(row) if x and k != i), rest)
        sources[relation.names[i]] = relation.names[source], -row[source] / row[i]
    single = {x.name for x in build_tree(request.base.data).children if x.tag == "joint"}
    return (
        sources if single >= {*sources, *(source for source, _ in sources.values())} else None
    )


def _with_mimics(document: Document, driven: dict[str, tuple[str, float]]) -> Document:
    """Make joints of a URDF file follow others; a joint that rests follows with ratio 0."""
    text, splices = Text(document.data), []
    for joint in build_tree(document.data).children:
        if joint.tag != "joint" or joint.name not in driven:
            continue
        source, ratio = driven[joint.name]
        mimic = Element("mimic", {"joint": source, "multiplier": number_words([ratio])})
        place = joint.span[1] - text.size(text.margin(joint.span[1]))
        margin = text.margin(joint.children[-1].span[0])
        line = "".join(f"{margin}{line}" for line in element_lines(mimic, ""))
        splices += [Splice(place, place, line), *_without_mark(text, joint)]
    return Document(document.name, text.replace(splices))


def _without_mark(text: Text, joint: Element) -> list[Splice]:
    """Remove ``independent`` from the start tag of a joint, which follows another now."""
    first = joint.span[0]
    head = text.data[first : joint.children[0].span[0]].decode(text.codec, "replace")
    mark = re.search(r"""\s+independent\s*=\s*("[^"]*"|'[^']*')""", head.partition(">")[0])
    if mark is None:
        return []
    start = first + text.size(head[: mark.start()])
    return [Splice(start, start + text.size(mark[0]), "")]
