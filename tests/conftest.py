"""One BLAS thread: the matrices are small, and sums keep their order on every machine."""

from __future__ import annotations

import os

# BLAS reads these when NumPy loads, and pytest loads this file before any test.
for name in ("OPENBLAS", "OMP", "MKL", "BLIS"):
    os.environ[f"{name}_NUM_THREADS"] = "1"
os.environ["VECLIB_MAXIMUM_THREADS"] = "1"
