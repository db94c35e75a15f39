"""Balls that contain the masses of a design: one about the joints of each link.

A distribution in the ball of centre c and radius r has, with ``p = [x; 1]``,

    tr(G P) = ∫ pᵀ G p dm = ∫ (r² - |x - c|²) dm ≥ 0,        G = [[-1, c], [cᵀ, r² - |c|²]],

which is linear in its pseudo-inertia P. With P ⪰ 0 the condition is sufficient: such a P is a
sum of products ``p_i p_iᵀ`` with ``p_iᵀ G p_i ≥ 0`` for each (J. F. Sturm, S. Zhang,
Mathematics of Operations Research 28(2), 2003), and these are point masses in the ball. (For
ellipsoids: P. M. Wensing, S. Kim, J.-J. Slotine, IEEE Robotics and Automation Letters 3(1),
2018.) In a plane the ball is a disc, and the extent along the normal is free. For force
balance only the trace of the second moments counts; G depends on nothing else of them.

Positions are those at the reference pose. A joint is at the origin of its frame in the file.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import BALL_DISTANCE_EQUAL, LINK_LENGTH_ZERO
from kinematics.model.linkage import Body, Joint, Linkage
from kinematics.numerics.array_types import Array

# Radius of the ball of a link, in lengths of the link.
BALL_RADIUS = 1.5


class Ball(NamedTuple):
    """A ball, in a plane a disc, in the coordinates of the chain.

    Attributes:
        centre: centre in characteristic lengths (d,); d is 2 in a plane and 3 in space.
        radius: radius in characteristic lengths.
    """

    centre: Array
    radius: float

    @property
    def form(self) -> Array:
        """The matrix G (d + 1, d + 1) of the condition ``tr(G P) ≥ 0``."""
        c = self.centre
        G = -np.eye(c.size + 1)
        G[:-1, -1] = G[-1, :-1] = c
        G[-1, -1] = self.radius**2 - c @ c
        return G


def ball_of(space: DesignSpace, body: Body, within: float) -> Ball:
    """Compute the ball that must contain the mass of a body.

    Its centre is that of the smallest ball around the joints of the link, loop joints
    included, and the centre of mass in the file, if there is one. Its radius is ``within``
    times the length of the link, which is the largest distance from the joint that carries the
    link to another of these points. A link shorter than a thousandth of the characteristic
    length of the linkage, such as a massless link with one joint, has the characteristic
    length.

    Args:
        space: the design space; in a plane, points are projected onto it.
        body: one of its bodies.
        within: the radius, in lengths of the link.

    Returns:
        The ball in the coordinates of the chain.
    """
    frame, d = space.chain.frame, 2 if space.planar else 3
    joints = joint_points(space, body)
    if body.inertia[0] > 0.0:
        joints.append(body.inertia[1:4] / body.inertia[0])
    points = (np.array(joints) - frame.origin) @ frame.R.T[:, :d] / frame.length
    length = float(np.linalg.norm(points - points[0], axis=1).max())
    return Ball(middle_of(points), within * (length if length > LINK_LENGTH_ZERO else 1.0))


def reach_of(ball: Ball, P: Array) -> float:
    """Compute the root mean square distance of a body from a ball's centre, over the radius.

    Args:
        P: pseudo-inertia (d + 1, d + 1) of the body, in the coordinates of the chain.
    """
    inside = float(np.sum(ball.form * P)) / (ball.radius**2 * float(P[-1, -1]) or 1.0)
    return float(np.sqrt(max(0.0, 1.0 - inside)))


def middle_of(points: Array) -> Array:
    """Compute the centre (d,) of the smallest ball around points (n, d).

    Each step takes the smallest ball around at most d + 1 support points and adds the point
    furthest outside. The radius grows with every step, so the iteration ends.
    """
    support, last = points[:1], -1.0
    while True:
        centre, radius, support = _smallest_ball(support)
        away = np.linalg.norm(points - centre, axis=1)
        if away.max() <= radius + BALL_DISTANCE_EQUAL or radius <= last:
            return centre
        support, last = np.vstack([support, points[np.argmax(away)]]), radius


def _smallest_ball(points: Array) -> tuple[Array, float, Array]:
    """Compute the smallest ball around few points: centre, radius, and points on it."""
    best = points[0], np.inf, points
    for count in range(1, min(len(points), points.shape[1] + 1) + 1):
        for chosen in combinations(range(len(points)), count):
            on = points[list(chosen)]
            sides = on[1:] - on[0]
            # |c - x_0| = |c - x_i|, with c in the plane through all of them.
            half = np.linalg.lstsq(2.0 * sides, np.sum(sides**2, axis=1))[0]
            radius = float(np.linalg.norm(points - on[0] - half, axis=1).max())
            if radius < best[1] - BALL_DISTANCE_EQUAL:
                best = on[0] + half, radius, on
    return best


def joint_points(space: DesignSpace, body: Body) -> list[Array]:
    """Return the points of a body's joints (3,), that of the carrying joint first.

    Args:
        body: one of its bodies.

    Returns:
        Points at the reference pose, metres, inertial frame; joints of loops included.
    """
    return [joint.point for joint in joints_on(space.linkage, body)]


def joints_on(linkage: Linkage, body: Body) -> list[Joint]:
    """List the joints of a body, that which carries it first, those of loops included."""
    joints, link = linkage.joints, body.link
    ends = {loop.end for loop in linkage.loops if loop.successor == link}
    others = [
        joint
        for j, joint in enumerate(joints)
        if joint.parent == link or (j in ends and joint.in_loop)
    ]
    return [joints[link], *others]
