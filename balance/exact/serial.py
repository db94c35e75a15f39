"""Inertia transfers in rational numbers: a lower bound on the nullity that nothing rounds.

The walk and the definition are those of `balance.transfers`; here they run on fractions. A
transfer found is one by identity, and its momentum is zero in every pose that the joints can
take, closed or not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

from balance.exact.chain import ExactChain
from kinematics.linkage import GROUND
from kinematics.rational import Vector, bracket, combination, cross, dot, echelon, null_space

__all__ = ["ExactTransfer", "branches", "exact_transfers"]

Rows = list[list[Fraction]]
# Ways through links without parameters that are tried from one body: transfers along the
# others are missed, and a bound that is too low is still one.
MOST = 200
ZERO = Fraction(0)


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
    """Transfers between bodies one joint, or one chain of joints without bodies, apart.

    Bodies that are welded, or at rest, exchange everything, through no joint. Where links
    without parameters branch, there are more transfers than are found here.

    Args:
        chain: the linkage.
        idle: joints that do not move.
    """
    parts = _parts(chain, idle)
    bodies: dict[int, int] = {}
    for b, link in enumerate(chain.links):
        bodies.setdefault(parts[link], b)
    ground = parts[GROUND]
    bodies[ground] = -1
    found = list(_rigid(chain, parts, bodies))
    reached, crossed = [_Reached(ground, (), [])], set()
    for state in reached:
        for joints, part in _ways(chain, parts, bodies, state.part, set(idle)):
            if state.below and joints[0] == state.below[-1]:
                continue
            if len(state.twists) == 6 and frozenset(joints) in crossed:
                continue
            crossed.add(frozenset(joints))
            twists = state.twists
            passing = [list(v) for v in _units(len(chain.parameters))]
            for j in joints:
                passing = _passing(chain, chain.screws[j], twists, passing)
                twists = _beyond(chain.screws[j], twists)
            source, target = bodies[state.part], bodies[part]
            if target >= 0:
                found += [
                    ExactTransfer(state.below, joints, source, target, tuple(z))
                    for z in passing
                ]
                known = (r.twists for r in reached if r.part == part)
                if not any(_contains(twists, other) for other in known):
                    reached.append(_Reached(part, state.below + joints, twists))
    return found


def branches(chain: ExactChain, idle: Sequence[int] = ()) -> bool:
    """Whether three or more joints meet at a link without parameters.

    There are more transfers then than `exact_transfers` finds.
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


def _rigid(
    chain: ExactChain, parts: dict[int, int], bodies: dict[int, int]
) -> Iterator[ExactTransfer]:
    """All that bodies can exchange with the first one of their part, or with the ground."""
    for b, link in enumerate(chain.links):
        if bodies[parts[link]] != b:
            for z in _units(len(chain.parameters)):
                yield ExactTransfer((), (), bodies[parts[link]], b, z)


def _units(count: int) -> Iterator[Vector]:
    return (tuple(Fraction(int(i == j)) for j in range(count)) for i in range(count))


def _parts(chain: ExactChain, idle: Sequence[int]) -> dict[int, int]:
    """Rigid part of each link, and of the ground: links that are welded make up one."""
    parts = {link: link for link in range(-1, len(chain.parent))}
    welds = [*chain.ends, *((j, chain.parent[j]) for j in idle)]
    for one, other in welds:
        keep, drop = parts[one], parts[other]
        for link, part in parts.items():
            if part == drop:
                parts[link] = keep
    return parts


def _ways(
    chain: ExactChain, parts: dict[int, int], bodies: dict[int, int], start: int, idle: set[int]
) -> Iterator[tuple[tuple[int, ...], int]]:
    """Joints one after the other from a part to the next one with a body, and that part."""
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
            elif len(ways) < MOST:
                ways.append(((*joints, j), (*passed, part)))


def _momentum(t: Sequence[Fraction], z: Sequence[Fraction]) -> Vector:
    """Momentum ``[ξ; p]`` of the ten parameters z at twist t."""
    w, v, m, c = t[:3], t[3:], z[0], z[1:4]
    E = ((z[4], z[7], z[8]), (z[7], z[5], z[9]), (z[8], z[9], z[6]))
    moments = (dot(row, w) + x for row, x in zip(E, cross(c, v), strict=True))
    return (*moments, *(m * a + b for a, b in zip(v, cross(w, c), strict=True)))


def _rate(s: Sequence[Fraction], z: Sequence[Fraction]) -> Vector:
    """Rate of the ten parameters of a body that moves with s: from ``P' = ŝ P + P ŝᵀ``."""
    w, v, m, c = s[:3], s[3:], z[0], z[1:4]
    E = ((z[4], z[7], z[8]), (z[7], z[5], z[9]), (z[8], z[9], z[6]))
    turned = [cross(w, row) for row in E]

    def entry(i: int, j: int) -> Fraction:
        moved = 2 * dot(c, v) if i == j else ZERO
        return turned[j][i] + turned[i][j] + moved - c[i] * v[j] - v[i] * c[j]

    first = (m * a + b for a, b in zip(v, cross(w, c), strict=True))
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return (ZERO, *first, *(entry(i, j) for i, j in pairs))


def _passing(chain: ExactChain, s: Vector, twists: Rows, candidates: Rows) -> Rows:
    """Those combinations of parameters that can pass a joint with ``twists`` below it.

    ``M(Lᵏ z) s = 0`` for k ≥ 0 and ``M(Lᵏ z) t = 0`` for k ≥ 1. L has a minimal polynomial
    of degree 3 for a prismatic joint, 5 for a revolute one, and at most 10 at all.
    """
    degree = 3 if not any(s[:3]) else 5 if not dot(s[:3], s[3:]) else 10
    # Where every twist can be attained, the first rate itself must vanish.
    every = len(twists) == 6
    for k in range(2 if every else degree):
        rates = [combination(z, chain.parameters) for z in candidates]
        for _ in range(k):
            rates = [list(_rate(s, z)) for z in rates]
        conditions = []
        for t in [s, *(twists if k else [])][: 0 if every and k else None]:
            momenta = [_momentum(t, z) for z in rates]
            conditions += [[dot(row, h) for h in momenta] for row in chain.rows]
        if every and k:
            conditions = [list(row) for row in zip(*rates, strict=True)][: len(candidates[0])]
        mixed = null_space(conditions, len(candidates))
        candidates = [combination(x, candidates) for x in mixed]
        if not candidates:
            break
    return candidates


def _beyond(s: Vector, twists: Rows) -> Rows:
    """Twists attainable beyond a joint: ``Σ ad(s)ᵏ V + ⟨s⟩``, in echelon form."""
    basis = echelon([list(s), *twists])[0]
    while len(basis) < 6:
        wider = echelon(basis + [list(bracket(s, t)) for t in basis])[0]
        if len(wider) == len(basis):
            break
        basis = wider
    return basis


def _contains(wide: Rows, narrow: Rows) -> bool:
    """Whether a span contains another."""
    return len(echelon(wide + narrow)[0]) == len(wide)
