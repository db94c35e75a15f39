"""Links that are alike in what is compared, as those of equal legs are.

What is compared of a link is the same in all poses and mirror images: its mass, the kinds of
its joints, distances and angles of their axes, and for each axis its distance from the centre
of mass, the second moment of mass along it, and the moment of inertia about the parallel axis
through the centre. Equal links are alike; alike ones may differ elsewhere. Classes are divided
until neighbours of alike links are alike (B. Weisfeiler, A. Lehman, Nauchno-Technicheskaya
Informatsia 2(9), 1968). The base has a class of its own, and where equal legs stand on it does
not count.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Hashable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple, TypeVar

import numpy as np

from balance.support.tolerances import LINKS_ALIKE
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.spatial.inertia import pseudo_inertia
from kinematics.numerics.array_types import Array

Key = TypeVar("Key", bound=Hashable)


class _Joint(NamedTuple):
    """A joint, or one of the revolute joints that make a ball joint.

    Attributes:
        kind: ``"revolute"``, ``"prismatic"``, ``"helical"`` or ``"ball"``.
        point: a point of it (3,), metres.
        axis: unit vector (3,).
        ends: the two rigid links.
    """

    kind: str
    point: Array
    axis: Array
    ends: tuple[int, int]


def alike_links(linkage: Linkage) -> list[tuple[int, ...]]:
    """Find which bodies are alike.

    Args:
        linkage: an assembled linkage.

    Returns:
        Positions of bodies, a tuple for each class, in the order of their first ones.
    """
    rigid = _rigid_links(linkage)
    moments = {link: np.zeros((4, 4)) for link in rigid.values()}
    for body in linkage.bodies:
        link = rigid[body.link]
        moments[link] = moments[link] + pseudo_inertia(body.inertia)
    joints = _joints_of(linkage, rigid, moments)
    members: dict[int, list[int]] = {link: [] for link in moments}
    for k, joint in enumerate(joints):
        for link in {*joint.ends}:
            members[link].append(k)
    places, between = _places(joints, members, moments), _distances(joints, members)
    masses = _number_values({link: float(P[3, 3]) for link, P in moments.items()})
    links = _number_classes({link: (link == rigid[GROUND], masses[link]) for link in masses})
    count = 0
    while count < len({*links.values()}):
        count = len({*links.values()})
        joint_classes = {
            k: (joint.kind, sorted(links[end] for end in joint.ends))
            for k, joint in enumerate(joints)
        }
        links = _number_classes(
            {
                link: (
                    number,
                    sorted((joint_classes[k], places[k, link]) for k in members[link]),
                    sorted(
                        (sorted((joint_classes[j], joint_classes[k])), between[j, k])
                        for j, k in combinations(members[link], 2)
                    ),
                )
                for link, number in links.items()
            }
        )
    classes: dict[int, list[int]] = defaultdict(list)
    for b, body in enumerate(linkage.bodies):
        classes[links[rigid[body.link]]].append(b)
    return [tuple(bodies) for bodies in classes.values()]


def classes_among(
    classes: Sequence[tuple[int, ...]], bodies: Collection[int]
) -> list[tuple[int, ...]]:
    """List what of each class is among some bodies, without the empty parts."""
    parts = (tuple(b for b in alike if b in bodies) for alike in classes)
    return [part for part in parts if part]


def _rigid_links(linkage: Linkage) -> dict[int, int]:
    """Name the rigid link of each link: the first of those that welds of loops join."""
    rigid = {link: link for link in range(GROUND, len(linkage.joints))}
    for loop in linkage.loops:
        pair = rigid[loop.end], rigid[loop.successor]
        rigid = {link: min(pair) if name in pair else name for link, name in rigid.items()}
    return rigid


def _joints_of(
    linkage: Linkage, rigid: Mapping[int, int], moments: Mapping[int, Array]
) -> list[_Joint]:
    """List the joints; revolute ones in a point that massless links join are a ball joint."""
    joints = [
        _Joint(joint.kind, joint.point, joint.direction, (rigid[joint.parent], rigid[k]))
        for k, joint in enumerate(linkage.joints)
    ]
    chains = [{k} for k in range(len(joints))]
    for link, P in moments.items():
        at = [k for k, joint in enumerate(joints) if link in joint.ends]
        if P[3, 3] == 0.0 and link != rigid[GROUND] and len(at) == 2:
            joined = set().union(*(chain for chain in chains if chain & {*at}))
            chains = [chain for chain in chains if not chain & joined] + [joined]
    for chain in chains:
        parts = [joints[k] for k in chain]
        points = np.array([joint.point for joint in parts])
        meet = np.ptp(points, axis=0).max() <= LINKS_ALIKE * linkage.chain.frame.length
        turns = all(joint.kind == "revolute" for joint in parts)
        axes = np.array([joint.axis for joint in parts])
        if turns and meet and np.linalg.matrix_rank(axes, LINKS_ALIKE) == 3:
            for k in chain:
                joints[k] = joints[k]._replace(kind="ball")
    return joints


def _places(
    joints: Sequence[_Joint],
    members: Mapping[int, Sequence[int]],
    moments: Mapping[int, Array],
) -> dict[tuple[int, int], tuple[int, int, int]]:
    """Number where joints are on links, by joint and link.

    The numbers are those of the distance from the centre of mass, of the second moment of
    mass about that centre along the axis, and of the moment of inertia about a parallel axis
    through it.
    """
    distances, along, turning, largest = {}, {}, {}, 0.0
    for link, group in members.items():
        P, mass = moments[link], float(moments[link][3, 3])
        centre = P[:3, 3] / mass if mass > 0.0 else np.zeros(3)
        about = P[:3, :3] - np.outer(P[:3, 3], centre)
        largest = max(largest, float(np.trace(about)))
        for k in group:
            joint = joints[k]
            away = centre - joint.point
            if joint.kind != "ball":
                away = np.cross(away, joint.axis)
            far_off = mass > 0.0 and joint.kind != "prismatic"
            distances[k, link] = float(np.linalg.norm(away)) if far_off else 0.0
            spread = float(joint.axis @ about @ joint.axis)
            inertia = float(np.trace(about)) - spread
            along[k, link], turning[k, link] = (
                (0.0, 0.0) if joint.kind == "ball" else (spread, inertia)
            )
    far, wide = _number_values(distances), _number_values(along, largest)
    heavy = _number_values(turning, largest)
    return {key: (far[key], wide[key], heavy[key]) for key in far}


def _distances(
    joints: Sequence[_Joint], members: Mapping[int, Sequence[int]]
) -> dict[tuple[int, int], tuple[int, int]]:
    """Number distances and cosines of the axes of pairs of joints of one link."""
    pairs = {pair for group in members.values() for pair in combinations(group, 2)}
    measures = {pair: _axes_apart(joints[pair[0]], joints[pair[1]]) for pair in sorted(pairs)}
    far = _number_values({pair: distance for pair, (distance, _) in measures.items()})
    turned = _number_values({pair: cosine for pair, (_, cosine) in measures.items()})
    return {pair: (far[pair], turned[pair]) for pair in measures}


def _axes_apart(first: _Joint, second: _Joint) -> tuple[float, float]:
    """Measure the distance of two axes and the cosine of their angle, where they have them."""
    away = second.point - first.point
    if first.kind == second.kind == "ball":
        return float(np.linalg.norm(away)), 0.0
    if "ball" in (first.kind, second.kind):
        joint = second if first.kind == "ball" else first
        across = np.cross(away, joint.axis)
        return 0.0 if joint.kind == "prismatic" else float(np.linalg.norm(across)), 0.0
    across, cosine = np.cross(first.axis, second.axis), abs(float(first.axis @ second.axis))
    sine = float(np.linalg.norm(across))
    if "prismatic" in (first.kind, second.kind):
        return 0.0, cosine
    if sine <= LINKS_ALIKE:
        return float(np.linalg.norm(np.cross(away, first.axis))), cosine
    return abs(float(away @ across)) / sine, cosine


def _number_values(values: Mapping[Key, float], size: float = 0.0) -> dict[Key, int]:
    """Number values in ascending order; those that are equal for their size have one number."""
    limit = LINKS_ALIKE * max([size, *values.values()])
    numbers: dict[Key, int] = {}
    number, last = 0, 0.0
    for key in sorted(values, key=values.__getitem__):
        number += values[key] - last > limit
        numbers[key], last = number, values[key]
    return numbers


def _number_classes(features: Mapping[int, object]) -> dict[int, int]:
    """Number features, equal ones alike, in the order of their texts."""
    texts = {key: repr(feature) for key, feature in features.items()}
    order = {text: number for number, text in enumerate(sorted({*texts.values()}))}
    return {key: order[text] for key, text in texts.items()}
