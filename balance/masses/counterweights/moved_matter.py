"""Matter that is moved: a share of the given mass of a link is taken, and placed in its region.

With the pseudo-inertia P of the given masses of a link, of mass m, a share θ between 0 and a
largest one is taken evenly from all of it, and the matter π that is placed on the link has at
least the mass that was taken:

    ΔP = π - θ P,    mass(π) ≥ θ m.

It is one more generator of a convex set of matter, so that the programs stay what they are, and
their duals have one more term: for any ``s ≥ 0``, a quadratic form Q has on all such ΔP at most

    h(Q + s) + most · max(0, -<Q, P> - (price + s) m),

with the support function h of the matter that may be placed, and a price of each kilogram that
is taken. H. Chaudhary and S. K. Saha (Mechanism and Machine Theory 43, 2008) place the mass of
links anew likewise, as equimomental point masses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import MomentCone
from balance.masses.counterweights.link_regions import names_of_links
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.cut_regions import FINE, Stock, fill
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.space.inertial_parameters.conversions import pseudo_inertia
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock
from balance.support.tolerances import SHARE_ZERO, SHIFT_ACCURACY
from kinematics.errors import BodyError, UsageError
from kinematics.numerics.array_types import Array

# Price of a kilogram that is moved, over that of one that is added.
PRICE_OF_MOVING = 1e-2


class Taken(NamedTuple):
    """What may be taken from links, by the order of their regions.

    Attributes:
        matter: given pseudo-inertia P of each link (links, 4, 4) in unit coordinates; zero for
            links of which nothing may be taken.
        most: largest share of it (links,).
    """

    matter: Array
    most: Array

    @property
    def masses(self) -> Array:
        """Mass of each P (links,)."""
        return np.asarray(self.matter[:, 3, 3])

    @property
    def spread(self) -> Array:
        """Size of each P over its mass (links,); 0 for links of which nothing is taken."""
        sizes = np.linalg.norm(self.matter, axis=(1, 2))
        return np.asarray(sizes / np.where(self.masses > 0.0, self.masses, 1.0))

    @property
    def links(self) -> list[int]:
        """Positions of the links of which something may be taken."""
        return [int(k) for k in np.flatnonzero(self.most)]

    @property
    def heaviest(self) -> float:
        """Most mass that may be taken in all."""
        return float(self.most @ self.masses)

    def rounded(self, shares: Array) -> Array:
        """Return shares (links,) of a solver, those near zero and the largest ones exactly."""
        near = np.where(shares >= self.most - SHARE_ZERO, self.most, shares)
        return np.asarray(np.where(shares > SHARE_ZERO, near, 0.0))

    def over(self, unit: float) -> Taken:
        """Return it in another unit of mass."""
        return self._replace(matter=self.matter / unit)

    def net(self, placed: Array, shares: Array) -> Array:
        """Compute ``π - θ P`` (links, 4, 4)."""
        return np.asarray(placed - shares[:, None, None] * self.matter)

    def cone(self, k: int, placed: MomentCone) -> MomentCone:
        """Describe ``π - θ P`` of a link; its last variable is the share θ.

        Args:
            k: position of the link.
            placed: what may be placed, in the same unit of mass.
        """
        if not self.most[k]:
            return placed
        matrices = np.concatenate([placed.matrices, -self.matter[k : k + 1]])
        rows = np.zeros((len(placed.rows) + 3, len(matrices)))
        rows[: len(placed.rows), :-1] = placed.rows
        rows[-3:-1, -1] = 1.0, -1.0
        rows[-1] = matrices[:, 3, 3] / self.masses[k]
        parts = (*placed.parts, ConstraintBlock("nonnegative", 3))
        constants = np.concatenate([placed.constants, [0.0, self.most[k], 0.0]])
        return MomentCone(matrices, rows, parts, placed.exact, constants)

    def gains(self, forms: Array, shifts: Array, price: float = 0.0) -> Array:
        """Compute ``most · max(0, -<Q, P> - (price + s) m)`` (links,) of forms Q."""
        worth = -np.einsum("lij,lij->l", forms, self.matter) - (price + shifts) * self.masses
        return np.asarray(self.most * np.maximum(0.0, worth))

    def shifts(
        self,
        stocks: Sequence[Stock],
        forms: Array,
        price: float = 0.0,
        factor: float = 1.0,
        rays: int = FINE,
    ) -> Array:
        """Compute the s (links,) of the least bound for forms Q.

        The bound falls with s until the part of the region where ``Q + s`` is positive has as
        much mass as may be taken, or until taking is worth nothing.

        Args:
            stocks: region and density of each link, in the unit of mass of P.
            forms: matrices (links, 4, 4).
            price: that of each unit of mass that is taken.
            factor: factor of the densities.
            rays: those of the parts that are to have so much mass.
        """
        from scipy.optimize import brentq

        shifts = np.zeros(len(forms))
        for k in self.links:
            worth = -float(np.sum(forms[k] * self.matter[k])) / self.masses[k] - price
            room = float(self.most[k] * self.masses[k])

            def short(s: float, k: int = k, room: float = room) -> float:
                form = shifted(forms[k], s)
                part = fill(stocks[k].with_rays_inside(form), form, rays)
                return room - factor * float(part[3, 3])

            if worth <= 0.0 or short(0.0) <= 0.0:
                continue
            shifts[k] = worth
            if short(worth) < 0.0:
                shifts[k] = brentq(
                    short, 0.0, worth, xtol=SHIFT_ACCURACY * worth, rtol=SHIFT_ACCURACY
                )
        return shifts


def shifted(forms: Array, shifts: Array | float) -> Array:
    """Add constants s (...,) to forms (..., 4, 4)."""
    Q = np.array(forms)
    Q[..., 3, 3] += shifts
    return Q


def nothing_taken(links: int) -> Taken:
    """Return what may be taken from so many links: nothing."""
    return Taken(np.zeros((links, 4, 4)), np.zeros(links))


def taken_from(
    space: DesignSpace,
    regions: Mapping[int, Region],
    moved: Mapping[int, float],
    unit: float = 1.0,
) -> Taken:
    """Find what may be taken from links.

    Args:
        space: the design space.
        regions: region by position of the body.
        moved: largest share of the given mass by position of the body.
        unit: kilograms per unit of mass.
    """
    P, most = nothing_taken(len(regions))
    file = given_parameters(space) if moved else np.empty((0, 10))
    for k, (b, region) in enumerate(regions.items()):
        if moved.get(b, 0.0):
            back = np.linalg.inv(space.frames[b] @ region.place)
            P[k], most[k] = back @ pseudo_inertia(file[b]) @ back.T / unit, moved[b]
    return Taken(P, most)


def moved_links(
    space: DesignSpace, regions: Mapping[int, Region], move: Mapping[str, float] | None
) -> dict[int, float]:
    """Check the links whose matter may be moved.

    Args:
        space: a design space of the linkage.
        regions: region by position of the body.
        move: largest share of the given mass by name; ``{"all": share}`` is for all regions.

    Returns:
        The shares by position of the body.

    Raises:
        BodyError: a link gets no matter, or has no mass.
        UsageError: a share is not above 0 and at most 1.
    """
    shares, names = dict(move or {}), [space.bodies[b] for b in regions]
    if len(shares) == 1 and names_of_links(space.linkage, tuple(shares)) == space.bodies:
        shares = dict.fromkeys(names, *shares.values())
    for name, share in shares.items():
        if name not in names:
            problem = "is to be moved, but gets no matter: name it among the links too"
            raise BodyError(space.source, name, problem, names)
        if not 0.0 < share <= 1.0:
            raise UsageError(
                f"link '{name}': a share of {share:g} of its mass: give one above 0 and up to 1"
            )
        if not given_parameters(space)[space.bodies.index(name), 0] > 0.0:
            raise BodyError(space.source, name, "has no mass that could be moved")
    return {space.bodies.index(name): float(share) for name, share in shares.items()}


def moved_masses(
    space: DesignSpace, regions: Mapping[int, Region], taken: Taken, shares: Array, unit: float
) -> dict[str, float]:
    """Name the links of which something may be taken, with what is taken, kg.

    Args:
        space: a design space of the linkage.
        regions: region by position of the body.
        taken: what may be taken.
        shares: what is taken of it (links,).
        unit: kilograms per unit of mass.
    """
    bodies = list(regions)
    masses = unit * taken.masses * shares
    return {space.bodies[bodies[k]]: float(masses[k]) for k in taken.links}
