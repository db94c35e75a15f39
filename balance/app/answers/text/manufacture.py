"""Text of shaking within tolerances for ``balance verify --tolerance mass=2%``.

`ShakingTolerance.to_dict` has the same content as data.
"""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.motion.manufacture.analyse import ShakingSpread, ShakingTolerance
from kinematics.wording import number_text, size_text

# Most deviations that are listed.
MAX_ROWS = 12
# Part of the worst case below which what a deviation adds is round-off.
ROUND_OFF = 1e-9


def _spread_text(spread: ShakingSpread, unit: str) -> str:
    """Describe the spread of a peak."""
    size = spread.bound or 1.0
    nominal, reached, bound, median, high, largest = (
        size_text(value, ".4g", size, ROUND_OFF)
        for value in (
            spread.nominal,
            spread.reached,
            spread.bound,
            spread.median,
            spread.high,
            spread.largest,
        )
    )
    return (
        f"{nominal} {unit} nominal; worst case {reached} to {bound}; drawn: median {median}, "
        f"95 % below {high}, largest {largest}"
    )


def tolerance_body(spread: ShakingTolerance) -> AnswerBody:
    """Build what is printed on shaking within tolerances."""
    bounds = spread.tolerances
    given = [
        f"{name} {number_text(value)}{unit}"
        for name, value, unit in (
            ("mass", 100.0 * bounds.mass, " %"),
            ("length", bounds.length, " m"),
            ("com", bounds.com, " m"),
        )
        if value > 0.0
    ]
    proof = "holds for every linkage within them"
    if not spread.proved:
        proof = "holds to first order in lengths"
    body: list[AnswerPart] = [
        Facts(
            [
                ("tolerances", f"{', '.join(given)}; the upper end of a worst case {proof}"),
                ("peak force", _spread_text(spread.force, "N")),
                ("peak moment", _spread_text(spread.moment, "N m")),
            ]
        ),
        "",
    ]
    rows = [("what adds most", "force (N)", "moment (N m)")]
    for share in spread.shares[:MAX_ROWS]:
        rows.append(
            (
                share.deviation.words,
                size_text(share.force, ".4g", spread.force.bound or 1.0, ROUND_OFF),
                size_text(share.moment, ".4g", spread.moment.bound or 1.0, ROUND_OFF),
            )
        )
    body.append(AnswerTable(rows, "<>"))
    if len(spread.shares) > MAX_ROWS:
        body.append(f"and {len(spread.shares) - MAX_ROWS} more (--json)")
    return body
