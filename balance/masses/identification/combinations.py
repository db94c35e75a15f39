"""Combinations of inertial parameters on which balance depends, in the frames of the links.

The momentum vanishes or not by ``C z``, C spanning the complement of the design space. With a
basis N of that space, split into rows D that can be eliminated, one for each column, and the
others I, the combinations

    z_I - N_I N_D⁻¹ z_D

are the same for all masses that shake alike: base parameters (M. Gautier, W. Khalil, IEEE
Transactions on Robotics and Automation 6(3), 1990), of the momentum instead of the torques.
Masses of the last links are eliminated first, then moments of inertia, then first moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.space.conditions.rank import singular_value_decomposition
from balance.space.inertial_parameters.body_inertia import in_link_frames
from balance.space.inertial_parameters.conversions import from_chain, to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    COEFFICIENT_ZERO,
    DEPENDENT_ROW,
    DEPENDENT_ROW_CLEAR,
    EXCITED_OUTSIDE,
)
from kinematics.closure.joint_positions import input_chain
from kinematics.model.arrays import Frame
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_basis
from kinematics.numerics.linalg.vectors import complement
from kinematics.wording import number_text

# Units of parameters by the first letter of their labels.
UNITS = {"m": "kg", "mc": "kg m", "E": "kg m²"}
# Order in which parameters are eliminated: by label, masses first.
ELIMINATED_FIRST = ("m", "Eyy", "Exx", "Exy", "Exz", "Eyz", "Ezz", "mcz", "mcy", "mcx")


class Combination(NamedTuple):
    """A combination of inertial parameters of links, in the frames of these links.

    Attributes:
        terms: label of a parameter, name of its link, and factor in SI units; the first factor
            is 1.
        unit: its unit.
        row: factors of all parameters in the units of the chain (bodies · 10,).
        determined: whether the loads determine it.
    """

    terms: tuple[tuple[str, str, float], ...]
    unit: str
    row: Array
    determined: bool

    @property
    def words(self) -> str:
        """The combination: ``mcx crank + 0.3 m coupler``."""
        text = ""
        for label, link, factor in self.terms:
            sign = " - " if factor < 0.0 else " + "
            size = "" if abs(factor) == 1.0 else f"{number_text(abs(factor))} "
            text += f"{sign if text or factor < 0.0 else ''}{size}{label} {link}"
        return text.removeprefix(" ")


class Relevant(NamedTuple):
    """Combinations on which balance depends, and which of them loads determine.

    Attributes:
        combinations: those that are determined, then those that are not.
        directions: orthonormal combinations that are determined (parameters, k), units of
            the chain.
        rank: number of all.
    """

    combinations: tuple[Combination, ...]
    directions: Array
    rank: int


def relevant_combinations(space: DesignSpace, excited: Array) -> Relevant:
    """Find combinations on which balance depends, and those of them that loads determine.

    Args:
        space: the design space of the linkage.
        excited: orthonormal directions that the loads determine (parameters, excited), units
            of the chain.
    """
    maps = _to_link_frames(space)
    null = space.basis_in_link_frames() / _scales(space)[:, None]
    null = np.linalg.qr(null)[0] if null.size else null
    scaled = maps / _scales(space)[:, None]
    combined = complement(null).T @ scaled
    whole = np.linalg.qr(combined.T)[0]
    inside = singular_value_decomposition(excited.T @ whole)
    # Cosines of the angles between both: 1 for what is in both.
    sines = np.linalg.norm(
        whole @ inside[2].T - excited @ (excited.T @ whole @ inside[2].T), axis=0
    )
    kept = inside[2][sines <= EXCITED_OUTSIDE]
    directions = whole @ kept.T
    everything = _eliminate(space, null, scaled)
    if len(kept) == len(everything):
        chosen = [item._replace(determined=True) for item in everything]
        return Relevant(tuple(chosen), directions, len(everything))
    chosen = []
    if len(kept):
        # Combinations in the frames of the links: W scaled = directions'.
        W = np.linalg.lstsq(scaled.T, directions, rcond=None)[0].T
        known = complement(complement(np.linalg.qr(W.T)[0])).T
        some = _eliminate(space, complement(first_basis(known).T), scaled)
        chosen = [item._replace(determined=True) for item in some]
    units = [item.row / np.linalg.norm(item.row) for item in everything]
    completing = _independent_rows(
        units, range(len(units)), directions, len(everything) - len(kept)
    )
    return Relevant(
        (*chosen, *(everything[k] for k in completing)), directions, len(everything)
    )


def _scales(space: DesignSpace) -> Array:
    """Return characteristic sizes of the parameters of all bodies, per kilogram (P,)."""
    powers = {"m": 0, "mc": 1, "E": 2}
    sizes = [space.length ** powers[_kind(label)] for label in space.labels]
    return np.tile(sizes, len(space.bodies))


def _kind(label: str) -> str:
    """Return what a parameter is: ``m``, ``mc`` or ``E``."""
    return label.rstrip("xyz")


def _to_link_frames(space: DesignSpace) -> Array:
    """Compute the matrix from parameters in units of the chain to those in link frames.

    Returns:
        Shape (counted parameters, bodies · 10), SI units in the link frames.
    """
    chain = input_chain(space.linkage)
    bodies = len(space.bodies)
    force = space.balance == "force"
    frame = Frame(R=space.axes) if space.planar else Frame()
    si = from_chain(chain.frame, False, False)
    counted = to_chain(si.T, frame, space.planar, force).T
    columns = np.asarray(np.kron(np.eye(bodies), counted), np.float64)
    return in_link_frames(columns, space.frames, space.axes, space.labels)


def _eliminate(space: DesignSpace, null: Array, scaled: Array) -> list[Combination]:
    """Eliminate as many parameters as an orthonormal basis has columns; see the module."""
    labels, bodies = space.labels, space.bodies
    count, size = len(labels), len(labels) * len(bodies)
    order = [
        b * count + labels.index(label)
        for label in ELIMINATED_FIRST
        if label in labels
        for b in reversed(range(len(bodies)))
    ]
    out = _independent_rows(null, order, np.empty((null.shape[1], 0)), null.shape[1])
    kept = [k for k in range(size) if k not in out]
    factors = np.zeros((len(kept), size))
    factors[range(len(kept)), kept] = 1.0
    if out:
        factors[:, out] = -np.linalg.solve(null[out].T, null[kept].T).T
    factors[np.abs(factors) <= COEFFICIENT_ZERO] = 0.0
    scales = _scales(space)
    combinations = []
    for k, row in zip(kept, factors, strict=True):
        used = [k, *(j for j in range(size) if j != k and row[j])]
        terms = tuple(
            (labels[j % count], bodies[j // count], float(row[j] * scales[k] / scales[j]))
            for j in used
        )
        unit = UNITS[_kind(labels[k % count])]
        combinations.append(Combination(terms, unit, scales[k] * (row @ scaled), False))
    return combinations


def _independent_rows(
    rows: Sequence[Array] | Array, order: Sequence[int], known: Array, count: int
) -> list[int]:
    """Choose rows that are independent of orthonormal columns, and of one another.

    Args:
        rows: rows of one length n.
        order: indices of the rows, those first that are chosen first.
        known: the columns (n, k).
        count: number of rows to choose.

    Returns:
        Their indices, ascending.
    """
    chosen: list[int] = []
    basis = known
    for clear in (DEPENDENT_ROW_CLEAR, DEPENDENT_ROW):
        for k in order:
            if k in chosen or len(chosen) == count:
                continue
            residual = rows[k] - basis @ (basis.T @ rows[k])
            residual = residual - basis @ (basis.T @ residual)
            size = float(np.linalg.norm(residual))
            if size > clear:
                chosen.append(k)
                basis = np.column_stack([basis, residual / size])
    return sorted(chosen)
