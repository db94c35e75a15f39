"""The serial design space, from its definition: loops opened by splitting moving bodies.

What opens the loops is a spanning tree of the graph of rigid parts and joints. Every other
joint stays: it lets go of one of its two parts, which must be a moving body, and takes a copy
of that body along, whose parameters count for the body. In what is left all joints move
freely. Its null space is that of the momentum at random finite poses and rates modulo a
prime; these are points of an irreducible variety, so once a fresh one adds no condition, none
does. The serial space is the sum over all trees and all choices of ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from math import comb
from typing import NamedTuple

import numpy as np

from tests.independent.prime_field import absorb, free_momentum

# Ways tried if they are too many; and fruitless ones after which no more are tried.
ALL, FRUITLESS = 60, 30


class Graph(NamedTuple):
    """Rigid parts, of which 0 is the ground, and the joints that move between them.

    Attributes:
        pairs: the two parts of each joint.
        screws: of the joints, modulo the prime (joints, 6).
        part: of each body.
        parts: how many there are.
    """

    pairs: list[tuple[int, int]]
    screws: np.ndarray
    part: list[int]
    parts: int


class Serial(NamedTuple):
    """Dimension of the serial space; whether all ways of opening were tried, or enough."""

    dimension: int
    complete: bool


def serial(graph: Graph, selection, p: int, limit: int, seed: int, effort: int = 1) -> Serial:
    """The serial space.

    Args:
        graph: the linkage with all loops closed.
        selection: pairs of points, rows and number of parameters of `prime_field.momentum`.
        p: the prime.
        limit: a dimension that it cannot exceed: once reached it is complete.
        seed: of poses and of ways of opening.
        effort: how many times the usual number of ways are tried.
    """
    rng = np.random.default_rng(seed)
    size = len(graph.part) * selection.parameters
    span, pivots = np.zeros((size, size), np.int64), np.zeros(size, np.int64)
    rank = fruitless = 0
    ways, whole = _ways(graph, rng, effort)
    for way in ways:
        before = rank
        rank = absorb(span, pivots, rank, _opened(graph, way, selection, p, rng), p)
        fruitless = fruitless + 1 if rank == before else 0
        if rank >= limit:
            return Serial(rank, True)
        if not whole and fruitless >= FRUITLESS * effort:
            return Serial(rank, False)
    return Serial(rank, whole)


def _ways(graph: Graph, rng, effort: int) -> tuple[Iterator, bool]:
    """Ways of opening: joints of the tree, and the end that each other joint lets go of.

    Also whether they are all.
    """
    massive = set(graph.part) - {0}
    joints, loops = range(len(graph.pairs)), len(graph.pairs) - graph.parts + 1
    if comb(len(graph.pairs), loops) * 2**loops <= ALL * effort:
        everything = (
            (tree, tuple(zip(rest, ends, strict=True)))
            for rest in combinations(joints, loops)
            if _spans(graph, tree := tuple(j for j in joints if j not in rest))
            for ends in product(*(_ends(graph, massive, j) for j in rest))
        )
        return everything, True
    return _random_ways(graph, massive, rng), False


def _random_ways(graph: Graph, massive: set[int], rng) -> Iterator:
    """Random ways without end."""
    while True:
        tree, group = [], list(range(graph.parts))
        # Joints without a body at either end cannot be left out.
        order = sorted(
            range(len(graph.pairs)),
            key=lambda j: (bool(massive & set(graph.pairs[j])), rng.random()),
        )
        for j in order:
            a, b = (group[x] for x in graph.pairs[j])
            if a != b:
                tree.append(j)
                group = [a if g == b else g for g in group]
        rest = [j for j in order if j not in tree]
        ends = [_ends(graph, massive, j) for j in rest]
        yield (
            tuple(tree),
            tuple(
                (j, some[rng.integers(len(some))]) for j, some in zip(rest, ends, strict=True)
            ),
        )


def _ends(graph: Graph, massive: set[int], joint: int) -> list[int]:
    """The ends of a joint at which a moving link may be split: with a body if there is one."""
    pair = graph.pairs[joint]
    return [s for s in (0, 1) if pair[s] in massive] or [s for s in (0, 1) if pair[s]]


def _spans(graph: Graph, tree: tuple[int, ...]) -> bool:
    """Whether joints connect all parts without a loop."""
    group = list(range(graph.parts))
    for j in tree:
        a, b = (group[x] for x in graph.pairs[j])
        if a == b:
            return False
        group = [a if g == b else g for g in group]
    return True


def _opened(graph: Graph, way, selection, p: int, rng) -> np.ndarray:
    """Null space of one opened linkage, copies added to their bodies; as rows."""
    order, slot, copies = _walk(graph, *way)
    copies = [(at, part) for at, part in copies if part in graph.part]
    below, above, joints = np.array(order, dtype=np.int64).reshape(-1, 3).T.copy()
    size, bodies = selection.parameters, len(graph.part)
    where = [slot[x] for x in graph.part] + [at for at, _ in copies]
    columns = len(where) * size
    basis, pivots = np.zeros((columns, columns), np.int64), np.zeros(columns, np.int64)
    rank = idle = 0
    while idle < 2:
        steps, rates = rng.integers(1, p, (2, len(joints)))
        M = free_momentum(
            below,
            above,
            graph.screws[joints],
            steps,
            rates,
            selection.pairs,
            selection.rows,
            size,
            p,
        )
        before, rank = rank, absorb(basis, pivots, rank, M[:, where].reshape(len(M), -1), p)
        idle = idle + 1 if rank == before else 0
    free = np.setdiff1d(np.arange(columns), pivots[:rank])
    null = np.zeros((free.size, columns), np.int64)
    null[np.arange(free.size), free] = 1
    null[:, pivots[:rank]] = (p - basis[:rank, free].T) % p
    blocks = null.reshape(free.size, len(where), size)
    folded = blocks[:, :bodies].copy()
    for k, (_, part) in enumerate(copies):
        folded[:, graph.part.index(part)] += blocks[:, bodies + k]
    return folded.reshape(free.size, -1) % p


def _walk(graph: Graph, tree, rest):
    """Joints away from the ground as slots and number, slots of parts, slots of copies."""
    slot, order, left = {0: 0}, [], list(tree)
    while left:
        for j in left:
            a, b = graph.pairs[j]
            if (a in slot) != (b in slot):
                known, new = (a, b) if a in slot else (b, a)
                slot[new] = len(slot)
                order.append((slot[known], slot[new], j))
                left.remove(j)
                break
    copies = []
    for j, s in rest:
        part, at = graph.pairs[j][s], graph.pairs[j][1 - s]
        copies.append((len(slot) + len(copies), part))
        order.append((slot[at], copies[-1][0], j))
    return order, slot, copies
