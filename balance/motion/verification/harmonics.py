"""Harmonics of a load over one revolution of a crank."""

from __future__ import annotations

import numpy as np

from kinematics.numerics.array_types import Array


def harmonic_peaks(load: Array, count: int) -> Array:
    """Compute the largest size of each harmonic of a load over one revolution.

    With N samples ``F_k`` at equal angles, the harmonic n is the vector

        F_n(θ) = Re(c_n e^{inθ}),    c_n = 2/N Σ_k F_k e^{-2πi n k/N},

    whose tip runs on an ellipse. Its long half axis is the largest singular value of
    ``[Re c_n, Im c_n]``: of a force on a line its amplitude, of a force that rotates its size.

    Args:
        load: components at equal angles, both ends of the revolution (N + 1, 3).
        count: number of harmonics.

    Returns:
        The sizes of the harmonics from the first on (count,), in the unit of the load.
    """
    spectrum = np.fft.rfft(load[:-1], axis=0)[1 : count + 1] * (2.0 / (len(load) - 1))
    axes = np.stack([spectrum.real, spectrum.imag], axis=2)
    return np.asarray(np.linalg.svd(axes, compute_uv=False)[:, 0])
