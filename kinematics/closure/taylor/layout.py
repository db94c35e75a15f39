"""Pack the geometry-independent data of a chain for `taylor.expansion_kernels`.

Turning links carry vectors, which change as they turn: the axes of joints, and arms between
their points. Which these are, and in which loops they count, follows from how joints are
connected, and from their kinds, turning or sliding.

The kernels (`kinematics.numerics.compiled.jit`) take the data as one array of integers and one
of numbers, cut into sections, because every array argument adds call overhead: a dozen more
take as long as the expansion of a five-bar to order 5. The integers begin with the place of
each section and the end of the last one; section s, a number of `SECTION`, is
``whole[whole[s] : whole[s + 1]]``. So are the sections of the workspace, with the numbers of
`WORK`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from kinematics.closure.taylor.monomials import monomial_table
from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import path
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.simd import aligned_zeros, round_up_to_vectors

Rows = list[list[int]]


class _Sections(NamedTuple):
    """Numbers of the sections of the integers.

    Attributes:
        sizes: the numbers of `_Sizes`.
        parent: link before each joint, -1 for the ground (n,).
        ends: links welded by each loop (L, 2).
        dependent: dependent joints (d,).
        equations: rows of the loop matrix that are solved (m,).
        joints: joints that lead to links with vectors: joint, parent, its axis or -1 (…, 3).
        arms: link, point where it ends, axis along which it lengthens or -1 (arms, 3). A
            point is that of a joint, or n and the number of a loop.
        axes: link, joint, whether it turns, first lane of its cross product and of its product
            with the joint's rate (axes, 5).
        terms: vectors in the loops: first row, 1 on side A or -1 on side B, number of an arm or
            of an axis less their count, as an index from the end (terms, 3).
        cuts: link whose joint has the point at which a loop is cut, or -1 (L,).
        degrees: where the monomials of each degree begin (order + 2,).
        places: of each monomial, its first pair and its root; see `Monomials`.
        pairs: pairs of factors.
        work: where each section of the workspace begins, and the end of the last one.
    """

    sizes: int
    parent: int
    ends: int
    dependent: int
    equations: int
    joints: int
    arms: int
    axes: int
    terms: int
    cuts: int
    degrees: int
    places: int
    pairs: int
    work: int


class _Sizes(NamedTuple):
    """Places of the numbers in the section of sizes.

    Attributes:
        joints: joints, n.
        width: columns.
        lanes: lanes that the loops need.
        stride: all lanes of a monomial.
        wide: joints, rounded up to whole vectors.
    """

    joints: int
    width: int
    lanes: int
    stride: int
    wide: int


class _Work(NamedTuple):
    """Numbers of the sections of the workspace.

    Those that vectors are loaded from come first, and have lengths of whole vectors: all of
    them begin at a line of the cache. From ``response`` to ``matrix`` a call begins with zeros.

    Attributes:
        left_factors: a row of lanes for each monomial.
        right_factors: likewise.
        product: sums of their products.
        rates: rates of all joints, a row of ``wide`` numbers for each monomial.
        effect: in a plane, what a product on each lane of the loops gives on the left.
        inverse: pseudo-inverse, transposed, a row for each row of the loop matrix.
        turning: in a plane, how each joint turns the link of each lane (n, stride).
        turned: in a plane, arms and axes at the reference pose, turned by a right angle, on
            the lanes of one monomial.
        response: rates of the joints for each lane of the loops.
        reflected: ``[A 1]`` and then ``[R Qᵀ]``, a row for each equation.
        matrix: the loop matrix (rows, n).
        points: points of the joints, then of the cuts.
        starts: arms and axes at the reference pose.
        omega: in space, angular velocities of the links.
        pitch: pitch of each joint.
        scratch: a number for each equation.
        columns: those of the independent joints (n, width), from the start.
        mimics: the mimic relations (g, n), likewise.
    """

    left_factors: int
    right_factors: int
    product: int
    rates: int
    effect: int
    inverse: int
    turning: int
    turned: int
    response: int
    reflected: int
    matrix: int
    points: int
    starts: int
    omega: int
    pitch: int
    scratch: int
    columns: int
    mimics: int


SECTION, SIZE, WORK = _Sections(*range(14)), _Sizes(*range(5)), _Work(*range(18))


class Layout(NamedTuple):
    """Geometry-independent data of the kernel, packed into two arrays.

    Attributes:
        whole: integers, in sections; see the head of this file.
        real: the columns of the independent joints, then the mimic relations.
        shape: number of monomials, and of joints.
        workspaces: those of this layout that nobody uses.
    """

    whole: IntArray
    real: Array
    shape: tuple[int, int]
    workspaces: list[Array]


def expansion_workspace(layout: Layout) -> Array:
    """Make the workspace of the kernel: columns and mimic relations, and zeros.

    Kernels leave what has to be 0 as it is.
    """
    ends = layout.whole[SECTION.work + 1] - 1
    workspace = aligned_zeros(int(layout.whole[ends]))
    workspace[workspace.size - layout.real.size :] = layout.real
    return workspace


class _Vectors(NamedTuple):
    """Vectors that turning links carry, as rows of the sections of the same names."""

    joints: Rows
    arms: Rows
    axes: Rows
    terms: Rows
    cuts: Rows


def packed_layout(chain: Chain, order: int, equations: tuple[int, ...] | None = None) -> Layout:
    """Pack the data of the kernel for a chain, once for each structure and kinds of screws.

    Args:
        chain: the linkage as arrays; its screws may change later, but for their kinds.
        order: highest degree of the monomials in the columns of the chain.
        equations: rows of the loop matrix to solve by least squares; all by default.

    Returns:
        Both arrays, and the shape of the result.

    Raises:
        LinkageError: there are too many products of monomials.
    """
    kinds = chain.screws[:, : 3 if chain.screws.shape[1] == 6 else 1].any(axis=1).tobytes()
    return chain.once(_pack, order, equations, kinds)


def _pack(chain: Chain, order: int, equations: tuple[int, ...] | None, _kinds: bytes) -> Layout:
    """Pack the data; the kinds of the screws, which it reads, are there for `Chain.once`."""
    table = monomial_table(chain.width, order)
    n, dim = chain.screws.shape
    rows = len(chain.ends) * dim + len(chain.mimics)
    vectors = _vectors(chain)
    # Lanes of a cross product, then of a product of a vector and a rate.
    space, across = (3, 6) if dim == 6 else (2, 2)
    arms, axes = len(vectors.arms), len(vectors.axes)
    # The last degree needs no turned axes: their lanes are the last ones.
    loop_lanes = across * arms + space * axes
    for k, axis in enumerate(vectors.axes):
        axis += [loop_lanes + across * k, across * arms + space * k]
    stride, wide = (
        round_up_to_vectors(loop_lanes + across * axes),
        round_up_to_vectors(n),
    )
    every = range(rows) if equations is None else equations
    m, monomials = len(every), len(table.exponents)
    lengths = _Work(
        left_factors=monomials * stride,
        right_factors=monomials * stride,
        product=monomials * stride,
        rates=monomials * wide,
        effect=loop_lanes * stride if dim == 3 else 0,
        inverse=rows * wide,
        turning=n * stride if dim == 3 else 0,
        turned=stride if dim == 3 else 0,
        response=loop_lanes * wide,
        reflected=m * max(round_up_to_vectors(chain.dependent.size + m), wide),
        matrix=rows * n,
        points=(n + len(vectors.cuts)) * space,
        starts=(arms + axes) * space,
        omega=3 * n if dim == 6 else 0,
        pitch=n,
        scratch=m,
        columns=chain.columns.size,
        mimics=chain.mimics.size,
    )
    sections: list[Iterable] = [
        [n, chain.width, loop_lanes, stride, wide],
        chain.parent,
        chain.ends,
        chain.dependent,
        every,
        *vectors,
        table.starts,
        table.places,
        table.pairs,
        np.cumsum([0, *lengths]),
    ]
    flat = [np.ravel(np.array(section, dtype=np.int64)) for section in sections]
    places = np.cumsum([len(flat) + 1, *map(len, flat)])
    return Layout(
        freeze(np.concatenate([places, *flat]), np.int64),
        freeze(np.concatenate([chain.columns.ravel(), chain.mimics.ravel()])),
        (monomials, n),
        [],
    )


def _vectors(chain: Chain) -> _Vectors:
    """List the vectors that turning links carry, and in which loops they count."""
    parent: list[int] = chain.parent.tolist()
    revolving, turns = _turning_links(chain)
    inside, apart = _loop_joints(chain)
    counting = set().union(*(side for sides in apart for side in sides))
    moved = [j for j in inside if turns[parent[j]]]
    with_axis = [j for j in moved if _needs_axis(chain.planar, revolving[j], j in counting)]
    axis = {j: k for k, j in enumerate(with_axis)}
    arms = [[parent[j], j, axis.get(j, -1)] for j in moved if j in counting]
    terms, cuts, last_arms = _loop_terms(chain, turns, apart, arms, axis)
    arms += last_arms
    axes = [[parent[j], j, int(revolving[j])] for j in with_axis]
    carriers = {j for link, *_ in arms + axes for j in path(chain.parent, link)}
    joints = [[j, parent[j], axis.get(j, -1)] for j in sorted(carriers)]
    return _Vectors(joints, arms, axes, terms, cuts)


def _turning_links(chain: Chain) -> tuple[list[bool], list[bool]]:
    """Return which joints turn, and which links; the last one is the ground.

    The ground is link -1: as an index that is the last entry.
    """
    n, dim = chain.screws.shape
    revolving: list[bool] = np.any(chain.screws[:, : 3 if dim == 6 else 1], axis=1).tolist()
    turns = [False] * (n + 1)
    for j, before in enumerate(chain.parent.tolist()):
        turns[j] = revolving[j] or turns[before]
    return revolving, turns


def _loop_joints(chain: Chain) -> tuple[list[int], list[tuple[set[int], set[int]]]]:
    """Return the joints between the loops' ends and the ground, and those on one side only."""
    paths = [[path(chain.parent, int(end)) for end in pair] for pair in chain.ends]
    inside = sorted({j for pair in paths for side in pair for j in side})
    return inside, [(set(side) - set(other), set(other) - set(side)) for side, other in paths]


