"""Text of springs for ``balance springs``.

`SpringBalance.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import numpy as np

from balance.app.answers.answer import MISSING, AnswerBody, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.app.answers.text.payload import payload_section
from balance.masses.springs.spring import AttachedPoint, Spring
from balance.masses.springs.spring_balance import SpringBalance
from balance.support.tolerances import SPRING_TORQUE_LEFT
from kinematics.wording import count_noun, number_text, size_text, vector_text

HEAD = ("spring", "from", "to", "stiffness (N/m)", "length (m)", "force up to (N)")
TORQUE_HEAD = ("input", "peak torque of gravity", "left")
# Most smallest sets in a line.
MAX_SETS = 6


def springs_facts(answer: SpringBalance) -> list[tuple[str, str]]:
    """List the facts on springs as pairs of label and value."""
    pairs = linkage_facts(answer.linkage, f"inputs {', '.join(answer.linkage.inputs)}")
    pairs += [
        ("gravity", f"{vector_text(answer.gravity)} m/s²"),
        ("verdict", answer.words),
        (
            "conditions",
            f"rank {answer.rank}, on {count_noun(answer.unknowns, 'unknown')} of "
            f"{count_noun(len(answer.springs), 'spring')} and gravity",
        ),
    ]
    if answer.balanced:
        pairs.append(("fewest", _sets_text(answer)))
    certainty = answer.certainty
    pairs.append(("certainty", f"{certainty.level}: {certainty.reason}"))
    return pairs


def _sets_text(answer: SpringBalance) -> str:
    """Say which of the smallest sets of springs balance."""
    sets = [" + ".join(str(k + 1) for k in chosen) for chosen in answer.sets]
    more = len(sets) - MAX_SETS
    listed = ", ".join([*sets[:MAX_SETS], *([f"and {more} more"] if more > 0 else [])])
    if not answer.every_set:
        return f"not sought among so many springs; these balance: {listed}"
    word = "set" if len(sets) == 1 else "sets"
    fewer = "none of fewer" if answer.excluded else "none of fewer were found"
    return f"{word} {listed} of springs, and {fewer}"


def springs_body(answer: SpringBalance) -> AnswerBody:
    """Build what is printed on springs."""
    body: list = [Facts(springs_facts(answer)), "", spring_table(answer)]
    body += ["", torque_table(answer)]
    needed = [spring for spring in answer.springs if spring.stiffness > 0.0]
    real = any(spring.free_length for spring in needed)
    if any(not spring.free_length for spring in needed):
        which = "Others act" if real else "Springs act"
        body += [
            "",
            f"{which} as if of no free length: lead each over a pulley at one end, "
            "with its free length behind it.",
        ]
    return [*body, *payload_section(answer.loads or answer.payload)]


def spring_table(answer: SpringBalance) -> AnswerTable:
    """Build the table of the springs; free lengths have a column where there are any."""
    real = any(spring.free_length for spring in answer.springs)
    rows = [_spring_row(k, spring, real) for k, spring in enumerate(answer.springs, 1)]
    head = [*HEAD[:4], *(["free length (m)"] * real), *HEAD[4:]]
    return AnswerTable([head, *rows], "<<<>")


def torque_table(answer: SpringBalance) -> AnswerTable:
    """Build the table of the inputs: peak torques of gravity, and what is left."""
    return AnswerTable([TORQUE_HEAD, *_torque_rows(answer)], "<>")


def _spring_row(number: int, spring: Spring, real: bool) -> tuple[str, ...]:
    """Build the row of one spring, with its free length or without."""
    ends = map(_point_text, spring.ends)
    if spring.stiffness == 0.0:
        return (str(number), *ends, "not needed", *([MISSING] * real), MISSING, MISSING)
    low, high = map(number_text, spring.lengths)
    return (
        str(number),
        *ends,
        number_text(spring.stiffness),
        *([number_text(spring.free_length)] * real),
        f"{low} to {high}",
        number_text(spring.force),
    )


def _point_text(end: AttachedPoint) -> str:
    """Write where a spring is attached."""
    return f"{end.link} {vector_text(end.point)}"


def _torque_rows(answer: SpringBalance) -> list[tuple[str, ...]]:
    """Build the rows of the inputs: peak torques of gravity, and what is left."""
    before, after = (np.abs(x).max(axis=0).tolist() for x in (answer.before, answer.after))
    rows: list[tuple[str, ...]] = []
    for name, weight, torque in zip(answer.linkage.inputs, before, after, strict=True):
        unit, largest = "N" if name in answer.linkage.sliding else "N m", max(before)
        torque_left = size_text(torque, ".4g", largest, SPRING_TORQUE_LEFT)
        given = number_text(weight, scale=largest)
        rows.append((name, f"{given} {unit}", f"{torque_left} {unit}"))
    return rows
