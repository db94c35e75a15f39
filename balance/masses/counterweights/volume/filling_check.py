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

from balance.masses.counterweights.exclusion import values_of_certificate
from balance.masses.counterweights.moved_matter import shifted, taken_from
from balance.masses.counterweights.volume.cut_regions import Stock, support_function
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import CERTIFICATE_ORTHOGONAL
from kinematics.wording import check_summary


class FillingCheck(NamedTuple):
    """Result of `check_filling`.

    Attributes:
        accepted: whether the certificate excludes all matter in the regions.
        orthogonality: size of the functional on the orthonormal basis of the design space,
            over its size.
        margin: minus its value on the given masses, over its size, kg.
        most: largest value of matter in the regions, over its size, kg.
    """

    accepted: bool
    orthogonality: float
    margin: float
    most: float

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals."""
        return check_summary(self)


def check_filling(
    space: DesignSpace,
    stocks: Mapping[int, Stock],
    certificate: ArrayLike,
    moved: Mapping[int, float] | None = None,
) -> FillingCheck:
    """Check a certificate without the solver.

    The residual of orthogonality, and the estimate of errors of integrals, count against it.

    Args:
        space: the design space.
        stocks: regions and densities by position of the body.
        certificate: w (parameters,) in the units of the chain.
        moved: largest share of the given mass that may be moved, by position of the body; see
            `balance.masses.counterweights.moved_matter`.
    """
    regions = {b: stock.region for b, stock in stocks.items()}
    values = values_of_certificate(space, regions, certificate)
    if values is None:
        return FillingCheck(False, np.inf, 0.0, np.inf)
    orthogonality, margin, forms, errors = values
    taken = taken_from(space, regions, moved or {})
    shifts = taken.shifts(list(stocks.values()), forms)
    # The residual may hide as much of what is taken as its size tells.
    most = float(taken.gains(forms, shifts - 0.25 * errors * taken.spread).sum())
    forms = shifted(forms, shifts)
    for stock, form, error in zip(stocks.values(), forms, errors, strict=True):
        integrated = stock.with_rays_inside(form)
        most += sum(support_function(integrated, form)) + float(error) * stock.whole
    accepted = bool(orthogonality <= CERTIFICATE_ORTHOGONAL and margin > most)
    return FillingCheck(accepted, orthogonality, margin, most)
