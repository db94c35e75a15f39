"""The tangent cone of the closed poses at a singular pose, to second order.

Joint rates v that close the loops at first order, ``S_0 v = 0``, are tangent to a motion only
if an acceleration closes them at second order:

    S_0 a + Ṡ(v) v = 0        ⇔        Uᵀ Ṡ(v) v = 0,    Uᵀ S_0 = 0

with the screws carried by their parents, ``ṡ_j = ad(V_parent) s_j`` (A. Müller, "Higher-order
analysis of kinematic singularities of lower pair linkages and serial manipulators", J. Mech.
Robotics 10, 2018; A. Müller, P. C. López-Custodio, J. S. Dai, "Identification of
non-transversal motion bifurcations of linkages", J. Mech. Robotics 13, 2021). In coordinates u
of the kernel, v = N u, each column of U gives a quadratic form, ``uᵀ Q u = 0``. Conditions of
higher order make the cone smaller; the finite poses near the singular one decide about them.
"""

from __future__ import annotations

import numpy as np

from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain
from kinematics.model.spatial.screws import ad
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.vectors import alike_groups

# First seed of the directions in which the search starts.
SEED = 4
# Steps of the damped Newton method, its damping over the squared residual, and the least square
# that counts: on a cone of several dimensions the directions along it are not determined.
STEPS, DAMPING, LEAST_SQUARE = 60, 1e-3, 1e-8
# Value of the forms, relative to the largest, up to which a direction is a start: conditions
# that hold twice are met slowly, and forms at a pose nearby are those of the pose but for it.
NEARLY_ZERO = 1e-2
# Distance of directions that are one start.
SAME_DIRECTION = 1e-2


def second_order_forms(chain: Chain, N: Array) -> Array:
    """Compute the quadratic forms that vanish on the tangent cone of the reference pose.

    Args:
        chain: joints in loops that are closed; spatial.
        N: orthonormal joint rates that close the loops at first order (n, f).

    Returns:
        Symmetric matrices Q (m, f, f): ``uᵀ Q u = 0`` for joint rates ``N u`` that close the
        loops at second order; m is the number of rows of the loop matrix beyond its rank.
    """
    S = loop_matrix(chain)
    rows = len(chain.ends) * chain.screws.shape[1]
    U = np.linalg.svd(S)[0][:, len(N) - N.shape[1] :]
    half = np.empty((U.shape[1], N.shape[1], N.shape[1]))
    for a, rates in enumerate(N.T):
        carried = loop_matrix(chain, _carried_screws(chain, rates))
        carried[rows:] = 0.0  # relations of joint positions are linear
        half[:, a] = U.T @ carried @ N
    return 0.5 * (half + half.transpose(0, 2, 1))


def _carried_screws(chain: Chain, rates: Array) -> Array:
    """Compute the rates of the screws, ``ṡ_j = ad(V_parent) s_j``, for joint rates (n,)."""
    twists, carried = np.zeros_like(chain.screws), np.zeros_like(chain.screws)
    for j, parent in enumerate(chain.parent.tolist()):
        s = chain.screws[j]
        V = twists[parent] if parent >= 0 else np.zeros(6)
        carried[j] = ad(V) @ s
        twists[j] = V + rates[j] * s
    return carried


def cone_directions(forms: Array, count: int, seed: int = 0) -> tuple[Array, IntArray]:
    """Find directions on the cone where quadratic forms vanish, by Newton's method.

    Args:
        forms: symmetric matrices (m, f, f).
        count: number of starts; evenly on the circle if f is 2, at random otherwise.

    Returns:
        Unit vectors (directions, f) at which the forms vanish, or nearly so, and how many
        starts lead to each (directions,). Of a cone of one sheet or more, samples.
    """
    size, f = float(np.abs(forms).max(initial=0.0)), forms.shape[1]
    u = _starts(f, count, seed)
    if size == 0.0:
        return u, np.ones(count, dtype=np.int64)
    Q = forms / size
    for _ in range(STEPS):
        Qu = np.einsum("mab,kb->kma", Q, u)
        J = np.concatenate([2.0 * Qu, 2.0 * u[:, None]], axis=1)
        r = np.concatenate(
            [np.einsum("kma,ka->km", Qu, u), (np.sum(u * u, axis=1) - 1.0)[:, None]], axis=1
        )
        damping = DAMPING * np.maximum(np.sum(r * r, axis=1), LEAST_SQUARE)
        normal = J.transpose(0, 2, 1) @ J + damping[:, None, None] * np.eye(f)
        u = u - np.linalg.solve(normal, np.einsum("kma,km->ka", J, r)[..., None])[..., 0]
    u /= np.linalg.norm(u, axis=1)[:, None]
    values = np.abs(np.einsum("mab,ka,kb->km", Q, u, u)).max(axis=1, initial=0.0)
    u = u[values <= NEARLY_ZERO]
    groups = alike_groups(u, lambda some, v: np.abs(some - v).max(axis=1) <= SAME_DIRECTION)
    hits = np.array([len(group) for group in groups], dtype=np.int64)
    return np.reshape(u[[group[0] for group in groups]], (-1, f)), hits


def _starts(f: int, count: int, seed: int) -> Array:
    """Make unit vectors (count, f): evenly on the circle, or at random."""
    if f == 2:
        angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False) + 0.05
        return np.column_stack([np.cos(angles), np.sin(angles)])
    u = np.random.default_rng([SEED, seed]).standard_normal((count, f))
    return u / np.linalg.norm(u, axis=1)[:, None]
