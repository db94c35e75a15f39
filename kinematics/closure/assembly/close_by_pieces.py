"""Close a component piece by piece: legs that share no joint but the crank which drives them.

With the joints held that most loops share, a component may fall apart into pieces that move
independently. A start from which one piece closes with probability p closes n of them at once
with pⁿ only; one by one, every piece takes the start that suits it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.assembly.closed_component import ClosedComponent
from kinematics.closure.mobility.components import Component, split_components
from kinematics.model.chain import loop_joints

Array = NDArray[np.float64]
CloseComponent = Callable[[Component], ClosedComponent | str]

# Most joints that are held for a component to fall apart.
MAX_HELD = 3


def close_by_pieces(part: Component, close: CloseComponent) -> tuple[Array | None, int]:
    """Find a closed pose of a component at which the joints that its pieces share rest.

    Args:
        part: a component whose loops are open.
        close: closes one piece, or returns a hint.

    Returns:
        Positions of its joints (n,), in its own units, and how many pieces it has; None if it
        does not fall apart, or a piece does not close.
    """
    pieces = _split(part)
    q = np.zeros(part.joints.size)
    for piece in pieces:
        closed = close(piece)
        if isinstance(closed, str) or closed.open:
            return None, len(pieces)
        q += closed.part.all_positions(closed.q, part.chain.units)
    return (q if pieces else None), len(pieces)


def _split(part: Component) -> list[Component]:
    """Split a component by holding up to `MAX_HELD` joints; no pieces if it stays whole."""
    held: set[int] = set()
    for _ in range(MAX_HELD):
        shared = _most_shared(part, held)
        if shared is None:
            return []
        held |= _followers(part, shared)
        pieces = split_components(part.draft, frozenset(held))
        moved = {k for piece in pieces for k in piece.loops}
        if len(moved) < len(part.draft.loops):  # a loop without joints stays open
            return []
        if sum(bool(piece.loops) for piece in pieces) > 1:
            return pieces
    return []


def _most_shared(part: Component, held: set[int]) -> int | None:
    """Find the joint of the tree that most loops share, the first of equals, if two do."""
    counts: Counter[int] = Counter()
    for loop in part.draft.loops:
        counts.update(loop_joints(part.chain.parent, loop.end, loop.successor) - held)
    most = max(counts.values(), default=0)
    return min(j for j, count in counts.items() if count == most) if most > 1 else None


def _followers(part: Component, joint: int) -> set[int]:
    """Find a joint and those that mimic relations couple to it."""
    joints = {joint}
    for _ in part.draft.mimics:
        for mimic in part.draft.mimics:
            if {mimic.joint, mimic.source} & joints:
                joints |= {mimic.joint, mimic.source}
    return joints