def _needs_axis(planar: bool, revolving: bool, counts: bool) -> bool:
    """Whether a joint's axis changes and counts: in the plane, only the sliders' axes turn."""
    return not planar if revolving else counts


def _loop_terms(
    chain: Chain,
    turns: list[bool],
    apart: list[tuple[set[int], set[int]]],
    arms: Rows,
    axis: dict[int, int],
) -> tuple[Rows, Rows, Rows]:
    """List what counts in the loops: terms, cuts, and the arms that end at the cuts.

    Args:
        chain: the linkage as arrays.
        turns: which links turn, and last the ground.
        apart: joints on one side only of each loop.
        arms: those that end at joints.
        axis: number of each joint's axis.
    """
    n, dim = chain.screws.shape
    arm = {j: k for k, (_, j, _) in enumerate(arms)}
    terms: Rows = []
    cuts: Rows = []
    last_arms: Rows = []
    for loop, (pair, sides) in enumerate(zip(chain.ends.tolist(), apart, strict=True)):
        # A loop is cut at the last joint of one side, of a link that turns if there is one.
        near = 0 if turns[pair[0]] else 1
        cuts.append([pair[near] if turns[pair[near]] else -1])
        for side, sign in ((0, 1), (1, -1)):
            vectors = [arm[j] for j in sides[side] if j in arm]
            vectors += [axis[j] - len(axis) for j in sides[side] if j in axis]
            if side != near and turns[pair[side]]:
                vectors.append(len(arms) + len(last_arms))
                last_arms.append([pair[side], n + loop, -1])
            terms += [[dim * loop, sign, vector] for vector in vectors]
    return terms, cuts, last_arms
