"""Transfers of many planar geometries of one topology side by side, one in each lane.

Where every rigid part has a body, the transfers of a plane follow from the kinds of the joints:
a revolute joint passes the point mass on its axis, ``(1, x, y, x² + y²)``, a prismatic one the
pure inertia, and the displacement along it if nothing turns below. (For force balance: mass at
the axis, and all displacements.) `balance.space.transfers.serial_part` finds the same by
a search, geometry by geometry.
"""

from __future__ import annotations

import numpy as np

from balance.space.momentum.regressor import parameters_per_body
from balance.space.transfers.rigid_parts import number_rigid_parts
from balance.space.transfers.serial_part import serial_transfers
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import broadcast, load_vector, square_root, store_vector

# Kinds of transfers: parameter 1, 2 or 3 alone; a point mass; a displacement along the joint.
POINT_MASS, DISPLACEMENT = 0, 4


def lane_transfers(chain: Chain, force: bool) -> IntArray | None:
    """List the transfers of a planar topology.

    Args:
        chain: one of the linkages, without idle joints.
        force: whether only linear momentum counts.

    Returns:
        Joint, body before it or -1, body after it or -1, and kind (count, 4); None if links
        have no parameters, so that the transfers depend on the geometry.
    """
    node, body, owner = chain.once(number_rigid_parts)
    n, transfers = chain.parent.size, serial_transfers(chain, force)
    if not chain.planar or parameters_per_body(True, force) != (3 if force else 4):
        return None
    if (owner[node[chain.parent] != node[:n]] <= n).any():
        return None
    rows = []
    for j in range(n):
        a, b = int(node[chain.parent[j]]), int(node[j])
        count = int(np.sum(transfers.owner == owner[j])) if a != b else 0
        if chain.screws[j, 0] != 0.0:
            kinds = [POINT_MASS][:count]
        elif force:
            kinds = [1, 2][:count]
        else:
            kinds = [3, DISPLACEMENT][:count]
        rows += [[j, body[a], body[b], kind] for kind in kinds]
    return np.array(rows, np.int64).reshape(-1, 4)


@kernel(reference_counting=False)
def fill_lane_transfers(listed, size, screws, F):
    """Write the transfers of every lane, each of size 1.

    Args:
        listed: in: as from `lane_transfers` (count, 4).
        size: parameters of each body.
        screws: in: joint screws (n, 3, lanes).
        F: out: rows (≥ count, unknowns, lanes).
    """
    zero, one = broadcast(0.0), broadcast(1.0)
    for r in range(listed.shape[0]):
        j, kind = listed[r, 0], listed[r, 3]
        sides = (listed[r, 1] >= 0) + (listed[r, 2] >= 0)
        share = one / square_root(broadcast(1.0 * max(sides, 1)))
        turn, u, v = (
            load_vector(screws[j, 0], 0),
            load_vector(screws[j, 1], 0),
            load_vector(screws[j, 2], 0),
        )
        # The axis is at (x, y) = turn (-v, u).
        x, y = zero - turn * v, turn * u
        square = x * x + y * y
        length = one + square + (square * square if size == 4 else zero)
        if kind == POINT_MASS:
            share = share / square_root(length)
        for i in range(F.shape[1]):
            store_vector(F[r, i], 0, zero)
        for side in range(2):
            at = listed[r, 1 + side] * size
            if at < 0:
                continue
            part = share if side == 1 else zero - share
            if kind == POINT_MASS:
                store_vector(F[r, at], 0, part)
                store_vector(F[r, at + 1], 0, part * x)
                store_vector(F[r, at + 2], 0, part * y)
                if size == 4:
                    store_vector(F[r, at + 3], 0, part * square)
            elif kind == DISPLACEMENT:
                store_vector(F[r, at + 1], 0, part * u)
                store_vector(F[r, at + 2], 0, part * v)
            else:
                store_vector(F[r, at + kind], 0, part)
