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

from balance.space.momentum.regressor import parameters_per_body, rows_per_column
from balance.space.transfers.joint_kernels import (
    Cluster,
    FoundTransfers,
    add_shared_transfers,
    add_transfers,
    attainable_beyond,
    passing_parameters,
    span_contains,
)
from balance.space.transfers.rigid_parts import find_cluster, number_rigid_parts
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.tolerances import RANK_RELATIVE


@kernel(reference_counting=False)
def search_transfers(parent, screws, rigid_parts, size, rows, tolerance, workspace):
    """Search the linkage from the ground for its transfers.

    Args:
        parent: in: link before each joint (n,).
        screws: in: joint screws (n, dim).
        rigid_parts: in: rigid part of each link, the first body on each, and a number for
            every joint; see `number_rigid_parts`.
        size: parameters of each body.
        rows: momentum components that count.
        tolerance: relative size of round-off.
        workspace: as from `search_workspace`. Its first three are out: the transfers,
            orthonormal for each owner; the owner of each; and the smallest size that a
            decision kept, and the largest that one dropped.

    Returns:
        Number of transfers found, or -1 if there is too little workspace.
    """
    node, body, owner = rigid_parts
    transfers, owners, gap, reached, spans, passes, twists, numbers, work, mixing = workspace
    known_transfers = FoundTransfers(transfers, owners, gap)
    n, dim = screws.shape
    joint, before, target = numbers[0], numbers[1], numbers[2]
    passed, tall, crossed, order = numbers[3], numbers[4], numbers[5], numbers[6]
    x, s = twists[-1, 0], twists[-1, 1]
    gap[0], gap[1] = 1.0, 0.0
    for k in range(crossed.size):
        crossed[k] = 0
    # Bodies reached, by which owner, and how many twists they can attain, which are in spans.
    reached[0, 0], reached[0, 1], reached[0, 2] = n, -1, 0
    count, states, i = 0, 1, 0
    # Every state is a rigid part with a span of twists that it can attain.
    while i < states:
        start, height = reached[i, 0], reached[i, 2]
        # Through every joint at that part, up to the next bodies.
        for entry in range(n):
            a, b, carrier = node[parent[entry]], node[entry], owner[entry]
            if a == b or (a != start and b != start) or carrier == reached[i, 1]:
                continue
            # Where every twist can be attained, least can be exchanged: nothing new.
            if crossed[carrier] and height == dim:
                continue
            crossed[carrier] = 1
            joints = find_cluster(entry, start, parent, node, body, joint, before, target)
            # What passes the joints, and the twists beyond them.
            passing = 0
            for k in range(joints):
                passed[k] = tall[k] = 0
                j = before[k]
                if target[k] >= 0:
                    for c in range(dim):
                        s[c] = screws[joint[k], c]
                    V = twists[j, : tall[j]] if j >= 0 else spans[i, :height]
                    passed[k] = passing_parameters(
                        s, V, size, rows, tolerance, work, order, passes[k], gap
                    )
                    tall[k] = attainable_beyond(s, V, tolerance, twists[k], gap)
                passing += passed[k]
            if states + joints > spans.shape[0] or count + passing >= transfers.shape[0]:
                return -1
            for k in range(joints):
                t, height_there = target[k], tall[k]
                covered = t < 0 or body[t] < 0
                for other in range(0 if covered else states):
                    if covered or reached[other, 0] != t:
                        continue
                    covered = span_contains(
                        twists[k, :height_there], spans[other, : reached[other, 2]], x, gap
                    )
                # A new state, with a copy of its span.
                if not covered:
                    reached[states, 0], reached[states, 1] = t, carrier
                    reached[states, 2] = height_there
                    for v in range(height_there):
                        for c in range(dim):
                            spans[states, v, c] = twists[k, v, c]
                    states += 1
            through = Cluster(start, before, target, body, joints)
            if joints > 1 or (target[0] >= 0 and body[target[0]] < 0):
                count = add_shared_transfers(
                    known_transfers,
                    count,
                    carrier,
                    passes,
                    passed,
                    through,
                    tolerance,
                    numbers[7:],
                    mixing,
                )
                if count < 0:
                    return -1
            else:
                count = add_transfers(
                    known_transfers, count, carrier, passes, passed[0], through
                )
        i += 1
    return count


