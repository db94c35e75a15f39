"""Start a mechanism that is driven at speed: rigid velocities and quasi-static bending.

Bodies at rest under an input at speed take a blow, whose forces grow with the number of modes.
Without one, the links bend as the inertia forces of the rigid motion ask, and no more. With
elastic coordinates q that stand still, rigid accelerations a_r and multipliers λ solve

    M_r a_r + Gᵀ λ + [0; K q] = Q - h        G_r a_r = γ

The bending changes along the motion, which gives its rates: differences of q at two instants.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.motion.flexible.mechanism import PlanarMechanism, solve_bordered
from kinematics.errors import LinkageError

Array = NDArray[np.float64]

# Most iterations of closing and bending; each is smaller by the square of the ratio of the
# frequency of the motion to that of the beam.
MOST_STEPS = 60
# Change of the coordinates over the size of the mechanism at which they have settled.
SETTLED = 1e-12
# Motion between the instants of a difference, in radians and sizes of the mechanism.
DIFFERENCE = 1e-3


def moves_at_start(mechanism: PlanarMechanism) -> bool:
    """Tell whether an input has a speed at the start."""
    return any(drive.profile(0.0)[1] != 0.0 for drive in mechanism.drives if not drive.moment)


def steady_start(mechanism: PlanarMechanism) -> tuple[Array, Array]:
    """Compute coordinates and rates (n,) of a mechanism that has moved steadily before.

    Args:
        mechanism: the mechanism; its start is taken without bending.

    Raises:
        LinkageError: the links bend too far, or the mechanism does not close.
    """
    p, v = _settle(mechanism, 0.0, mechanism.start)
    bends = _elastic(mechanism)
    turning = [at.start + 2 for at in mechanism.slices]
    fastest = np.abs(v[turning]).max(initial=0.0)
    shifts = np.abs(np.delete(v, turning)).max(initial=0.0) / mechanism.size
    h = DIFFERENCE / max(fastest, shifts, 1e-300)
    ahead, behind = (_settle(mechanism, t, p + t * v)[0] for t in (h, -h))
    rates = np.zeros(len(p))
    rates[bends] = (ahead - behind)[bends] / (2.0 * h)
    return p, _rigid_rates(mechanism, 0.0, p, rates)


def _elastic(mechanism: PlanarMechanism) -> NDArray[np.bool_]:
    """Mark the elastic coordinates (n,)."""
    mask = np.zeros(len(mechanism.start), dtype=np.bool_)
    for at in mechanism.slices:
        mask[at.start + 3 : at.stop] = True
    return mask


def _settle(mechanism: PlanarMechanism, t: float, p: Array) -> tuple[Array, Array]:
    """Bend the links as the rigid motion at a time asks; rates are those of the rigid motion.

    Raises:
        LinkageError: the bending does not settle.
    """
    for _ in range(MOST_STEPS):
        p = _close(mechanism, t, p)
        v = _rigid_rates(mechanism, t, p, np.zeros(len(p)))
        bent = _bend(mechanism, t, p, v)
        change = np.abs(bent - p).max(initial=0.0)
        p = bent
        if change <= SETTLED * max(mechanism.size, 1e-6):
            return _close(mechanism, t, p), v
        if not change < 1e3 * mechanism.size:
            break
    raise LinkageError(
        "the links bend too far at this speed for a start without a blow: lower the speed, or "
        "spin the input up from rest (spin:SPEED,RISE)"
    )


def _close(mechanism: PlanarMechanism, t: float, p: Array) -> Array:
    """Move the rigid coordinates onto the constraints; the bending stays."""
    rigid, v = ~_elastic(mechanism), np.zeros(len(p))
    for _ in range(MOST_STEPS):
        constraints = mechanism.constraints(t, p, v)
        if np.abs(constraints.g).max(initial=0.0) < SETTLED * max(mechanism.size, 1e-6):
            break
        p = p.copy()
        p[rigid] -= _least(mechanism, p, constraints.rows, constraints.g)
    return p


def _rigid_rates(mechanism: PlanarMechanism, t: float, p: Array, v: Array) -> Array:
    """Complete the rates of the elastic coordinates by rigid ones that keep the constraints."""
    constraints, rigid = mechanism.constraints(t, p, v), ~_elastic(mechanism)
    v = v.copy()
    v[rigid] -= _least(mechanism, p, constraints.rows, constraints.rows @ v + constraints.rates)
    return v


def _least(mechanism: PlanarMechanism, p: Array, rows: Array, residual: Array) -> Array:
    """Solve G_r Δ = residual for the rigid change Δ of least mass-weighted size."""
    rigid = ~_elastic(mechanism)
    mass = mechanism.inertia(p, np.zeros(len(p)))[0][np.ix_(rigid, rigid)]
    right = np.concatenate([np.zeros(len(mass)), residual])
    return solve_bordered(mass, rows[:, rigid], right)[: len(mass)]


def _bend(mechanism: PlanarMechanism, t: float, p: Array, v: Array) -> Array:
    """Compute the coordinates with the bending that the rigid accelerations at a state ask."""
    bends = _elastic(mechanism)
    mass, bias = mechanism.inertia(p, v)
    closure = mechanism.constraints(t, p, v)
    stiffness = np.zeros_like(mass)
    for part, at in zip(mechanism.parts, mechanism.slices, strict=True):
        elastic = slice(at.start + 3, at.stop)
        stiffness[elastic, elastic] = part.stiffness
    # Unknown are rigid accelerations and elastic coordinates, in the places of each other.
    columns = np.where(bends, stiffness, mass)
    right = np.concatenate([stiffness @ p - bias, closure.gamma])
    for drive in mechanism.drives:
        if drive.moment:
            right[: len(p)] += drive.profile(t)[0] * closure.positions[drive.joint].row
    full = np.block([
        [columns, closure.rows.T],
        [np.where(bends, 0.0, closure.rows), np.zeros((len(closure.rows), len(closure.rows)))],
    ])  # fmt: skip
    try:
        solution = np.linalg.solve(full, right)
    except np.linalg.LinAlgError:
        raise LinkageError(
            "the flexible mechanism starts in a singular pose, where its constraints depend on "
            "one another; start it elsewhere (--at)"
        ) from None
    return np.where(bends, solution[: len(p)], p)
