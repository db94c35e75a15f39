"""Displacements as products of shifts and turns about coordinate axes, in decimals.

The inverse of a pose ``xyz, rpy`` is the product ``Rx(-r) Ry(-p) Rz(-y) T(-xyz)``: each number
keeps its digits. Relative poses are therefore written as chains of origins, without any
arithmetic but sums of shifts, so that exact ranks, and rules on rounded angles, remain.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from decimal import Context, Decimal
from typing import NamedTuple

from kinematics.model.document.element import Element
from kinematics.numerics.linalg.rational import MAX_DIGITS

# Digits of sums of lengths: those of all numbers whose sizes differ by up to 10**100.
_SUMS = Context(prec=200)


class Shift(NamedTuple):
    """A translation, metres."""

    d: tuple[Decimal, Decimal, Decimal]


class Turn(NamedTuple):
    """A rotation about a coordinate axis: 0, 1 or 2 for x, y or z; radians."""

    axis: int
    angle: Decimal


Steps = tuple[Shift | Turn, ...]
_NONE = Shift((Decimal(), Decimal(), Decimal()))


def to_decimal(word: str) -> Decimal:
    """Convert a checked number; one of too many digits, or that underflows, is rounded."""
    value = float(word)
    if not value:
        return Decimal()
    return Decimal(word if len(word) <= MAX_DIGITS else repr(value))


def negated(word: str) -> str:
    """Write the negative of a checked number with the same digits."""
    value = to_decimal(word)
    return str(value.copy_negate()) if value else word


def inverse_steps(steps: Iterable[Shift | Turn]) -> Steps:
    """Compute the steps of the inverse displacement."""
    return tuple(map(_inverse_step, reversed(tuple(steps))))


def _inverse_step(step: Shift | Turn) -> Shift | Turn:
    if isinstance(step, Turn):
        return Turn(step.axis, step.angle.copy_negate())
    x, y, z = (value.copy_negate() for value in step.d)
    return Shift((x, y, z))


def simplify(steps: Iterable[Shift | Turn]) -> Steps:
    """Add shifts that follow each other, and leave out turns that cancel.

    Other turns about one axis are not added: a sum of rounded angles is not a rounded angle.
    """
    done: list[Shift | Turn] = []
    for step in steps:
        last = done[-1] if done else None
        if isinstance(step, Shift) and isinstance(last, Shift):
            x, y, z = map(_SUMS.add, last.d, step.d)
            done[-1] = Shift((x, y, z))
        elif last is not None and last == _inverse_step(step):
            done[-1] = _NONE
        else:
            done.append(step)
        if not any(done[-1].d if isinstance(done[-1], Shift) else [done[-1].angle]):
            done.pop()
    return tuple(done)


def origins(steps: Sequence[Shift | Turn], line: int) -> list[Element]:
    """Write steps as the fewest ``<origin>`` elements, each in the frame of the one before.

    An origin is a shift followed by turns about z, y and x.

    Args:
        line: line of the elements in messages.
    """
    groups: list[dict[int, Shift | Turn]] = []
    before = 0
    for step in steps:
        rank = 3 - step.axis if isinstance(step, Turn) else 0
        if rank <= before or not groups:
            groups.append({})
        groups[-1][rank] = step
        before = rank
    return [Element("origin", dict(_attributes(group)), (), line) for group in groups]


def _attributes(group: dict[int, Shift | Turn]) -> Iterator[tuple[str, str]]:
    """Attributes of the origin with a shift (0) and turns about z, y, x (1, 2, 3)."""
    shift = group.get(0)
    if isinstance(shift, Shift):
        yield "xyz", " ".join(map(str, shift.d))
    turns = [group.get(rank) for rank in (3, 2, 1)]
    if any(turns):
        yield "rpy", " ".join(str(t.angle) if isinstance(t, Turn) else "0" for t in turns)


def matrix_of(steps: Iterable[Shift | Turn]) -> tuple[list[list[float]], list[float]]:
    """Compute rotation (3, 3) and position (3,) of a displacement, in floating point."""
    R = [[float(i == j) for j in range(3)] for i in range(3)]
    p = [0.0, 0.0, 0.0]
    for step in steps:
        if isinstance(step, Shift):
            p = [
                a + math.fsum(map(float.__mul__, row, map(float, step.d)))
                for a, row in zip(p, R, strict=True)
            ]
            continue
        i, j = (step.axis + 1) % 3, (step.axis + 2) % 3
        c, s = math.cos(float(step.angle)), math.sin(float(step.angle))
        for row in R:
            row[i], row[j] = c * row[i] + s * row[j], c * row[j] - s * row[i]
    return R, p
