"""The motion of the centre of mass that shakes least, and the bound that it gives.

From rest to rest in the duration T, with the centre of mass d apart at the ends, no motion of a
moving mass m has less shaking force than a straight line of the centre of mass:

    peak ≥ 4 m d / T²      (constant acceleration, then constant braking)
    rms  ≥ √12 m d / T²    (the cubic law)

(S. Briot, V. Arakelian, J.-P. Le Baron, Shaking force minimization of high-speed robots via
centre of mass acceleration control, Mech. Mach. Theory 57, 2012.) Whether the inputs can make
such a motion depends on the linkage and on its limits.

The same holds for any two poses, d apart, that a motion from rest to rest passes: with
|a| ≤ A its speed is at most A min(t, T - t), which adds up to A T²/4; and √12 is that of the
whole duration, for the Green's function of the speed is positive. A cycle of the duration T
passes two poses that are d apart with

    peak ≥ 16 m d / T²        rms ≥ 8 √3 m d / T²,

for ``d = ∫ (G - c) a dt`` with the periodic triangle G of the height t₁ (T - t₁) / T, where t₁
is the time between the poses: with its mean c ``∫ |G - c|`` is t₁ (T - t₁) / 4, and
``∫ (G - c)²`` is t₁² (T - t₁)² / (12 T), both largest for t₁ = T/2.
"""

from __future__ import annotations

import numpy as np

from balance.motion.quiet.motion_space import MotionSpace
from balance.motion.quiet.objective import Measure
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from kinematics.numerics.array_types import Array

# Factors of m d / T², and by how much those of cycles are larger.
LEAST = {"peak": 4.0, "rms": np.sqrt(12.0)}
OF_CYCLES = 4.0
# Steps of the fit of a motion to the law, and weight of the change of the inputs in it.
STEPS = 8
INPUT_WEIGHT = 1e-3


def force_bound(
    model: SampledLinkage,
    passed: SampledPoses,
    duration: float,
    measure: Measure,
    cycle: bool = False,
) -> float:
    """Compute the least shaking force of any motion that passes some poses, newtons.

    Args:
        passed: two poses or more; the motion rests in the first and the last.
        duration: T, seconds.
        cycle: whether it is a cycle, which does not rest.
    """
    com = model.com(passed)
    distance = np.linalg.norm(com[:, None] - com, axis=2).max()
    factor = LEAST[measure] * (OF_CYCLES if cycle else 1.0)
    return float(factor * model.mass * distance / duration**2)


def _law_shares(measure: Measure, tau: Array) -> Array:
    """Compute the share of the way at shares τ of the duration (N,)."""
    if measure == "rms":
        return tau**2 * (3.0 - 2.0 * tau)
    return np.where(tau < 0.5, 2.0 * tau**2, 1.0 - 2.0 * (1.0 - tau) ** 2)


def fit_to_law(
    model: SampledLinkage,
    space: MotionSpace,
    y: Array,
    near: SampledPoses,
    time: Array,
    measure: Measure,
) -> Array:
    """Fit a motion of a space to the law of the centre of mass, by Gauss-Newton steps.

    Args:
        y: free coefficients to start from (free, inputs).
        near: closed poses of that motion at the times.

    Returns:
        Free coefficients of the fitted motion, which need not reach the law.
    """
    basis = space.basis(time, 0)
    poses, free = near, basis.shape[1]
    start, end = model.com(poses)[[0, -1]]
    law = start + _law_shares(measure, time / space.duration)[:, None] * (end - start)
    size = max(float(np.linalg.norm(end - start)), 1e-9)
    for _ in range(STEPS):
        by_u = model.momenta(poses)[:, 3:] / (model.mass or 1.0)
        width = by_u.shape[2]
        J = np.einsum("niw,nf->niwf", by_u, basis).reshape(-1, width * free)
        residual = (law - model.com(poses)).ravel()
        damping = INPUT_WEIGHT * size * np.eye(width * free)
        rows = np.concatenate([J, damping])
        step = np.linalg.lstsq(rows, np.append(residual, np.zeros(width * free)), rcond=None)[0]
        step = step.reshape(width, free).T
        step *= min(1.0, 1.0 / (np.abs(step).max() or 1.0))
        poses_there = model.near(poses, space.path(y + step).at(time)[0])
        if poses_there is None:
            break
        y, poses = y + step, poses_there
    return y
