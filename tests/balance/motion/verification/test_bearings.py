"""Joint wrenches of closed linkages: equilibrium, passive joints, work, and the least norm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import balance
import kinematics
from balance.motion import shaking
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.shaking_wrench import inertia_loads, wrench_to_si
from balance.motion.verification.trajectory import drive
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.series import loop_matrix
from tests.support.motions import around, bodies, slope, states

STEP = 1e-3


@pytest.mark.parametrize("model", ["four_bar_general", "three_rsr", "slider_crank", "sarrus"])
def test_joint_wrenches_move_every_link(model):
    joint_wrenches_are_right(kinematics.load(model))


def joint_wrenches_are_right(linkage):
    """Newton and Euler for each link; nothing passes along passive joints; work is energy."""
    import pinocchio as pin

    chain, z = input_chain(linkage), bodies(linkage)
    inputs = linkage.positions_of(linkage.inputs)
    way = states(linkage, 6, seed=3)
    parts = way.q / chain.units, way.ud / chain.units[inputs], way.udd / chain.units[inputs]
    loads = inertia_loads(chain, z, *parts)
    held = joint_reactions(chain, loads)
    size = np.abs(held.joints).max()
    net = held.joints.copy()
    base = np.zeros((6, 6))
    for j, parent in enumerate(chain.parent):
        if parent >= 0:
            net[:, parent] -= held.joints[:, j]
        else:
            base += held.joints[:, j]
    for number, (end, successor) in enumerate(chain.ends):
        net[:, end] += held.welds[:, number]
        if successor >= 0:
            net[:, successor] -= held.welds[:, number]
        else:
            base += held.welds[:, number]
    for b, link in enumerate(chain.links):
        net[:, link] -= loads.rate[:, b]
    assert np.abs(net).max() <= 1e-11 * size
    assert np.allclose(
        wrench_to_si(base, chain.frame),
        shaking(linkage, way.q, way.ud, way.udd, z),
        rtol=0,
        atol=1e-10 * size,
    )
    passive = np.setdiff1d(np.arange(len(chain.parent)), inputs)
    if not len(chain.mimics):
        along = np.einsum("tji,tji->tj", loads.screws, held.joints)
        assert np.abs(along - held.motors).max() <= 1e-11 * size
        assert np.abs(along[:, passive]).max() <= 1e-11 * size
    assert not held.motors[:, chain.dependent].any()
    model = PinocchioModel(linkage, z)
    data = model.model.createData()
    for k in range(6):
        near = around(linkage, way, k, STEP)
        energy = [
            pin.computeKineticEnergy(model.model, data, q, qd)
            for q, qd in zip(near.q, near.qd, strict=True)
        ]
        # Motors are in units of the chain: mass times length squared over time squared.
        power = chain.frame.length**2 * held.motors[k] @ (way.qd[k] / chain.units)
        assert slope(np.array(energy), STEP) == pytest.approx(power, rel=1e-8)
        A = loop_matrix(chain, loads.screws[k])[:, chain.dependent]
        assert held.open == A.shape[0] - A.shape[1]
        if len(chain.mimics):
            continue
        least = least_wrenches(chain, loads, held.motors[k], k)
        assert np.abs(held.joints[k] - least).max() <= 1e-9 * size


def equilibrium(chain, screws):
    """Equations of all links and passive joints for the wrenches of joints and welds."""
    n, loops = len(chain.parent), len(chain.ends)
    rows = np.zeros((7 * n, 6 * (n + loops)))

    def add(link, column, sign):
        if link >= 0:
            rows[6 * link : 6 * link + 6, 6 * column : 6 * column + 6] += sign * np.eye(6)

    for j, parent in enumerate(chain.parent):
        add(j, j, 1.0)
        add(parent, j, -1.0)
        rows[6 * n + j, 6 * j : 6 * j + 6] = screws[j]
    for number, (end, successor) in enumerate(chain.ends):
        add(end, n + number, 1.0)
        add(successor, n + number, -1.0)
    return rows


def least_wrenches(chain, loads, motors, k):
    """Wrenches of the joints (n, 6) of least norm that hold all links, by Lagrange."""
    n, loops = len(chain.parent), len(chain.ends)
    E = equilibrium(chain, loads.screws[k])
    right = np.zeros(len(E))
    for b, link in enumerate(chain.links):
        right[6 * link : 6 * link + 6] += loads.rate[k, b]
    right[6 * n :] = motors
    weight = np.diag(np.r_[np.ones(6 * n), np.zeros(6 * loops)])
    system = np.block([[weight, E.T], [E, np.zeros((len(E), len(E)))]])
    right = np.r_[np.zeros(len(weight)), right]
    return np.linalg.lstsq(system, right, rcond=1e-12)[0][: 6 * n].reshape(n, 6)


RECUT = """
  <joint name="q3" type="continuous"><origin xyz="-0.7 -0.7 0.3"/>
    <parent link="coupler"/><child link="rocker"/><axis xyz="0.36 -0.12 0.56"/></joint>
  <loop name="q4" type="revolute"><predecessor link="rocker"><origin xyz="0.3 -0.5 -0.3"/>
    </predecessor><successor link="base"><origin xyz="-0.2 -0.6 -0.15"/></successor>
    <axis xyz="0.06 -0.3 0.56"/></loop></robot>"""


def bennett_cut_elsewhere(folder):
    """The Bennett linkage of the gallery, cut at the rocker's pivot on the base."""
    text = Path(kinematics.load("bennett").source).read_text("utf-8")
    head = text[: text.index('  <joint name="q4"')]
    # The rocker's frame is now at its other joint.
    head = head.replace("-0.16 0.24 0.16", "0.14 -0.26 -0.14")
    path = folder / "recut.urdf"
    path.write_text(head + RECUT, encoding="utf-8")
    return kinematics.load(path)


