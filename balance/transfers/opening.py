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

from balance.conditions.elimination import FLOOR
from balance.conditions.solutions import null_space
from balance.momentum import parameters_per_body, rows_per_column
from balance.transfers.clusters import cluster, parts
from balance.transfers.joint import SAME, beyond, contains, transferable
from kinematics.kernels import kernel
from kinematics.linkage import Chain

__all__ = ["CLEAR", "SURE", "Transfers", "search", "transfers"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# What is dropped as round-off is beyond doubt below this part of the limit for it; what is
# kept, above this part of the whole. In regular linkages the sizes are 1e-15 and 1e-2.
SURE, CLEAR = 0.01, 1e-6


@kernel(borrows=True)
def _cross(
    joints, V, screws, joint, before, target, size, rows, floor, work, order, passes, passed,
    twists, tall, gap,
):  # fmt: skip
    """What passes the joints of a cluster with twists V before it, and the twists beyond."""
    for k in range(joints):
        s = screws[joint[k]]
        passed[k] = tall[k] = 0
        if target[k] < 0:
            continue
        j = before[k]
        if j < 0:
            passed[k] = transferable(s, V, size, rows, floor, work, order, passes[k], gap)
            tall[k] = beyond(s, V, floor, twists[k], gap)
        else:
            U = twists[j, : tall[j]]
            passed[k] = transferable(s, U, size, rows, floor, work, order, passes[k], gap)
            tall[k] = beyond(s, U, floor, twists[k], gap)


@kernel(borrows=True)
def _known(reached, spans, count, target, U, x, gap):
    """Whether a body was reached before with no more than the twists U."""
    for other in range(count):
        if reached[other, 0] == target and contains(
            U, spans[other, : reached[other, 2]], x, gap
        ):
            return True
    return False


@kernel(borrows=True)
def _keep(found, of, count, owner, shares, combinations, start, target, body, joints, gap):
    """Add what passes a cluster to the transfers of its owner, if not in their span.

    Transfers are orthonormal for each owner, which takes two rounds (B. N. Parlett, 1980).

    Returns:
        How many transfers there are now.
    """
    size = shares.shape[2]
    for c in range(combinations):
        x = found[count]
        for j in range(x.size):
            x[j] = 0.0
        for k in range(joints):
            b = body[target[k]] if target[k] >= 0 else -1
            for p in range(size):
                if b >= 0:
                    x[b * size + p] += shares[k, c, p]
                if k == 0 and body[start] >= 0:
                    x[body[start] * size + p] -= shares[k, c, p]
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
            gap[1] = max(gap[1], left)
        else:
            gap[0] = min(gap[0], left)
            for j in range(x.size):
                x[j] /= left
            of[count] = owner
            count += 1
    return count


@kernel
def _share(
    found, of, known, owner, passes, passed, start, target, body, count, before, floor, gap
):  # fmt: skip
    """Keep combinations of what passes the joints that leave the inner links empty.

    Returns:
        How many transfers there are now.
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
    n, m = first[count], inner * size
    A, mixed = np.zeros((m, n)), np.empty((n, n))
    for k in range(count):
        for c in range(passed[k]):
            for p in range(size):
                if body[target[k]] < 0:
                    A[row[k] + p, first[k] + c] = passes[k, c, p]
                if before[k] >= 0:
                    A[row[before[k]] + p, first[k] + c] = -passes[k, c, p]
    combinations = null_space(A, m, n, floor, np.empty(n, np.int64), mixed, gap)
    out = np.zeros((count, combinations, size))
    for i in range(combinations):
        for k in range(count):
            for c in range(passed[k]):
                for p in range(size):
                    out[k, i, p] += mixed[i, first[k] + c] * passes[k, c, p]
    return _keep(found, of, known, owner, out, combinations, start, target, body, count, gap)


@kernel(borrows=True)
def _walk(
    parent, screws, node, body, owner, size, rows, floor, found, of, reached, spans, passes,
    twists, numbers, work, gap,
):  # fmt: skip
    """Walk through the linkage from the ground; see `search`.

    Returns:
        How many transfers were found, or -1 if there is too little room.
    """
    n, dim = screws.shape
    joint, before, target = numbers[0], numbers[1], numbers[2]
    passed, tall, crossed, order = numbers[3], numbers[4], numbers[5], numbers[6]
    for k in range(crossed.size):
        crossed[k] = 0
    # Bodies reached, by which owner, and how many twists they can attain, which are in spans.
    reached[0, 0], reached[0, 1], reached[0, 2] = n, -1, 0
    count, states, i = 0, 1, 0
    while i < states:
        start, height = reached[i, 0], reached[i, 2]
        for entry in range(n):
            a, b = node[parent[entry]], node[entry]
            if a == b or (a != start and b != start) or owner[entry] == reached[i, 1]:
                continue
            # Where every twist can be attained, least can be exchanged: nothing new.
            if crossed[owner[entry]] and height == dim:
                continue
            crossed[owner[entry]] = 1
            joints = cluster(entry, start, parent, node, body, joint, before, target)
            _cross(
                joints, spans[i, :height], screws, joint, before, target, size, rows, floor,
                work, order, passes, passed, twists, tall, gap,
            )  # fmt: skip
            passing = 0
            for k in range(joints):
                passing += passed[k]
            if states + joints > spans.shape[0] or count + passing >= found.shape[0]:
                return -1
            for k in range(joints):
                t = target[k]
                if t < 0 or body[t] < 0:
                    continue
                U = twists[k, : tall[k]]
                if not _known(reached, spans, states, t, U, twists[-1, 0], gap):
                    reached[states, 0], reached[states, 1] = t, owner[entry]
                    reached[states, 2] = tall[k]
                    for v in range(tall[k]):
                        for c in range(dim):
                            spans[states, v, c] = twists[k, v, c]
                    states += 1
            if joints > 1 or (target[0] >= 0 and body[target[0]] < 0):
                count = _share(
                    found, of, count, owner[entry], passes, passed, start, target, body,
                    joints, before, floor, gap,
                )  # fmt: skip
            else:
                count = _keep(
                    found, of, count, owner[entry], passes, passed[0], start, target, body,
                    joints, gap,
                )  # fmt: skip
        i += 1
    return count


@kernel
def search(parent, screws, node, body, owner, unknowns, size, rows, floor):
    """All transfers, orthonormal for each owner; see `transfers` and `parts`.

    Returns:
        Transfers (count, parameters), the owner of each, and how many they are; rows after
        those are room. Then the smallest size that was kept, and the largest that was dropped
        as round-off, in all decisions.
    """
    n, dim = screws.shape
    # The joints of a cluster, what passes them, and the twists beyond them.
    numbers = np.empty((7, max(2 * n + 1, size)), np.int64)
    passes, twists = np.empty((2 * n, size, size)), np.empty((2 * n + 1, dim, dim))
    work = np.empty((rows * (dim + 1) + 2 * size, size))
    room = 2 * n + size
    gap = np.array([1.0, 0.0])
    while True:
        found, of = np.empty((2 * room, unknowns)), np.empty(2 * room, np.int64)
        reached, spans = np.empty((room, 3), np.int64), np.empty((room, dim, dim))
        count = _walk(
            parent, screws, node, body, owner, size, rows, floor, found, of, reached, spans,
            passes, twists, numbers, work, gap,
        )  # fmt: skip
        if count >= 0:
            return found, of, count, gap
        room *= 2


class Transfers(NamedTuple):
    """What may be exchanged, in the frame and units of the chain.

    Attributes:
        rows: transfers (count, parameters): added to all bodies, they change no momentum.
        owner: what carries each of them (count,): a number shared by the joints that it
            passes through, or ``-1 - part`` between bodies of one rigid part.
        joints: the number of each joint of the chain (n,).
        part: rigid part of each link, and last of the ground, whose number is n; (n + 1,).
        kept: smallest size, of a vector of size 1, that a decision kept.
        dropped: largest size that a decision dropped as round-off.
    """

    rows: Array
    owner: IntArray
    joints: IntArray
    part: IntArray
    kept: float
    dropped: float


def transfers(chain: Chain, force: bool = False, floor: float = FLOOR) -> Transfers:
    """Every inertia transfer of a linkage whose loops are opened by splitting bodies.

    Args:
        chain: the linkage without idle joints.
        force: whether only linear momentum counts, and parameters m, mc.
        floor: relative size of round-off.
    """
    size = parameters_per_body(chain.planar, force)
    node, body, joints = parts(chain.parent, chain.ends, chain.links)
    rows, owner, count, gap = search(
        chain.parent, chain.screws, node, body, joints, chain.links.size * size, size,
        rows_per_column(chain.planar, force), floor,
    )  # fmt: skip
    kept, dropped = gap.tolist()
    found = Transfers(rows[:count], owner[:count], joints, node, kept, dropped)
    return _with_rigid_parts(found, chain.links, size)


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
