"""The walk to geometries that balance with masses that can be built.

The margin of feasibility is 0 wherever nothing can be built, and has no gradient. The momentum
that the best buildable masses leave has one:

    y = argmin |M z|   over   P_b(z) ⪰ ε,  Σ_b tr P_b = 1        (a cone program)
    r = M y / s_max,   D = ∂(M y)/∂g / s_max,   J = (1 - Q Qᵀ) D,

where Q spans ``M Z`` and Z the directions in which the masses may change: those that keep the
total and, to first order, the cones that are active at y. Steps are those of
`balance.studies.discovery.walk`.

A distribution z of mass can be built if ``P_b(z) ≻ 0`` for all bodies b. Masses are scaled so
that total mass and inertia, ``Σ_b tr P_b``, are 1; lengths by the size of the linkage. In the
plane the cone of a body is ``m > 0, m J > |mc|²`` (see
`balance.masses.designs.pseudo_inertia_cone`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from balance.masses.designs.pseudo_inertia_cone import Cone
from balance.space.inertial_parameters.conversions import pseudo_inertia
from balance.studies.discovery.lane_regions import lane_condition_rates
from balance.studies.discovery.polish import Ends, far_conditions
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.walk import (
    REACH,
    LaneConditions,
    Measured,
    Walks,
    Watcher,
    conditions_at,
    descend,
    step_terms,
    take_conditions,
)
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from kinematics.numerics.array_types import Array, IntArray

# A walk has arrived if the momentum of the best masses falls below this, and is polished then.
NEAR = 1e-6
# Part of the largest singular value below which a change of the masses changes nothing.
CHANGES_NOTHING = 1e-9
# Least eigenvalue of each pseudo-inertia in a walk, times the number of bodies. Walks from 300
# four-bars and 150 Watt linkages: 0.02 stops most on their way, 0.0003 lets many end where
# links vanish.
LEAST_SHARE = 0.002
# Margin above which masses can be built; where none can, the solver reaches 1e-10.
CAN_BE_BUILT = 1e-8
# A cone is active if its least eigenvalue exceeds the limit by less than this.
ACTIVE = 1e-6


@dataclass(frozen=True, eq=False)
class BuildableResidual:
    """The momentum of the buildable masses that leave the least of it.

    Attributes:
        structure: the topology.
        geometry: the linkages.
        conditions: theirs.
        cones: of the bodies.
    """

    structure: TopologyArrays
    geometry: LaneGeometry
    conditions: LaneConditions
    cones: _MassCones

    @cached_property
    def _best(self) -> list[_LeastMomentum | None]:
        """The best masses of each lane."""
        return [
            self.cones.least_momentum(rows) if usable else None
            for rows, usable in zip(self._rows, self.conditions.usable, strict=True)
        ]

    @cached_property
    def _rows(self) -> Array:
        """``Uᵀ M / s_max`` (lanes, p, p)."""
        values = self.conditions.values / np.maximum(self.conditions.values[:, :1], 1e-300)
        return np.asarray(values[..., None] * self.conditions.Vt)

    @cached_property
    def ratio(self) -> Array:
        """The momentum over the largest singular value (lanes,)."""
        return np.array(
            [
                np.inf if best is None else np.sqrt(np.sum((rows @ best.z) ** 2))
                for rows, best in zip(self._rows, self._best, strict=True)
            ]
        )

    def terms(self, lanes: IntArray) -> tuple[Array, Array]:
        """Compute ``Jᵀ J`` and ``Jᵀ r``; see `Measured`."""
        conditions, largest = (
            take_conditions(self.conditions, lanes),
            self.conditions.values[lanes, 0],
        )
        unknowns = self.structure.unknowns
        z, Q = np.zeros((len(lanes), 1, unknowns)), np.zeros((len(lanes), unknowns, unknowns))
        for k, lane in enumerate(lanes.tolist()):
            best = self._best[lane]
            assert best is not None
            z[k, 0] = best.z
            U, values, _ = np.linalg.svd(self._rows[lane] @ best.free, full_matrices=False)
            rank = int(np.sum(values > CHANGES_NOTHING))
            Q[k, :, :rank] = U[:, :rank]
        here, poses = self.geometry.take(lanes), conditions.poses
        D = lane_condition_rates(self.structure, here, poses, conditions.regions, z)[:, 0]
        r = conditions.U @ (self._rows[lanes] @ z[:, 0, :, None])
        return step_terms(D / largest[:, None, None], conditions.U @ Q, r[..., 0])


def walk_to_buildable(
    structure: TopologyArrays,
    start: LaneGeometry,
    *,
    reach: float = REACH,
    watch: Watcher | None = None,
) -> Walks:
    """Walk from each start to a geometry that buildable masses balance, as far as that goes.

    Args:
        reach: way of the fastest joint at the poses, radians.
        watch: told of each step; see `balance.studies.discovery.walk.descend`.

    Returns:
        The ends; a walk has arrived if its ratio is at most 1e-6.
    """
    cones = mass_cones(structure)

    def measure(geometry: LaneGeometry) -> Measured:
        conditions = conditions_at(structure, geometry, reach)
        return BuildableResidual(structure, geometry, conditions, cones)

    return descend(structure, start, measure, NEAR, watch)


def margins(structure: TopologyArrays, ends: Ends) -> list[float]:
    """Compute how well the masses of special geometries can be built.

    Returns:
        For each the largest t with ``P_b ⪰ t`` for balanced masses of total mass and inertia 1;
        0 if there are none.
    """
    cones = mass_cones(structure)
    conditions = far_conditions(structure, ends.geometry, clearly=True)
    kept = structure.unknowns - ends.nullity
    out = [cones.margin(Vt[k:].T) for Vt, k in zip(conditions.Vt, kept.tolist(), strict=True)]
    return [margin if margin > CAN_BE_BUILT else 0.0 for margin in out]


class _LeastMomentum(NamedTuple):
    """Buildable masses that leave the least momentum.

    Attributes:
        z: the parameters of all bodies (unknowns,).
        free: orthonormal directions in which they may change (unknowns, directions).
    """

    z: Array
    free: Array


class _MassCones(NamedTuple):
    """Cones of the bodies of a topology.

    Attributes:
        blocks: pseudo-inertia matrices of unit parameters (bodies, unknowns, k, k).
        planar: whether only the trace of the second moments counts.
        total: total mass and inertia of unit parameters (unknowns,).
    """

    blocks: Array
    planar: bool
    total: Array

    def least_momentum(self, rows: Array) -> _LeastMomentum | None:
        """Minimise ``|rows z|`` over masses that can be built, ``P_b(z) ⪰ ε``.

        Args:
            rows: any matrix with the norms of the momentum rows (n, unknowns).

        Returns:
            The minimiser; None if the solver finds none.
        """
        n, unknowns = rows.shape
        cone = Cone(self.blocks, unknowns, self.planar)
        least = LEAST_SHARE / len(self.blocks)
        unit = np.tile(cone.rows(least * np.eye(cone.size)), len(self.blocks))
        bodies = cone.stack_rows(self.blocks)
        whole = np.zeros((1 + n + 1 + len(bodies), unknowns + 1))
        whole[0, :unknowns], whole[1, -1] = self.total, 1.0
        whole[2 : n + 2, :unknowns], whole[n + 2 :, :unknowns] = rows, bodies
        offset = np.concatenate([[-1.0], np.zeros(n + 1), -unit])
        optimum = solve_conic(
            np.append(np.zeros(unknowns), 1.0),
            whole,
            offset,
            [ConstraintBlock("zero", 1), ConstraintBlock("second_order", n + 1)]
            + [cone.part] * len(self.blocks),
            careful=False,
        )
        z = optimum.x[:-1]
        if optimum.infeasible or not np.isfinite(z).all():
            return None
        return _LeastMomentum(z, self._free(z, least))

    def _free(self, z: Array, least: float) -> Array:
        """Compute the directions that keep the total, and the active cones to first order."""
        P = np.einsum("bnij,n->bij", self.blocks, z)
        fixed = [self.total[None]]
        for matrix, blocks in zip(P, self.blocks, strict=True):
            fixed.append(self._fixed(matrix, blocks, least))
        rows = np.concatenate(fixed)
        _, values, Vt = np.linalg.svd(rows)
        return np.asarray(Vt[int(np.sum(values > 1e-9 * values[0])) :].T)

    def _fixed(self, P: Array, blocks: Array, least: float) -> Array:
        """Compute the gradients of the active constraints of one body (n, unknowns)."""
        if not self.planar:
            values, Q = np.linalg.eigh(P - least * np.eye(len(P)))
            V = Q[:, values < ACTIVE]
            rows = np.einsum("ia,nij,jb->abn", V, blocks, V)
            return np.asarray(rows[np.triu_indices(V.shape[1])])
        # (J - 2 ε) (m - ε) = |mc|²
        m, mc = P[2, 2] - least, P[:2, 2]
        J = P[0, 0] + P[1, 1] - 2.0 * least
        root = np.sqrt((J - m) ** 2 + 4.0 * (mc @ mc))
        dm, dJ = blocks[:, 2, 2], blocks[:, 0, 0] + blocks[:, 1, 1]
        if J + m + root < 4.0 * ACTIVE:
            return np.stack([dm, dJ, blocks[:, 0, 2], blocks[:, 1, 2]])
        if J + m - root > 2.0 * ACTIVE:
            return np.zeros((0, len(blocks)))
        return (J * dm + m * dJ - 2.0 * blocks[:, :2, 2] @ mc)[None] / (J + m)

    def margin(self, basis: Array) -> float:
        """Maximise t with ``P_b ⪰ t`` over the masses that a basis spans, of total 1.

        Args:
            basis: columns of parameters (unknowns, n).

        Returns:
            The margin; 0 or less if no masses can be built.
        """
        n = basis.shape[1]
        cone = Cone(np.einsum("bnij,nk->bkij", self.blocks, basis), n, self.planar)
        unit = np.tile(cone.rows(np.eye(cone.size)), len(self.blocks))
        rows = np.zeros((1 + len(unit), n + 1))
        rows[0, :n], rows[1:, :n], rows[1:, n] = (
            self.total @ basis,
            cone.stack_rows(cone.blocks),
            -unit,
        )
        optimum = solve_conic(
            np.append(np.zeros(n), -1.0),
            rows,
            np.append(-1.0, 0.0 * unit),
            [ConstraintBlock("zero", 1)] + [cone.part] * len(self.blocks),
        )
        return (
            0.0
            if optimum.infeasible or not np.isfinite(optimum.x[-1])
            else float(optimum.x[-1])
        )


def mass_cones(structure: TopologyArrays) -> _MassCones:
    """Build the cones of the bodies of a topology."""
    bodies, each = len(structure.bodies), structure.algebra.parameters
    if structure.planar:
        unit = np.zeros((4, 3, 3))
        unit[0, 2, 2] = 1.0
        unit[1, 0, 2] = unit[1, 2, 0] = unit[2, 1, 2] = unit[2, 2, 1] = 1.0
        unit[3, 0, 0] = unit[3, 1, 1] = 0.5
    else:
        unit = pseudo_inertia(np.eye(10))
    blocks = np.zeros((bodies, bodies, each, *unit.shape[1:]))
    blocks[range(bodies), range(bodies)] = unit
    total = np.tile(np.einsum("nii->n", unit), bodies)
    return _MassCones(
        blocks.reshape(bodies, bodies * each, *unit.shape[1:]), structure.planar, total
    )
