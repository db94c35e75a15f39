"""Rigid parts of a linkage, and clusters: joints between which there are no bodies."""

from __future__ import annotations

import numpy as np

from kinematics.model.arrays import Chain, freeze
from kinematics.numerics.array_types import IntArray
from kinematics.numerics.compiled.jit import kernel


def number_rigid_parts(chain: Chain) -> tuple[IntArray, IntArray, IntArray]:
    """Number the rigid parts of a chain, and the owners of transfers.

    Returns:
        Rigid part of each link, the ground last (n + 1,); the first body on each, or -1
        (n + 1,); a number for every joint, equal for joints between which there is no body
        (n,).
    """
    parent, n = chain.parent.tolist(), chain.parent.size
    node, whole = list(range(n + 1)), [[j] for j in range(n + 1)]
    for end, successor in chain.ends.tolist():
        keep, drop = node[successor], node[end]
        _merge(node, whole, *((drop, keep) if drop == n else (keep, drop)))
    body = [-1] * (n + 1)
    for b in range(chain.links.size - 1, -1, -1):
        body[node[chain.links[b]]] = b
    body[n] = -1
    sides = [(node[parent[j]], node[j]) for j in range(n)]
    group, members = list(range(n + 1)), [[j] for j in range(n + 1)]
    for a, b in sides:
        if a != n and b != n and body[a] < 0 and body[b] < 0:
            _merge(group, members, group[a], group[b])
    owner = [
        group[a]
        if a != n and body[a] < 0
        else group[b]
        if b != n and body[b] < 0
        else n + 1 + j
        for j, (a, b) in enumerate(sides)
    ]
    return freeze(node, np.int64), freeze(body, np.int64), freeze(owner, np.int64)


def _merge(name: list[int], members: list[list[int]], keep: int, drop: int) -> None:
    """Merge the members of one group into another."""
    if keep != drop:
        for j in members[drop]:
            name[j] = keep
        members[keep] += members[drop]
        members[drop] = []


@kernel(reference_counting=False)
def find_cluster(entry, start, parent, node, body, joint, before, target):
    """List the joints from a body through one of its joints up to the next bodies.

    A joint between links without bodies is met from either side.

    Args:
        entry: the joint at the body.
        start: rigid part of the body.
        parent: in: link before each joint (n,).
        node: in: rigid part of each link; the last, which -1 finds, is the ground's (n + 1,).
        body: in: the first body on each rigid part, or -1 (n + 1,).
        joint: out: the joints (≥ n,).
        before: out: the place among them of the joint before each, or -1 (≥ n,).
        target: out: rigid part after each, or -1 if nothing can be carried to it: the ground,
            or a part reached before (≥ n,).

    Returns:
        Number of joints.
    """
    n = parent.size
    joint[0], before[0] = entry, -1
    count = 1
    k = 0
    # Breadth first: beyond joint k, to a part without a body, all its other joints.
    while k < count:
        j = joint[k]
        source = start if before[k] < 0 else target[before[k]]
        t = node[j] if node[j] != source else node[parent[j]]
        for other in range(k):
            if body[t] < 0 and target[other] == t:
                t = n
        target[k] = t if t != n else -1
        if t != n and body[t] < 0:
            for other in range(n):
                a, b = node[parent[other]], node[other]
                if other != j and a != b and (a == t or b == t):
                    joint[count], before[count] = other, k
                    count += 1
        k += 1
    return count
