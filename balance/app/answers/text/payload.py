"""Text of payloads: the load, and what must move with it."""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.masses.counterweights.movable_weights import MovableWeights
from balance.masses.partial_balance.load_range import LoadsLeft
from balance.masses.payload import Payload
from balance.masses.springs.spring_loads import SpringLoads
from kinematics.wording import number_text, vector_text


def payload_section(
    load: Payload | MovableWeights | SpringLoads | LoadsLeft | None,
) -> AnswerBody:
    """Build what is printed on a payload; nothing without one."""
    if load is None:
        return []
    if isinstance(load, Payload):
        return ["", Facts([("payload", load.words)])]
    payload = load.payload
    facts = [
        ("payload", payload.words),
        (
            "fixed",
            f"what stays is for the mean, {number_text(payload.mean)} kg: the least mean "
            "square over all loads",
        ),
        ("left" if isinstance(load, LoadsLeft) else "movable", load.words),
    ]
    body: AnswerBody = ["", Facts(facts)]
    if isinstance(load, LoadsLeft):
        return body
    low, high = (f"at {number_text(x)} kg" for x in (payload.low, payload.high))
    if isinstance(load, MovableWeights):
        rows = [
            (w.link, number_text(w.mass), vector_text(w.start), vector_text(w.end))
            for w in load.weights
        ]
        head = ("link", "mass (kg)", f"{low} (link frame, m)", high)
        return [*body, "", AnswerTable([head, *rows], "<><")] if rows else body
    moves: list[tuple[str, ...]] = [
        ("spring", "stiffness (N/m)", f"{low} (link frames, m)", high),
        *(
            (
                str(spring.number),
                number_text(spring.stiffness),
                *(" and ".join(map(vector_text, ends)) for ends in (spring.start, spring.end)),
            )
            for spring in load.springs
        ),
    ]
    return [*body, "", AnswerTable(moves, "<><")] if load.springs else body
