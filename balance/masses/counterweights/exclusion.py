"""Certificates that no matter in some regions balances a linkage, and their check.

A certificate is a linear functional w on the inertial parameters of all bodies that vanishes
on every balanced distribution, is negative on the given masses, and is not positive on any
point mass in the regions. The sum of the given masses and of added matter is then negative
under w, so that it is not balanced.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.added_matter import parameters_per_moment
from balance.masses.counterweights.moved_matter import taken_from
from balance.masses.counterweights.quadratic_minimum import least_values
from balance.masses.counterweights.regions import Region
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES
from balance.support.tolerances import (
    CERTIFICATE_ENTRY_RELATIVE,
    CERTIFICATE_ORTHOGONAL,
    MASS_EXCLUDED,
)
from kinematics.numerics.array_types import Array
from kinematics.wording import check_summary


class Exclusion(NamedTuple):
    """Result of `check_exclusion`.

    Attributes:
        accepted: whether the certificate excludes a million times the given mass.
        orthogonality: size of the functional on the orthonormal basis of the design space,
            over its size.
        margin: minus its value on the given masses, over its size, kg.
        excluded: added mass that it excludes, kg: any mass below this, in any places of the
            regions, leaves the linkage unbalanced.
    """

    accepted: bool
    orthogonality: float
    margin: float
    excluded: float

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals.

        The mass that it excludes is one over the errors of the solver, so that a bound tells.
        """
        return check_summary(self, excluded=1.0 / MASS_EXCLUDED)


class CertificateValues(NamedTuple):
    """What a functional on the inertial parameters is worth, divided by its size.

    Attributes:
        orthogonality: its size on the orthonormal basis of the design space.
        margin: minus its value on the given masses, less what orthogonality may hide.
        forms: its value on a unit point mass at u, ``[u; 1]ᵀ F [u; 1]``, by region
            (regions, 4, 4).
        moment_errors: most that orthogonality may hide of such a value (regions,).
    """

    orthogonality: float
    margin: float
    forms: Array
    moment_errors: Array


def values_of_certificate(
    space: DesignSpace, regions: Mapping[int, Region], certificate: ArrayLike
) -> CertificateValues | None:
    """Evaluate a functional w (parameters,), in the units of the chain; None if it is none."""
    w = np.asarray(certificate, dtype=np.float64)
    size = float(np.linalg.norm(w))
    if not (np.isfinite(size) and size > 0.0):
        return None
    w = w / size
    force = space.balance == "force"
    file = given_parameters(space)
    given = to_chain(file, space.chain.frame, space.planar, force).reshape(-1)
    orthogonality = float(np.linalg.norm(space.scaled_basis.T @ w))
    margin = -float(w @ given) - orthogonality * float(np.linalg.norm(given))
    per_moment = parameters_per_moment(space, regions)
    parts = w.reshape(len(space.bodies), 1, -1)[list(regions)]
    forms = ((parts @ per_moment)[:, 0] @ TRIANGLES[4].T).reshape(-1, 4, 4)
    # The size of [u; 1][u; 1]ᵀ is at most 4 in a box, the largest of the shapes.
    moment_errors = orthogonality * 4.0 * np.linalg.norm(per_moment, 2, axis=(1, 2))
    return CertificateValues(orthogonality, margin, forms, moment_errors)


def check_exclusion(
    space: DesignSpace,
    regions: Mapping[int, Region],
    certificate: ArrayLike,
    moved: Mapping[int, float] | None = None,
) -> Exclusion:
    """Check a certificate without the solver.

    With the residual δ of orthogonality, added matter of mass M gives the sum at most
    ``-margin + δ |z| + M (g + δ s)``, where g is the largest value of w on a unit point mass in
    a region, and s bounds the parameters of such a mass. The maximum of the quadratic
    polynomial is computed exactly; see `minimise_in_region`. What may be moved counts against
    the margin; see `balance.masses.counterweights.moved_matter`.

    Args:
        regions: region by position of the body.
        certificate: w (parameters,) in the units of the chain.
        moved: largest share of the given mass that may be moved, by position of the body.
    """
    values = values_of_certificate(space, regions, certificate)
    if values is None:
        return Exclusion(False, np.inf, 0.0, 0.0)
    most = -least_values(list(regions.values()), -values.forms)
    taken = taken_from(space, regions, moved or {})
    errors = values.moment_errors
    # What is placed has errors of a point in the region, and what is taken those of its size.
    gains = taken.gains(values.forms, -most - errors * (1.0 + 0.25 * taken.spread))
    orthogonality, margin = values.orthogonality, values.margin - float(gains.sum())
    gain = float((most + errors).max(initial=0.0))
    excluded = 0.0 if margin <= 0.0 else margin / gain if gain > 0.0 else np.inf
    enough = excluded >= MASS_EXCLUDED * float(given_parameters(space)[:, 0].sum())
    accepted = bool(orthogonality <= CERTIFICATE_ORTHOGONAL and margin > 0.0 and enough)
    return Exclusion(accepted, orthogonality, margin, float(excluded))


def describe_exclusion(
    space: DesignSpace, regions: Mapping[int, Region], certificate: Array
) -> str:
    """Describe the regions and bodies on which a certificate lives, in words.

    Args:
        regions: region by position of the body.
        certificate: w (parameters,).
    """
    parts = certificate.reshape(len(space.bodies), -1)
    force = space.balance == "force"
    file = to_chain(given_parameters(space), space.chain.frame, space.planar, force)
    sizes = np.linalg.norm(parts, axis=1)
    bodies = [space.bodies[b] for b in regions]
    named = links_in_certificate(space, bodies, certificate)
    leaves = -np.einsum("bi,bi->b", parts, file)
    causes = [space.bodies[b] for b in np.flatnonzero(leaves > 0.1 * leaves.max())]
    second = parts[:, (3 if space.planar else 4) :]
    rotary = second.size and np.abs(second).max() > CERTIFICATE_ENTRY_RELATIVE * sizes.max()
    what = "moment of inertia" if rotary else "mass moment"
    claim = f"can cancel the {what} that {quoted_names(causes)} {_leave(causes)}"
    if not named:
        added = quoted_names(bodies)
        return f"infeasible: no matter on {added}, wherever it is, {claim}"
    plural = "region" if len(named) == 1 else "regions"
    return f"infeasible: no matter in the {plural} of {quoted_names(named)} {claim}"


def links_in_certificate(
    space: DesignSpace, links: Iterable[str], certificate: Array
) -> list[str]:
    """List those of some links whose matter a certificate weighs; that of others it ignores.

    Args:
        links: names of links.
        certificate: w (parameters,).
    """
    sizes = np.linalg.norm(certificate.reshape(len(space.bodies), -1), axis=1)
    least = CERTIFICATE_ENTRY_RELATIVE * float(sizes.max())
    return [name for name in links if sizes[space.bodies.index(name)] > least]


def quoted_names(names: Sequence[str]) -> str:
    """Quote names, with commas and *and* between them; empty for none."""
    if not names:
        return ""
    *some, last = [f"'{name}'" for name in names]
    return " and ".join(filter(None, [", ".join(some), last]))


def _leave(names: list[str]) -> str:
    return "leaves" if len(names) == 1 else "leave"
