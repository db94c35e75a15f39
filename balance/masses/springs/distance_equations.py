"""Free lengths in rational numbers: springs between the same points whose parts add up to none.

A spring of free length L stores ``- k L |p_A - p_B|`` besides what one without stores. That is
no rational function of a pose, and drops out where ``Σ k L = 0`` over the springs between two
points: where one pulls when its ends meet, and another one pushes.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from balance.masses.springs.spring_term import SpringTerm

# Part of the largest ``k L`` that their sum may have in floating point.
DROPS_OUT = Fraction(1, 10**8)


def distance_equations(
    terms: Sequence[SpringTerm], start: int, width: int
) -> list[tuple[list[Fraction], Fraction]] | None:
    """Write ``Σ k L = 0`` for springs between the same points, with k unknown or given.

    Args:
        terms: the springs; each has its stiffness, unless that is given, and its shifts among
            the unknowns.
        start: place of the first of these.
        width: number of all unknowns.

    Returns:
        Rows on the unknowns, and what they are; None if the stiffnesses by floating point
        leave distances in the energy.
    """
    groups: dict[frozenset[object], list[tuple[SpringTerm, int]]] = {}
    for term in terms:
        ends = frozenset(zip(term.links, term.points, strict=True))
        groups.setdefault(ends, []).append((term, start))
        start += (not term.given) + len(term.axes)
    equations = []
    for members in groups.values():
        parts = [term.stiffness * term.length for term, _ in members]
        if not any(parts):
            continue
        if abs(sum(parts, Fraction(0))) > DROPS_OUT * max(abs(part) for part in parts):
            return None
        row, right = [Fraction(0)] * width, Fraction(0)
        for term, at in members:
            if term.given:
                right -= term.stiffness * term.length
            else:
                row[at] = term.length
        equations.append((row, right))
    return equations
