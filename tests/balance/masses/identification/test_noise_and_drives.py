"""Identified masses of machines with noise, friction and rotors: the filter, and Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.identification.low_pass import low_pass
from balance.motion.verification.trajectory import drive, random_motions
from kinematics.errors import FileError
from tests.independent import identification_run
from tests.independent.identification_run import other_masses
from tests.independent.measured_loads import Arm

WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")


def planar_arm(folder):
    """Two links that hang in a vertical plane, with motors at both joints."""
    link = """<link name="{}"><inertial><origin xyz="{} {} 0"/><mass value="0.6"/><inertia
      ixx="0.001" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
    joint = """<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/>
      <origin xyz="{} 0 0" rpy="0 {} 0"/><axis xyz="0 0 1"/></joint>"""
    parts = [
        '<link name="base"/>',
        link.format("upper", 0.28, 0.01),
        link.format("lower", 0.17, -0.02),
        joint.format("shoulder", "base", "upper", 0.0, np.pi / 2.0),
        joint.format("elbow", "upper", "lower", 0.3, 0.0),
    ]
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(parts)}</robot>', "utf-8")
    return kinematics.load(path)


ROTORS, VISCOUS, DRY = np.array([3e-3, 4e-3]), np.array([0.01, 0.02]), np.array([0.12, 0.1])


def swinging(time):
    """Positions, speeds and accelerations of both joints, below 1.5 Hz."""
    parts = [
        [np.sin(w * time + p), w * np.cos(w * time + p), -w * w * np.sin(w * time + p)]
        for w, p in ((4.1, 0.3), (8.3, 1.0), (6.7, 2.0))
    ]
    a, b, c = (np.array(part) for part in parts)
    return np.stack([0.5 * a + 0.2 * b, 0.7 * c - 0.4 * a], axis=2)


def arm_torques(linkage, truth, u, ud, udd):
    """Torques of the motors with friction and rotors; Pinocchio computes those of the links."""
    torques = Arm(linkage, np.array([0.0, 0.0, -9.81])).loads(truth, u, ud, udd)[1]
    return torques + ROTORS * udd + VISCOUS * ud + DRY * np.sign(ud)


@pytest.mark.parametrize("balanced", ["force", "dynamic"])
def test_rotors_and_friction_by_pinocchio(tmp_path, balanced):
    """The rotor at the elbow is told from its link; the one at the frame cannot be."""
    linkage = planar_arm(tmp_path)
    truth = other_masses(linkage, np.random.default_rng(4))
    way = drive(linkage, np.linspace(0.0, 4.0, 200), *swinging(np.linspace(0.0, 4.0, 200)))
    torques = arm_torques(linkage, truth, way.u, way.ud, way.udd)
    loads = {"time": way.time, "shoulder": torques[:, 0], "elbow": torques[:, 1]}
    found = balance.identify(linkage, way, loads, friction=True, rotors=True, balance=balanced)
    assert found.complete == (balanced == "force")
    for item in found.combinations:
        if item.combination.determined:
            true = identification_run.true_value(item, truth.reshape(-1), found)
            assert abs(item.value - true) < 1e-8
    assert found.sensors["rotor shoulder"] is found.sensor_errors["rotor shoulder"] is None
    assert abs(found.sensors["rotor elbow"] - ROTORS[1]) < 1e-9
    for k, name in enumerate(linkage.inputs):
        assert abs(found.sensors[f"viscous {name}"] - VISCOUS[k]) < 1e-8
        assert abs(found.sensors[f"dry {name}"] - DRY[k]) < 1e-8
    without = balance.identify(linkage, way, loads, friction=True, balance=balanced)
    assert without.complete and without.recordings[0].channels[1].residual > 1e-3


@pytest.mark.slow
def test_a_noisy_encoder_needs_the_filter(tmp_path):
    """An encoder of 14 bits and torques with noise: within three standard errors in 95 %.

    Without the filter, the accelerations of the table are those of its steps.
    """
    linkage = planar_arm(tmp_path)
    truth = other_masses(linkage, np.random.default_rng(4))
    time = np.arange(0.0, 8.0, 0.004)
    u, ud, udd = swinging(time)
    torques = arm_torques(linkage, truth, u, ud, udd)
    tick, within = 2.0 * np.pi / 2**14, []
    for run in range(6):
        rng = np.random.default_rng([3, run])
        read = tick * np.round((u + 0.5 * tick * rng.normal(size=u.shape)) / tick)
        noisy = torques + 0.05 * rng.normal(size=torques.shape)
        loads = {"time": time, "shoulder": noisy[:, 0], "elbow": noisy[:, 1]}
        table = tmp_path / "motion.csv"
        head = "time,shoulder,elbow"
        rows = np.column_stack([time, read])
        np.savetxt(table, rows, "%.9f", ",", comments="", header=head)
        found = balance.identify(
            linkage, table, loads, friction=True, rotors=True, cutoff=4.0, balance="force"
        )
        kept = len(found.recordings[0].measurements.time)
        assert found.cutoff == 4.0 and found.complete and 50 < kept < 60
        off = identification_run.deviations(found, truth.reshape(-1))
        known = {"rotor elbow": ROTORS[1], "viscous elbow": VISCOUS[1], "dry elbow": DRY[1]}
        rest = [(found.sensors[n] - x) / found.sensor_errors[n] for n, x in known.items()]
        within += [*(abs(off) < 3.0), *(abs(x) < 3.0 for x in rest)]
        size = max(abs(item.value) for item in found.combinations)
        assert all(item.error < 0.02 * size for item in found.combinations)
    assert np.mean(within) >= 0.95
    with pytest.raises(FileError, match=r"leave nothing of the accelerations.* --cutoff"):
        balance.identify(linkage, table, loads, friction=True, balance="force")


def test_the_filter_has_the_response_of_butterworth():
    """Twice the amplitude ``(1 + (f / f_c)⁸)^-1/2``, and no delay."""
    time = np.linspace(0.0, 10.0, 4001)
    middle = slice(1000, 3000)
    for frequency in (0.5, 5.0, 8.0, 50.0):
        wave = np.sin(2.0 * np.pi * frequency * time)
        passed = low_pass(time, wave[:, None], 5.0)[middle, 0]
        expected = wave[middle] / (1.0 + (frequency / 5.0) ** 8)
        assert np.abs(passed - expected).max() < 2e-3


@pytest.mark.slow
def test_the_filter_leaves_exact_loads_exact():
    """Of a closed loop, with the wrench at the base: both sides are filtered alike."""
    linkage = kinematics.load("five_bar")
    (way,) = random_motions(linkage, 1, 80, seed=3)
    truth = other_masses(linkage, np.random.default_rng(5))
    time = np.linspace(0.0, 1.0, 600)
    there = drive(linkage, time, *way.path.at(time))
    run = balance.verify(linkage, truth, motions=[there]).runs[0]
    loads = {"time": time, **dict(zip(WRENCH, run.shaking.T, strict=True))}
    answer = balance.identify(
        linkage, there, loads, gravity=(0, 0, 0), on_linkage=True, cutoff=20.0
    )
    assert answer.complete
    for item in answer.combinations:
        true = identification_run.true_value(item, truth.reshape(-1), answer)
        assert abs(item.value - true) < 1e-4 * np.abs(truth).max()
