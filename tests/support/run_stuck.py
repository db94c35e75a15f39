"""Run a job whose chunks never end: ``python -m tests.support.run_stuck SIGN [FILE]``.

Each chunk appends a character to the file SIGN and waits. Without FILE the job fills a table in
memory.
"""

from __future__ import annotations

import sys

from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.sweep_table import compute_table
from tests.support.squares import Squares

if __name__ == "__main__":
    sign, *path = sys.argv[1:]
    job = Squares(stuck=sign)
    if path:
        with ResultsFile.create(path[0], job) as results:
            run_chunks(job, results, workers=2)
    else:
        compute_table(job, 2, "squares")
