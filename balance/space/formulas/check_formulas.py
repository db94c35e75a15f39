"""Checks of formulas: at fresh geometries modulo another prime, and in the numbers of the file."""

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
from kinematics.errors import ExactError
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS, reduced_echelon

Array = NDArray[np.float64]

FRESH_GEOMETRIES = 20
"""Number of geometries at which formulas are checked."""


def fresh_geometries(
    samples: GeometrySamples, parameters: Sequence[Parameter], conditions: Sequence[Condition]
) -> int:
    """Check formulas modulo another prime; return the number of geometries.

    At each geometry velocities at finite poses, without series, give the conditions: they and
    the formulas span the same space.

    Raises:
        ExactError: they do not.
    """
    p, rng = PRIMES_OF_61_BITS[1], random.Random(11)
    place = {parameter: i for i, parameter in enumerate(parameters)}
    for _ in range(FRESH_GEOMETRIES):
        point = samples.free.draw(p, rng)
        rows = []
        for condition in conditions:
            row = [0] * len(parameters)
            row[place[condition.solved]] = 1
            for term in condition.terms:
                row[place[term.parameter]] = term.coefficient.remainder(point, p)
            rows.append(row)
        every = range(len(parameters))
        ours = reduced_echelon(rows, every, p)
        if ours != reduced_echelon(samples.finite_rows(point, p), every, p):
            raise ExactError(
                f"{samples.source.linkage.source}: the formulas do not hold at other poses of "
                "other dimensions: several motions may meet in these"
            )
    return FRESH_GEOMETRIES


def file_residual(
    space: DesignSpace, parts: PlanarParts, free: FreeDimensions,
    parameters: Sequence[Parameter], conditions: Sequence[Condition], target: int,
) -> float:  # fmt: skip
    """Compute how far masses of the design space of the file violate the formulas.

    Returns:
        The largest violation over the sum of the sizes of its terms; infinite if the formulas
        are fewer than the conditions.
    """
    rows = real_rows(space, parts, free, parameters, conditions)
    if not len(rows):
        return 0.0 if target == 0 else float("inf")
    scale = np.ones(len(space.labels))
    for k, label in enumerate(space.labels):
        scale[k] = space.length ** {"m": 0, "E": 2}.get(label.rstrip("xyzc"), 1)
    units = np.tile(scale, len(space.bodies))
    basis = space.basis / units[:, None]
    scaled = rows * units
    sizes = np.abs(scaled) @ np.abs(basis)
    residual = float((np.abs(scaled @ basis) / np.maximum(sizes, sizes.max() * 1e-3)).max(initial=0.0))
    norms = np.linalg.norm(scaled, axis=1)
    kept = scaled[norms > 1e-9 * norms.max()]
    independent = np.linalg.matrix_rank(kept / np.linalg.norm(kept, axis=1)[:, None], tol=1e-9)
    return residual if independent == space.rank else float("inf")


def real_rows(
    space: DesignSpace, parts: PlanarParts, free: FreeDimensions,
    parameters: Sequence[Parameter], conditions: Sequence[Condition],
) -> Array:  # fmt: skip
    """Evaluate formulas in the numbers of the file, as rows for the parameters of the space."""
    labels = space.labels
    values = free.values_in_file()
    rows = []
    for condition in conditions:
        row = np.zeros(len(space.bodies) * len(labels), complex)
        for parameter, coefficient in [
            (condition.solved, 1 + 0j),
            *((term.parameter, term.coefficient.value(values)) for term in condition.terms),
        ]:
            part = parts.parts[parts.body_parts[parameter.body]]
            start = parameter.body * len(labels)
            row[start : start + len(labels)] += coefficient * _in_plane(
                parameter.kind, part.origin, part.axis, len(labels)
            )
        rows += [row.real, row.imag]
    return np.array(rows)


def _in_plane(kind: str, origin: complex, axis: complex, count: int) -> NDArray[np.complex128]:
    """Express a parameter in the frame of a part by ``m, mcx, mcy, Ezz`` about the origin."""
    row = np.zeros(4, complex)
    if kind == "m":
        row[0] = 1
    elif kind == "J":
        row[:] = abs(origin) ** 2, -2 * origin.real, -2 * origin.imag, 1
    else:
        s = np.array([-origin, 1, 1j, 0]) * axis.conjugate()
        row[:] = {"s": s, "sx": s.real + 0j, "sy": 1j * s.imag}[kind]
    return row[:count]
