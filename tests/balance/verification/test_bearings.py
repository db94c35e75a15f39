"""Joint wrenches of closed linkages: equilibrium, passive joints, work, and the least norm."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance import shaking
from balance.verification.joint_reactions import joint_reactions
from balance.verification.shaking_wrench import inertia_loads, wrench_to_si
from balance.verification.to_pinocchio import PinocchioModel
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
        outside = held.welds[k].ravel() - A @ np.linalg.lstsq(A, held.welds[k].ravel())[0]
        assert np.abs(outside).max() <= 1e-10 * size


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
