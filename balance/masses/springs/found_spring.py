"""A spring that was found: where it is attached, and how stiff and long it is."""

from __future__ import annotations

from typing import NamedTuple

from kinematics.wording import number_text, vector_text


class AttachedPoint(NamedTuple):
    """Where a spring is attached.

    Attributes:
        link: name of the link.
        point: in the frame of the link (3,), metres.
    """

    link: str
    point: tuple[float, float, float]

    def __repr__(self) -> str:
        """Give one line: the link and the point."""
        return f"AttachedPoint: {self.words}"

    @property
    def words(self) -> str:
        """The link and the point in words."""
        return f"{self.link} at {vector_text(self.point)} m"


class Spring(NamedTuple):
    """A spring that acts as one without free length: its force is stiffness times length.

    Attributes:
        asked: the text that asked for it.
        ends: where it is attached.
        stiffness: N/m; 0 if it is not needed.
        lengths: least and greatest distance of its ends over the workspace, metres.
        force: greatest force over the workspace, N.
    """

    asked: str
    ends: tuple[AttachedPoint, AttachedPoint]
    stiffness: float
    lengths: tuple[float, float]
    force: float

    def __repr__(self) -> str:
        """Give one line: stiffness and ends."""
        first, second = self.ends
        return f"Spring: {number_text(self.stiffness)} N/m, {first.words} to {second.words}"
