"""Vary the geometry of a linkage, so that no call repeats another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinematics import ScrewJoint, from_screws
from kinematics.closure.assembly.assemble import assemble
from kinematics.loading.model_gallery import load
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage


def variants(model: str, count: int, seed: int = 0, size: float = 0.02) -> list[Linkage]:
    """Make copies of a linkage with its joint centres moved at random.

    Joints at one point stay together, and those of a planar linkage stay in its plane, so that
    mobility stays; every loop is closed at the reference pose by construction.

    Args:
        model: name in the gallery.
        count: number of copies.
        seed: seed of the random numbers.
        size: standard deviation, in characteristic lengths.
    """
    linkage = load(model)
    rng = np.random.default_rng(seed)
    return [_move_joints(linkage, rng, size) for _ in range(count)]


def _move_joints(linkage: Linkage, rng: np.random.Generator, size: float) -> Linkage:
    """Make one copy."""
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
        joints.append(replace(joint, screw=freeze(screw), point=freeze(joint.point + step)))
    return assemble(replace(linkage, joints=tuple(joints)), linkage.inputs)


def resized(model: str, count: int, seed: int = 0) -> list[Linkage]:
    """Make similar copies of a linkage, in other sizes at other positions.

    Args:
        model: name in the gallery.
        count: number of copies.
        seed: seed of the random numbers.
    """
    linkage = load(model)
    rng = np.random.default_rng(seed)
    copies = []
    for _ in range(count):
        factor, shift = rng.uniform(0.5, 2.0), rng.standard_normal(3)
        copies.append(placed(linkage, factor, shift))
    return copies


def placed(linkage: Linkage, size: float, shift: np.ndarray) -> Linkage:
    """Scale a linkage about the inertial origin, and then move it.

    Args:
        linkage: the linkage; its bodies do not change.
        size: factor of all lengths.
        shift: displacement of the inertial origin (3,), metres.
    """
    joints = []
    for joint in linkage.joints:
        screw = joint.screw.copy()
        if joint.kind != "prismatic":
            screw[3:] = size * screw[3:] + np.cross(shift, screw[:3])
        point = freeze(size * joint.point + shift)
        joints.append(replace(joint, screw=freeze(screw), point=point))
    return assemble(replace(linkage, joints=tuple(joints)), linkage.inputs)


def two_loops(links: int, seed: int) -> Linkage:
    """Make two loops on one base, with hinges at random decimals.

    Args:
        links: links of each loop, the base among them.
        seed: seed of the random numbers.
    """
    rng = np.random.default_rng(seed)
    joints, loops = [], []
    for side, x in (("a", 0.0), ("b", 4.0)):
        names = ["base", *(f"{side}{k}" for k in range(1, links))]
        points = np.round(rng.uniform(-1, 1, (links, 2)), 2) + (x, 0)
        for k, (x1, y1) in enumerate(points[:-1]):
            joint = ScrewJoint(f"{side}j{k}", names[k], names[k + 1], point=(x1, y1, 0.0))
            joints.append(joint)
        loops.append(ScrewJoint(f"{side}end", names[-1], "base", point=(*points[-1], 0.0)))
    return from_screws(joints, loops)


def four_bar_chain(count: int, seed: int = 0) -> str:
    """Write a URDF file with a row of coupled four-bars whose cranks make full turns.

    The rocker of each is the crank of the next. The row has one degree of freedom, so that
    every condition beyond the first few must come from higher derivatives or from other poses.

    Args:
        count: number of four-bars.
        seed: seed of the random lengths and phases, which are rounded to millimetres.
    """
    rng = np.random.default_rng(seed)
    links, joints, loops = [_link("ground", False), _link("rocker0")], [], []
    joints.append(_joint("u", "ground", "rocker0", np.zeros(2), ' independent="true"'))
    foot, tip = np.zeros(2), _polar(rng, 0.9, 1.1)
    for k in range(count):
        while True:
            base, rocker = _polar(rng, 0.5, 0.7), _polar(rng, 0.8, 1.2)
            coupler = base + rocker - tip
            lengths = np.sort(np.hypot(*np.array([base, tip, coupler, rocker]).T))
            # A drag link: the ground is the shortest, and the sum of Grashof holds.
            if np.hypot(*base) == lengths[0] and lengths[0] + lengths[3] < lengths[1:3].sum():
                break
        foot = foot + base
        links += [_link(f"coupler{k}"), _link(f"rocker{k + 1}")]
        joints.append(_joint(f"a{k}", f"rocker{k}", f"coupler{k}", tip))
        joints.append(_joint(f"o{k}", "ground", f"rocker{k + 1}", foot))
        loops.append(
            f'<loop name="b{k}" type="revolute">'
            f'<predecessor link="coupler{k}"><origin xyz="{_xyz(coupler)}"/></predecessor>'
            f'<successor link="rocker{k + 1}"><origin xyz="{_xyz(rocker)}"/></successor>'
            '<axis xyz="0 0 1"/></loop>'
        )
        tip = _polar(rng, 0.9, 1.1)
    return "\n".join([f'<robot name="chain{count}">', *links, *joints, *loops, "</robot>"])


def _polar(rng: np.random.Generator, low: float, high: float) -> np.ndarray:
    """Draw a vector in any direction, with a length between two bounds, to the millimetre."""
    angle, length = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(low, high)
    return np.round(length * np.array([np.cos(angle), np.sin(angle)]), 3)


def _xyz(point: np.ndarray) -> str:
    """Write a point of the plane as an attribute."""
    return f"{point[0]:.3f} {point[1]:.3f} 0"


def _link(name: str, massive: bool = True) -> str:
    """Write a link with or without mass."""
    inertial = (
        '<inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    return f'<link name="{name}">{inertial if massive else ""}</link>'


def _joint(name: str, parent: str, child: str, origin: np.ndarray, marks: str = "") -> str:
    """Write a joint that turns about the normal."""
    return (
        f'<joint name="{name}" type="continuous"{marks}><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{_xyz(origin)}"/><axis xyz="0 0 1"/></joint>'
    )
