"""Texts of verdicts: infeasible designs, and undecided ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.masses.designs.constraints import Constraints
from balance.masses.designs.mass_regions import reach_of
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import CERTIFICATE_ENTRY_RELATIVE, MASSES_EQUAL
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import MAX_NAMES, number_text

# A space with missing conditions is too large: certificates stay valid, designs do not.
UNSETTLED = (
    "not all conditions are known, and a design may break the others; leave out max_order, if "
    "it was given"
)
MOTION_IN_DOUBT = (
    "it is in doubt which joints move, and a design may shake in other motions: {}"
)
UNCHECKED = (
    "neither a design nor a certificate stands up to its check; ask less of the masses, or "
    "put the linkage nearer to the origin"
)
UNCHECKED_DENSITY = (
    "bodies of any density balance the linkage, but for this limit of density neither a design "
    "nor a certificate stands up to its check; give another density, or thickness"
)
UNCHECKED_MATTER = "neither an answer nor a certificate stands up to its check"
TOO_NARROW = (
    "a certificate excludes the designs of the space that was found, but conditions near "
    "round-off may be false ones, and there may be more designs"
)


FORCES_ALONE = "balance the forces alone"


def describe_limits(constraints: Constraints) -> str:
    """Describe the balls and densities of the constraints, to follow a verdict."""
    within = f" within {constraints.within:g} link lengths" if constraints.balls else ""
    densities = sorted({limit.density for limit in constraints.densities.values()})
    if not densities:
        return within
    span = f"{densities[0]:g}" + (f" to {densities[-1]:g}" if len(densities) > 1 else "")
    return f"{within} at no more than {span} kg/m³"


def describe_conflict(space: DesignSpace, Z: Array, constraints: Constraints) -> str:
    """Describe the bodies to which a certificate gives weight, and what to do, as a reason.

    Args:
        Z: matrices of the certificate (bodies, k, k).
        constraints: the constraints that it excludes.
    """
    sizes = np.abs(Z).max(axis=(1, 2))
    weighed = (sizes > CERTIFICATE_ENTRY_RELATIVE * sizes.max()).tolist()
    clash = [
        name
        for name, positive_weight in zip(space.bodies, weighed, strict=True)
        if positive_weight
    ]
    listed = _join_names(clash)
    if set(clash) <= {space.bodies[b] for b in constraints.keep}:
        return (
            f"{listed}, as kept, cannot be balanced by any masses of the others; "
            "keep fewer links"
        )
    extent = np.abs(Z[:, :-1, :-1]).max() > CERTIFICATE_ENTRY_RELATIVE * sizes.max()
    what = "some second moments" if extent else "the masses"
    sums = f"{what} of {listed} {'are zero' if len(clash) == 1 else 'add up to zero'}"
    positive = "which are positive for bodies that can be built"
    if constraints.densities:
        thicker = "thicker links, " if space.planar else ""
        return (
            f"with what is kept and bounded, {listed} would be denser than that; "
            f"take {thicker}a denser material, keep fewer links, or widen the bounds"
        )
    if constraints.sized:
        return (
            f"with what is kept and bounded, {sums} or less, {positive}; keep fewer "
            "links, or widen the bounds"
        )
    if constraints:
        return f"in every balanced distribution there, {sums} or less, {positive}"
    remedy = "change the geometry or restrict the motion"
    if space.balance == "dynamic":
        remedy = f"change the geometry, restrict the motion, or {FORCES_ALONE}"
    return f"in every balanced distribution {sums}, {positive}; {remedy}"


def _join_names(names: Sequence[str]) -> str:
    """Join names by commas and ``and``; of many the first, and how many are left."""
    parts = list(names)
    if len(parts) > MAX_NAMES + 1:
        parts = [*parts[:MAX_NAMES], f"{len(parts) - MAX_NAMES} others"]
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def describe_furthest(space: DesignSpace, P: Array, constraints: Constraints) -> str:
    """Describe the body of a design that is furthest outside its ball, and the distance.

    Args:
        P: pseudo-inertias (bodies, k, k), in the coordinates of the chain.
    """
    reaches = [reach_of(ball, P[b]) for b, ball in constraints.balls.items()]
    b = list(constraints.balls)[first_largest(reaches, relative=MASSES_EQUAL)]
    ball, name, length = constraints.balls[b], space.bodies[b], space.chain.frame.length
    away = float(np.linalg.norm(P[b][:-1, -1] / P[b][-1, -1] - ball.centre))
    if away > ball.radius:
        return f"centre of mass of {name} {number_text(away * length, '.2g')} m away"
    spread = reach_of(ball, P[b]) * ball.radius * length
    return f"mass of {name} {number_text(spread, '.2g')} m away (root mean square)"
