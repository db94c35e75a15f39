"""Arms on a satellite, and what their motions do to it, by Pinocchio on a free-flyer."""

from __future__ import annotations

import numpy as np

import balance
from kinematics import ScrewJoint, from_screws


def arm_in_line(count):
    """Links of 0.4 m from the side of the satellite, lighter outwards, axes along z."""
    joints, bodies, before = [], {}, "base"
    for k in range(count):
        x, link = 0.5 + 0.4 * k, f"link{k + 1}"
        joints.append(ScrewJoint(f"q{k + 1}", before, link, point=(x, 0, 0)))
        inertia = np.diag([0.01, 0.1, 0.1]) / (k + 1)
        bodies[link] = (3.0 / (k + 1), (x + 0.2, 0, 0), inertia)
        before = link
    return from_screws(joints, (), bodies, name=f"arm{count}")


def arm_in_space(count):
    """Links of 0.3 m with axes along z, y and x in turn."""
    joints, bodies, before = [], {}, "base"
    for k in range(count):
        x, link = 0.2 + 0.3 * k, f"link{k + 1}"
        axis = np.eye(3)[2 - k % 3]
        joints.append(ScrewJoint(f"q{k + 1}", before, link, axis=axis, point=(x, 0, 0)))
        bodies[link] = (2.0, (x + 0.15, 0.02, 0.01), np.diag([0.01, 0.04, 0.05]))
        before = link
    return from_screws(joints, (), bodies, name=f"space_arm{count}")


def model_on_satellite(arm, base):
    """The arm in Pinocchio, on a free-flyer with the mass and the inertia of the base."""
    import pinocchio as pin

    model = pin.Model()
    last = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    inertia = np.eye(3) if base.inertia is None else np.diag(base.moments)
    body = pin.Inertia(base.mass, np.array(base.com), inertia)
    model.appendBodyToJoint(last, body, pin.SE3.Identity())
    before = np.zeros(3)
    for joint, link in zip(arm.joints, arm.bodies, strict=True):
        place = pin.SE3(np.eye(3), joint.point - before)
        kind = pin.JointModelRevoluteUnaligned(np.array(joint.screw[:3]))
        last = model.addJoint(last, kind, place, joint.name)
        mass, centre, moment = balance.bodies.mass_properties(link.inertia)
        body = pin.Inertia(mass, centre - joint.point, moment)
        model.appendBodyToJoint(last, body, pin.SE3.Identity())
        before = joint.point
    return model


def turning_rates(arm, base, u, rates):
    """Angular velocities of the satellite (N, 3), in its axes, that leave no momentum."""
    import pinocchio as pin

    model, turning = model_on_satellite(arm, base), []
    data, still = model.createData(), np.array([0, 0, 0, 0, 0, 0, 1.0])
    for q, qd in zip(u, rates, strict=True):
        A = pin.computeCentroidalMap(model, data, np.append(still, q))
        turning.append(np.linalg.solve(A[:, :6], -A[:, 6:] @ qd)[3:])
    return np.array(turning)


def attitude_after(arm, base, path):
    """The rotation of the satellite at the end of a path, by exponentials of steps."""
    import pinocchio as pin
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(path.s, path.u, k=5)
    knots = np.linspace(path.s[0], path.s[-1], 2001)
    half, R = 0.5 * (knots[1] - knots[0]), np.eye(3)
    # Magnus' series to the fourth order, at two Gauss points.
    points = [knots[:-1] + half * (1.0 + side / np.sqrt(3.0)) for side in (-1.0, 1.0)]
    first, second = (turning_rates(arm, base, spline(s), spline(s, 1)) for s in points)
    steps = half * (first + second) + half**2 / np.sqrt(3.0) * np.cross(first, second)
    for step in steps:
        R = R @ pin.exp3(step)
    return R
