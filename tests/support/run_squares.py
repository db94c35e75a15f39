"""Run the job of squares: ``python -m tests.support.run_squares ROWS FILE WORKERS [DASK]``."""

from __future__ import annotations

import sys

from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from tests.support.held_runs import hold_at
from tests.support.squares import Squares

JOB = Squares(rows=6000, chunk_rows=100, pause=0.01)

if __name__ == "__main__":
    rows, path, workers, *dask = sys.argv[1:]
    hold_at(int(rows))
    with ResultsFile.resume(path, JOB) as results:
        run_chunks(JOB, results, workers=int(workers), dask=dask[0] if dask else None)
