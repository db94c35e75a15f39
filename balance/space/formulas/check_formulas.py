"""Checks of formulas: at fresh geometries modulo another prime, and in those of the file."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.space.formulas.formula_data import Condition
from balance.space.formulas.geometry_samples import GeometrySamples
from balance.space.formulas.parameters import Parameter
from balance.space.formulas.planar_parts import PlanarParts
from balance.space.formulas.relations import FreeDimensions
from balance.space.spaces.design_space import DesignSpace
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS, echelon_modulo

Array = NDArray[np.float64]

# Size of a row over the largest, or singular value of unit rows: below this they vanish.
ROW_VANISHES = 1e-9
# Terms of a condition over the largest mass: below this it says that parameters are zero.
ROW_OF_ZEROS = 1e-3
# Smallest singular value of a space above which its basis is accurate to round-off.
KEPT_ACCURATELY = 1e-3
FRESH_GEOMETRIES = 20
"""Number of geometries at which formulas are checked."""


def fresh_geometries(
    samples: GeometrySamples, parameters: Sequence[Parameter], conditions: Sequence[Condition]
) -> int:
    """Count the fresh geometries, up to 20, at which formulas hold modulo another prime.

    At each geometry velocities at finite poses, without series, give the conditions: they and
    the formulas span the same space.

    Returns:
        20, or the number of geometries before one at which they do not.
    """
    p, rng = PRIMES_OF_61_BITS[1], random.Random(11)
    place = {parameter: i for i, parameter in enumerate(parameters)}
    for done in range(FRESH_GEOMETRIES):
        point = samples.free.draw(p, rng)
        rows = []
        for condition in conditions:
            row = [0] * len(parameters)
            row[place[condition.solved]] = 1
            for term in condition.terms:
                row[place[term.parameter]] = term.coefficient.remainder(point, p)
            rows.append(row)
        every = range(len(parameters))
        ours = echelon_modulo(rows, every, p)
        if ours != echelon_modulo(samples.finite_rows(point, p), every, p):
            return done
    return FRESH_GEOMETRIES


def file_residual(
    space: DesignSpace, parts: PlanarParts, free: FreeDimensions,
    conditions: Sequence[Condition], complete: bool,
) -> float:  # fmt: skip
    """Compute how far masses of the design space of the file violate the formulas.

    Returns:
        The largest violation over the sum of the sizes of its terms, times the smallest
        singular value of the space where it is below 1e-3, for its basis has an error of
        round-off over this value; infinite if the formulas are complete and fewer than the
        conditions.
    """
    rows = real_rows(space, parts, free, conditions)
    if not rows.size:
        return 0.0 if space.rank == 0 or not complete else float("inf")
    powers = [{"m": 0, "Ezz": 2}.get(label, 1) for label in space.labels]
    scale = space.length ** np.array(powers, float)
    units = np.tile(scale, len(space.bodies))
    scaled, basis = rows * units, space.basis / units[:, None]
    scaled = scaled[np.abs(scaled).max(axis=1) > ROW_VANISHES * np.abs(scaled).max()]
    scaled /= np.linalg.norm(scaled, axis=1)[:, None]
    if complete and np.linalg.matrix_rank(scaled, tol=ROW_VANISHES) != space.rank:
        return float("inf")
    sizes = (np.abs(scaled) @ np.abs(basis)).max(axis=1, keepdims=True)
    sizes = np.maximum(sizes, ROW_OF_ZEROS * np.abs(basis).max(initial=0.0))
    violation = float((np.abs(scaled @ basis) / sizes).max(initial=0.0))
    return violation * min(1.0, space.kept / KEPT_ACCURATELY)


def real_rows(
    space: DesignSpace, parts: PlanarParts, free: FreeDimensions,
    conditions: Sequence[Condition],
) -> Array:  # fmt: skip
    """Evaluate formulas in the numbers of the file, as rows for the parameters of the space."""
    count, values = len(space.labels), free.values_in_file()
    rows = []
    for condition in conditions:
        row = np.zeros(len(space.bodies) * count, complex)
        for parameter, coefficient in [
            (condition.solved, 1 + 0j),
            *(
                (each.parameter, 1j**each.turns * each.coefficient.value(values))
                for each in condition.terms
            ),
        ]:
            part = parts.parts[parts.body_parts[parameter.body]]
            start = parameter.body * count
            entry = _in_plane(parameter.kind, part.origin, part.axis)
            row[start : start + count] += coefficient * entry[:count]
        rows += [row.real, row.imag]
    return np.array(rows)


def _in_plane(kind: str, origin: complex, axis: complex) -> NDArray[np.complexfloating]:
    """Express a parameter in the frame of a part by ``m, mcx, mcy, Ezz`` about the origin."""
    if kind == "m":
        return np.array([1, 0, 0, 0], complex)
    if kind == "J":
        return np.array([abs(origin) ** 2, -2 * origin.real, -2 * origin.imag, 1], complex)
    s = np.array([-origin, 1, 1j, 0]) * axis.conjugate()
    return {"s": s, "sx": s.real + 0j, "sy": s.imag + 0j}[kind]
