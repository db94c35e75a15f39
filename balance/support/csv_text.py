"""Tables of numbers as comma-separated values, with all their digits."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import StringIO
from typing import TYPE_CHECKING, TextIO

import numpy as np

from kinematics.numerics.array_types import Array

if TYPE_CHECKING:
    from _csv import Writer


def csv_writer(text: TextIO) -> Writer:
    """Write rows of words and numbers to an open text, one in a line."""
    return csv.writer(text, lineterminator="\n")


def csv_table(names: Sequence[str], columns: Sequence[Array]) -> bytes:
    """Write columns of numbers, with a line of their names.

    Args:
        names: a name for each column of numbers.
        columns: columns (N,), or several at once (N, n).
    """
    text = StringIO(newline="")
    writer = csv_writer(text)
    writer.writerow(names)
    writer.writerows([map(repr, row) for row in np.column_stack(columns).tolist()])
    return text.getvalue().encode()
