"""A motion: a linear subspace of the displacements of the independent coordinates."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from kinematics.error_text import did_you_mean
from kinematics.errors import MotionError, UsageError
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import MAX_DIGITS, decimal, rational_null_space
from kinematics.numerics.tolerances import RELATION_ROUND_OFF
from kinematics.wording import first_names

# Largest factor: sums of such factors do not overflow.
MAX_FACTOR = 1e300
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


@dataclass(frozen=True, eq=False)
class Motion:
    """Displacements ``u = basis @ y`` of the inputs from the reference pose.

    Attributes:
        inputs: names of the independent coordinates.
        relations: the relations as text, such as ``"j4=j7"``.
        basis: shape (inputs, degrees of freedom of the motion), SI units.
    """

    inputs: tuple[str, ...]
    relations: tuple[str, ...]
    basis: Array

    def __repr__(self) -> str:
        """Give one line: the relations, or the number of free inputs."""
        rule = ", ".join(self.relations) or f"{self.basis.shape[1]} free"
        return f"Motion of {first_names(self.inputs)}: {rule}"

    @classmethod
    def free(cls, inputs: Sequence[str]) -> Motion:
        """Make the motion that moves every input freely."""
        return cls(tuple(inputs), (), _identity(len(inputs)))

    @classmethod
    def parse(cls, relations: str | Sequence[str], inputs: Sequence[str]) -> Motion:
        """Make the motion that satisfies linear relations of displacements.

        Args:
            relations: one, or several; each ``"sum = sum"``, a sum being made of terms
                ``name``, ``number*name`` and ``0``: ``"j4=j7"``, ``"j4=-2*j7"``, ``"c=-a-b"``.
                Displacements are in radians and metres.
            inputs: names of the independent coordinates.

        Returns:
            The motion.

        Raises:
            MotionError: a relation cannot be read, names a joint that is not an input, or
                the relations leave nothing to move.

        Example:
            >>> from kinematics import Motion
            >>> Motion.parse("u1 = -2*u2", ["u1", "u2"]).basis
            array([[ 1. ],
                   [-0.5]])
        """
        relations = [relations] if isinstance(relations, str) else relations
        rows = [_relation_row(relation, tuple(inputs)) for relation in relations]
        columns = rational_null_space(
            [_scale_to_unit(row) for row in rows], len(inputs), _largest_in_row
        )
        if not columns and inputs:
            raise MotionError(", ".join(relations), "leaves no input to move", inputs)
        basis = np.array(columns, dtype=np.float64).reshape(len(columns), len(inputs)).T
        return cls(tuple(inputs), tuple(relations), freeze(basis))

    def coefficients(self) -> list[tuple[str, list[Fraction]]]:
        """Compute the independent relations and their rational coefficients, one per input.

        Relations that repeat others up to rounding are left out. Those of a motion without
        text span the orthogonal complement of its basis, and are called ``motion``.
        """
        if self.relations:
            rows = [_relation_row(relation, self.inputs) for relation in self.relations]
            kept = _select_independent(rows)
            return [(self.relations[k], rows[k]) for k in kept]
        columns = [[Fraction(x) for x in column] for column in self.basis.T.tolist()]
        return [("motion", row) for row in rational_null_space(columns, len(self.inputs))]


@cache
def _identity(count: int) -> Array:
    """The basis of a motion of so many free inputs."""
    return freeze(np.eye(count))


def motion_of(
    linkage: Linkage, relations: Motion | str | Sequence[str] | None
) -> Motion | None:
    """Make the motion of a linkage from relations of its inputs; None if it is free.

    Args:
        relations: as for `Motion.parse`; a motion, or None, is returned as it is.

    Raises:
        MotionError: a relation is wrong.
        UsageError: it is no relation, such as a motion over time.
    """
    if relations is None or isinstance(relations, Motion):
        return relations
    if not isinstance(relations, Iterable):
        raise UsageError(
            "motion is a relation of inputs, such as 'u2=u1', not a "
            f"{type(relations).__name__}: give motions over time as motions"
        )
    try:
        return Motion.parse(relations, linkage.inputs)
    except MotionError as error:
        raise MotionError(error.relation, error.problem, error.valid, linkage.source) from None


def while_text(motion: Motion | str | Sequence[str] | None) -> str:
    """Say during which motion something holds: `` while u2=u1``; nothing if it is free."""
    relations = motion.relations if isinstance(motion, Motion) else motion or ()
    words = relations if isinstance(relations, str) else ", ".join(relations)
    return f" while {words}" if words else ""


def _relation_row(relation: str, inputs: tuple[str, ...]) -> list[Fraction]:
    """Compute the coefficients of left side minus right side."""
    sides = relation.split("=")
    if len(sides) != 2:
        raise MotionError(relation, "must hold one '='", inputs)
    left, right = (_side_coefficients(relation, side, inputs) for side in sides)
    return [a - b for a, b in zip(left, right, strict=True)]


def _side_coefficients(relation: str, text: str, inputs: tuple[str, ...]) -> list[Fraction]:
    """Compute the coefficients of one sum of terms."""
    alternatives = "|".join(re.escape(name) for name in sorted(inputs, key=len, reverse=True))
    term = re.compile(rf"\s*([+-]?)\s*(?:({_NUMBER})\s*\*\s*)?({alternatives})(?![\w.])\s*")
    zero = re.compile(r"\s*[+-]?\s*0+(?:\.0*)?\s*$")
    row = [Fraction(0)] * len(inputs)
    if zero.match(text):
        if text.strip() in inputs:
            problem = f"'{text.strip()}' is a number and an input: write 1*{text.strip()}"
            raise MotionError(relation, problem, inputs)
        return row
    position = 0
    while position < len(text) or position == 0:
        match = term.match(text, position)
        if match is None or (position > 0 and not match[1]):
            raise MotionError(relation, _reading_problem(text[position:], inputs), inputs)
        word = match[2] or "1"
        if len(word) > MAX_DIGITS or not float(word) <= MAX_FACTOR:
            raise MotionError(relation, f"'{word[:MAX_DIGITS]}' is too large", inputs)
        row[inputs.index(match[3])] += decimal(word) * (-1 if match[1] == "-" else 1)
        position = match.end()
    return row


def _reading_problem(text: str, inputs: Sequence[str]) -> str:
    """Describe the error in the text where reading stopped."""
    word = re.match(rf"\s*[+-]?\s*(?:{_NUMBER}\s*\*\s*)?([A-Za-z_][\w./-]*)", text)
    if word:
        return f"'{word[1]}' is not an input{did_you_mean(word[1], inputs)}"
    return f"cannot read '{text.strip()}' (write sums of terms such as j1 or -2*j1)"


def _scale_to_unit(row: list[Fraction]) -> list[Fraction]:
    """Divide a row by its largest coefficient."""
    size = max(map(abs, row), default=Fraction(0))
    return [x / size for x in row] if size else row


def _select_independent(rows: list[list[Fraction]]) -> list[int]:
    """Select the numbers of the rows that leave less to move than those before them."""
    units = [_scale_to_unit(row) for row in rows]
    kept: list[int] = []
    freedoms = len(rows[0])
    for k, row in enumerate(units):
        kept_rows = [units[i] for i in kept]
        free = len(rational_null_space([*kept_rows, row], len(row), _largest_in_row))
        if free < freedoms:
            kept.append(k)
            freedoms = free
    return kept


def _largest_in_row(
    rows: Sequence[Sequence[Fraction]], pivots: Sequence[int]
) -> tuple[int, int] | None:
    """Choose the pivot of one relation after the other: its largest coefficient.

    A relation repeats others if these leave nothing of it but the rounding of its decimals.
    """
    for i, row in enumerate(rows):
        column = max(range(len(row)), key=lambda c: abs(row[c]), default=0)
        if row and abs(row[column]) > RELATION_ROUND_OFF:
            return i, column
    return None
