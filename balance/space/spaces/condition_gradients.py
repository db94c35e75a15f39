"""Gradients of the momentum, and of loop closure, with respect to the joint screws.

A number that follows from the motion along rays has one derivative for each component of each
screw. All of them are found by the chain rule from the last step of the recursions

    k s_{j,k}  = Σ_{a<k} ad(V_{parent,a}) s_{j,k-1-a}
    τ_{j,k}    = Σ_{a≤k} s_{j,a} C_{j,k-a}     (C_k of dependent joints: the τ close the loops)
    T_k        = Σ_way τ_{j,k},                V_k = T_k δ
    k z_k      = Σ_{a<k} L(V_a) z_{k-1-a}
    h_{w,k}    = Σ_{a≤k} M(T_{w,a}) z_{k-a}

to the first, at the cost of a few evaluations, however many joints there are (A. Griewank and
A. Walther, Evaluating Derivatives, 2008). See `kinematics.closure.series` and
`balance.space.momentum.product_tensors` for the recursions. A name that ends in ``_bar`` holds
the derivatives with respect to what it names; indices are rays r, orders k and a, joints n,
columns w and components d.
"""

from __future__ import annotations

import numpy as np

from balance.space.conditions.rank import singular_value_decomposition
from balance.space.momentum.product_tensors import product_tensors
from kinematics.closure.series import Series, loop_matrix
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array

# Number of random sums of all closure residuals, which vanish only if every residual does.
RANDOM_SUMS = 4


