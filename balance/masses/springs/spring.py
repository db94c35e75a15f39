"""A spring: where it is attached, how stiff and how long it is."""

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
    """A spring: its force is stiffness times the distance of its ends beyond the free length.

    Attributes:
        asked: the text that asked for it.
        ends: where it is attached.
        stiffness: N/m; 0 if it is not needed.
        lengths: least and greatest distance of its ends over the workspace, metres.
        force: greatest force over the workspace, N.
        free_length: distance of its ends at which the force vanishes, metres; below 0 if it
            pulls where they meet.
    """

    asked: str
    ends: tuple[AttachedPoint, AttachedPoint]
    stiffness: float
    lengths: tuple[float, float]
    force: float
    free_length: float = 0.0

    def __repr__(self) -> str:
        """Give one line: stiffness, free length and ends."""
        first, second = self.ends
        length = f", free length {number_text(self.free_length)} m" * bool(self.free_length)
        return (
            f"Spring: {number_text(self.stiffness)} N/m{length}, {first.words} to "
            f"{second.words}"
        )

    @property
    def pushes(self) -> bool:
        """Whether its ends come nearer than the free length in the workspace."""
        return self.stiffness > 0.0 and self.lengths[0] < self.free_length
