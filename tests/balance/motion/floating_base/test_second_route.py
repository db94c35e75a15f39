"""Ten linkages on bases that float: our reduced equations and Pinocchio's full ones agree.

Trees and loops, planar and spatial; inputs prescribed, or free under torques; with springs and
without. Shortly by default, and for 10 s with ``ALL_CASES=1``.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance.motion import FloatingBase, simulate_floating_base
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.closure.newton import expand_at, forward_kinematics
from tests.independent.floating_in_pinocchio import FloatingModel
from tests.support.covering import ALL_CASES

FREE = FloatingBase(4.0, (0.5, 0.7, 0.9), (0.1, -0.2, 0.05))
SPRINGS = FloatingBase(4.0, (0.5, 0.7, 0.9), (0.1, -0.2, 0.05), 40.0, 900.0)
TURNING = {"wx": 0.3, "wy": -0.2, "wz": 0.5, "vx": 0.1, "vz": -0.3}
IN_PLANE = {"wz": 0.5, "vx": 0.1, "vy": -0.2}
TEN = {
    "zero_reaction_arm": (FREE, {}),
    "double_pendulum_counter_rotary": (FREE, {"initial": IN_PLANE}),
    "hprs": (FREE, {"initial": TURNING}),
    "fuga_i": (SPRINGS, {}),
    "four_bar_general": (SPRINGS, {"initial": IN_PLANE}),
    "five_bar": (FREE, {"torques": {"u1": 0.02}, "initial": {"u2": 0.4, **IN_PLANE}}),
    "slider_crank": (FREE, {"spatial": True, "initial": TURNING}),
    "four_bar_kite_balanced": (FREE, {}),
    "three_rsr": (SPRINGS, {"motion": "u2=u3", "initial": TURNING}),
    "rusr": (FREE, {"torques": {}, "initial": TURNING}),
}
LIMIT = 1e-8


def start_of(linkage, found):
    """Positions and rates of all joints at the start, by the closure of the loops."""
    chain = input_chain(linkage)
    q = joint_positions(linkage, found.samples.u[0])
    series = expand_at(chain, forward_kinematics(chain, q / chain.units))
    inputs = linkage.positions_of(linkage.inputs)
    rates = series.C[0, 0] @ (found.samples.ud[0] / chain.units[inputs])
    return q, rates * chain.units


@pytest.mark.table(1)
@pytest.mark.parametrize("model", TEN)
def test_agrees_with_pinocchio(model):
    base, options = TEN[model]
    linkage = kinematics.load(model)
    found = simulate_floating_base(
        linkage, base, duration=10.0 if ALL_CASES else 0.4, **options
    )
    assert found.energy_drift < 1e-9 and found.momentum_drift < 1e-9
    planar = linkage.planar and not options.get("spatial")
    assert found.planar == planar
    of = found.samples
    torques = [options.get("torques", {}).get(name, 0.0) for name in linkage.inputs]
    R, moved, joints = FloatingModel(linkage, base, planar).run(
        found.time,
        *start_of(linkage, found),
        np.concatenate([of.turning[0], of.velocity[0]]),
        found.path,
        np.array(torques),
    )
    inputs = linkage.positions_of(linkage.inputs)
    size = 1.0 + np.abs(of.displacement).max()
    assert np.abs(Rotation.from_rotvec(of.rotation.copy()).as_matrix() - R).max() < LIMIT
    assert np.abs(of.displacement - moved).max() < LIMIT * size
    assert np.abs(of.u - joints[:, inputs]).max() < LIMIT * (1.0 + np.abs(of.u).max())
    moves = max(found.rotation, found.displacement)
    assert moves > 1e-6 or model == "four_bar_kite_balanced"
