"""Linkages of one topology and ever new geometry, so that no call repeats another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinematics.assembly import assemble
from kinematics.linkage import Linkage, frozen
from kinematics.models import load

__all__ = ["resized", "variants"]


def variants(model: str, count: int, seed: int = 0, size: float = 0.02) -> list[Linkage]:
    """Copies of a linkage with its joint centres moved at random.

    Joints that meet in a point still do, and a planar linkage moves them in its plane, so
    mobility stays; every loop is closed at the reference pose by construction.

    Args:
        model: name in the gallery.
        count: how many.
        seed: of the random numbers.
        size: standard deviation, in characteristic lengths.
    """
    linkage = load(model)
    rng = np.random.default_rng(seed)
    return [_moved(linkage, rng, size) for _ in range(count)]


def _moved(linkage: Linkage, rng: np.random.Generator, size: float) -> Linkage:
    """One copy."""
    frame = linkage.chain.frame
    axes = frame.R[:2] if linkage.planar else frame.R
    moves: dict[tuple[float, ...], np.ndarray] = {}
    joints = []
    for joint in linkage.joints:
        key = tuple(np.round(joint.point, 9))
        drawn = size * frame.length * rng.standard_normal(len(axes)) @ axes
        step = moves.setdefault(key, drawn)
        screw = joint.screw.copy()
        screw[3:] += np.cross(step, screw[:3])
        joints.append(replace(joint, screw=frozen(screw), point=frozen(joint.point + step)))
    return assemble(replace(linkage, joints=tuple(joints)), linkage.inputs)


def resized(model: str, count: int, seed: int = 0) -> list[Linkage]:
    """Copies of a linkage of other sizes at other places: what is special about it stays.

    Args:
        model: name in the gallery.
        count: how many.
        seed: of the random numbers.
    """
    linkage = load(model)
    rng = np.random.default_rng(seed)
    copies = []
    for _ in range(count):
        factor, shift = rng.uniform(0.5, 2.0), rng.standard_normal(3)
        joints = []
        for joint in linkage.joints:
            screw = joint.screw.copy()
            if joint.kind != "prismatic":
                screw[3:] = factor * screw[3:] + np.cross(shift, screw[:3])
            point = frozen(factor * joint.point + shift)
            joints.append(replace(joint, screw=frozen(screw), point=point))
        copies.append(assemble(replace(linkage, joints=tuple(joints)), linkage.inputs))
    return copies
