"""Continuation of closed poses along a ray, away from the reference pose."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle

import numpy as np

from kinematics.closure.newton import Pose, follow_ray
from kinematics.closure.series import expand, expand_from
from kinematics.model.arrays import Chain
from kinematics.model.chain import move_chain
from kinematics.numerics.array_types import Array

# Order of the series that predict the next pose.
SERIES_ORDER = 3


def continue_along(chain: Chain, ray: Array, longest_step: float = np.inf) -> Iterator[Pose]:
    """Follow closed poses along a ray; the series at each pose predicts the next one.

    The continuation ends where no further pose is found on the same branch.

    Args:
        chain: the linkage at its reference pose.
        ray: direction in the coordinates of the chain (w,).
        longest_step: in the parameter of the ray.

    Returns:
        The poses, in order.
    """
    series = expand(chain, ray[None], SERIES_ORDER)
    q = np.zeros(chain.parent.size)
    while True:
        pose, step = follow_ray(chain, q, series, ray, longest_step)
        if step == 0.0:
            return
        yield pose
        q = pose.q
        series = expand_from(chain, pose.screws, ray[None], SERIES_ORDER)


def continue_in_directions(chain: Chain, rays: Array) -> Iterator[tuple[Chain, Pose]]:
    """Follow closed poses along rays and against them, in turn, ever further away.

    Where one joint moves all others, the fastest is the coordinate, chosen anew at each
    pose, so that no dead centre ends the continuation.

    Args:
        chain: the linkage at its reference pose.
        rays: directions in the coordinates of the chain (count, w).

    Returns:
        Poses, each with the chain in the coordinates that were used there.
    """
    directions = [sign * ray for ray in rays for sign in (1.0, -1.0)]
    if chain.dependent.size == chain.parent.size - 1:
        paths = [_continue_single_freedom(chain, direction) for direction in directions]
    else:
        paths = [
            ((chain, pose) for pose in continue_along(chain, direction))
            for direction in directions
        ]
    ended = 0
    for path in cycle(paths):
        next_pose = next(path, None)
        ended = ended + 1 if next_pose is None else 0
        if ended == len(paths):
            return
        if next_pose is not None:
            yield next_pose


def _continue_single_freedom(chain: Chain, ray: Array) -> Iterator[tuple[Chain, Pose]]:
    """Follow the only motion of a linkage, in one sense."""
    q, screws, here = np.zeros(chain.parent.size), chain.screws, chain
    while True:
        rates = expand_from(here, screws, ray[None], 0).C[0, 0] @ ray
        fastest = np.argmax(np.abs(rates))
        here = move_chain(chain, np.array([fastest]), np.eye(1))
        ray = np.sign(rates[fastest : fastest + 1])
        series = expand_from(here, screws, ray[None], SERIES_ORDER)
        pose, step = follow_ray(here, q, series, ray)
        if step == 0.0:
            return
        yield here, pose
        q, screws = pose.q, pose.screws
