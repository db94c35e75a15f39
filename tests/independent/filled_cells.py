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


def least_masses(space, regions, density, count):
    """Lower and upper bound of the least mass that balances forces; infinite if none does."""
    rows, given = conditions(space), given_parameters(space)
    target = -rows @ given.reshape(-1)
    per_link = rows.reshape(len(rows), len(space.bodies), -1)
    columns, capacities, insides, slack, slack_owner = [], [], [], [], []
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
    A, cap = np.hstack(columns), np.concatenate(capacities)
    owner = np.repeat(np.arange(len(columns)), [column.shape[1] for column in columns])
    inner = np.concatenate(insides)
    upper = _solve(A[:, inner], target, cap[inner], None, None)
    lower = _solve(A, target, cap, np.hstack(slack), (owner, slack_owner))
    return lower, upper


def _solve(A, target, cap, slack, owners):
    """Least mass of cells; with slacks of first moments up to the mass of their link."""
    n = A.shape[1]
    if slack is None:
        answer = linprog(
            np.ones(n), A_eq=A, b_eq=target, bounds=np.column_stack([0 * cap, cap])
        )
    else:
        owner, slack_owner = owners
        k = slack.shape[1]
        limit = np.array([-(owner == b).astype(float) for b in slack_owner])
        answer = linprog(
            np.append(np.ones(n), np.zeros(k)),
            A_ub=np.block([[limit, np.eye(k)], [limit, -np.eye(k)]]),
            b_ub=np.zeros(2 * k),
            A_eq=np.hstack([A, slack]),
            b_eq=target,
            bounds=[*zip(0 * cap, cap, strict=True), *[(None, None)] * k],
        )
    return answer.fun if answer.status == 0 else np.inf
