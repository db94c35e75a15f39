"""Arms whose motions are planned, and figures of motions by Pinocchio."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

import kinematics
from balance.motion.verification.trajectory import drive
from kinematics import ScrewJoint, from_screws

MACHINES = Path(__file__).parents[2] / "docs" / "machines"


def slide(mass=2.0):
    """A mass on a slide along x."""
    joint = ScrewJoint("u1", "base", "slide", kind="prismatic", axis=(1, 0, 0))
    return from_screws([joint], bodies={"slide": (mass, (0, 0, 0), np.eye(3))}, name="slide")


def planar_arm(count):
    """An arm of two or three links in a plane, straight along x."""
    joints, bodies, x, before = [], {}, 0.0, "base"
    for k, (length, mass) in enumerate(((0.5, 3.0), (0.4, 2.0), (0.3, 1.0))[:count], 1):
        joints.append(ScrewJoint(f"u{k}", before, f"link{k}", point=(x, 0, 0)))
        inertia = np.diag([0.1, 1.0, 1.0]) * mass * length**2 / 12
        bodies[f"link{k}"] = (mass, (x + length / 2, 0, 0), inertia)
        x, before = x + length, f"link{k}"
    return from_screws(joints, bodies=bodies, name=f"planar_{count}r")


def scara():
    """Two parallel axes, and a slide along them."""
    joints = [
        ScrewJoint("u1", "base", "upper"),
        ScrewJoint("u2", "upper", "fore", point=(0.4, 0, 0)),
        ScrewJoint("u3", "fore", "quill", kind="prismatic", axis=(0, 0, 1)),
    ]
    bodies = {
        "upper": (4.0, (0.2, 0, 0), 0.06 * np.eye(3)),
        "fore": (3.0, (0.6, 0, 0.05), 0.04 * np.eye(3)),
        "quill": (1.0, (0.75, 0, -0.1), 0.01 * np.eye(3)),
    }
    return from_screws(joints, bodies=bodies, name="scara")


def six_axes():
    """An arm of six axes with the proportions of a UR5."""
    points = (
        (0, 0, 0),
        (0, 0.1, 0.09),
        (0.42, 0.1, 0.09),
        (0.81, 0.1, 0.09),
        (0.81, 0.1, 0.0),
        (0.81, 0.1, 0.0),
    )
    axes = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, -1), (0, 1, 0))
    coms = (
        (0, 0.05, 0.08),
        (0.2, 0.12, 0.09),
        (0.6, 0.05, 0.09),
        (0.8, 0.1, 0.08),
        (0.81, 0.1, 0.01),
        (0.81, 0.17, 0),
    )
    masses = (3.7, 8.4, 2.3, 1.2, 1.2, 0.2)
    joints, bodies, before = [], {}, "base"
    for k, (point, axis, com, mass) in enumerate(
        zip(points, axes, coms, masses, strict=True), 1
    ):
        joints.append(ScrewJoint(f"u{k}", before, f"link{k}", point=point, axis=axis))
        bodies[f"link{k}"] = (mass, com, 0.01 * mass * np.eye(3))
        before = f"link{k}"
    return from_screws(joints, bodies=bodies, name="six_axes")


def ur5e():
    """The UR5e of the studies, its forearm upright."""
    names = ("shoulder_lift", "elbow", "wrist_1_turn", "wrist_2_turn")
    upright = np.deg2rad([-90.0, 90.0, -90.0, -90.0]).tolist()
    return kinematics.load(MACHINES / "ur5e.urdf", at=dict(zip(names, upright, strict=True)))


# Linkages, and poses between which they move.
TASKS = {
    "planar_2r": (lambda: planar_arm(2), [0.2, 0.4], [1.4, 1.5]),
    "planar_3r": (lambda: planar_arm(3), [0.1, 0.5, 0.3], [1.0, 0.9, -0.4]),
    "scara": (scara, [-0.4, 0.6, 0.0], [0.8, 1.2, 0.15]),
    "six_axes": (six_axes, [0, -0.4, 0.9, 0.2, 0.1, 0], [1.2, -0.9, 1.3, -0.3, 0.5, 0.5]),
    "ur5e": (ur5e, [0.0] * 6, [1.57, -0.52, 0.7, -0.17, 0.0, 0.0]),
    "five_bar": (lambda: kinematics.load("five_bar"), [0.0, 0.0], [0.5, -0.3]),
    "delta": (lambda: kinematics.load("delta"), [0.0, 0.0, 0.0], [0.3, -0.2, 0.25]),
}


@cache
def pinocchio_model(linkage):
    """The model of a linkage without loops, and the places of its inputs."""
    import pinocchio as pin

    model = pin.buildModelFromXML(linkage.to_urdf())
    at = [model.joints[model.getJointId(name)].idx_v for name in linkage.inputs]
    return model, np.array(at)


def base_wrenches(linkage, u, ud, udd):
    """The wrench ``[moment; force]`` of the base on a linkage, by Pinocchio.

    Of loops, the joints of the tree that is left when they are opened move as they close them.
    """
    import pinocchio as pin

    model, _ = pinocchio_model(linkage)
    data, wrenches = model.createData(), []
    for state in _states(linkage, u, ud, udd):
        pin.computeCentroidalMomentumTimeVariation(model, data, *state)
        force, moment = data.dhg.linear, data.dhg.angular
        wrenches.append([*(moment + np.cross(data.com[0], force)), *force])
    return np.array(wrenches)


def torques(linkage, u, ud, udd, gravity=(0.0, 0.0, -9.81)):
    """The torques of the inputs of a linkage without loops, by Pinocchio."""
    import pinocchio as pin

    model, at = pinocchio_model(linkage)
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    states = _states(linkage, u, ud, udd)
    return np.array([pin.rnea(model, data, *state)[at] for state in states])


def _states(linkage, u, ud, udd):
    """Configurations, velocities and accelerations of the model, sample by sample."""
    import pinocchio as pin

    model, at = pinocchio_model(linkage)
    if linkage.loops:
        motion = drive(linkage, np.linspace(0.0, 1.0, len(u)), u, ud, udd)
        tree = [k for k, joint in enumerate(linkage.joints) if model.existJointName(joint.name)]
        u, ud, udd = (rates[:, tree] for rates in (motion.q, motion.qd, motion.qdd))
        ids = [model.getJointId(linkage.joints[k].name) for k in tree]
        at = np.array([model.joints[number].idx_v for number in ids])
    rows = np.zeros((len(u), 3, model.nv))
    rows[:, :, at] = np.stack([u, ud, udd], axis=1)
    for way, v, a in rows:
        yield pin.integrate(model, pin.neutral(model), way), v, a
