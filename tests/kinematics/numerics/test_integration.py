"""Integration of equations with known solutions."""

import numpy as np
import pytest

from kinematics.numerics.integration import Integration, StalledError


@pytest.mark.parametrize("jacobian", [None, lambda t, y: np.array([[-1.0]])])
def test_a_decay_is_exponential(jacobian):
    """By either method, also between the steps."""
    decay = Integration(
        lambda t, y: -y, 0.0, np.ones(1), 2.0, jacobian=jacobian, rtol=1e-10, atol=1e-12
    )
    steps = 0
    while decay.running:
        before = decay.solver.t
        decay.step()
        steps += 1
        at = (before + decay.solver.t) / 2.0
        assert decay.solver.dense_output()(at)[0] == pytest.approx(np.exp(-at), rel=1e-8)
        assert decay.proposed >= 0.999 * decay.solver.step_size > 0.0
    assert steps > 3 and decay.solver.t == 2.0
    assert decay.solver.y[0] == pytest.approx(np.exp(-2.0), rel=1e-8)


def test_an_integration_goes_on_from_a_state_that_is_assigned():
    doubled = Integration(lambda t, y: y, 0.0, np.ones(1), 1.0, rtol=1e-10, atol=1e-12)
    doubled.step()
    at = doubled.solver.t
    doubled.solver.y = doubled.solver.f = np.array([2.0 * np.exp(at)])
    while doubled.running:
        doubled.step()
    assert doubled.solver.y[0] == pytest.approx(2.0 * np.e, rel=1e-8)


def test_a_solution_that_ends_early_stalls_there():
    """``dy/dt = y²`` from 1 is ``1 / (1 - t)``."""
    pole = Integration(lambda t, y: y * y, 0.0, np.ones(1), 2.0, rtol=1e-8, atol=1e-8)
    with np.errstate(all="ignore"), pytest.raises(StalledError):
        while pole.running:
            pole.step()
    assert pole.solver.t == pytest.approx(1.0, abs=1e-6)
