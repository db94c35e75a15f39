"""An order in which the parts of a planar linkage can be placed: freely, or two at a time.

Two parts that are joined to each other, and each to a part that is placed, are a dyad: their
places follow from one quadratic equation, for all dimensions (L. W. Assur, 1914).
"""

from __future__ import annotations

from typing import NamedTuple

from balance.space.formulas.planar_parts import PlanarParts

# Most orders that are tried before a linkage counts as one without an order.
MAX_TRIED_ORDERS = 20_000


class FreeStep(NamedTuple):
    """A part is placed at a random position of one joint.

    Attributes:
        joint: index of the joint.
        base: the part that is placed.
        part: the part to place.
    """

    joint: int
    base: int
    part: int


class DyadStep(NamedTuple):
    """Two parts are placed.

    Attributes:
        joints: of the first part to its base, between the two, of the second to its base.
        bases: the parts that are placed.
        parts: the two to place.
    """

    joints: tuple[int, int, int]
    bases: tuple[int, int]
    parts: tuple[int, int]


Step = FreeStep | DyadStep


class _OrderSearch:
    """Depth-first search of orders; joints that no step uses have to close by themselves."""

    def __init__(self, linkage: PlanarParts, unturned: frozenset[int]) -> None:
        self.unturned = unturned
        self.joints = [joint.parts for joint in linkage.joints]
        self.slides = [joint.slides for joint in linkage.joints]
        self.count = len(linkage.parts)
        self.tried = 0

    def complete(self, placed: frozenset[int], free: int) -> list[Step] | None:
        """Complete an order with a number of free steps; None if there is none."""
        if len(placed) == self.count:
            return [] if free == 0 else None
        self.tried += 1
        if self.tried > MAX_TRIED_ORDERS:
            return None
        if (dyad := self._dyad(placed)) is not None:
            rest = self.complete(placed | set(dyad.parts), free)
            return None if rest is None else [dyad, *rest]
        if free == 0:
            return None
        for step in self._free_steps(placed):
            rest = self.complete(placed | {step.part}, free - 1)
            if rest is not None:
                return [step, *rest]
        return None

    def _links_to(self, placed: frozenset[int], part: int, but: int) -> list[tuple[int, int]]:
        """List joints from a part to placed ones, each with that one."""
        pairs = []
        for k, (a, b) in enumerate(self.joints):
            if k != but and part in (a, b) and (base := a + b - part) in placed:
                pairs.append((k, base))
        return pairs

    def _dyad(self, placed: frozenset[int]) -> DyadStep | None:
        for middle, (a, b) in enumerate(self.joints):
            if a in placed or b in placed or {a, b} & self.unturned:
                continue
            for first, base in self._links_to(placed, a, middle):
                for last, other in self._links_to(placed, b, middle):
                    kinds = [self.slides[k] for k in (first, middle, last)]
                    if sum(kinds) < 2 or kinds == [True, False, True]:
                        return DyadStep((first, middle, last), (base, other), (a, b))
        return None

    def _free_steps(self, placed: frozenset[int]) -> list[FreeStep]:
        steps = []
        for k, (a, b) in enumerate(self.joints):
            if (a in placed) != (b in placed):
                base, part = (a, b) if a in placed else (b, a)
                steps.append(FreeStep(k, base, part))
        return steps


def assembly_order(linkage: PlanarParts) -> tuple[int, list[Step]] | None:
    """Find an order for general dimensions: the part that is placed first, and the steps.

    Parts that do not turn are placed by free steps, after the ground, if that is possible.

    Returns:
        None if parts cannot be placed two at a time.
    """
    for unturned in (linkage.unturned, frozenset[int]()):
        search = _OrderSearch(linkage, unturned)
        for first in range(1 if unturned else len(linkage.parts)):
            steps = search.complete(frozenset([first]), linkage.mobility)
            if steps is not None:
                return first, steps
    return None
