"""Text of the least violation of requirements for ``balance reduce --require``.

`LeastViolation.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.counterweights import counterweight_rows
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.partial_balance.least_violation import LeastViolation
from balance.support.tolerances import SHAKING_GAP_PROVED
from kinematics.wording import number_text, size_text

DIGITS, FORM = 4, ".4g"
HEAD = ("requirement", "weight", "missed by before", "after", "multiplier", "part of the sum")


def violation_body(answer: LeastViolation) -> AnswerBody:
    """Build what is printed on the least violation of requirements."""
    total = answer.total**2
    rows: list[tuple[str, ...]] = [HEAD]
    for item in answer.violations:
        part = item.cost / total if answer.dearest is not None else 0.0
        after, multiplier = item.after, item.after**2
        rows.append(
            (
                item.text,
                number_text(item.weight),
                size_text(item.before, FORM),
                _missed_text(after),
                _missed_text(multiplier),
                f"{part:.0%}",
            )
        )
    facts = linkage_facts(answer.space.linkage, answer.space.aim)
    facts += [
        ("verdict", answer.words),
        ("minimised", "weighted sum of squares of what requirements miss, without units"),
        ("bound", f"root of the sum at least {_missed_text(answer.bound)}"),
        ("added", f"{number_text(answer.mass)} kg of {number_text(answer.budget)} kg"),
    ]
    body: list[AnswerPart] = [Facts(facts), "", AnswerTable(rows, "<>")]
    if answer.weights:
        lumps = counterweight_rows(answer.weights, answer.links, digits=DIGITS, nothing="none")
        body += ["", AnswerTable(lumps)]
    return body


def _missed_text(size: float) -> str:
    """Write what a requirement misses, as a bound if it is within the solver's accuracy."""
    return size_text(size, FORM, floor=SHAKING_GAP_PROVED)
