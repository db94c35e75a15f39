"""A mode of motion: one of several motions that start from one pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from kinematics.errors import LinkageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.tolerances import NAMED_POSITION
from kinematics.wording import number_text


class ModeOfMotion(NamedTuple):
    """A mode of motion that starts from a pose at which several meet, and a pose on it.

    Attributes:
        number: from 1, in the order of all modes.
        mobility: its degrees of freedom.
        here: whether it passes that pose itself; otherwise another mode leads to it.
        positions: of the joints of the tree that have moved to the pose on it, by name, counted
            from the pose of the file, radians and metres.
        linkage: the linkage, at the pose on it; or the reason for which there is none.
    """

    number: int
    mobility: int
    here: bool
    positions: Mapping[str, float]
    linkage: Linkage | LinkageError

    @property
    def place(self) -> str:
        """Positions of the joints in words: ``a=0.5, b=-0.5``; small ones are left out."""
        named = (
            f"{name}={number_text(q, '.3g')}"
            for name, q in self.positions.items()
            if abs(q) > NAMED_POSITION
        )
        return ", ".join(named) or "the pose of the file"
