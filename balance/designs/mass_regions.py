"""Where the masses of a design may be: within a ball about the joints of each link.

A distribution in the ball of centre c and radius r has, with ``p = [x; 1]``,

    tr(G P) = ∫ pᵀ G p dm = ∫ (r² - |x - c|²) dm ≥ 0,        G = [[-1, c], [cᵀ, r² - |c|²]],

which is linear in its pseudo-inertia P. Together with P ⪰ 0 that is all: such a P is a sum of
products ``p_i p_iᵀ`` with ``p_iᵀ G p_i ≥ 0`` for each (J. F. Sturm, S. Zhang, Mathematics of
Operations Research 28(2), 2003), and these are point masses in the ball. (P. M. Wensing,
S. Kim, J.-J. Slotine, IEEE Robotics and Automation Letters 3(1), 2018, have this for
ellipsoids.) In a plane the ball is a disc, and what is along the normal is free; for force
balance only the trace of the second moments counts, which is all that G sees of them.

Places are those at the reference pose, joints being where the file puts their frames.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.spaces.design_space_result import DesignSpace
from kinematics.model.linkage import Body

__all__ = ["BALL_RADIUS", "Ball", "ball_of", "middle_of", "reach_of"]

Array = NDArray[np.float64]

# Radius of the ball of a link, in lengths of the link.
BALL_RADIUS = 1.5
# A link of less than this part of the characteristic length has no length of its own.
NO_LENGTH = 1e-3
# Distances that differ by this, in characteristic lengths, are equal.
EQUAL = 1e-12


class Ball(NamedTuple):
    """A ball, in a plane a disc, in the coordinates of the chain.

    Attributes:
        centre: in characteristic lengths (d,), d being 2 in a plane and 3 in space.
        radius: in characteristic lengths.
    """

    centre: Array
    radius: float

    @property
    def form(self) -> Array:
        """The matrix G (d + 1, d + 1), see above."""
        c = self.centre
        G = -np.eye(c.size + 1)
        G[:-1, -1] = G[-1, :-1] = c
        G[-1, -1] = self.radius**2 - c @ c
        return G


def ball_of(space: DesignSpace, body: Body, within: float) -> Ball:
    """The ball in which the mass of a body is to be.

    Its centre is that of the smallest ball that holds the joints of the link, those of loops
    among them, and the centre of mass in the file, if there is one. Its radius is ``within``
    times the length of the link: the largest distance from the joint that carries it to
    another of these places. A link of less than a thousandth of the characteristic length of
    the linkage takes that one, such as a link without mass that has one joint.

    Args:
        space: the design space; in a plane, only places in that plane count.
        body: one of its bodies.
        within: the radius, in lengths of the link.
    """
    frame, d = space.chain.frame, 2 if space.planar else 3
    places = _joints(space, body)
    if body.inertia[0] > 0.0:
        places.append(body.inertia[1:4] / body.inertia[0])
    points = (np.array(places) - frame.origin) @ frame.R.T[:, :d] / frame.length
    length = float(np.linalg.norm(points - points[0], axis=1).max())
    return Ball(middle_of(points), within * (length if length > NO_LENGTH else 1.0))


def reach_of(ball: Ball, P: Array) -> float:
    """Root mean square distance of a body from the centre of a ball, over its radius.

    Args:
        ball: the ball.
        P: pseudo-inertia (d + 1, d + 1) of the body, in the coordinates of the chain.
    """
    inside = float(np.sum(ball.form * P)) / (ball.radius**2 * float(P[-1, -1]) or 1.0)
    return float(np.sqrt(max(0.0, 1.0 - inside)))


def middle_of(points: Array) -> Array:
    """Centre (d,) of the smallest ball that holds points (n, d).

    A ball through at most d + 1 of them is tried; the point that is furthest outside takes
    part next. The radius grows with every step, so that there is a last one.
    """
    support, last = points[:1], -1.0
    while True:
        centre, radius, support = _through(support)
        away = np.linalg.norm(points - centre, axis=1)
        if away.max() <= radius + EQUAL or radius <= last:
            return centre
        support, last = np.vstack([support, points[np.argmax(away)]]), radius


def _through(points: Array) -> tuple[Array, float, Array]:
    """The smallest ball that holds a few points: its centre, radius, and those on it."""
    best = points[0], np.inf, points
    for count in range(1, min(len(points), points.shape[1] + 1) + 1):
        for chosen in combinations(range(len(points)), count):
            on = points[list(chosen)]
            sides = on[1:] - on[0]
            # |c - x_0| = |c - x_i|, with c in the plane through all of them.
            half = np.linalg.lstsq(2.0 * sides, np.sum(sides**2, axis=1))[0]
            radius = float(np.linalg.norm(points - on[0] - half, axis=1).max())
            if radius < best[1] - EQUAL:
                best = on[0] + half, radius, on
    return best


def _joints(space: DesignSpace, body: Body) -> list[Array]:
    """Places of the joints of a body (3,), that of the one that carries it first."""
    joints, link = space.linkage.joints, body.link
    ends = {loop.end for loop in space.linkage.loops if loop.successor == link}
    others = [joint.point for j, joint in enumerate(joints)
              if joint.parent == link or (j in ends and joint.in_loop)]  # fmt: skip
    return [joints[link].point, *others]
