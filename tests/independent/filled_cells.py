"""Matter of limited density by a second route: cells of the regions, and linear programs.

A region is cut into equal cells along the axes of the link frame. Matter in the cells that lie
inside is allowed, so that their linear program is an upper bound of the least mass. All matter
in the region lies in the cells that touch it, with its first moment off the middles of the
cells by at most half a cell for each kilogram: that program is a lower bound.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from tests.independent.second_counterweights import (
    conditions,
    given_parameters,
    point_parameters,
    to_inertial,
)


def cells(region, count):
    """Middles of cells (n, 3) in the link frame, their size (3,), and which lie inside."""
    half = np.linalg.norm(region.place[:3, :3], axis=1)
    if region.kind in ("box", "hull"):
        half = np.abs(region.vertices @ region.place[:3, :3].T).max(axis=0)
    if region.kind == "cylinder":
        A = region.place[:3, :3]
        half = np.hypot(A[:, 0], A[:, 1]) + np.abs(A[:, 2])
    sides = (count / np.prod(half)) ** (1 / 3) * half
    n = np.maximum(2, np.round(sides)).astype(int)
    ticks = [(2 * np.arange(k) + 1) / k - 1.0 for k in n]
    middles = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3) * half
    size = 2.0 * half / n
    corners = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T * size
    points = middles + region.place[:3, 3]
    inside = np.all(
        [region.excess(region.to_unit(points + corner)) <= 1e-9 for corner in corners], axis=0
    )
    reach = region.excess(region.to_unit(points))
    near = reach <= np.abs(np.linalg.inv(region.place[:3, :3])).sum(axis=1).max() * size.max()
    return points[near], size, inside[near]


def least_masses(space, regions, density, count, move=None):
    """Lower and upper bound of the least mass that balances forces; infinite if none does.

    Shares of the given masses in ``move`` may be taken, at a hundredth of the price, if at
    least their mass is placed on the link again.
    """
    rows, given = conditions(space), given_parameters(space)
    target = -rows @ given.reshape(-1)
    per_link = rows.reshape(len(rows), len(space.bodies), -1)
    columns, capacities, insides, slack, slack_owner = [], [], [], [], []
    taken = []
    for k, (name, region) in enumerate(regions.items()):
        part = per_link[:, space.bodies.index(name)]
        points, size, inside = cells(region, count)
        columns.append(part @ point_parameters(space, to_inertial(space, name, points)).T)
        capacities.append(np.full(len(points), density * np.prod(size)))
        insides.append(inside)
        ends = np.vstack([np.zeros(3), 0.5 * np.diag(size)])
        values = point_parameters(space, to_inertial(space, name, ends))
        slack.append(part @ (values[1:] - values[0]).T)
        slack_owner += [k] * 3
        if move and name in move:
            body = given[space.bodies.index(name)]
            taken.append((k, -part @ body, body[0], move[name]))
    A, cap = np.hstack(columns), np.concatenate(capacities)
    owner = np.repeat(np.arange(len(columns)), [column.shape[1] for column in columns])
    inner = np.concatenate(insides)
    none = np.zeros((len(A), 0)), []
    upper = _solve(A[:, inner], target, cap[inner], owner[inner], *none, taken)
    lower = _solve(A, target, cap, owner, np.hstack(slack), slack_owner, taken)
    return lower, upper


def _solve(A, target, cap, owner, slack, slack_owner, taken):
    """Least mass of cells; slacks of first moments are up to the mass of their link."""
    n, k, t = A.shape[1], slack.shape[1], len(taken)
    limit = np.array([-(owner == b).astype(float) for b in slack_owner]).reshape(k, n)
    placed = np.array([-(owner == b).astype(float) for b, *_ in taken]).reshape(t, n)
    masses = np.array([mass for _, _, mass, _ in taken])
    shares = np.array([column for _, column, _, _ in taken]).reshape(t, len(A)).T
    answer = linprog(
        np.concatenate([np.ones(n), np.zeros(k), -0.99 * masses]),
        A_ub=np.block(
            [
                [limit, np.eye(k), np.zeros((k, t))],
                [limit, -np.eye(k), np.zeros((k, t))],
                [placed, np.zeros((t, k)), np.diag(masses)],
            ]
        ),
        b_ub=np.zeros(2 * k + t),
        A_eq=np.hstack([A, slack, shares]),
        b_eq=target,
        bounds=[
            *zip(0 * cap, cap, strict=True),
            *[(None, None)] * k,
            *[(0.0, most) for *_, most in taken],
        ],
    )
    return answer.fun if answer.status == 0 else np.inf
