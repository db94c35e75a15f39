"""The walk to geometries that balance with masses that can be built.

The margin of feasibility is 0 wherever nothing can be built, and has no gradient. The momentum
that the best buildable masses leave has one:

    y = argmin |M z|   over   P_b(z) ⪰ ε,  Σ_b tr P_b = 1        (a cone program)
    r = M y / s_max,   D = ∂(M y)/∂g / s_max,   J = (1 - Q Qᵀ) D,

where Q spans ``M Z`` and Z the directions in which the masses may change: those that keep the
total and, to first order, the cones that are active at y. Steps are those of
`balance.studies.discovery.walk`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from balance.studies.discovery.lane_motion import momentum_rates
from balance.studies.discovery.mass_cones import (
    CAN_BE_BUILT,
    LeastMomentum,
    MassCones,
    mass_cones,
)
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

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A walk has arrived if the momentum of the best masses falls below this, and is polished then.
NEAR = 1e-6
# Part of the largest singular value below which a change of the masses changes nothing.
CHANGES_NOTHING = 1e-9


@dataclass(frozen=True, eq=False)
class BuildableResidual:
    """The momentum of the buildable masses that leave the least of it.

    Attributes:
        structure: the topology.
        geometry: the linkages.
        found: their conditions.
        cones: of the bodies.
    """

    structure: TopologyArrays
    geometry: LaneGeometry
    found: LaneConditions
    cones: MassCones

    @cached_property
    def _best(self) -> list[LeastMomentum | None]:
        """The best masses of each lane."""
        return [
            self.cones.least_momentum(rows) if usable else None
            for rows, usable in zip(self._rows, self.found.usable, strict=True)
        ]

    @cached_property
    def _rows(self) -> Array:
        """``Uᵀ M / s_max`` (lanes, p, p)."""
        values = self.found.values / np.maximum(self.found.values[:, :1], 1e-300)
        return np.asarray(values[..., None] * self.found.Vt)

    @cached_property
    def ratio(self) -> Array:
        """The momentum over the largest singular value (lanes,)."""
        return np.array([
            np.inf if best is None else np.sqrt(np.sum((rows @ best.z) ** 2))
            for rows, best in zip(self._rows, self._best, strict=True)
        ])  # fmt: skip

    def terms(self, lanes: IntArray) -> tuple[Array, Array]:
        """Compute ``Jᵀ J`` and ``Jᵀ r``; see `Measured`."""
        conditions, largest = take_conditions(self.found, lanes), self.found.values[lanes, 0]
        unknowns = self.structure.unknowns
        z, Q = np.zeros((len(lanes), 1, unknowns)), np.zeros((len(lanes), unknowns, unknowns))
        for k, lane in enumerate(lanes.tolist()):
            best = self._best[lane]
            assert best is not None
            z[k, 0] = best.z
            U, values, _ = np.linalg.svd(self._rows[lane] @ best.free, full_matrices=False)
            rank = int(np.sum(values > CHANGES_NOTHING))
            Q[k, :, :rank] = U[:, :rank]
        D = momentum_rates(self.structure, self.geometry.take(lanes), conditions.poses, z)[:, 0]
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
