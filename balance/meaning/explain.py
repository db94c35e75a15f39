"""What a design space means, joint by joint, and what the loops add, in words."""

from __future__ import annotations

from typing import NamedTuple

from balance.meaning.freedoms import Freedom, parallel_freedoms, summary, transfer_freedoms
from balance.meaning.sites import Described
from balance.partition import Transfer

__all__ = ["ExplainedTransfer", "Explanation", "explain"]


class ExplainedTransfer(NamedTuple):
    """What may be moved across one joint, as primitives.

    Attributes:
        joints: see `Transfer`.
        bodies: see `Transfer`.
        ground: see `Transfer`.
        freedoms: one for each dimension of the transfer.
    """

    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    ground: bool
    freedoms: tuple[Freedom, ...]

    @property
    def dimension(self) -> int:
        """How many independent transfers there are."""
        return len(self.freedoms)

    @property
    def title(self) -> str:
        """The joint and the bodies in one phrase."""
        around = ", ".join([*(["ground"] if self.ground else []), *self.bodies])
        if self.joints:
            return f"{', '.join(dict.fromkeys(_whole(self.joints)))} ({around})"
        return f"{', '.join(self.bodies)} ({'at rest' if self.ground else 'rigidly joined'})"

    @property
    def words(self) -> str:
        """All of it in one line."""
        return summary(self.freedoms) or "nothing"

    def to_dict(self) -> dict[str, object]:
        """Plain data, ready for JSON."""
        return {
            "joints": list(self.joints),
            "bodies": list(self.bodies),
            "dimension": self.dimension,
            "freedoms": [freedom.to_dict() for freedom in self.freedoms],
        }


class Explanation(NamedTuple):
    """A design space in terms of point masses, displacements and pure-inertia rods.

    Attributes:
        transfers: joint by joint, what may be moved across it.
        freedoms: what only the closure of the loops frees.
    """

    transfers: tuple[ExplainedTransfer, ...]
    freedoms: tuple[Freedom, ...]

    def to_dict(self) -> dict[str, object]:
        """The entries ``transfers`` and ``freedoms`` of the report."""
        return {
            "transfers": [item.to_dict() for item in self.transfers],
            "freedoms": [freedom.to_dict() for freedom in self.freedoms],
        }


def explain(space: Described, transfers: tuple[Transfer, ...]) -> Explanation:
    """The transfers and the parallel part of a design space in readable form."""
    explained = (
        ExplainedTransfer(item.joints, item.bodies, item.ground, transfer_freedoms(space, item))
        for item in transfers
    )
    return Explanation(tuple(explained), parallel_freedoms(space))


def _whole(joints: tuple[str, ...]) -> list[str]:
    """Names in the file: without the numbers, from 0, that a joint of several freedoms adds."""
    stems = [name.rpartition(".") for name in joints]
    numbers: dict[str, set[str]] = {}
    for stem, _, number in stems:
        numbers.setdefault(stem, set()).add(number)
    several = {
        stem for stem, found in numbers.items()
        if len(found) > 1 and found == {str(k) for k in range(len(found))}
    }  # fmt: skip
    return [
        stem if stem in several else name
        for name, (stem, _, _) in zip(joints, stems, strict=True)
    ]
