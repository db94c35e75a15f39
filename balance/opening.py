"""The serial design space: the transfers of a linkage, with its loops opened in every way.

Loops are opened by splitting a moving body: every joint stays, and a copy of the body, whose
parameters count for the body, hangs at its far end. The serial design space is the sum over
all ways of opening. A joint has the same transfers in all ways that give the same V, and
fewer if V is larger; so it is enough to walk through the linkage from the ground, to keep
the smallest V at each body, and to collect the transfers met. A walk that comes back to a
body does not add any, because V grows along it. (J. J. de Jong, PhD thesis, University of
Twente, section 5.5.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.elimination import FLOOR, null_space
from balance.momentum import parameters_per_body, rows_per_column
from balance.transfer import SAME, beyond, contains, transferable
from kinematics.kernels import kernel
from kinematics.linkage import Chain

__all__ = ["Transfers", "search", "transfers"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@kernel
def _nodes(parent, ends, links):
    """Rigid parts: node of each link (the ground last), and the first body on each, or -1."""
    n = parent.size
    node = np.arange(n + 1)
    for loop in range(ends.shape[0]):
        keep, drop = node[ends[loop, 1]], node[ends[loop, 0]]
        if drop == n:
            keep, drop = drop, keep
        for j in range(n + 1):
            if node[j] == drop:
                node[j] = keep
    body = np.full(n + 1, -1)
    for b in range(links.size - 1, -1, -1):
        body[node[links[b]]] = b
    return node, body


@kernel
def _owners(parent, node, body):
    """A number for every joint, the same for joints between which there is no body."""
    n = parent.size
    group = np.arange(n + 1)
    for j in range(n):
        a, b = node[parent[j]], node[j]
        if a != n and b != n and body[a] < 0 and body[b] < 0:
            keep, drop = group[a], group[b]
            for i in range(n + 1):
                if group[i] == drop:
                    group[i] = keep
    owner = np.empty(n, np.int64)
    for j in range(n):
        a, b = node[parent[j]], node[j]
        owner[j] = n + 1 + j
        if a != n and body[a] < 0:
            owner[j] = group[a]
        elif b != n and body[b] < 0:
            owner[j] = group[b]
    return owner


@kernel
def _cluster(entry, start, parent, node, body, joint, before, target):
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


@kernel
def _shares(count, before, target, body, passes, passed, floor):
    """Combinations of what passes the joints of a cluster that leave its inner links empty.

    Returns:
        Parameters that pass each joint; (combinations, joints, parameters).
    """
    size = passes.shape[2]
    first = np.zeros(count + 1, np.int64)
    row = np.empty(count, np.int64)
    inner = 0
    for k in range(count):
        first[k + 1] = first[k] + passed[k]
        row[k] = inner * size
        if target[k] >= 0 and body[target[k]] < 0:
            inner += 1
    A = np.zeros((inner * size, first[count]))
    for k in range(count):
        for c in range(passed[k]):
            for p in range(size):
                if body[target[k]] < 0:
                    A[row[k] + p, first[k] + c] = passes[k, c, p]
                if before[k] >= 0:
                    A[row[before[k]] + p, first[k] + c] = -passes[k, c, p]
    mixed = null_space(A, floor)
    out = np.zeros((mixed.shape[1], count, size))
    for m in range(mixed.shape[1]):
        for k in range(count):
            for c in range(passed[k]):
                for p in range(size):
                    out[m, k, p] += mixed[first[k] + c, m] * passes[k, c, p]
    return out


@kernel
def _keep(found, of, count, owner, x):
    """Add x to the orthonormal transfers of its owner, if it is not in their span.

    Returns:
        The transfers, their owners, and how many they are: there is more room.
    """
    if count == found.shape[0]:
        more, numbers = np.empty((2 * count + 16, x.size)), np.empty(2 * count + 16, np.int64)
        more[:count], numbers[:count] = found, of
        found, of = more, numbers
    # Twice is enough (B. N. Parlett, 1980).
    for _ in range(2):
        for r in range(count):
            if of[r] == owner:
                dot = 0.0
                for j in range(x.size):
                    dot += found[r, j] * x[j]
                for j in range(x.size):
                    x[j] -= dot * found[r, j]
    left = 0.0
    for j in range(x.size):
        left += x[j] * x[j]
    left = np.sqrt(left)
    if left <= SAME:
        return found, of, count
    for j in range(x.size):
        found[count, j] = x[j] / left
    of[count] = owner
    return found, of, count + 1


@kernel
def search(parent, screws, ends, links, size, rows, floor):
    """All transfers, orthonormal for each owner; see `transfers`.

    Returns:
        Transfers (count, parameters) and the owner of each; the owner of each joint and the
        rigid part of each link.
    """
    n, dim = screws.shape
    node, body = _nodes(parent, ends, links)
    body[n] = -1
    owner = _owners(parent, node, body)
    found, of, count = np.empty((16, links.size * size)), np.empty(16, np.int64), 0
    x = np.empty(links.size * size)
    # The joints of a cluster, what passes them, and the twists beyond them.
    joint, before = np.empty(2 * n, np.int64), np.empty(2 * n, np.int64)
    target = np.empty(2 * n, np.int64)
    passes, passed = np.empty((2 * n, size, size)), np.zeros(2 * n, np.int64)
    twists, tall = np.empty((2 * n, dim, dim)), np.zeros(2 * n, np.int64)
    # Bodies reached, the owner of the joint they were reached by, what they can attain.
    room = 2 * n + 2
    at, by = np.empty(room, np.int64), np.empty(room, np.int64)
    spans, height = np.empty((room, dim, dim)), np.empty(room, np.int64)
    at[0], by[0], height[0] = n, -1, 0
    reached = 1
    crossed = np.zeros(2 * n + 1, np.bool_)
    i = 0
    while i < reached:
        start = at[i]
        for entry in range(n):
            a, b = node[parent[entry]], node[entry]
            if a == b or (a != start and b != start) or owner[entry] == by[i]:
                continue
            # Where every twist can be attained, least can be exchanged: nothing new.
            if crossed[owner[entry]] and height[i] == dim:
                continue
            crossed[owner[entry]] = True
            joints = _cluster(entry, start, parent, node, body, joint, before, target)
            if reached + joints > room:
                room *= 2
                at, by = np.concatenate((at, at)), np.concatenate((by, by))
                spans, height = np.concatenate((spans, spans)), np.concatenate((height, height))
            for k in range(joints):
                s = screws[joint[k]]
                V = spans[i, : height[i]]
                if before[k] >= 0:
                    V = twists[before[k], : tall[before[k]]]
                passed[k] = tall[k] = 0
                if target[k] < 0:
                    continue
                passed[k] = transferable(s, V, size, rows, floor, passes[k])
                tall[k] = beyond(s, V, floor, twists[k])
                if body[target[k]] < 0:
                    continue
                U = twists[k, : tall[k]]
                known = False
                for other in range(reached):
                    if at[other] == target[k] and contains(U, spans[other, : height[other]]):
                        known = True
                        break
                if not known:
                    at[reached], by[reached], height[reached] = target[k], owner[entry], tall[k]
                    spans[reached] = twists[k]
                    reached += 1
            shares = passes[0, : passed[0]].reshape((passed[0], 1, size))
            if joints > 1 or (target[0] >= 0 and body[target[0]] < 0):
                shares = _shares(joints, before, target, body, passes, passed, floor)
            for c in range(shares.shape[0]):
                x[:] = 0.0
                for k in range(joints):
                    b = body[target[k]] if target[k] >= 0 else -1
                    for p in range(size):
                        if b >= 0:
                            x[b * size + p] += shares[c, k, p]
                        if k == 0 and start != n:
                            x[body[start] * size + p] -= shares[c, k, p]
                found, of, count = _keep(found, of, count, owner[entry], x)
        i += 1
    return found[:count].copy(), of[:count].copy(), owner, node


class Transfers(NamedTuple):
    """What may be exchanged, in the frame and units of the chain.

    Attributes:
        rows: transfers (count, parameters): added to all bodies, they change no momentum.
        owner: what carries each of them (count,): a number shared by the joints that it
            passes through, or ``-1 - part`` between bodies of one rigid part.
        joints: the number of each joint of the chain (n,).
        part: rigid part of each link, and last of the ground, whose number is n; (n + 1,).
    """

    rows: Array
    owner: IntArray
    joints: IntArray
    part: IntArray


def transfers(chain: Chain, force: bool = False, floor: float = FLOOR) -> Transfers:
    """Every inertia transfer of a linkage whose loops are opened by splitting bodies.

    Args:
        chain: the linkage without idle joints.
        force: whether only linear momentum counts, and parameters m, mc.
        floor: relative size of round-off.
    """
    size = parameters_per_body(chain.planar, force)
    rows, owner, joints, part = search(
        chain.parent, chain.screws, chain.ends, chain.links, size,
        rows_per_column(chain.planar, force), floor,
    )  # fmt: skip
    return _with_rigid_parts(Transfers(rows, owner, joints, part), chain.links, size)


def _with_rigid_parts(found: Transfers, links: IntArray, size: int) -> Transfers:
    """As found, and all that bodies of one rigid part can exchange, or the ground can take."""
    part, ground = found.part[links], found.joints.size
    parts = part.tolist()
    if ground not in parts and len(set(parts)) == len(parts):
        return found
    first = {p: b for b, p in reversed(list(enumerate(parts)))}
    rows, owner = [found.rows], [found.owner]
    for b, p in enumerate(parts):
        if p != ground and b == first[p]:
            continue
        block = np.zeros((size, part.size, size))
        block[:, b] = np.eye(size)
        if p != ground:
            block[:, first[p]] = -np.eye(size)
        rows.append(block.reshape(size, -1))
        owner.append(np.full(size, -1 - p))
    return found._replace(rows=np.concatenate(rows), owner=np.concatenate(owner))
