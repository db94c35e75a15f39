"""Inertia transfers in rational numbers: a lower bound on the nullity that nothing rounds.

Search and definition are those of `balance.space.transfers`, on fractions. A transfer found
holds by identity: its momentum is zero in every pose that the joints can take, closed or not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations_with_replacement
from math import lcm
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.exact.chain import ExactChain, unit_vectors
from balance.space.momentum.product_tensors import MOMENTUM, RATE
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import GROUND
from kinematics.numerics.linalg.rational import (
    Vector,
    dot,
    echelon,
    rational_bracket,
    rational_null_space,
)

Rows = list[list[Fraction]]
Whole = NDArray[np.object_]
# Most paths through links without parameters from one body. Transfers along other paths are
# missed, and the lower bound on the nullity stays a lower bound.
MAX_PATHS = 200
_RATE = RATE.astype(np.int64).astype(object)
_MOMENTUM = MOMENTUM.astype(np.int64).astype(object).reshape(6, 60)


class ExactTransfer(NamedTuple):
    """Parameters that pass one or several joints from one body to another.

    Attributes:
        below: joints on the way from the ground to the first of ``joints``.
        joints: joints passed one after the other, with no body between them.
        source: body that gives, -1 for the ground.
        target: body that takes.
        z: in the parameters of `ExactChain.parameters`.
    """

    below: tuple[int, ...]
    joints: tuple[int, ...]
    source: int
    target: int
    z: Vector


class _Reached(NamedTuple):
    """A body, or the ground, and how it was reached."""

    part: int
    below: tuple[int, ...]
    twists: Rows


def exact_transfers(chain: ExactChain, idle: Sequence[int] = ()) -> list[ExactTransfer]:
    """Find transfers between bodies that a joint, or a chain of joints without bodies, joins.

    Bodies that are welded, or at rest, exchange everything, through no joint. Where links
    without parameters branch, there are more transfers than are found here.

    Args:
        idle: joints that do not move.
    """
    parts = _parts(chain, idle)
    bodies: dict[int, int] = {}
    for b, link in enumerate(chain.links):
        bodies.setdefault(parts[link], b)
    ground = parts[GROUND]
    bodies[ground] = -1
    transfers = list(_rigid_transfers(chain, parts, bodies))
    reached, crossed = [_Reached(ground, (), [])], set()
    for state in reached:
        for joints, part in _paths(chain, parts, bodies, state.part, set(idle)):
            if state.below and joints[0] == state.below[-1]:
                continue
            if len(state.twists) == 6 and frozenset(joints) in crossed:
                continue
            crossed.add(frozenset(joints))
            twists = state.twists
            passing = [list(v) for v in unit_vectors(len(chain.parameters))]
            for j in joints:
                passing = _passing_parameters(chain, chain.screws[j], twists, passing)
                twists = _attainable_beyond(chain.screws[j], twists)
            source, target = bodies[state.part], bodies[part]
            if target >= 0:
                transfers += [
                    ExactTransfer(state.below, joints, source, target, tuple(z))
                    for z in passing
                ]
                spans = (r.twists for r in reached if r.part == part)
                if not any(_span_contains(twists, other) for other in spans):
                    reached.append(_Reached(part, state.below + joints, twists))
    return transfers


def has_branching_links(chain: ExactChain, idle: Sequence[int] = ()) -> bool:
    """Decide whether three or more joints meet at a link without parameters.

    There are more transfers then than `exact_transfers` finds.

    Args:
        idle: joints that do not move.
    """
    parts = _parts(chain, idle)
    with_body = {parts[link] for link in (GROUND, *chain.links)}
    met = Counter(
        part
        for j, parent in enumerate(chain.parent)
        if parts[j] != parts[parent]
        for part in (parts[j], parts[parent])
    )
    return any(count > 2 for part, count in met.items() if part not in with_body)


def _rigid_transfers(
    chain: ExactChain, parts: list[int], bodies: dict[int, int]
) -> Iterator[ExactTransfer]:
    """Yield all that bodies can exchange with the first one of their part, or the ground."""
    for b, link in enumerate(chain.links):
        if bodies[parts[link]] != b:
            for z in unit_vectors(len(chain.parameters)):
                yield ExactTransfer((), (), bodies[parts[link]], b, z)


def _parts(chain: ExactChain, idle: Sequence[int]) -> list[int]:
    """Number the rigid part of each link, and of the ground; idle joints count as welds."""
    welds = [*chain.ends, *((j, chain.parent[j]) for j in idle)]
    parts: list[int] = rigid_parts(len(chain.parent), welds).tolist()
    return parts


def _paths(
    chain: ExactChain, parts: list[int], bodies: dict[int, int], start: int, idle: set[int]
) -> Iterator[tuple[tuple[int, ...], int]]:
    """Yield the paths of joints from a part to the next one with a body, and that part."""
    ways: list[tuple[tuple[int, ...], tuple[int, ...]]] = [((), (start,))]
    for joints, passed in ways:
        for j, parent in enumerate(chain.parent):
            ends = (parts[parent], parts[j])
            if j in idle or ends[0] == ends[1] or passed[-1] not in ends:
                continue
            part = ends[0] if ends[1] == passed[-1] else ends[1]
            if part in passed:
                continue
            if part in bodies:
                yield (*joints, j), part
            elif len(ways) < MAX_PATHS:
                ways.append(((*joints, j), (*passed, part)))


def _passing_parameters(chain: ExactChain, s: Vector, twists: Rows, candidates: Rows) -> Rows:
    """Find combinations of parameters that can pass a joint with ``twists`` below it.

    ``M(Lᵏ z) s = 0`` for k ≥ 0 and ``M(Lᵏ z) t = 0`` for k ≥ 1. L has a minimal polynomial
    of degree 3 for a prismatic joint, 5 for a revolute one, and at most 10 at all.
    """
    if not candidates:
        return []
    if len(twists) == 6 and len(candidates) == len(chain.parameters) == 10:
        return _masses_at_rest(s)
    degree = 3 if not any(s[:3]) else 5 if not dot(s[:3], s[3:]) else 10
    # Where every twist can be attained, the first rate itself must vanish.
    every = len(twists) == 6
    rate = np.tensordot(_integer_rows([s])[0], _RATE, 1).T
    momenta = _integer_rows(chain.rows) @ (_integer_rows([s, *twists]) @ _MOMENTUM).reshape(
        -1, 6, 10
    )
    momenta = momenta.reshape(-1, 10).T
    combinations = _integer_rows(candidates)
    z = combinations @ _integer_rows(chain.parameters)
    for k in range(2 if every else degree):
        if k:
            z = z @ rate
        wanted = z @ (momenta if k else momenta[:, : len(chain.rows)])
        combinations, z = _combinations_that_vanish(
            combinations, z, z[:, : combinations.shape[1]] if every and k else wanted
        )
        if not len(combinations):
            break
    # Each has an entry after which all others vanish, and which the others do not have.
    return [[_quotient(x, row[np.flatnonzero(row)[-1]]) for x in row] for row in combinations]


def _masses_at_rest(s: Vector) -> Rows:
    """Find the parameters of all masses that a joint leaves at rest.

    Those are what passes a joint below which every twist can be attained: ``L z = 0`` and
    ``M(z) s = 0`` are the symmetric and the antisymmetric part of ``ŝ P = 0``, so that the
    columns of the pseudo-inertia P lie in the null space of ``ŝ``: the points of the axis of a
    revolute joint and its direction, the direction alone of a helical one, all directions of a
    prismatic one.

    Returns:
        Parameters (count, 10): each has an entry after which all others vanish, and which the
        others do not have.
    """
    zero = Fraction(0)
    n, v = s[:3], s[3:]
    moved = [[zero, -n[2], n[1], v[0]], [n[2], zero, -n[0], v[1]], [-n[1], n[0], zero, v[2]]]
    masses = [
        _parameters_of(a, b)
        for a, b in combinations_with_replacement(rational_null_space(moved, 4), 2)
    ]
    reduced, _ = echelon([z[::-1] for z in masses])
    return [row[::-1] for row in reversed(reduced)]


def _parameters_of(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    """Compute the parameters of the pseudo-inertia ``P = a bᵀ + b aᵀ``; a and b are (4,)."""
    P = [[x * y + w * z for y, z in zip(b, a, strict=True)] for x, w in zip(a, b, strict=True)]
    xx, yy, zz = P[0][0], P[1][1], P[2][2]
    moments = [yy + zz, xx + zz, xx + yy, -P[0][1], -P[0][2], -P[1][2]]
    return [P[3][3], P[0][3], P[1][3], P[2][3], *moments]


def _integer_rows(rows: Sequence[Sequence[Fraction]]) -> Whole:
    """Multiply rational rows by the least number that makes all entries whole."""
    common = lcm(*(x.denominator for row in rows for x in row))
    return np.array([[_times(x, common) for x in row] for row in rows], dtype=object)


def _times(x: Fraction, common: int) -> Fraction | int:
    """Multiply a number by a multiple of its denominator; a whole number if it is rational."""
    product = x * common
    return product.numerator if type(product) is Fraction else product


def _quotient(x: Fraction | int, y: Fraction | int) -> Fraction:
    """Divide whole numbers, or numbers of a field."""
    return Fraction(x, y) if isinstance(x, int) and isinstance(y, int) else Fraction(1) * x / y


def _combinations_that_vanish(
    combinations: Whole, z: Whole, values: Whole
) -> tuple[Whole, Whole]:
    """Combine rows of ``combinations``, and of z, so that all values vanish.

    Args:
        combinations: rows of whole numbers (count, parameters).
        z: other rows that belong to them (count, 10).
        values: values that must vanish (count, values).
    """
    conditions = [[_quotient(x, 1) for x in row] for row in values.T.tolist() if any(row)]
    mixed = _integer_rows(rational_null_space(conditions, len(combinations))).reshape(
        -1, len(combinations)
    )
    return mixed @ combinations, mixed @ z


def _attainable_beyond(s: Vector, twists: Rows) -> Rows:
    """Find the twists attainable beyond a joint, ``Σ ad(s)ᵏ V + ⟨s⟩``, in echelon form."""
    basis = echelon([list(s), *twists])[0]
    while len(basis) < 6:
        wider = echelon(basis + [list(rational_bracket(s, t)) for t in basis])[0]
        if len(wider) == len(basis):
            break
        basis = wider
    return basis


def _span_contains(wide: Rows, narrow: Rows) -> bool:
    """Whether a span contains another."""
    return len(echelon(wide + narrow)[0]) == len(wide)
