"""Joints at rest in every motion, shown by the loops that they are in, not by orders alone.

A reflection ``x' = R x + d`` acts on twists: ``Σ [ω; v] = [-R ω; R v + R ω × d]``. Where it
maps the joints of a linkage onto joints, and the rates of the independent joints onto
themselves, the mirror image of every motion is a motion with the same inputs, and so the same
motion, since the inputs determine it. A joint that is its own image then only has displacements
that commute with the reflection: of the units of which it is made, those turn for which
``Σ s = s``, and the others are at rest.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import combinations, takewhile
from typing import NamedTuple

from balance.space.exact.chain import ExactChain, lie_algebra
from kinematics.model.chain import loop_joints, path, rigid_parts
from kinematics.numerics.linalg.rational import Vector, cross, dot, echelon, rational_bracket

Span = tuple[tuple[Fraction, ...], ...]


def joints_shown_at_rest(chain: ExactChain, idle: Collection[int]) -> set[int]:
    """Show that joints are at rest in every motion, however high the order.

    All of them are if the linkage moves as freely with them locked; see `_moves_if_locked`.
    Otherwise joints are shown one loop after the other. Let g be the Lie
    algebra that the other joints of a loop generate. These move links in cosets of its group
    G, which g fixes. Where the screws of joints are independent modulo g, products of their
    displacements and of elements of G leave the unit coset at first order as soon as one of
    them moves, so that the loop does not close: near the reference pose, and by analytic
    continuation in every motion, they are at rest. Links that resting joints connect count as
    one link, so that loops get shorter.

    Args:
        chain: the linkage and its motion.
        idle: joints that do not move at any order computed.

    Returns:
        Those of them that are shown to be at rest.
    """
    free = {j for j in idle if j in chain.dependent or any(chain.columns[j])}
    if not free or _moves_if_locked(chain, set(idle)):
        return set(idle)
    resting, before = (set(idle) - free) | (joints_at_rest_by_symmetry(chain) & free), -1
    while len(resting) > before:
        before = len(resting)
        for row in chain.mimics:
            moving = [j for j, c in enumerate(row) if c and j not in resting]
            resting |= set(moving) & free if len(moving) == 1 else set()
        for loop in list(_loops(chain, free - resting, resting)):
            around = loop - resting
            for group in (around & free, *({j} for j in around & free)):
                if _leaves_group_of_others(chain, around, group):
                    resting |= group
                    break
    return resting


def _moves_if_locked(chain: ExactChain, idle: set[int]) -> bool:
    """Whether a linkage has all its degrees of freedom left with some of its joints locked.

    If so, these joints are at rest in every motion: the closed poses lie on a manifold that
    has as many dimensions as the loop matrix leaves rates, and those of the locked linkage
    are one of that dimension within it, so that they are the same near the reference pose.

    Closed poses of the locked linkage are a manifold where independent constraints close its
    loops: each loop stays in the group that its screws generate, which is closed by as many
    constraints as it has dimensions; or it is closed if joints cancel, by linear constraints.
    """
    if any(any(chain.columns[j]) for j in idle - set(chain.dependent)):
        return False
    constraints = sum(
        any(c and j not in idle for j, c in enumerate(row)) for row in chain.mimics
    )
    relations: list[list[Fraction]] = []
    for ends in chain.ends:
        around = [(j, sign) for j, sign in _loop_in_order(chain, *ends) if j not in idle]
        cancelling = _cancelling_relations(chain, around)
        if cancelling is None:
            constraints += len(lie_algebra([chain.screws[j] for j, _ in around]))
        else:
            relations += cancelling
    constraints += len(echelon(relations)[0])
    return len(set(chain.dependent) - idle) == constraints


def _loop_in_order(chain: ExactChain, end: int, successor: int) -> list[tuple[int, int]]:
    """List the joints around a loop, with 1 where it passes them outwards, and -1 inwards."""
    out, back = path(chain.parent, end), path(chain.parent, successor)
    shared = set(out) & set(back)
    outwards = [(j, 1) for j in reversed(out) if j not in shared]
    return outwards + [(j, -1) for j in back if j not in shared]


def _cancelling_relations(
    chain: ExactChain, around: Sequence[tuple[int, int]]
) -> list[list[Fraction]] | None:
    """Find linear relations of positions with which the displacements around a loop cancel.

    ``exp(a ŝ) exp(b ŝ) = 1`` for ``a + b = 0``: neighbours of one screw cancel, which makes
    their neighbours new ones of each other. What is left cancels if all its screws commute
    and its displacements add up to none.

    Args:
        around: joints in order, with signs.

    Returns:
        Rows (relations, n), where positions count in parts of the screws; None if joints are
        left that do not commute.
    """
    rest, relations = list(around), list[list[Fraction]]()
    while run := _neighbours_of_one_screw(chain, rest):
        relations += _sum_of_displacements(chain, run)
        rest = [step for step in rest if step not in run]
    screws = [chain.screws[j] for j, _ in rest]
    if any(any(rational_bracket(a, b)) for a, b in combinations(screws, 2)):
        return None
    return relations + _sum_of_displacements(chain, rest)


def _neighbours_of_one_screw(
    chain: ExactChain, around: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Find all joints of one screw next to one another, if others are left around the loop."""
    for k in range(len(around)):
        first, *others = [*around[k:], *around[:k]]
        run = [first, *takewhile(partial(_has_same_screw, chain, first), others)]
        if 1 < len(run) < len(around) and not _has_same_screw(chain, first, others[-1]):
            return run
    return []


