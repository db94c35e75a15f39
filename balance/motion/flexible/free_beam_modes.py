"""Modes of a free uniform Euler-Bernoulli beam: frequencies, zeros and shapes.

With λ = l (ρA ω² / EI)^¼ and ξ the distance from the middle over the length l, the frequencies
solve cos λ = sech λ. The modes, scaled to the amplitude of their cosine or sine, are

    ψ(ξ) = cos λξ + cos(λ/2) cosh(λξ) / cosh(λ/2)      symmetric, mode 1, 3, 5 …
    ψ(ξ) = sin λξ + sin(λ/2) sinh(λξ) / sinh(λ/2)      antisymmetric, mode 2, 4, 6 …

(J. P. den Hartog, Mechanical Vibrations, 4th ed., 1956). Quotients of hyperbolic functions are
evaluated by exponentials of negative numbers, so that nothing overflows or cancels.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

MOST_MODES = 500
# Newton converges quadratically from starts with errors below 0.02.
NEWTON_STEPS = 12


FLEX_SCHEMA = "balance.flex/1"
"""Of all data on flexible links."""


@dataclass(frozen=True, eq=False)
class FreeMode:
    """A bending mode of a free uniform beam, without dimensions.

    Attributes:
        number: 1, 2, 3 …; odd modes are symmetric.
        wave_number: λ.
        frequency: ω in units of sqrt(EI / (ρA l⁴)), equal to λ².
        zeros: the points ξ ≥ 0 at which the mode vanishes, from the middle to the end.
    """

    number: int
    wave_number: float
    frequency: float
    zeros: tuple[float, ...]

    def __repr__(self) -> str:
        """Number, λ² and zeros."""
        zeros = " ".join(f"{zero:.6f}" for zero in self.zeros[:6])
        more = " …" if len(self.zeros) > 6 else ""
        return f"FreeMode {self.number}: λ² {self.frequency:.6f}, zeros ± {zeros}{more}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON, an item of ``schemas/flex.schema.json``."""
        return {
            "number": self.number,
            "wave_number": self.wave_number,
            "frequency": self.frequency,
            "zeros": list(self.zeros),
        }


def free_modes(count: int) -> tuple[FreeMode, ...]:
    """Compute the first bending modes of a free uniform beam.

    Args:
        count: number of modes, from 1 to 500.

    Returns:
        The modes in the order of their frequencies; the two rigid motions are left out.

    Raises:
        UsageError: the count is out of range.

    Example:
        >>> from balance.motion.flexible.free_beam_modes import free_modes
        >>> round(free_modes(1)[0].zeros[0], 12)
        0.275842477298
    """
    if not 1 <= count <= MOST_MODES:
        raise UsageError(f"{count} modes: give a number from 1 to {MOST_MODES}")
    waves = mode_numbers(count)
    return tuple(
        FreeMode(k + 1, float(waves[k]), float(waves[k] ** 2), _mode_zeros(k + 1, waves[k]))
        for k in range(count)
    )


def mode_numbers(count: int) -> Array:
    """Compute the wave numbers λ of the first modes by Newton's method.

    The offset of λ from its limit (k + ½) π is the unknown, because it is as small as
    exp(-λ) and would drown in the rounding of λ.
    """
    limit = (np.arange(count) + 1.5) * np.pi
    sign = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    offset = np.zeros(count)
    for _ in range(NEWTON_STEPS):
        wave = limit + offset
        decay = np.exp(-wave)
        sech = 2.0 * decay / (1.0 + decay**2)
        slope = sign * np.cos(offset) + sech * np.tanh(wave)
        offset = offset - (sign * np.sin(offset) - sech) / slope
    return np.asarray(limit + offset)


def mode_shape(number: int, xi: Array, wave_number: float | None = None) -> Array:
    """Evaluate a mode.

    Args:
        number: number of the mode; odd modes are symmetric.
        xi: distances from the middle over the length, from -½ to ½.
        wave_number: λ, if it is known.

    Returns:
        ψ(ξ), of the shape of ``xi``.
    """
    wave = mode_numbers(number)[-1] if wave_number is None else wave_number
    near, far = _edge_decays(wave, np.abs(xi))
    if number % 2:
        edge = (near + far) / (1.0 + np.exp(-wave))
        return np.asarray(np.cos(wave * xi) + np.cos(wave / 2) * edge)
    edge = np.sign(xi) * (near - far) / (1.0 - np.exp(-wave))
    return np.asarray(np.sin(wave * xi) + np.sin(wave / 2) * edge)


def mode_slope(number: int, xi: Array, wave_number: float | None = None) -> Array:
    """Evaluate the slope dψ/dξ of a mode.

    Args:
        number: number of the mode; odd modes are symmetric.
        xi: distances from the middle over the length, from -½ to ½.
        wave_number: λ, if it is known.

    Returns:
        The slope, of the shape of ``xi``.
    """
    wave = mode_numbers(number)[-1] if wave_number is None else wave_number
    near, far = _edge_decays(wave, np.abs(xi))
    if number % 2:
        edge = np.sign(xi) * (near - far) / (1.0 + np.exp(-wave))
        return np.asarray(wave * (np.cos(wave / 2) * edge - np.sin(wave * xi)))
    edge = (near + far) / (1.0 - np.exp(-wave))
    return np.asarray(wave * (np.sin(wave / 2) * edge + np.cos(wave * xi)))


def _edge_decays(wave: float, distance: Array) -> tuple[Array, Array]:
    """Compute exp(-λ(½ - |ξ|)) and exp(-λ(½ + |ξ|))."""
    return np.exp(-wave * (0.5 - distance)), np.exp(-wave * (0.5 + distance))


def _mode_zeros(number: int, wave: float) -> tuple[float, ...]:
    """Find the zeros of a mode with ξ ≥ 0 by bisection and Newton steps between signs."""
    from scipy.optimize import brentq

    # A half wave separates zeros: one lies between neighbouring extremes of the cosine or sine.
    first = 0.0 if number % 2 else 0.5 * np.pi / wave
    edges = [first + i * np.pi / wave for i in range((number + 1) // 2)] + [0.5]

    def shape(xi: float) -> float:
        return float(mode_shape(number, np.asarray(xi), wave))

    inner = [float(brentq(shape, a, b, xtol=1e-16, rtol=1e-15)) for a, b in pairwise(edges)]
    return (*inner,) if number % 2 else (0.0, *inner)
