"""Certificates that no matter of limited density in some regions balances, and their check.

A certificate is a linear functional w on the inertial parameters of all bodies that vanishes
on every balanced distribution. With the given masses at ``-margin`` under w, matter that
balances has ``w = margin``; but all matter in the regions, wherever it is, has at most

    Σ_b ρ_b ∫_{K_b} max(w_b, 0) dV,

the value of the parts where a unit mass has a positive one, at full density.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.added_matter import parameters_per_moment
from balance.masses.counterweights.volume.stock import Stock, support_function
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES
from balance.support.tolerances import CERTIFICATE_ORTHOGONAL
from kinematics.wording import check_summary


class FillingCheck(NamedTuple):
    """Result of `check_filling`.

    Attributes:
        accepted: whether the certificate excludes all matter in the regions.
        orthogonality: size of the functional on the orthonormal basis of the design space,
            over its size.
        left: minus its value on the given masses, over its size, kg.
        held: most that matter in the regions has, over its size, kg.
    """

    accepted: bool
    orthogonality: float
    left: float
    held: float

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals."""
        return check_summary(self)


def check_filling(
    space: DesignSpace, stocks: Mapping[int, Stock], certificate: ArrayLike
) -> FillingCheck:
    """Check a certificate without the solver.

    The residual of orthogonality, and the estimate of errors of integrals, count against it.

    Args:
        space: the design space.
        stocks: regions and densities by position of the body.
        certificate: w (parameters,) in the units of the chain.
    """
    w = np.asarray(certificate, dtype=np.float64)
    size = float(np.linalg.norm(w))
    if not (np.isfinite(size) and size > 0.0):
        return FillingCheck(False, np.inf, 0.0, np.inf)
    w = w / size
    force = space.balance == "force"
    given = to_chain(given_parameters(space), space.chain.frame, space.planar, force).reshape(
        -1
    )
    slip = float(np.linalg.norm(space.scaled_basis.T @ w))
    margin = -float(w @ given) - slip * float(np.linalg.norm(given))
    regions = {b: stock.region for b, stock in stocks.items()}
    per_moment = parameters_per_moment(space, regions)
    parts = w.reshape(len(space.bodies), 1, -1)[list(regions)]
    forms = ((parts @ per_moment)[:, 0] @ TRIANGLES[4].T).reshape(-1, 4, 4)
    # The size of [u; 1][u; 1]ᵀ is at most 4 in a box, the largest of the shapes.
    slips = slip * 4.0 * np.linalg.norm(per_moment, 2, axis=(1, 2))
    held = 0.0
    for stock, form, further in zip(stocks.values(), forms, slips, strict=True):
        seen = stock.with_rays_inside(form)
        held += sum(support_function(seen, form)) + float(further) * stock.whole
    accepted = bool(slip <= CERTIFICATE_ORTHOGONAL and margin > held)
    return FillingCheck(accepted, slip, margin, held)
