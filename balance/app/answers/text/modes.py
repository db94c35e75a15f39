"""Text of the modes of motion that meet at a pose, for ``balance report``."""

from __future__ import annotations

from balance.app.answers.answer import MISSING, AnswerBody, AnswerTable, Facts
from balance.masses.mode_answers import VERDICT_TEXTS, ModeAnswer, ModeAnswers

HEAD = (
    "mode",
    "mobility",
    "inputs",
    "rank by order",
    "nullity",
    "serial",
    "parallel",
    "buildable",
    "certainty",
)


def modes_body(answers: ModeAnswers) -> AnswerBody:
    """Build what is printed on the modes: a table, then the pose on each.

    Args:
        answers: result of `balance.motion_modes`.
    """
    here = [answer for answer in answers.modes if answer.mode.here]
    facts = [
        ("linkage", f"{answers.name}, {answers.balance} balance"),
        ("pose", f"singular: {len(here)} modes of motion meet at this pose"),
    ]
    if len(here) < len(answers.modes):
        more = [str(answer.mode.number) for answer in answers.modes if not answer.mode.here]
        word = "modes" if len(more) > 1 else "mode"
        facts.append(("further", f"{word} {', '.join(more)}: another mode leads there"))
    if answers.doubt:
        facts.append(("complete", f"there may be more modes: {answers.doubt}"))
    return [
        answers.sentence,
        "",
        Facts(facts, least=13),
        "",
        AnswerTable([HEAD, *map(_row, answers.modes)]),
        "",
        Facts([_place(answer) for answer in answers.modes], least=13),
        "",
        "choose a mode with --mode N; with --write-closed FILE the file is written there",
    ]


def _row(answer: ModeAnswer) -> tuple[str, ...]:
    """Describe a mode in the columns of the table."""
    space, mode = answer.space, answer.mode
    if space is None or answer.verdict is None:
        return (str(mode.number), str(mode.mobility), *[MISSING] * (len(HEAD) - 2))
    return (
        str(mode.number),
        str(mode.mobility),
        ", ".join(space.inputs),
        " ".join(str(order.rank) for order in space.orders),
        str(space.nullity),
        str(space.serial.shape[1]),
        str(space.parallel.shape[1]),
        VERDICT_TEXTS[answer.verdict],
        space.level,
    )


def _place(answer: ModeAnswer) -> tuple[str, str]:
    """Describe the pose on a mode, or why there is no answer there, and what is in doubt."""
    doubts = answer.space.doubts if answer.space else (answer.problem,)
    return f"mode {answer.mode.number}", "; ".join([f"at {answer.mode.place}", *doubts])
