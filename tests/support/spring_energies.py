"""Energies and torques of linkages with springs by Pinocchio, and arms that springs balance."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from balance.motion.verification.verify_motions import PinocchioModel
from kinematics import ScrewJoint, from_screws
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.errors import PoseError

G = 9.81
Y = (0, 1, 0)


def balancer(mass=2.0, centre=0.3):
    """One link on a hinge."""
    bodies = {"arm": (mass, (centre, 0, 0), 0.01 * np.eye(3))}
    return from_screws([ScrewJoint("u1", "base", "arm", axis=Y)], bodies=bodies, name="arm")


def lamp(m1=0.3, s1=0.2, l1=0.4, m2=0.6, s2=0.3):
    """Two links on parallel hinges: the lower stands, the upper lies."""
    joints = [
        ScrewJoint("u1", "base", "lower", axis=Y),
        ScrewJoint("u2", "lower", "upper", axis=Y, point=(0, 0, l1)),
    ]
    bodies = {
        "lower": (m1, (0, 0, s1), 0.01 * np.eye(3)),
        "upper": (m2, (s2, 0, l1), 0.01 * np.eye(3)),
    }
    return from_screws(joints, bodies=bodies, name="lamp")


def closed_poses(linkage, count, reach):
    """Closed poses around the reference pose (poses, joints)."""
    rng, poses = np.random.default_rng(11), []
    while len(poses) < count:
        try:
            poses.append(joint_positions(linkage, rng.uniform(-reach, reach, linkage.mobility)))
        except PoseError:
            continue
    return np.array(poses)


def _model(linkage, gravity):
    """A model of the linkage with loops opened, whose joints are those of the linkage."""
    inertias = np.array([body.inertia for body in linkage.bodies])
    model = PinocchioModel(linkage, inertias).model
    model.gravity.linear = np.array(gravity)
    return model


def _ends(linkage, spring):
    """Link and point at the reference pose of both ends, from the origin of the model."""
    for end in spring.ends:
        link, pose = linkage.places[end.link]
        origin = input_chain(linkage).frame.origin
        yield link, pose[:3, :3] @ end.point + pose[:3, 3] - origin


def _placed(model, data, start, link, point):
    """Where a point of a link is, if at the reference pose it is given."""
    if link < 0:
        return point
    placement = data.oMi[link + 1] * start[link + 1].inverse()
    return placement.act(point)


def energies_with_springs(linkage, answer, count, reach=0.4):
    """Energies of gravity and springs at closed poses, and those of gravity alone."""
    model = _model(linkage, answer.gravity)
    data = model.createData()
    start = _reference(model, data)
    both, alone = [], []
    for q in closed_poses(linkage, count, reach):
        pin.forwardKinematics(model, data, q)
        alone.append(pin.computePotentialEnergy(model, data, q))
        total = alone[-1]
        for spring in answer.springs:
            first, second = (
                _placed(model, data, start, *end) for end in _ends(linkage, spring)
            )
            stretch = np.linalg.norm(first - second) - spring.free_length
            total += 0.5 * spring.stiffness * stretch**2
        both.append(total)
    return np.array(both), np.array(alone)


def torques_with_springs(linkage, answer, count, reach=3.0):
    """Torques of an arm without loops at random poses: with springs, and of gravity alone."""
    return torques_at(linkage, answer, closed_poses(linkage, count, reach))


def torques_at(linkage, answer, poses):
    """The same at given poses (poses, joints)."""
    model = _model(linkage, answer.gravity)
    data = model.createData()
    start = _reference(model, data)
    left, alone = [], []
    for q in poses:
        gravity = pin.computeGeneralizedGravity(model, data, q).copy()
        pin.computeJointJacobians(model, data, q)
        torque = gravity.copy()
        for spring in answer.springs:
            ends = list(_ends(linkage, spring))
            points = [_placed(model, data, start, *end) for end in ends]
            apart = points[0] - points[1]
            force = spring.stiffness * (1 - spring.free_length / np.linalg.norm(apart)) * apart
            for sign, (link, _), point in zip((1, -1), ends, points, strict=True):
                if link >= 0:
                    J = pin.getJointJacobian(model, data, link + 1, pin.WORLD)
                    rates = J[:3] + np.cross(J[3:].T, point).T
                    torque += sign * force @ rates
        left.append(torque)
        alone.append(gravity)
    return np.array(left), np.array(alone)


def _reference(model, data):
    """Placements of the joints at the reference pose."""
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    return [pin.SE3(m) for m in data.oMi]


def random_arm(seed):
    """An arm of one to three links in a plane or in space, and springs that can balance it.

    Springs go from the ground, and from each link, to a point of each link after it.
    """
    rng = np.random.default_rng(seed)
    count, planar = 1 + seed % 3, seed % 2 == 0
    joints, bodies, point, before = [], {}, np.zeros(3), "base"
    names = [f"l{k}" for k in range(count)]
    tips = {}
    for name in names:
        axis = (0, 1, 0) if planar else rng.standard_normal(3)
        joints.append(
            ScrewJoint(f"u{name}", before, name, axis=tuple(axis), point=tuple(point))
        )
        step = rng.uniform(0.3, 0.6) * np.array([np.cos(0.7 * seed), 0, np.sin(0.7 * seed)])
        bodies[name] = (rng.uniform(0.5, 2), tuple(point + 0.4 * step), 0.01 * np.eye(3))
        tips[name] = 0.8 * step
        point, before = point + step, name
    linkage = from_screws(joints, bodies=bodies, name=f"arm{seed}")
    between = []
    for k, name in enumerate(names):
        far = ",".join(f"{x:.12g}" for x in tips[name])
        for earlier in ["base", *names[:k]]:
            box = "-6:6,-6:6,-6:6"
            between.append(f"{earlier}@{box} {name}@{far}")
    return linkage, between


def mujoco_model(mujoco, linkage, answer):
    """An arm without loops in MuJoCo, its springs as tendons, all frames those of the world."""
    sites = {link: "" for link in (-1, *range(len(linkage.joints)))}
    tendons = ""
    for k, spring in enumerate(answer.springs):
        if not spring.stiffness:
            continue
        names = []
        for end in spring.ends:
            link, pose = linkage.places[end.link]
            place = " ".join(repr(float(x)) for x in pose[:3, :3] @ end.point + pose[:3, 3])
            names.append(f"s{k}_{len(names)}")
            sites[link] += f'<site name="{names[-1]}" pos="{place}"/>'
        tendons += (
            f'<spatial stiffness="{spring.stiffness!r}" '
            f'springlength="{spring.free_length!r} {spring.free_length!r}">'
            f'<site site="{names[0]}"/><site site="{names[1]}"/></spatial>'
        )
    masses = {body.link: body.inertia for body in linkage.bodies}
    inside = ""
    for link in reversed(range(len(linkage.joints))):
        joint, z = linkage.joints[link], masses[link]
        assert joint.parent == link - 1
        axis, point, centre = (
            " ".join(repr(float(x)) for x in values)
            for values in (joint.direction, joint.point, z[1:4] / z[0])
        )
        inside = (
            f'<body><joint axis="{axis}" pos="{point}"/>'
            f'<inertial pos="{centre}" mass="{float(z[0])!r}" diaginertia="1 1 1"/>'
            f"{sites[link]}{inside}</body>"
        )
    gravity = " ".join(map(repr, answer.gravity))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="{gravity}"/><worldbody>{sites[-1]}{inside}</worldbody>'
        f"<tendon>{tendons}</tendon></mujoco>"
    )
