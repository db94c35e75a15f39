"""MuJoCo's mass matrix, momentum and equality Jacobian are those of what is read."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm, null_space

import kinematics
from balance.momentum import momentum_regressor
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import loop_matrix
from tests.support.covering import number_of_cases
from tests.support.mjcf_text import mjcf_text, random_tree, words, world

mujoco = pytest.importorskip("mujoco")

POSES = 50
TREES = range(number_of_cases(5, 12))
LOOPS = (
    "four_bar_general",
    "bennett",
    "slider_crank",
    "five_bar",
    "three_rsr",
    "six_bar_watt",
    "sarrus",
    "rusr",
)
# Radians or metres; the gallery keeps clear of singular poses that far.
REACH = 0.15
# The same for chains at random places.
SHORT = 0.01


def cross(v):
    return np.cross(np.eye(3), v)


def hat(screw):
    top = np.column_stack([cross(screw[:3]), screw[3:]])
    return np.vstack([top, np.zeros(4)])


def adjoint(H):
    R = H[:3, :3]
    return np.block([[R, np.zeros((3, 3))], [cross(H[:3, 3]) @ R, R]])


def spatial_inertia(z):
    m, c, (xx, yy, zz, xy, xz, yz) = z[0], z[1:4], z[4:]
    E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.block([[E, cross(c)], [cross(c).T, m * np.eye(3)]])


def mass_matrix(linkage, q):
    """The mass matrix (n, n) by exponentials of screws."""
    H, J = {-1: np.eye(4)}, {-1: np.zeros((6, len(linkage.joints)))}
    for i, joint in enumerate(linkage.joints):
        before = H[joint.parent]
        J[i] = J[joint.parent].copy()
        J[i][:, i] = adjoint(before) @ joint.screw
        H[i] = before @ expm(hat(joint.screw) * q[i])
    M = np.zeros((len(q), len(q)))
    for body in linkage.bodies:
        back = np.linalg.inv(adjoint(H[body.link]))
        M += J[body.link].T @ back.T @ spatial_inertia(body.inertia) @ back @ J[body.link]
    return M


def turn(axis, angle):
    quat = np.zeros(4)
    mujoco.mju_axisAngle2Quat(quat, np.eye(3)[axis], angle)
    return quat


def product(p, q):
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, p, q)
    return found


def matrix(quat):
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quat)
    return R.reshape(3, 3)


def set_pose(model, linkage, q):
    """MuJoCo's positions for those of our joints, and the rates of its from ours."""
    at = {joint.name: i for i, joint in enumerate(linkage.joints)}
    qpos, rates = model.qpos0.copy(), np.zeros((model.nv, len(q)))
    for j in range(model.njnt):
        name = model.jnt(j).name or f"joint{j}"
        place, row = model.jnt_qposadr[j], model.jnt_dofadr[j]
        if model.jnt_type[j] != mujoco.mjtJoint.mjJNT_BALL:
            qpos[place] += q[at[name]]
            rates[row, at[name]] = 1.0
            continue
        columns = [at[f"{name}.{k}"] for k in range(3)]
        x, y, z = (turn(k, q[column]) for k, column in enumerate(columns))
        qpos[place : place + 4] = product(product(x, y), z)
        back = matrix(z).T
        rates[row : row + 3, columns[0]] = back @ matrix(y).T @ np.eye(3)[0]
        rates[row : row + 3, columns[1]] = back @ np.eye(3)[1]
        rates[row : row + 3, columns[2]] = np.eye(3)[2]
    return qpos, rates


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", TREES)
def test_mass_matrix_and_momentum_of_trees(seed, tmp_path):
    path = tmp_path / "tree.xml"
    path.write_text(random_tree(seed))
    linkage = kinematics.load(path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    z = np.concatenate([body.inertia for body in linkage.bodies])
    inputs = linkage.positions_of(linkage.inputs)
    for _ in range(POSES):
        q, u = rng.uniform(-1.0, 1.0, (2, len(linkage.joints)))
        data.qpos, rates = set_pose(model, linkage, q)
        data.qvel = rates @ u
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        for column, unit in zip(M, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        theirs, ours = rates.T @ M @ rates, mass_matrix(linkage, q)
        assert np.abs(ours - theirs).max() <= 1e-10 * np.abs(theirs).max()
        mujoco.mj_subtreeVel(model, data)
        p = model.body_subtreemass[0] * data.subtree_linvel[0]
        h = np.concatenate([data.subtree_angmom[0] + np.cross(data.subtree_com[0], p), p])
        found = u[inputs] @ (momentum_regressor(linkage, q[inputs], spatial=True) @ z)
        assert np.abs(found - h).max() <= 1e-10 * np.abs(h).max()


CONNECTS = '<connect body1="{0}" body2="{1}" anchor=".1 .2 .3"/>' * 2
CLOSURES = {
    "hinge": CONNECTS.replace('".1 .2 .3"', '"0 .5 -.4"', 1),
    "ball": '<connect body1="{0}" body2="{1}" anchor=".1 .2 .3"/>',
    "weld": '<weld body1="{0}" body2="{1}" anchor=".1 .2 .3"/>',
    "far_weld": '<weld body1="{0}" body2="{1}" relpose="0 0 0 0 0 0 0"/>',
    "loose_weld": '<weld body1="{0}" body2="{1}" anchor="1 2 0" torquescale="0"/>',
}


def closed_chain(closure):
    """Two branches of four hinges each, at random places, whose ends are constrained."""
    rng = np.random.default_rng(8)
    branches = []
    for side in "ab":
        inside = ""
        for k in (3, 2, 1, 0):
            pos, axis = rng.uniform(-1.0, 1.0, (2, 3))
            place = f'pos="{words(pos)}" quat="{words(rng.uniform(-1.0, 1.0, 4))}"'
            joint = f'<joint name="{side}{k}j" axis="{words(axis)}" pos=".1 0 .2"/>'
            geom = '<geom type="box" size=".1 .2 .3"/>'
            inside = f'<body name="{side}{k}" {place}>{joint}{geom}{inside}</body>'
        branches.append(inside)
    equality = CLOSURES[closure].format("a3", "b3")
    return world("".join(branches)).replace(
        "</mujoco>", f"<equality>{equality}</equality></mujoco>"
    )


@pytest.mark.table(3)
@pytest.mark.parametrize("name", [*LOOPS, *CLOSURES])
def test_equality_jacobian_of_loops(name, tmp_path):
    """Velocities that MuJoCo's constraints allow are those that our loops allow."""
    path = tmp_path / "model.xml"
    if name in CLOSURES:
        path.write_text(closed_chain(name))
    else:
        path.write_text(mjcf_text(Path(kinematics.gallery()[name]).read_text(), "quats"))
    linkage = kinematics.load(path)
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data, rng = mujoco.MjData(model), np.random.default_rng(5)
    chain = si_chain(linkage, True)
    for _ in range(POSES):
        reach = SHORT if name in CLOSURES else REACH
        q = joint_positions(linkage, rng.uniform(-reach, reach, linkage.mobility))
        data.qpos, rates = set_pose(model, linkage, q)
        mujoco.mj_forward(model, data)
        equal = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert np.abs(data.efc_pos[equal]).max() <= 1e-11
        theirs = null_space(data.efc_J.reshape(-1, model.nv)[equal], rcond=1e-9)
        ours = rates @ null_space(
            loop_matrix(chain, forward_kinematics(chain, q).screws), rcond=1e-9
        )
        ours, _ = np.linalg.qr(ours)
        assert theirs.shape == ours.shape == (model.nv, linkage.mobility)
        assert np.abs(ours - theirs @ (theirs.T @ ours)).max() <= 1e-10