def _has_same_screw(chain: ExactChain, step: tuple[int, int], other: tuple[int, int]) -> bool:
    return len(echelon([chain.screws[j] for j, _ in (step, other)])[0]) == 1


def _sum_of_displacements(
    chain: ExactChain, steps: Sequence[tuple[int, int]]
) -> list[list[Fraction]]:
    """Write ``Σ ± s_j q_j = 0``, a row for each component of a twist (6, n)."""
    rows = [[Fraction(0)] * len(chain.parent) for _ in range(6)]
    for j, sign in steps:
        for row, x in zip(rows, chain.screws[j], strict=True):
            row[j] += sign * x
    return rows


def _loops(
    chain: ExactChain, joints: Collection[int], resting: Collection[int]
) -> Iterator[set[int]]:
    """Yield the moving joints of loops: each of the file, and the shortest through joints.

    Of these, one is the shortest through sliding joints alone: the translations that these
    generate are a smaller algebra than one with turns.
    """
    for ends in chain.ends:
        yield loop_joints(chain.parent, *ends) - set(resting)
    welds = [*((chain.parent[j], j) for j in resting), *chain.ends]
    part = rigid_parts(len(chain.parent), welds).tolist()
    moving = [j for j in range(len(chain.parent)) if j not in resting]
    sides = {j: (part[chain.parent[j]], part[j]) for j in moving}
    sliding = {j: ends for j, ends in sides.items() if not any(chain.screws[j][:3])}
    for joint in sorted(joints):
        for links in (sides, sliding | {joint: sides[joint]}):
            if others := _shortest_path(links, joint):
                yield others | {joint}


def _shortest_path(sides: Mapping[int, tuple[int, int]], joint: int) -> set[int]:
    """Find the fewest joints between the two sides of a joint, without it; none if none."""
    start, goal = sides[joint]
    before: dict[int, tuple[int, int]] = {start: (start, joint)}
    queue = [start]
    for here in queue:
        for j, (a, b) in sides.items():
            there = b if here == a else a
            if j != joint and here in (a, b) and there not in before:
                before[there] = here, j
                queue.append(there)
    joints: set[int] = set()
    while goal in before and goal != start:
        goal, j = before[goal]
        joints.add(j)
    return joints


def _leaves_group_of_others(chain: ExactChain, around: set[int], joints: set[int]) -> bool:
    """Whether screws are independent modulo the algebra that others around a loop generate."""
    basis = lie_algebra([chain.screws[j] for j in sorted(around - joints)])
    more = [list(chain.screws[j]) for j in sorted(joints)]
    return len(echelon(basis + more)[0]) == len(basis) + len(more)


