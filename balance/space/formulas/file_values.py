"""Masses of a file in the parameters of its formulas, and what the formulas make of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.space.formulas.formula_data import Formulas
from kinematics.numerics.array_types import Array

# A sum over the sizes of what is added: up to this it is round-off.
SUM_VANISHES = 1e-9


class FileValues(NamedTuple):
    """Values in the file of a linkage, SI units.

    Attributes:
        parameters: of the bodies, in the order of `Formulas.parameters`; s is complex.
        sums: left sides of the conditions; 0 where the masses of the file fulfil them.
    """

    parameters: tuple[complex, ...]
    sums: tuple[complex, ...]


def file_values(formulas: Formulas) -> FileValues:
    """Evaluate formulas with the dimensions and masses of the file."""
    parts = formulas.parts
    masses = [each.inertia for each in formulas.linkage.bodies]
    if formulas.planar:
        masses = [_planar(z, formulas.axes) for z in masses]
    values, sizes = {}, {}
    for parameter in formulas.parameters:
        row, mass = parts.in_file(parameter), masses[parameter.body]
        sizes[parameter] = float(abs(row) @ abs(mass))
        values[parameter] = _drop_round_off(complex(row @ mass), sizes[parameter])
    at, sums = formulas.free.values_in_file(), []
    for condition in formulas.conditions:
        total, size = values[condition.solved], sizes[condition.solved]
        for term in condition.terms:
            factor = 1j**term.turns * term.coefficient.value(at)
            total += factor * values[term.parameter]
            size += abs(factor) * sizes[term.parameter]
        sums.append(_drop_round_off(total, size))
    return FileValues(tuple(values.values()), tuple(sums))


def _drop_round_off(value: complex, size: float) -> complex:
    """Replace round-off by zero, in each part of a number.

    Args:
        size: sum of the sizes of what was added.
    """
    real, imag = (x if abs(x) > SUM_VANISHES * size else 0.0 for x in (value.real, value.imag))
    return complex(real, imag)


def _planar(z: Array, axes: Array) -> Array:
    """Return ``m, mcx, mcy, Ezz`` in axes (3, 3) of parameters (10,) about the origin."""
    xx, yy, zz, xy, xz, yz = z[4:]
    E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.array([z[0], *(axes[:2] @ z[1:4]), axes[2] @ E @ axes[2]])
