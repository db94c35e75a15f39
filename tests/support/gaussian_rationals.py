"""Complex numbers with rational parts: exact arithmetic for geometries and masses."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Gaussian:
    """A complex number; it works with `numpy.conj`, with ``1j``, and with Python's numbers."""

    x: Fraction
    y: Fraction

    @classmethod
    def of(cls, value):
        """Convert an exact number."""
        if isinstance(value, Gaussian):
            return value
        z = (value.real, value.imag) if isinstance(value, complex) else (value, 0)
        return cls(Fraction(z[0]), Fraction(z[1]))

    def __add__(self, other):
        other = Gaussian.of(other)
        return Gaussian(self.x + other.x, self.y + other.y)

    def __neg__(self):
        return Gaussian(-self.x, -self.y)

    def __sub__(self, other):
        return self + -Gaussian.of(other)

    def __mul__(self, other):
        other = Gaussian.of(other)
        x, y = self.x * other.x - self.y * other.y, self.x * other.y + self.y * other.x
        return Gaussian(x, y)

    def __truediv__(self, other):
        other = Gaussian.of(other)
        size = other.x**2 + other.y**2
        return self * other.conjugate() * (1 / size)

    def __pow__(self, n):
        out = Gaussian.of(1)
        for _ in range(abs(n)):
            out = out * self
        return out if n >= 0 else Gaussian.of(1) / out

    def __rsub__(self, other):
        return Gaussian.of(other) - self

    def __rtruediv__(self, other):
        return Gaussian.of(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def conjugate(self):
        """Mirror in the real axis."""
        return Gaussian(self.x, -self.y)


def unit(t):
    """The direction ``(1 + i t)² / (1 + t²)``, for a rational t."""
    size = 1 + t * t
    return Gaussian((1 - t * t) / size, 2 * t / size)