class _Mirror(NamedTuple):
    """A plane ``n·x = α``, with n of any length."""

    n: Vector
    alpha: Fraction

    def turn(self, a: Vector) -> Vector:
        """Mirror a direction: ``a - 2 (a·n) n / n²``."""
        factor = 2 * dot(a, self.n) / dot(self.n, self.n)
        return tuple(x - factor * y for x, y in zip(a, self.n, strict=True))

    def carry(self, twist: Vector) -> Vector:
        """Mirror a twist: ``ω' = -R ω``, ``v' = R v - ω' × d``, d the image of the origin."""
        w = tuple(-x for x in self.turn(twist[:3]))
        factor = 2 * self.alpha / dot(self.n, self.n)
        moved = cross(w, tuple(factor * x for x in self.n))
        v = tuple(x - y for x, y in zip(self.turn(twist[3:]), moved, strict=True))
        return w + v


class _Edge(NamedTuple):
    """A joint between two links, made of one unit, or of three that turn about one point."""

    before: int
    after: int
    units: tuple[int, ...]


def joints_at_rest_by_symmetry(chain: ExactChain) -> set[int]:
    """Find joints that are at rest in every motion because the motion is its own mirror image.

    Planes are tried that exchange two independent joints of equal or opposite rates.

    Args:
        chain: the linkage and its motion, whose inputs determine all joints.
    """
    if chain.mimics or any(chain.radicands):
        return set()
    edges = _edges(chain)
    resting: set[int] = set()
    for mirror in _mirrors(chain):
        images = _images(chain, edges, mirror)
        if images is not None and _keeps_inputs(chain, edges, images, mirror):
            for edge, image, kept in zip(edges, *images, strict=True):
                if edges[image] is edge and kept:
                    resting |= _resting_units(chain, edge, mirror)
    return resting


def _edges(chain: ExactChain) -> list[_Edge]:
    """Join the units of a linkage to joints; welded links have one number."""
    of = {link: link for link in range(-1, len(chain.parent))}

    def find(link: int) -> int:
        while of[link] != link:
            link = of[link]
        return link

    for ends in chain.ends:
        low, high = sorted(map(find, ends))
        of[high] = low
    single = [
        _Edge(find(parent), find(unit), (unit,)) for unit, parent in enumerate(chain.parent)
    ]
    uses = [link for edge in single for link in (edge.before, edge.after)]
    edges, taken = list[_Edge](), set[int]()
    for first in single:
        run = [first]
        while len(run) < 3 and uses.count(run[-1].after) == 2:
            following = [x for x in single if x.before == run[-1].after]
            if not following:
                break
            run.append(following[0])
        units = tuple(edge.units[0] for edge in run)
        if len(run) == 3 and not taken & set(units) and _is_spherical(chain, units):
            taken |= set(units)
            edges.append(_Edge(run[0].before, run[-1].after, units))
    return edges + [edge for edge in single if edge.units[0] not in taken]


def _is_spherical(chain: ExactChain, units: Sequence[int]) -> bool:
    """Whether three units turn independently about one point."""
    screws = [chain.screws[unit] for unit in units]
    turning = len(echelon([screw[:3] for screw in screws])[0]) == 3
    return turning and len(lie_algebra(screws)) == 3


def _mirrors(chain: ExactChain) -> Iterator[_Mirror]:
    """Yield planes that exchange two independent joints of equal or opposite rates."""
    inputs = [
        j
        for j, screw in enumerate(chain.screws)
        if j not in chain.dependent and any(screw[:3]) and any(chain.columns[j])
    ]
    for j, k in combinations(inputs, 2):
        opposite = tuple(-x for x in chain.columns[k])
        if chain.columns[j] not in (chain.columns[k], opposite):
            continue
        a, b = chain.screws[j], chain.screws[k]
        if dot(a[:3], a[:3]) != dot(b[:3], b[:3]):
            continue
        for sign in (-1, 1):
            n = tuple(x + sign * y for x, y in zip(a[:3], b[:3], strict=True))
            if any(n):
                yield from _plane(a, b, n)


