"""Explanation of a design space in words: transfers by joint, and the parallel part."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from balance.space.interpretation.freedoms import (
    Freedom,
    parallel_freedoms,
    summarise,
    transfer_freedoms,
)
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.transfers.by_joint import Transfer
from kinematics.loading.model_gallery import LinkageLike
from kinematics.wording import count_noun, repr_lines


class ExplainedTransfer(NamedTuple):
    """Inertia transfer across one joint, as primitives.

    Attributes:
        title: the joint, by its name in the file, and the bodies in one phrase.
        joints: see `Transfer`.
        bodies: see `Transfer`.
        freedoms: one for each dimension of the transfer.
    """

    title: str
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    freedoms: tuple[Freedom, ...]

    def __repr__(self) -> str:
        """One line in words."""
        return f"ExplainedTransfer across {self.title}: {self.words}"

    @property
    def dimension(self) -> int:
        """Number of independent transfers."""
        return len(self.freedoms)

    @property
    def words(self) -> str:
        """All freedoms in one line of words."""
        return summarise(self.freedoms) or "nothing"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return {
            "joints": list(self.joints),
            "bodies": list(self.bodies),
            "dimension": self.dimension,
            "freedoms": [freedom.to_dict() for freedom in self.freedoms],
        }


class Explanation(NamedTuple):
    """A design space in terms of point masses, displacements and pure-inertia rods.

    Attributes:
        transfers: inertia transfers, joint by joint.
        freedoms: the parallel part, which exists only with the loops closed.
    """

    transfers: tuple[ExplainedTransfer, ...]
    freedoms: tuple[Freedom, ...]

    def __repr__(self) -> str:
        """Up to six lines: transfers by joint, and the parallel part."""
        lines = [f"{item.title}: {item.words}" for item in self.transfers]
        lines += [f"freed by the loops: {freedom.words}" for freedom in self.freedoms]
        head = (
            f"Explanation: {count_noun(len(self.transfers), 'transfer')}, "
            f"{count_noun(len(self.freedoms), 'freedom')}"
        )
        return repr_lines(head, *lines)

    def to_dict(self) -> dict[str, object]:
        """Convert to the entries ``transfers`` and ``freedoms`` of the report."""
        return {
            "transfers": [item.to_dict() for item in self.transfers],
            "freedoms": [freedom.to_dict() for freedom in self.freedoms],
        }


def explain(space: DesignSpace | LinkageLike) -> Explanation:
    """Explain a design space: the inertia transfers of each joint, and what the loops add.

    What each type of joint can transfer: docs/theory/transfers.md.

    Args:
        space: a design space, or an argument of `design_space`.

    Returns:
        The transfers of each joint and the parallel part, as point masses, displacements of
        mass and pure-inertia rods at joints and along links.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, sections 5.2 (primitives) and 5.5
        (transfers); S. S. Chen, D. L. Donoho and M. A. Saunders, 1998, for few terms.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> for transfer in balance.explain(space).transfers:
        ...     print(f"{transfer.title}: {transfer.words}")
        u1 (ground, crank): a point mass at the centre
        q2 (crank, coupler): a point mass at the centre
        q4 (ground, rocker): a point mass at the centre
        q3 (coupler, rocker): a point mass at the centre
    """
    space = as_space(space)
    explained = (
        ExplainedTransfer(
            _title(space, item), item.joints, item.bodies, transfer_freedoms(space, item)
        )
        for item in space.transfers
    )
    return Explanation(tuple(explained), parallel_freedoms(space))


def _title(space: DesignSpace, transfer: Transfer) -> str:
    """Write the joints and bodies of a transfer in one phrase."""
    if not transfer.joints:
        how = "at rest" if transfer.ground else "rigidly joined"
        return f"{', '.join(transfer.bodies)} ({how})"
    around = ", ".join([*(["ground"] if transfer.ground else []), *transfer.bodies])
    return f"{', '.join(_joints(space, transfer))} ({around})"


def _joints(space: DesignSpace, transfer: Transfer) -> list[str]:
    """List names of joints; the name in the file where several degrees of one joint move."""
    joints = [space.linkage.joints[j] for j in space.linkage.positions_of(transfer.joints)]
    counts = Counter(joint.whole for joint in joints)
    names = [joint.whole if counts[joint.whole] > 1 else joint.name for joint in joints]
    return list(dict.fromkeys(names))