def search_workspace(
    n: int, dim: int, unknowns: int, size: int, rows: int, capacity: int
) -> tuple[Array | IntArray, ...]:
    """Allocate transfers, their owners and the arrays of the search; see `search_transfers`.

    Args:
        dim: components of a twist: 6, in a plane 3.
        unknowns: parameters of all bodies.
        size: parameters of each body.
        rows: momentum components that count.
        capacity: largest number of states of the search.
    """
    wide = 2 * capacity + 4 * size
    return (
        np.empty((2 * capacity, unknowns)),
        np.empty(2 * capacity, np.int64),
        np.empty(2),
        np.empty((capacity, 3), np.int64),
        np.empty((capacity, dim, dim)),
        np.empty((2 * n, size, size)),
        np.empty((2 * n + 1, dim, dim)),
        np.empty((10, wide), np.int64),
        np.empty((rows * (dim + 1) + 2 * size, size)),
        np.empty(2 * wide * wide),
    )


def enough_states(n: int, size: int) -> int:
    """Give a number of states that is enough for the search in most linkages.

    Args:
        n: number of joints.
        size: parameters of each body.
    """
    return 2 * n + size


class Transfers(NamedTuple):
    """Inertia transfers in the frame and units of the chain.

    Attributes:
        rows: transfers (count, parameters): added to all bodies, they change no momentum.
        owner: owner of each of them (count,): a number shared by the joints that it passes
            through, or ``-1 - part`` between bodies of one rigid part.
        owner_of_joint: number of the owner of each joint of the chain (n,).
        rigid_part: rigid part of each link, and last that of the ground, n; (n + 1,).
        kept: smallest size, of a vector of size 1, that a decision kept.
        dropped: largest size that a decision dropped as round-off.
    """

    rows: Array
    owner: IntArray
    owner_of_joint: IntArray
    rigid_part: IntArray
    kept: float
    dropped: float


def serial_transfers(
    chain: Chain, force: bool = False, tolerance: float = RANK_RELATIVE
) -> Transfers:
    """Find every inertia transfer of a linkage whose loops are opened by splitting bodies.

    Args:
        chain: the linkage without idle joints.
        force: whether only linear momentum counts, and parameters m, mc.
        tolerance: relative size of round-off.
    """
    size = parameters_per_body(chain.planar, force)
    n, dim = chain.screws.shape
    rigid_parts = chain.once(number_rigid_parts)
    node, _, joints = rigid_parts
    rows, unknowns = rows_per_column(chain.planar, force), chain.links.size * size
    workspace = chain.borrow(
        (size,),
        lambda: search_workspace(n, dim, unknowns, size, rows, enough_states(n, size)),
    )
    while True:
        count = search_transfers(
            chain.parent, chain.screws, rigid_parts, size, rows, tolerance, workspace
        )
        if count >= 0:
            break
        workspace = search_workspace(n, dim, unknowns, size, rows, 2 * len(workspace[3]))
    kept, dropped = workspace[2].tolist()
    transfers = Transfers(
        workspace[0][:count].copy(), workspace[1][:count].copy(), joints, node, kept, dropped
    )
    chain.give_back((size,), workspace)
    return _with_rigid_parts(transfers, chain.links, size)


def _with_rigid_parts(transfers: Transfers, links: IntArray, size: int) -> Transfers:
    """Add all that bodies of one rigid part can exchange, and that the ground can take."""
    part, ground = transfers.rigid_part[links], transfers.owner_of_joint.size
    parts = part.tolist()
    if ground not in parts and len(set(parts)) == len(parts):
        return transfers
    first = {p: b for b, p in reversed(list(enumerate(parts)))}
    rows, owner = [transfers.rows], [transfers.owner]
    for b, p in enumerate(parts):
        if p != ground and b == first[p]:
            continue
        block = np.zeros((size, part.size, size))
        block[:, b] = np.eye(size)
        if p != ground:
            block[:, first[p]] = -np.eye(size)
        rows.append(block.reshape(size, -1))
        owner.append(np.full(size, -1 - p))
    return transfers._replace(rows=np.concatenate(rows), owner=np.concatenate(owner))
