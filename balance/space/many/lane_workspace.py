"""Workspace of `balance.space.many.lane_kernels`; lanes are the last axis of its arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.space.conditions.order_kernels import EXPANSION_ORDERS, FIRST_EXPANSION_ORDER
from kinematics.closure.lane_poses import LanePoses, lane_poses_workspace
from kinematics.closure.lane_series import LaneSeries, lane_series_workspace
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, lanes
from kinematics.numerics.linalg.lane_pivoted_qr import LaneFactor, lane_factor_workspace


class FreshPose(NamedTuple):
    """Arrays of a finite pose; the last axis is that of the lanes.

    Attributes:
        series: motions there.
        H: displacements of the bodies (bodies, 1, 4, lanes).
        N: their rates, likewise.
        X: momentum rows (1, rows, bodies, parameters, lanes).
        rows: the same memory (rows, unknowns, lanes).
        radius: as from `radius_lanes` (4, lanes).
        poses: the pose.
    """

    series: LaneSeries
    H: Array
    N: Array
    X: Array
    rows: Array
    radius: Array
    poses: LanePoses


class OneLane(NamedTuple):
    """Arrays of one lane, for its basis.

    Attributes:
        order: places of columns, or their numbers (unknowns,).
        columns: unknowns that the factor has (unknowns,).
        serial_rows: factor of the transfers (unknowns, unknowns).
        R: factor of the conditions (unknowns, unknowns).
    """

    order: IntArray
    columns: IntArray
    serial_rows: Array
    R: Array


class LaneSweep(NamedTuple):
    """Arrays of one thread; the last axis is that of the lanes where one is named.

    Attributes:
        screws: joint screws (n, 3, lanes).
        mimics: mimic relations (g, n, lanes).
        series: motions at the reference pose.
        H: displacements of the bodies (bodies, orders, 4, lanes).
        N: their rates, likewise.
        X: momentum rows (orders, rows, bodies, parameters, lanes).
        rows: the same memory (orders, rows, unknowns, lanes).
        radius: as from `radius_lanes` (4, lanes).
        fresh: a finite pose.
        serial: factors of the transfers.
        factor: factors of the conditions.
        weight: weight of the rows of one order (lanes,).
        ranks: rank after each order (orders,).
        state: 1 for a lane that is settled, -1 for one that is given up (lanes,).
        lane: for the basis of one lane.
    """

    screws: Array
    mimics: Array
    series: LaneSeries
    H: Array
    N: Array
    X: Array
    rows: Array
    radius: Array
    fresh: FreshPose
    serial: LaneFactor
    factor: LaneFactor
    weight: Array
    ranks: IntArray
    state: IntArray
    lane: OneLane


def lane_sweep_workspace(chain: Chain, transfers: int, per: int, size: int) -> LaneSweep:
    """Allocate the workspace of `balance.space.many.lane_kernels.lane_sweep`.

    Args:
        chain: one of the linkages, planar.
        transfers: their number, with those between bodies of rigid parts.
        per: momentum components of each column.
        size: parameters of each body.
    """
    n, bodies, orders = (
        chain.parent.size,
        chain.links.size,
        EXPANSION_ORDERS[-1] + 1,
    )
    unknowns = bodies * size
    X, fresh_X = (lanes(count, per, bodies, size) for count in (orders, 1))
    fresh = FreshPose(
        lane_series_workspace(chain, FIRST_EXPANSION_ORDER),
        lanes(bodies, 1, 4),
        lanes(bodies, 1, 4),
        fresh_X,
        fresh_X.reshape(per, unknowns, VECTOR_WIDTH),
        lanes(4),
        lane_poses_workspace(chain),
    )
    lane_work = OneLane(
        np.zeros(unknowns, np.int64),
        np.zeros(unknowns, np.int64),
        np.zeros((unknowns, unknowns)),
        np.zeros((unknowns, unknowns)),
    )
    return LaneSweep(
        lanes(n, 3),
        lanes(len(chain.mimics), n),
        lane_series_workspace(chain, orders - 1),
        lanes(bodies, orders, 4),
        lanes(bodies, orders, 4),
        X,
        X.reshape(orders, per, unknowns, VECTOR_WIDTH),
        lanes(4),
        fresh,
        lane_factor_workspace(unknowns, transfers),
        lane_factor_workspace(unknowns, per),
        lanes(),
        np.zeros(orders, np.int64),
        np.zeros(VECTOR_WIDTH, np.int64),
        lane_work,
    )
