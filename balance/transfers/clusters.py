"""Rigid parts of a linkage, and clusters: joints between which there are no bodies."""

from __future__ import annotations

from kinematics.kernels import kernel

__all__ = ["cluster", "parts"]


@kernel(borrows=True)
def parts(parent, ends, links, node, group, body, owner):
    """Find rigid parts, and who carries what passes a joint.

    Args:
        parent: as in `kinematics.linkage.Chain`, as are the next two.
        ends: loops.
        links: links of the bodies.
        node: takes the node of each link, the ground last (n + 1,).
        group: room for as many numbers.
        body: takes the first body on each, or -1 (n + 1,).
        owner: takes a number for every joint, the same for joints between which there is no
            body (n,).
    """
    n = parent.size
    for j in range(n + 1):
        node[j] = group[j] = j
        body[j] = -1
    for loop in range(ends.shape[0]):
        keep, drop = node[ends[loop, 1]], node[ends[loop, 0]]
        if drop == n:
            keep, drop = drop, keep
        for j in range(n + 1):
            if node[j] == drop:
                node[j] = keep
    for b in range(links.size - 1, -1, -1):
        body[node[links[b]]] = b
    body[n] = -1
    for j in range(n):
        a, b = node[parent[j]], node[j]
        if a != n and b != n and body[a] < 0 and body[b] < 0:
            keep, drop = group[a], group[b]
            for i in range(n + 1):
                if group[i] == drop:
                    group[i] = keep
    for j in range(n):
        a, b = node[parent[j]], node[j]
        owner[j] = n + 1 + j
        if a != n and body[a] < 0:
            owner[j] = group[a]
        elif b != n and body[b] < 0:
            owner[j] = group[b]


@kernel(borrows=True)
def cluster(entry, start, parent, node, body, joint, before, target):
    """The joints from a body through one of its joints up to the next bodies.

    Fills in the joints, the place among them of the one before each, and the rigid part
    after each; -1 for one that nothing can be carried to: the ground, or a part reached
    before. A joint between links without bodies is met from either side.

    Returns:
        How many they are.
    """
    n = parent.size
    joint[0], before[0] = entry, -1
    count = 1
    k = 0
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
