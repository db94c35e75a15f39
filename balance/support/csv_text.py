"""Tables of numbers as comma-separated values, with all their digits."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import StringIO

import numpy as np
from numpy.typing import NDArray


def csv_table(names: Sequence[str], columns: Sequence[NDArray[np.float64]]) -> bytes:
    """Write columns of numbers, with a line of their names.

    Args:
        names: a name for each column of numbers.
        columns: columns (N,), or several at once (N, n).
    """
    text = StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([map(repr, row) for row in np.column_stack(columns).tolist()])
    return text.getvalue().encode()
