"""Linkages built by hand: any graph of rigid parts and joints, at a pose where it is closed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinematics.model.arrays import freeze
from kinematics.model.linkage import GROUND, Body, Joint, Loop, UnassembledLinkage
from tests.support.laws import point_masses, sums, unit_vector


class Edge(NamedTuple):
    """A joint of one degree of freedom between two rigid parts.

    Attributes:
        kind: as in `Joint`.
        screw: unit screw at the reference pose (6,).
        point: a point of the joint (3,).
        sides: numbers of the parts, 0 for the ground.
        name: of the joint.
    """

    kind: str
    screw: np.ndarray
    point: np.ndarray
    sides: tuple[int, int]
    name: str


def axis_edge(kind, n, point, sides, name, pitch=0.0) -> Edge:
    """A joint with axis n through a point, of some pitch in metres per radian."""
    moment = np.cross(point, n) + pitch * n
    screw = np.r_[0 * n, n] if kind == "prismatic" else np.r_[n, moment]
    return Edge(kind, screw, point, sides, name)


def spatial_edge(rng, sides, name) -> Edge:
    """A revolute, helical or prismatic joint anywhere."""
    kind = rng.choice(["revolute", "revolute", "helical", "prismatic"])
    pitch = rng.uniform(0.2, 0.8) if kind == "helical" else 0.0
    return axis_edge(str(kind), unit_vector(rng), rng.standard_normal(3), sides, name, pitch)


def planar_edge(rng, sides, name) -> Edge:
    """A revolute joint along z, or a prismatic one in the plane."""
    angle, point = rng.uniform(0, 2 * np.pi), np.r_[rng.standard_normal(2), 0.0]
    if rng.uniform() < 0.2:
        n = np.array([np.cos(angle), np.sin(angle), 0.0])
        return axis_edge("prismatic", n, point, sides, name)
    return axis_edge("revolute", np.array([0.0, 0.0, 1.0]), point, sides, name)


def linked(joints: Sequence[Edge], bodies: Sequence[int], rng, **more) -> UnassembledLinkage:
    """The linkage of some joints; the first ones to reach a part make the tree.

    Args:
        joints: in any order and direction.
        bodies: part of each body with parameters, named ``b0``, ``b1`` …
        rng: of their inertias.
        more: further fields of the draft.
    """
    link, made, waiting, closing = {0: GROUND}, [], list(joints), []
    while waiting:
        edge = waiting.pop(next(k for k, e in enumerate(waiting) if link.keys() & {*e.sides}))
        a, b = edge.sides if edge.sides[0] in link else edge.sides[::-1]
        if b in link:
            closing.append((edge, a, b))
        else:
            link[b] = len(made)
            made.append(_joint(edge, link[a], a == edge.sides[0]))
    loops = []
    for edge, a, b in closing:
        loops.append(Loop(f"weld_{edge.name}", len(made), link[b]))
        made.append(_joint(edge, link[a], True, in_loop=True))
    named = [
        Body(f"b{k}", link[part], freeze(sums(*point_masses(rng))), freeze(np.eye(4)))
        for k, part in enumerate(bodies)
    ]
    return UnassembledLinkage(
        "by_hand", "by hand", tuple(made), tuple(named), tuple(loops), **more
    )


def _joint(edge: Edge, parent: int, forth: bool, in_loop: bool = False) -> Joint:
    """The joint of an edge, walked forth or back."""
    screw = edge.screw if forth else -edge.screw
    kind, point = edge.kind, freeze(edge.point)
    return Joint(edge.name, kind, parent, freeze(screw), point, in_loop)
