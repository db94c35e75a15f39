"""What the kernel of Taylor expansions needs besides the geometry of a chain.

Turning links carry vectors, which change as they turn (see
`kinematics.taylor.expansion_kernels`): which these are, and in which loops they count, follows
from how joints are connected, and from which of them turn and which slide.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.compiled.simd import padded
from kinematics.model.arrays import Chain, IntArray, frozen
from kinematics.model.chain import path
from kinematics.taylor.monomials import Monomials

__all__ = ["Layout", "layout"]

Array = NDArray[np.float64]


class Layout(NamedTuple):
    """All that a chain's geometry does not change, in two arrays, for each costs time to pass.

    Attributes:
        whole: sections of whole numbers, after the places where they begin: sizes, parents,
            ends of the loops, dependent joints, equations that are solved, joints on the
            loops, arms, axes, which of these count in which loop, points where the loops are
            cut, and the table of the monomials.
        real: the columns of the independent joints, then the mimic relations.
        shape: number of monomials, and of joints.
    """

    whole: IntArray
    real: Array
    shape: tuple[int, int]


def layout(chain: Chain, table: Monomials, equations: IntArray | None = None) -> Layout:
    """The layout of a chain.

    Args:
        chain: the linkage as arrays; its screws may change later, but for their kinds.
        table: the monomials of as many variables as the chain has columns.
        equations: rows of the loop matrix that are solved, in the least-squares sense; all
            by default.
    """
    n, dim = chain.screws.shape
    rows = len(chain.ends) * dim + len(chain.mimics)
    joints, arms, axes, terms, cuts = _vectors(chain)
    # The last degree needs no turned axes: their lanes are the last ones.
    space = 3 if dim == 6 else 2
    across = 6 if dim == 6 else 2
    few = across * len(arms) + space * len(axes)
    for lane, axis in enumerate(axes):
        axis += [few + across * lane, across * len(arms) + space * lane]
    lanes = padded(few + across * len(axes))
    every = range(rows) if equations is None else equations
    dependent, m = padded(chain.dependent.size), len(every)
    room = (
        3 * len(table.exponents) * lanes + (few + rows + 1) * dependent + (rows + 1) * n
        + (n + len(cuts) + len(arms) + len(axes)) * space + n * (dim - space)
        + m + m * padded(chain.dependent.size + m) + 8
    )  # fmt: skip
    sections: list[Iterable] = [
        [n, chain.width, few, lanes, room],
        chain.parent, chain.ends, chain.dependent, every, joints, arms, axes, terms, cuts,
        table.starts, table.places, table.pairs,
    ]  # fmt: skip
    flat = [np.ravel(np.array(section, dtype=np.int64)) for section in sections]
    places = np.cumsum([len(flat) + 1, *map(len, flat)])
    return Layout(
        frozen(np.concatenate([places, *flat]), np.int64),
        frozen(np.concatenate([chain.columns.ravel(), chain.mimics.ravel()])),
        (len(table.exponents), n),
    )


def _vectors(chain: Chain) -> tuple[list[list[int]], ...]:
    """What turning links carry.

    Returns:
        Joints that lead to such links: joint, parent, number of its axis or -1. Arms: link,
        point where they end (a joint, or n and the number of a loop), axis along which they
        lengthen or -1. Axes: link, joint, whether it turns. Terms of the loops: first row,
        1 on side A or -1 on side B, an arm, or an axis if counted from their end. Cuts: link
        whose joint has the point at which the two ends of a loop meet, or -1.
    """
    n, dim = chain.screws.shape
    parent: list[int] = chain.parent.tolist()
    revolving: list[bool] = np.any(chain.screws[:, : dim - (3 if dim == 6 else 2)], 1).tolist()
    turns = [False] * (n + 1)  # the last one is the ground
    for j in range(n):
        turns[j] = revolving[j] or turns[parent[j]]
    ways = [[path(chain.parent, int(end)) for end in pair] for pair in chain.ends]
    apart = [[set(one) - set(other), set(other) - set(one)] for one, other in ways]
    inside = sorted({j for pair in ways for way in pair for j in way})
    moved = [j for j in inside if turns[parent[j]]]
    crossing = set().union(*(way for pair in apart for way in pair))
    in_axes = [j for j in moved if (dim == 6 if revolving[j] else j in crossing)]
    axis = {j: k for k, j in enumerate(in_axes)}
    arms = [[parent[j], j, axis.get(j, -1)] for j in moved if j in crossing]
    arm = {j: k for k, (_, j, _) in enumerate(arms)}
    cuts: list[list[int]] = []
    terms: list[list[int]] = []
    for loop, (pair, sides) in enumerate(zip(chain.ends.tolist(), apart, strict=True)):
        near = 0 if turns[pair[0]] else 1
        cuts.append([pair[near] if turns[pair[near]] else -1])
        for side, sign in ((0, 1), (1, -1)):
            found = [arm[j] for j in sides[side] if j in arm]
            found += [axis[j] - len(axis) for j in sides[side] if j in axis]
            if side != near and turns[pair[side]]:
                found.append(len(arms))
                arms.append([pair[side], n + loop, -1])
            terms += [[dim * loop, sign, vector] for vector in found]
    axes = [[parent[j], j, revolving[j]] for j in in_axes]
    carriers = {j for link, *_ in arms + axes for j in path(chain.parent, link)}
    joints = [[j, parent[j], axis.get(j, -1)] for j in sorted(carriers)]
    return joints, arms, axes, terms, cuts
