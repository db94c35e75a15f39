"""Joints at rest in every motion, shown by the loops that they are in, not by orders alone."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from balance.space.exact.chain import ExactChain, lie_algebra, loops_are_regular
from balance.space.exact.mirrored_motions import joints_at_rest_by_symmetry
from kinematics.model.chain import loop_joints, rigid_parts
from kinematics.numerics.linalg.rational import echelon


def joints_shown_at_rest(chain: ExactChain, idle: Collection[int]) -> set[int]:
    """Show that joints are at rest in every motion, however high the order.

    All of them are if the linkage is regular, and still is with them locked; see
    `loops_are_regular`. Otherwise joints are shown one loop after the other. Let g be the Lie
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
    if not free or (loops_are_regular(chain) and loops_are_regular(chain, idle)):
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


def _loops(
    chain: ExactChain, joints: Collection[int], resting: Collection[int]
) -> Iterator[set[int]]:
    """Yield the moving joints of each loop of the file, and of the shortest through joints."""
    for ends in chain.ends:
        yield loop_joints(chain.parent, *ends) - set(resting)
    welds = [*((chain.parent[j], j) for j in resting), *chain.ends]
    part = rigid_parts(len(chain.parent), welds).tolist()
    moving = [j for j in range(len(chain.parent)) if j not in resting]
    sides = {j: (part[chain.parent[j]], part[j]) for j in moving}
    for joint in sorted(joints):
        if path := _shortest_path(sides, joint):
            yield path | {joint}


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
    path: set[int] = set()
    while goal in before and goal != start:
        goal, j = before[goal]
        path.add(j)
    return path


def _leaves_group_of_others(chain: ExactChain, around: set[int], joints: set[int]) -> bool:
    """Whether screws are independent modulo the algebra that others around a loop generate."""
    basis = lie_algebra([chain.screws[j] for j in sorted(around - joints)])
    more = [list(chain.screws[j]) for j in sorted(joints)]
    return len(echelon(basis + more)[0]) == len(basis) + len(more)