def test_bearing_forces_do_not_depend_on_the_cut(tmp_path):
    """Issue 38: 10.9 N or 11.6 N by where the loop was cut."""
    first, second = kinematics.load("bennett"), bennett_cut_elsewhere(tmp_path)
    time = np.linspace(0.0, 1.0, 21)
    u = 0.4 * np.sin(3.0 * time)[:, None]
    ud, udd = 1.2 * np.cos(3.0 * time)[:, None], -9.0 * u
    found = [
        balance.verify(one, motions=[drive(one, time, u, ud, udd)]) for one in (first, second)
    ]
    forces = [
        dict(zip((j.name for j in one.linkage.joints), one.runs[0].bearing.T, strict=True))
        for one in found
    ]
    for name in ("u1", "q2", "q3", "q4"):
        assert np.allclose(forces[0][name], forces[1][name], rtol=1e-9)
    assert found[0].bearing == pytest.approx(found[1].bearing, rel=1e-9)
    assert found[0].preload and found[0].least_bearing < 1e-9 * found[0].scale


@pytest.mark.parametrize("model", ["bennett", "four_bar_general", "sarrus"])
def test_the_range_that_preload_allows(model):
    """The least force of each joint: least squares over all wrenches that hold the links."""
    linkage = kinematics.load(model)
    chain, z = input_chain(linkage), bodies(linkage)
    inputs = linkage.positions_of(linkage.inputs)
    way = states(linkage, 3, seed=2)
    parts = way.q / chain.units, way.ud / chain.units[inputs], way.udd / chain.units[inputs]
    loads = inertia_loads(chain, z, *parts)
    held = joint_reactions(chain, loads)
    n = len(chain.parent)
    E = equilibrium(chain, loads.screws[0])
    null = np.linalg.svd(E)[2][np.linalg.matrix_rank(E, tol=1e-9) :].T
    for j in range(n):
        effect = null[6 * j + 3 : 6 * j + 6]
        force = held.joints[0, j, 3:]
        y = np.linalg.lstsq(effect, force, rcond=1e-9)[0] if np.abs(effect).max() > 1e-9 else 0
        least = np.linalg.norm(force - effect @ y) if np.ndim(y) else np.linalg.norm(force)
        assert held.least[0, j] == pytest.approx(least, abs=1e-9 * np.abs(force).max())
        assert held.preloaded[j] == (np.abs(effect).max() > 1e-9)


def test_a_mimic_joint_passes_its_work_on(tmp_path):
    """Two hinges of which one follows the other: one motor does all the work."""
    text = '<robot name="p"><link name="base"/>'
    for k, parent in enumerate(("base", "a0")):
        follows = '<mimic joint="j0" multiplier="-2.5"/>' if k else ""
        text += (
            f'<link name="a{k}"><inertial><origin xyz="0.4 0.1 0.2"/><mass value="1.5"/>'
            '<inertia ixx="0.3" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/></inertial>'
            f'</link><joint name="j{k}" type="continuous"><origin xyz="{k} 0 0"/>'
            f'<parent link="{parent}"/><child link="a{k}"/><axis xyz="{k} 0 1"/>{follows}'
            "</joint>"
        )
    path = tmp_path / "mimic.urdf"
    path.write_text(f"{text}</robot>", encoding="utf-8")
    joint_wrenches_are_right(kinematics.load(path))
