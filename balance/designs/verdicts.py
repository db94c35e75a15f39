"""What is said of designs that do not exist, and of those that no check has settled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.designs.constraints import Constraints
from balance.designs.mass_regions import reach_of
from balance.spaces.design_space_result import DesignSpace

__all__ = [
    "TOO_NARROW",
    "UNSETTLED",
    "describe_conflict",
    "describe_furthest",
    "describe_limits",
]

Array = NDArray[np.float64]

# Part of a certificate that counts as none.
FELT = 1e-12
# More conditions rule out more designs: a proof that there is none stays one.
UNSETTLED = (
    "not all conditions are known, and a design may break the others; leave out max_order, if "
    "it was given"
)
TOO_NARROW = (
    "a certificate excludes the designs of the space that was found, but conditions near "
    "round-off may be false ones, and there may be more designs"
)


def describe_limits(asked: Constraints) -> str:
    """The limits of a restriction in words that follow a verdict; none without limits."""
    return f" within {asked.within:g} link lengths" if asked.balls else ""


def describe_conflict(space: DesignSpace, Z: Array, asked: Constraints) -> str:
    """What a certificate says: which bodies' positivity clash."""
    sizes = np.abs(Z).max(axis=(1, 2))
    felt = (sizes > FELT * sizes.max()).tolist()
    clash = [name for name, weighs in zip(space.bodies, felt, strict=True) if weighs]
    listed = " and ".join(filter(None, [", ".join(clash[:-1]), clash[-1]]))
    verdict = f"infeasible{describe_limits(asked)}"
    if set(clash) <= {space.bodies[b] for b in asked.keep}:
        return (
            f"{verdict}: {listed}, as kept, cannot be balanced by any masses of the others; "
            "keep fewer links"
        )
    extent = np.abs(Z[:, :-1]).max() > FELT * sizes.max()
    what = "some second moments" if extent else "the masses"
    sums = f"{what} of {listed} {'are zero' if len(clash) == 1 else 'add up to zero'}"
    positive = "which are positive for bodies that can be built"
    if asked.sized:
        return (
            f"{verdict}: with what is kept and bounded, {sums} or less, {positive}; keep fewer "
            "links, or widen the bounds"
        )
    if asked:
        return f"{verdict}: in every balanced distribution there, {sums} or less, {positive}"
    remedy = "change the geometry or restrict the motion"
    if space.balance == "dynamic":
        remedy = "change the geometry, restrict the motion, or balance the forces alone"
    return f"{verdict}: in every balanced distribution {sums}, {positive}; {remedy}"


def describe_furthest(space: DesignSpace, P: Array, asked: Constraints) -> str:
    """Which body of a design is furthest beyond the ball in which it might be, and how far.

    Args:
        space: the design space.
        P: pseudo-inertias (bodies, k, k), in the coordinates of the chain.
        asked: the restriction, with balls.
    """
    b = max(asked.balls, key=lambda b: reach_of(asked.balls[b], P[b]))
    ball, name, length = asked.balls[b], space.bodies[b], space.chain.frame.length
    away = float(np.linalg.norm(P[b][:-1, -1] / P[b][-1, -1] - ball.centre))
    if away > ball.radius:
        return f"centre of mass of {name} {away * length:.2g} m away"
    spread = reach_of(ball, P[b]) * ball.radius * length
    return f"mass of {name} {spread:.2g} m away (root mean square)"
