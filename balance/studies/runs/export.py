"""Export of results to CSV, Parquet and workbooks; the first two of any number of rows."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import IO, Any

from balance.studies.runs.chunk_job import ROW_NUMBER
from balance.studies.runs.results_file import ResultsFile
from balance.support.atomic_files import open_atomic
from balance.support.csv_text import csv_writer
from balance.support.workbook import require_openpyxl, workbook_of
from kinematics.errors import PackageError, UsageError

# Rows of a sheet of Excel, of which the first has the names.
SHEET_ROWS = 1_048_576


def export_csv(
    file: ResultsFile, path: str, progress: Callable[[int, int], None] | None = None
) -> int:
    """Write all results as CSV: a head with names and units, then one line per row, in order.

    The heads are those of `Column.heading`, such as ``coupler.length (m)``. Numbers have as
    many digits as give them back exactly; a missing value is an empty cell.
    The same results give the same bytes.

    Args:
        path: path of the CSV file.
        progress: called with the rows written and all rows.

    Returns:
        The number of rows.

    Raises:
        FileError: the file cannot be written.
    """
    with open_atomic(path) as raw:
        return _write_csv(file, raw, progress)


def export_workbook(
    file: ResultsFile, path: str, progress: Callable[[int, int], None] | None = None
) -> int:
    """Write all results as a workbook of one sheet: the table of `export_csv`.

    Args:
        path: path of the ``.xlsx`` file.
        progress: called with the rows read and all rows.

    Returns:
        The number of rows.

    Raises:
        FileError: the file cannot be written.
        PackageError: openpyxl is missing.
        UsageError: there are more rows than a sheet holds.
    """
    require_openpyxl()
    rows = file.computed()[1]
    if rows >= SHEET_ROWS:
        raise UsageError(
            f"a sheet holds {SHEET_ROWS:,} rows, and these are {rows:,}: write a .csv instead"
        )
    table = io.BytesIO()
    done = _write_csv(file, table, progress)
    with open_atomic(path) as raw:
        raw.write(workbook_of(table.getvalue(), "results"))
    return done


def _write_csv(
    file: ResultsFile, raw: IO[bytes], progress: Callable[[int, int], None] | None
) -> int:
    """Write all results as CSV to a stream; count the rows."""
    total, done = file.computed()[1], 0
    text = io.TextIOWrapper(raw, encoding="utf-8", newline="", write_through=True)
    writer = csv_writer(text)
    writer.writerow([ROW_NUMBER, *(column.heading for column in file.columns)])
    for rows in file.batches([column.name for column in file.columns]):
        writer.writerows(rows)
        done += len(rows)
        if progress is not None:
            progress(done, total)
    text.detach()
    return done


def export_parquet(
    file: ResultsFile, path: str, progress: Callable[[int, int], None] | None = None
) -> int:
    """Write all results as Parquet; units and the study are in its metadata.

    Args:
        path: path of the Parquet file.
        progress: called with the rows written and all rows.

    Returns:
        The number of rows.

    Raises:
        FileError: the file cannot be written.
        PackageError: PyArrow is missing.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        command = "pip install 'screwbalance[parquet]'"
        raise PackageError("a Parquet file", "PyArrow", command) from None
    schema = _schema(file, pyarrow)
    total, done = file.computed()[1], 0
    with open_atomic(path) as raw, pyarrow.parquet.ParquetWriter(raw, schema) as writer:
        for rows in file.batches([column.name for column in file.columns]):
            columns = zip(*rows, strict=True)
            arrays = [
                pyarrow.array(values, field.type)
                for field, values in zip(schema, columns, strict=True)
            ]
            writer.write_batch(pyarrow.record_batch(arrays, schema=schema))
            done += len(rows)
            if progress is not None:
                progress(done, total)
    return done


def _schema(file: ResultsFile, pyarrow: Any) -> Any:
    """Describe the columns for PyArrow."""
    types = {
        "integer": pyarrow.int64(),
        "real": pyarrow.float64(),
        "text": pyarrow.string(),
    }
    fields = [pyarrow.field(ROW_NUMBER, pyarrow.int64())]
    for column in file.columns:
        unit = {"unit": column.unit} if column.unit else None
        fields.append(pyarrow.field(column.name, types[column.kind], metadata=unit))
    return pyarrow.schema(fields, metadata=file.about)