def _plane(a: Vector, b: Vector, n: Vector) -> Iterator[_Mirror]:
    """Yield the plane of a normal that exchanges two lines, if there is one.

    With ``x = p + t d`` on the first line and ``Σ`` for ``n·x = 0``, the moment of the image
    differs from that of the second line by ``2 α n × ω' / n²``, which gives α.
    """
    centred = _Mirror(n, Fraction(0))
    for target in (b, tuple(-x for x in b)):
        image = centred.carry(a)
        if image[:3] != target[:3]:
            continue
        away = tuple(x - y for x, y in zip(image[3:], target[3:], strict=True))
        step = cross(image[:3], tuple(2 * x / dot(n, n) for x in n))
        if not any(step):
            continue
        mirror = _Mirror(n, dot(away, step) / dot(step, step))
        if mirror.carry(a) == target:
            yield mirror


def _span(screws: Sequence[Vector]) -> Span:
    """Write the span of screws in a form that is the same for all bases."""
    return tuple(tuple(row) for row in echelon(screws)[0])


def _images(
    chain: ExactChain, edges: Sequence[_Edge], mirror: _Mirror
) -> tuple[list[int], list[bool]] | None:
    """Find the joint onto which a reflection maps each, and whether it keeps its direction.

    Returns:
        Both; None if the linkage is not its own image.
    """
    places: dict[Span, int] = {}
    for k, edge in enumerate(edges):
        places[_span([chain.screws[unit] for unit in edge.units])] = k
    if len(places) < len(edges):
        return None
    spans = (_span([mirror.carry(chain.screws[u]) for u in edge.units]) for edge in edges)
    images = [places.get(span, -1) for span in spans]
    if -1 in images:
        return None
    links, kept = {-1: -1}, [True] * len(edges)
    for _ in edges:
        for k, edge in enumerate(edges):
            image = edges[images[k]]
            for here, there in ((edge.before, edge.after), (edge.after, edge.before)):
                if here not in links or links[here] not in (image.before, image.after):
                    continue
                across = {image.before: image.after, image.after: image.before}
                links.setdefault(there, across[links[here]])
    for k, edge in enumerate(edges):
        image = edges[images[k]]
        ends = links.get(edge.before), links.get(edge.after)
        if ends not in ((image.before, image.after), (image.after, image.before)):
            return None
        kept[k] = ends == (image.before, image.after)
    return images, kept


def _keeps_inputs(
    chain: ExactChain,
    edges: Sequence[_Edge],
    images: tuple[list[int], list[bool]],
    mirror: _Mirror,
) -> bool:
    """Whether the rates of the independent joints are their own mirror image."""
    for edge, image, kept in zip(edges, *images, strict=True):
        other = edges[image]
        free = [unit for unit in (*edge.units, *other.units) if unit not in chain.dependent]
        if not free:
            continue
        if len(edge.units) > 1 or len(free) < len({*edge.units, *other.units}):
            return False
        (unit,), (there,) = edge.units, other.units
        carried, screw = mirror.carry(chain.screws[unit]), chain.screws[there]
        place = next(i for i, x in enumerate(screw) if x)
        factor = carried[place] / screw[place] * (1 if kept else -1)
        if tuple(factor * x for x in chain.columns[unit]) != chain.columns[there]:
            return False
    return True


def _resting_units(chain: ExactChain, edge: _Edge, mirror: _Mirror) -> set[int]:
    """Find the units at rest of a joint whose displacements commute with a reflection."""
    screws = [chain.screws[unit] for unit in edge.units]
    images = [mirror.carry(screw) for screw in screws]
    turning = {
        unit
        for unit, screw, image in zip(edge.units, screws, images, strict=True)
        if screw == image
    }
    sums = [
        tuple(x + y for x, y in zip(screw, image, strict=True))
        for screw, image in zip(screws, images, strict=True)
    ]
    fixed = len(echelon(sums)[0])
    return set(edge.units) - turning if len(turning) == fixed else set()
