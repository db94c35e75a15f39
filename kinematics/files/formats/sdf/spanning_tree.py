"""Choose a spanning tree of the graph of links and joints; the other joints close loops."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple


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
    """Choose the link that is taken as fixed.

    A link that no joint connects to another is not chosen. Where joints form a tree that begins
    at a link without a parent, that link is the root; otherwise it is the preferred one.

    Args:
        links: names, in the order of the file; not empty.
        pairs: parent and child of every joint.
        preferred: the canonical link of the model.
    """
    joined = [name for name in links if any(name in pair for pair in pairs)] or list(links)
    carried = [child for _, child in pairs]
    free = [name for name in joined if name not in carried]
    tree = len(carried) == len(set(carried))
    if tree and free:
        return preferred if preferred in free else free[0]
    return preferred if preferred in joined else (free or joined)[0]


def span_all(
    links: Sequence[str], pairs: Sequence[tuple[str, str]], ground: str
) -> tuple[SpanningTree, list[str]]:
    """Span the ground and what joints connect to it, then every other group of links.

    Args:
        links: names, in the order of the file.
        pairs: parent and child of every joint.

    Returns:
        The joints of all trees, and the roots of the others.
    """
    trees, roots, reached = [span(pairs, ground)], [], {ground}
    while True:
        for k in (*trees[-1].forward, *trees[-1].backward):
            reached |= {*pairs[k]}
        unreached = [name for name in links if name not in reached]
        if not unreached:
            break
        between = [pair for pair in pairs if not reached & {*pair}]
        roots.append(choose_root(unreached, between, unreached[0]))
        reached.add(roots[-1])
        trees.append(span(pairs, roots[-1]))
    forward = frozenset[int]().union(*(tree.forward for tree in trees))
    backward = frozenset[int]().union(*(tree.backward for tree in trees))
    closing = (k for k in range(len(pairs)) if k not in forward and k not in backward)
    return SpanningTree(forward, backward, tuple(closing)), roots


def span(pairs: Sequence[tuple[str, str]], root: str) -> SpanningTree:
    """Choose the joints of a spanning tree, from its root outwards.

    The first joint of the file from a link of the tree to one that is not in it is taken. Only
    if there is none, one that leads into the tree is turned round.

    Args:
        pairs: parent and child of every joint, in the order of the file.
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
