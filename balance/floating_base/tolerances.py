"""Numeric tolerances of simulations on a base that floats, each named for what it bounds."""

from __future__ import annotations

__all__ = [
    "BASE_AT_REST_RELATIVE", "BASE_DRIFT_RELATIVE", "BASE_STEP_RELATIVE", "FREQUENCY_ZERO",
    "MASS_MATRIX_SINGULAR",
]  # fmt: skip

# Relative tolerance of the steps of an integration; the least that DOP853 takes is 2.2e-14.
BASE_STEP_RELATIVE = 2e-12
# Speed of a base that counts as at rest, relative to the speed of the bodies on it: masses in
# files are rounded to nine digits.
BASE_AT_REST_RELATIVE = 1e-9
# Drift of energy or momentum, relative to their peaks, up to which a simulation is trusted.
BASE_DRIFT_RELATIVE = 1e-9
# Smallest eigenvalue of a mass matrix with unit diagonal that counts as zero.
MASS_MATRIX_SINGULAR = 1e-12
# Square of a natural frequency that counts as zero, relative to the largest one.
FREQUENCY_ZERO = 1e-12
