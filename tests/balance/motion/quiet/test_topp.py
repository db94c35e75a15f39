"""The shortest timing of a path beside two other programs for it, on timing alone.

toppra (H. Pham, Q.-C. Pham, 2018) integrates controllable sets along the path; the program of
Verscheure et al. (2009), b piecewise linear, is written in CVXPY. Torques are Pinocchio's.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import balance
from tests.support.planned_arms import planar_arm, scara, torques

PATHS = {
    "line": (lambda: planar_arm(2), [[0.2, 0.4], [1.4, 1.5]]),
    "curve": (lambda: planar_arm(2), [[0.2, 0.4], [0.7, 1.3], [1.4, 0.8], [1.1, 0.1]]),
    "scara": (scara, [[-0.4, 0.6, 0.0], [0.2, 1.2, 0.1], [0.8, 0.9, 0.15]]),
}
LIMITS = {
    "torque": {"torque": 12.0},
    "both": {"torque": 30.0, "velocity": 1.4, "acceleration": 9.0},
}
CASES = [("line", "torque"), ("curve", "torque"), ("curve", "both"), ("scara", "both")]


def geometry(name):
    """The linkage, the poses, and the spline through them over shares of their distances."""
    build, poses = PATHS[name]
    linkage = build()
    length = linkage.spatial_chain.frame.length
    slides = [
        linkage.joints[j].kind == "prismatic" for j in linkage.positions_of(linkage.inputs)
    ]
    units = np.where(slides, length, 1.0)
    steps = np.linalg.norm(np.diff(poses, axis=0) / units, axis=1)
    s = np.append(0.0, np.cumsum(steps)) / steps.sum()
    return linkage, np.array(poses), s, make_interp_spline(s, poses, k=min(3, len(s) - 1))


def heavy(name):
    """Torques that hold the weight: a scara's slide needs its own."""
    return {"u3": 40.0} if name == "scara" else {}


def torque_limits(name, limits):
    """Limits of the torque, by input in order."""
    linkage = PATHS[name][0]()
    return np.array([heavy(name).get(joint, limits["torque"]) for joint in linkage.inputs])


def ours(name, limits):
    """The shortest duration that the product finds."""
    linkage, poses, *_ = geometry(name)
    torque = dict(zip(linkage.inputs, torque_limits(name, limits).tolist(), strict=True))
    plan = balance.quiet_timing(linkage, poses, 8.0, front=2, **(limits | {"torque": torque}))
    return plan.shortest


def by_cvxpy(name, limits, nodes=241):
    """The shortest duration, with b piecewise linear on even intervals of s."""
    import cvxpy as cp

    linkage, _, _, spline = geometry(name)
    step = 1.0 / (nodes - 1)
    middle = (np.arange(nodes - 1) + 0.5) * step
    u, tangent, curve = (spline(middle, k) for k in range(3))
    nothing = np.zeros_like(u)
    still = torques(linkage, u, nothing, nothing)
    by_change = torques(linkage, u, nothing, tangent) - still
    by_b = torques(linkage, u, tangent, curve) - still
    b = cp.Variable(nodes)
    mean, change = 0.5 * (b[1:] + b[:-1]), (b[1:] - b[:-1]) / (2.0 * step)
    most = torque_limits(name, limits)
    bounds = [b >= 0.0, b[0] == 0.0, b[-1] == 0.0]
    for k in range(u.shape[1]):
        load = cp.multiply(by_b[:, k], mean) + cp.multiply(by_change[:, k], change)
        bounds.append(cp.abs(load + still[:, k]) <= most[k])
        if "velocity" in limits:
            bounds.append(cp.multiply(tangent[:, k] ** 2, mean) <= limits["velocity"] ** 2)
        if "acceleration" in limits:
            rate = cp.multiply(curve[:, k], mean) + cp.multiply(tangent[:, k], change)
            bounds.append(cp.abs(rate) <= limits["acceleration"])
    # 2 Δs / (√b + √b) on each interval.
    root = cp.Variable(nodes)
    bounds.append(root <= cp.sqrt(b))
    duration = cp.sum(2.0 * step * cp.inv_pos(root[1:] + root[:-1]))
    problem = cp.Problem(cp.Minimize(duration), bounds)
    return problem.solve(solver="CLARABEL")


def by_toppra(name, limits):
    """The shortest duration by toppra."""
    ta = pytest.importorskip("toppra", reason="toppra is not installed")
    from toppra import algorithm, constraint

    linkage, poses, s, _ = geometry(name)
    if len(poses) == 2:
        poses = np.array([poses[0], poses.mean(axis=0), poses[1]])
        s = np.array([0.0, 0.5, 1.0])
    path = ta.SplineInterpolator(s, poses)
    scheme = constraint.DiscretizationType.Interpolation

    def load(q, qd, qdd):
        return torques(linkage, q[None], qd[None], qdd[None])[0]

    most = torque_limits(name, limits)
    bounds = [
        constraint.JointTorqueConstraint(
            load, np.stack([-most, most], axis=1), np.zeros(most.size), scheme
        )
    ]
    for kind, kept in (
        ("velocity", constraint.JointVelocityConstraint),
        ("acceleration", constraint.JointAccelerationConstraint),
    ):
        if kind in limits:
            bounds.append(kept(np.tile([-limits[kind], limits[kind]], (most.size, 1))))
    grid = np.linspace(0.0, 1.0, 601)
    solver = algorithm.TOPPRA(bounds, path, gridpoints=grid, solver_wrapper="seidel")
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    return float(np.sum(2.0 * np.diff(grid) / (speed[1:] + speed[:-1])))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), CASES)
def test_the_shortest_timing_is_that_of_a_second_program(name, kind):
    limits = LIMITS[kind]
    assert ours(name, limits) == pytest.approx(by_cvxpy(name, limits), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), CASES)
def test_the_shortest_timing_is_that_of_toppra(name, kind):
    limits = LIMITS[kind]
    assert ours(name, limits) == pytest.approx(by_toppra(name, limits), rel=1e-2)
