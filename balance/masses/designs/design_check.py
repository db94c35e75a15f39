"""The check of a design: balance, positive definite pseudo-inertias, and constraints.

The check uses plain NumPy and the design space, not the solver that found the design.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.designs.constraints import Constraints
from balance.masses.designs.density import density_over_limit
from balance.masses.designs.mass_regions import reach_of
from balance.masses.designs.pseudo_inertia_cone import from_si, matrices_of, parameters_by_body
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    BOUND_RELATIVE,
    DENSITY_RELATIVE,
    DESIGN_RESIDUAL,
    FAR_ORIGIN_ROUND_OFF,
    KEPT_BODY_RESIDUAL,
    PLATE_RELATIVE,
    REACH_RELATIVE,
)
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out
from kinematics.wording import check_summary


class DesignCheck(NamedTuple):
    """Result of `check_design`.

    Attributes:
        accepted: whether the design lies in the design space to 1e-12, has a larger margin,
            and fulfils the constraints. With an inertial origin far away, the round-off of
            the parameters replaces 1e-12.
        conditions: distance from the design space over the size of the design, lengths in
            characteristic lengths; in a plane also how far the bodies are from having one
            plane of symmetry parallel to the motion.
        eigenvalue: smallest eigenvalue of the pseudo-inertias over the sum of their traces.
        reach: largest root mean square distance of a body's mass from the centre of the ball
            that must contain it, over the radius; 0 if there are no balls.
        density: largest density that a body needs over its limit, 0 if there are no limits;
            see `balance.masses.designs.density`.
    """

    accepted: bool
    conditions: float
    eigenvalue: float
    reach: float = 0.0
    density: float = 0.0

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals to three digits."""
        return check_summary(self)


def check_design(
    space: DesignSpace | LinkageLike, z: ArrayLike, constraints: Constraints | None = None
) -> DesignCheck:
    """Check balance and realisability of a design in plain NumPy, without the solver.

    Args:
        space: the design space, or the linkage, its path or its name.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        constraints: kept bodies, mass bounds, balls and densities, from ``Design.constraints``;
            none by default. Kept bodies must equal those of the file. Masses in files are
            rounded, so the conditions need then hold to 1e-9 only, and these bodies need not be
            definite. Bounds and densities must hold to 1e-8 of their value, radii of balls to
            1e-6, and flat bodies whose density is limited are plates to 1e-6 of their
            thickness.

    Returns:
        The verdict on the design and its residuals.

    Example:
        >>> import balance, kinematics
        >>> linkage = kinematics.load("robot.urdf")
        >>> space = balance.design_space(linkage, balance="force")
        >>> balance.checks.check_design(space, balance.masses.feasible(space).z).accepted
        True
        >>> given = [body.inertia for body in linkage.bodies]
        >>> balance.checks.check_design(space, given).accepted
        False
    """
    space, constraints = as_space(space), constraints or Constraints()
    z = np.reshape(z, (len(space.bodies), 10))
    P = from_si(z, space.chain.frame)
    chain_z = from_pseudo_inertia(P)
    part, Q = chain_z[:, parameters_by_body(space)].reshape(-1), space.scaled_basis
    residual = project_out(part, Q)
    conditions = float(np.linalg.norm(residual) / (np.linalg.norm(part) or 1.0))
    if space.planar and space.balance == "dynamic":
        conditions = max(conditions, out_of_plane_asymmetry(P[space.chain.links >= 0]))
    total = float(np.einsum("bii->", P))
    if not (np.isfinite(chain_z).all() and total > 0.0):
        return DesignCheck(False, conditions, -np.inf)
    free = [b for b in range(len(P)) if b not in constraints.keep]
    eigenvalue = float(np.linalg.eigvalsh(P[free]).min()) / total
    origin = space.chain.frame.origin / space.chain.frame.length
    doubt = max(DESIGN_RESIDUAL, FAR_ORIGIN_ROUND_OFF * float(origin @ origin))
    balanced = conditions <= max(doubt, KEPT_BODY_RESIDUAL if constraints.keep else 0.0)
    flat = matrices_of(space, z)
    furthest = max(
        (reach_of(ball, flat[b]) for b, ball in constraints.balls.items()), default=0.0
    )
    if not eigenvalue > 0.0:
        return DesignCheck(False, conditions, eigenvalue, furthest)
    excess = density_excess(space, z, constraints)
    accepted = (
        balanced
        and eigenvalue > doubt
        and furthest <= 1.0 + REACH_RELATIVE
        and excess <= 1.0 + DENSITY_RELATIVE
        and _are_plates(space, P, constraints)
        and _satisfies(space, z, constraints)
    )
    return DesignCheck(accepted, conditions, eigenvalue, furthest, excess)


def density_excess(space: DesignSpace, z: Array, constraints: Constraints) -> float:
    """Compute the largest density that a body needs, over its limit; 0 without limits.

    Args:
        z: parameters (bodies, 10) about the inertial origin, SI units, of bodies that are
            positive definite.
        constraints: the constraints with the limits.
    """
    P, area = matrices_of(space, z), space.chain.frame.length**2
    return max(
        (
            density_over_limit(P[b], limit.least_moment / area)
            for b, limit in constraints.densities.items()
        ),
        default=0.0,
    )


def _are_plates(space: DesignSpace, P: Array, constraints: Constraints) -> bool:
    """Whether flat bodies with a limit have the second moments of plates along the normal.

    Args:
        P: pseudo-inertias (bodies, 4, 4) in the coordinates of the chain.
    """
    for b, limit in constraints.densities.items():
        if limit.thickness is not None:
            along = P[b, 2, 2] - P[b, 2, 3] ** 2 / P[b, 3, 3]
            plate = P[b, 3, 3] * (limit.thickness / space.chain.frame.length) ** 2 / 12.0
            round_off = DESIGN_RESIDUAL * float(np.trace(P[b]))
            if not abs(along - plate) <= PLATE_RELATIVE * plate + round_off:
                return False
    return True


def _satisfies(space: DesignSpace, z: Array, constraints: Constraints) -> bool:
    """Whether a design has the kept bodies, and its masses are within their bounds."""
    within = all(
        low * (1.0 - BOUND_RELATIVE) <= z[b, 0] <= high * (1.0 + BOUND_RELATIVE)
        for b, (low, high) in constraints.bounds.items()
    )
    return within and all(
        np.array_equal(z[b], space.linkage.bodies[b].inertia) for b in constraints.keep
    )


def leaves_plane(space: DesignSpace, constraints: Constraints) -> bool:
    """Whether kept bodies have no common plane of symmetry."""
    moving = [b for b in constraints.keep if space.chain.links[b] >= 0]
    kept = np.array([space.linkage.bodies[b].inertia for b in moving]).reshape(-1, 10)
    return out_of_plane_asymmetry(from_si(kept, space.chain.frame)) > KEPT_BODY_RESIDUAL


def out_of_plane_asymmetry(P: Array) -> float:
    """Compute how far bodies are from a common plane of symmetry, relative to their size.

    Args:
        P: pseudo-inertias (bodies, 4, 4) in the coordinates of a planar chain.
    """
    shift = np.eye(4)
    shift[2, 3] = -plane_offset(P)
    size = np.linalg.norm(P) or 1.0
    return float(np.linalg.norm((shift @ P @ shift.T)[:, 2, [0, 1, 3]]) / size)


def plane_offset(P: Array) -> float:
    """Compute the height of the total centre of mass of pseudo-inertias (bodies, 4, 4).

    It is measured along the third axis, from the origin.
    """
    return float(P[:, 2, 3].sum() / (P[:, 3, 3].sum() or 1.0))
