"""Text of a synthesis for ``balance synthesize``.

`Synthesis.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import math

from balance.motion_tolerances import SYNTHESIS_MOMENTUM, SYNTHESIS_SHAKING
from balance.report.answer import AnswerBody, AnswerPart, Facts
from balance.synthesis.mechanism import Synthesis, SynthesizedMechanism
from kinematics.wording import number_text, size_text

__all__ = ["mechanism_rows", "synthesis_body", "synthesis_facts"]

HEAD = ("mechanism", "pivots (m)", "turns (deg)", "misses (m)", "momentum", "shaking",
        "design space", "defects")  # fmt: skip
NONE = "-"


def synthesis_facts(found: Synthesis) -> list[tuple[str, str]]:
    """List the facts on a synthesis as pairs of label and value.

    Args:
        found: the synthesis.
    """
    places = "; ".join(
        f"({number_text(each.x, '.6g')}, {number_text(each.y, '.6g')}) at "
        f"{number_text(math.degrees(each.angle), '.6g')}°"
        for each in found.positions
    )
    kind = found.kind if found.kind == "four-bar" else f"{found.kind}, {found.case}"
    pairs = [("positions", places), ("mechanism", kind)]
    if found.ratio is not None:
        pairs.append(("ratio", f"k = {number_text(found.ratio, '.6g')}"))
    pairs += [("verdict", found.words), *(("remark", words) for words in found.remarks)]
    for one in found.mechanisms[:1]:
        pairs += _best(one)
    return pairs


def _best(one: SynthesizedMechanism) -> list[tuple[str, str]]:
    """List the facts on the best mechanism."""
    pairs = []
    if one.relation is not None:
        pairs.append(("motion", f"--motion {one.relation}"))
    if one.first_position:
        inputs = one.first_position.items()
        at = ", ".join(f"{name}={number_text(x, '.9g')} rad" for name, x in inputs)
        pairs.append(("file pose", f"away from position 1, which is nearly flat, at {at}"))
    numbers = one.numbers
    if "J1" in numbers:
        lengths = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("l1", "l2", "l3")
        )
        centres = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("s1", "s2", "s3", "s4")
        )
        inertias = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("J1", "J2", "C")
        )
        pairs += [("lengths", f"{lengths} m"), ("centres", f"{centres} m"),
                  ("inertias", f"{inertias} kg m²")]  # fmt: skip
    return pairs


def mechanism_rows(found: Synthesis) -> list[tuple[str, ...]]:
    """Build the table of mechanisms, its head first.

    Args:
        found: the synthesis.
    """
    return [HEAD, *map(_row, found.mechanisms)]


def _row(one: SynthesizedMechanism) -> tuple[str, ...]:
    """Build the row of a mechanism."""
    pivots = "  ".join(
        f"{name} ({number_text(z.real, '.5g')}, {number_text(z.imag, '.5g')})"
        for name, z in one.pivots.items()
    )
    turns = ", ".join(number_text(math.degrees(turn), ".5g") for turn in one.link_turns[1:])
    sizes = (
        NONE if value is None else size_text(value, floor=floor)
        for value, floor in (
            (one.confirmation.momentum, SYNTHESIS_MOMENTUM),
            (one.confirmation.shaking, SYNTHESIS_SHAKING),
        )
    )
    defects = "; ".join(f"{each.kind}: {each.words}" for each in one.defects) or "none"
    space = one.confirmation.space or one.confirmation.reason
    return (one.kind, pivots, turns, size_text(one.position_error), *sizes, space, defects)


def synthesis_body(found: Synthesis) -> AnswerBody:
    """Build what is printed on a synthesis."""
    head, *rows = mechanism_rows(found)
    body: list[AnswerPart] = [Facts(synthesis_facts(found))]
    for row in rows:
        body += ["", Facts(list(zip(head, row, strict=True)))]
    return body
