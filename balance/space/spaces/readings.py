"""Two readings of a file: its numbers as written, and the special linkage they may mean."""

from __future__ import annotations

from typing import NamedTuple

from kinematics.wording import count_noun, size_text

# Half widths of the intervals beyond which a linkage is off on purpose.
ON_PURPOSE = 30.0
# Distance of a special geometry, in parts of the size: below this, digits of it are round-off.
DISTANCE_ROUND_OFF = 1e-14
MOST_DIGITS = 17
"""Most significant digits of a number: those of a double."""


class Reading(NamedTuple):
    """Both readings of a file whose numbers are special but for rounding, or just miss it.

    Attributes:
        held: which one the answer is that of: ``"as_written"`` or ``"as_meant"``.
        relations: those of the special geometry, in words.
        digits: significant digits of the file.
        deciding: digits with which a file would decide; None if doubles do not have so many.
        written: conditions of the linkage as written; None if they cannot be compared.
        special: conditions of the special geometry.
        distance: of the special geometry, in parts of the size of the linkage.
        nearness: the same in half widths of what the digits leave open.
        instead: what the linkage has as written in place of conditions to compare.
    """

    held: str
    relations: tuple[str, ...]
    digits: int
    deciding: int | None
    written: int | None
    special: int
    distance: float
    nearness: float
    instead: str = "loops that do not close"

    @property
    def words(self) -> str:
        """Both answers, which one holds, and what would decide, in one line."""
        here, there = self.written_text, self.special_text
        decided = f"; {self.deciding_text}" if self.deciding_text else ""
        if self.held == "as_written":
            return f"as written, held here: {here}; if rounded: {there}{decided}"
        return f"as meant, held here: {there}; as written: {here}{decided}"

    @property
    def written_text(self) -> str:
        """The answer for the linkage as written."""
        if self.written is None:
            return self.instead
        return count_noun(self.written, "condition")

    @property
    def special_text(self) -> str:
        """The answer for the special geometry, and its relations."""
        return f"{count_noun(self.special, 'condition')} ({', '.join(self.relations)})"

    @property
    def away(self) -> str:
        """How far the special geometry is away."""
        return f"{size_text(self.distance, '.0e', floor=DISTANCE_ROUND_OFF)} of the size away"

    @property
    def deciding_text(self) -> str:
        """What would decide; empty where no file of doubles does."""
        return (
            "" if self.deciding is None else f"a file with {self.deciding} digits would decide"
        )

    def to_dict(self) -> dict[str, object]:
        """Convert to an entry of ``readings`` of the report."""
        return {
            "held": self.held,
            "relations": list(self.relations),
            "digits": self.digits,
            "deciding_digits": self.deciding,
            "conditions_as_written": self.written,
            "conditions_as_special": self.special,
            "distance": self.distance,
            "nearness": self.nearness,
        }


def deciding_digits(digits: int, nearness: float) -> int | None:
    """Compute the digits with which a file tells a special linkage from one that misses it.

    With each digit more the intervals are a tenth as wide. One that is off on purpose is then
    far outside of them, and one that was rounded is inside.

    Args:
        digits: significant digits of the file.
        nearness: distance of the special geometry, in half widths of the intervals.

    Returns:
        The digits; None if a double does not have so many, or if there is no distance.
    """
    if nearness <= 0.0:
        return None
    for more in range(1, MOST_DIGITS - digits + 1):
        if nearness * 10.0**more > ON_PURPOSE:
            return digits + more
    return None