class ConditionGradients:
    """Derivatives of the conditions along rays with respect to all joint screws."""

    def __init__(self, chain: Chain, rays: Array, series: Series, force: bool) -> None:
        """Prepare the recursions.

        Args:
            rays: directions (rays, w).
            series: the motion along them.
            force: whether only linear momentum counts.
        """
        self._chain, self._rays, self._series = chain, rays, series
        self._tensors = product_tensors(chain.planar, force)
        self._path_matrix, self._loop_matrix = _path_and_loop_matrices(chain)
        # A = Q B, so that the rates of dependent joints are -B⁻¹ Qᵀ (residual without them).
        U, values, Vt = singular_value_decomposition(loop_matrix(chain)[:, chain.dependent])
        self._range, self._solver = U, (U / values) @ Vt
        ground = np.zeros_like(series.V[:, :, :1])
        above = np.concatenate([series.V, ground], axis=2)[:, :, chain.parent]
        self._ad = np.einsum("rknd,dij->rknij", above, self._tensors.bracket)
        screws = np.zeros_like(above)
        screws[:, 0] = chain.screws
        for k in range(1, screws.shape[1]):
            for a in range(k):
                carried = np.einsum("rnij,rnj->rni", self._ad[:, a], screws[:, k - 1 - a])
                screws[:, k] += carried / k
        self._screws = screws

    def of_momentum(self, weights: Array, z: Array) -> Array:
        """Differentiate a weighted sum of the momentum of given masses.

        Args:
            weights: of the momentum (orders, rays, w, rows).
            z: parameters of the bodies (bodies, parameters per body).

        Returns:
            Derivatives with respect to the screws (n, 6 or 3).
        """
        links = self._chain.links
        T, V = self._series.T[:, :, links], self._series.V[:, :, links]
        rates, masses = self._tensors.rate, self._carry_parameters(V, z * (links >= 0)[:, None])
        T_bar, V_bar, z_bar = (np.zeros_like(x) for x in (T, V, masses))
        M = np.einsum("krwi,diq->krwdq", weights, self._tensors.momentum)
        for k in reversed(range(len(weights))):
            for a in range(k + 1):
                T_bar[:, a] += np.einsum("rwdq,rbq->rbwd", M[k], masses[:, k - a])
                z_bar[:, k - a] += np.einsum("rwdq,rbwd->rbq", M[k], T[:, a])
        for k in reversed(range(1, len(weights))):
            moved = np.einsum("rbi,diq->rbdq", z_bar[:, k] / k, rates)
            for a in range(k):
                V_bar[:, a] += np.einsum("rbdq,rbq->rbd", moved, masses[:, k - 1 - a])
                z_bar[:, k - 1 - a] += np.einsum("rbdq,rbd->rbq", moved, V[:, a])
        of_links = np.equal.outer(np.arange(len(self._path_matrix)), links).astype(np.float64)
        T_bar = np.einsum("nb,rkbwd->rknwd", of_links, T_bar)
        V_bar = np.einsum("nb,rkbd->rknd", of_links, V_bar)
        rows = np.zeros((*T.shape[:2], len(self._solver), T.shape[3]))
        return self._convert_to_screws(T_bar, V_bar, rows)

    def of_closure(self, weights: Array) -> Array:
        """Differentiate random sums of the closure residual that no joint rates can remove.

        Args:
            weights: of the orders.

        Returns:
            Derivatives with respect to the screws (sums, n, 6 or 3).
        """
        rng = np.random.default_rng(108)
        T, V = (np.zeros_like(x) for x in (self._series.T, self._series.V))
        gradients = []
        rows, count = self._range.shape
        for _ in range(RANDOM_SUMS if rows > count else 0):
            x = rng.standard_normal((*T.shape[:2], rows, T.shape[3]))
            x -= self._range @ (self._range.T @ x)
            gradients.append(self._convert_to_screws(T, V, x * weights[:, None, None]))
        return np.reshape(gradients, (-1, *self._chain.screws.shape))

    def _carry_parameters(self, V: Array, z: Array) -> Array:
        """Compute the parameters that bodies carry along, as series (r, k, bodies, q)."""
        out = np.zeros((*V.shape[:2], *z.shape))
        out[:, 0] = z
        L = np.einsum("rkbd,diq->rkbiq", V, self._tensors.rate)
        for k in range(1, V.shape[1]):
            for a in range(k):
                out[:, k] += np.einsum("rbiq,rbq->rbi", L[:, a], out[:, k - 1 - a]) / k
        return out

    def _convert_to_screws(self, T_bar: Array, V_bar: Array, residual_bar: Array) -> Array:
        """Convert derivatives with respect to twists and residual to those of screws.

        Args:
            T_bar: with respect to T (r, k, n, w, d).
            V_bar: with respect to V (r, k, n, d).
            residual_bar: with respect to the residual (r, k, rows, w).
        """
        chain, C, s = self._chain, self._series.C, self._screws
        V_bar, s_bar, C_bar = V_bar.copy(), np.zeros_like(s), np.zeros_like(C)
        child = np.equal.outer(np.arange(len(self._path_matrix)), chain.parent).astype(
            np.float64
        )
        for k in reversed(range(s.shape[1])):
            pulled = T_bar[:, k] + V_bar[:, k, :, None] * self._rays[:, None, :, None]
            own_bar = np.einsum("mn,rmwd->rnwd", self._path_matrix, pulled)
            C_bar[:, k] += np.einsum("rnd,rnwd->rnw", s[:, 0], own_bar)
            reaction = residual_bar[:, k] - self._solver @ C_bar[:, k, chain.dependent]
            own_bar += self._residual_at_joints(reaction)
            for a in range(k + 1):
                s_bar[:, a] += np.einsum("rnwd,rnw->rnd", own_bar, C[:, k - a])
                if a:
                    C_bar[:, k - a] += np.einsum("rnd,rnwd->rnw", s[:, a], own_bar)
            carried_bar = s_bar[:, k] / max(k, 1)
            moved = np.einsum("rni,dij->rndj", carried_bar, self._tensors.bracket)
            for a in range(k):
                V_bar[:, a] += child @ np.einsum("rndj,rnj->rnd", moved, s[:, k - 1 - a])
                s_bar[:, k - 1 - a] += np.einsum("rnij,rni->rnj", self._ad[:, a], carried_bar)
        return np.asarray(s_bar[:, 0].sum(axis=0))

    def _residual_at_joints(self, reaction: Array) -> Array:
        """Convert derivatives with respect to the residual to those with respect to the τ."""
        dim = self._screws.shape[3]
        rays, _, width = reaction.shape
        loops = reaction[:, : len(self._loop_matrix) * dim].reshape(rays, -1, dim, width)
        return np.einsum("ln,rldw->rnwd", self._loop_matrix, loops)


def _path_and_loop_matrices(chain: Chain) -> tuple[Array, Array]:
    """Mark joints on the path to each link by ones (n, n), and around each loop by signs."""
    n = len(chain.parent)
    ways = np.zeros((n + 1, n))
    for j, parent in enumerate(chain.parent):
        ways[j] = ways[parent]
        ways[j, j] = 1.0
    return ways[:-1], ways[chain.ends[:, 0]] - ways[chain.ends[:, 1]]
