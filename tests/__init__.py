"""Tests of the packages; `python -m tests.FOLDER.SCRIPT` runs a long search.

BLAS uses one thread: the matrices are small, and sums keep their order on every machine.
"""

import os

# BLAS reads these when NumPy loads, and Python loads this file before any module of tests.
for _name in ("OPENBLAS", "OMP", "MKL", "BLIS"):
    os.environ[f"{_name}_NUM_THREADS"] = "1"
os.environ["VECLIB_MAXIMUM_THREADS"] = "1"
