"""Choose a spanning tree of the graph of links and joints; the other joints close loops."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

__all__ = ["SpanningTree", "choose_root", "span"]


class SpanningTree(NamedTuple):
    """Joints of a graph, by index.

    Attributes:
        forward: joints whose parent carries their child.
        backward: joints whose child carries their parent.
        closing: joints between links that both are in the tree, or both are not.
    """

    forward: frozenset[int]
    backward: frozenset[int]
    closing: tuple[int, ...]


def choose_root(links: Sequence[str], pairs: Sequence[tuple[str, str]], preferred: str) -> str:
    """Choose the link that is taken as fixed: the preferred or first one without a parent.

    Args:
        links: names, in the order of the file; not empty.
        pairs: parent and child of every joint.
        preferred: the link that is named as the first.
    """
    carried = {child for _, child in pairs}
    free = [name for name in links if name not in carried] or list(links)
    return preferred if preferred in free else free[0]


def span(pairs: Sequence[tuple[str, str]], root: str) -> SpanningTree:
    """Choose the joints of a spanning tree, from its root outwards.

    The first joint of the file from a link of the tree to one that is not in it is taken. Only
    if there is none, one that leads into the tree is turned round.

    Args:
        pairs: parent and child of every joint, in the order of the file.
        root: the ground.
    """
    leaving: dict[str, list[int]] = {}
    entering: dict[str, list[int]] = {}
    for k, (parent, child) in enumerate(pairs):
        leaving.setdefault(parent, []).append(k)
        entering.setdefault(child, []).append(k)
    reached = {root}
    ahead, behind = leaving.get(root, [])[:], entering.get(root, [])[:]
    heapify(ahead)
    heapify(behind)
    forward: set[int] = set()
    backward: set[int] = set()
    while ahead or behind:
        queue, side, taken = (ahead, 1, forward) if ahead else (behind, 0, backward)
        k = heappop(queue)
        link = pairs[k][side]
        if link not in reached:
            reached.add(link)
            taken.add(k)
            for other in leaving.get(link, ()):
                heappush(ahead, other)
            for other in entering.get(link, ()):
                heappush(behind, other)
    closing = (k for k in range(len(pairs)) if k not in forward and k not in backward)
    return SpanningTree(frozenset(forward), frozenset(backward), tuple(closing))
