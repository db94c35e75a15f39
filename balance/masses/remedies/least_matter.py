"""The least matter that balances a linkage with a remedy, in regions that are wide enough."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.counterweights import counterweights
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.link_regions import wide_region
from balance.masses.counterweights.regions import Region
from balance.masses.designs.feasibility import Feasibility, feasible
from balance.space.certification.certify_space import certify
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.spaces.design_space import DesignSpace
from balance.support.vector_digits import vector_digits
from kinematics.wording import number_text

# Distance from the middle of a region, of its size, from which matter is at its rim.
AT_RIM = 0.999
# How a reason begins to say which matter is at a rim; see `rim_text`.
RIM = "; at the rim of the regions of "
# Grams and millimetres in a unit of SI, and how they are written: optima are flat.
WORKSHOP, MASS_FORM, PLACE_DIGITS = 1e3, ".3g", 3
# Why nothing is proved of a geometry that is special but for the last digits of its lengths.
ROUNDED = (
    "matter in these regions does not balance it, and its lengths are rounded, so that no "
    "proof covers other masses"
)
# Why there is no verdict where no proof is asked for.
UNPROVED = "no matter was found in these regions, and no proof was asked for"


class LeastMatter(NamedTuple):
    """The least matter, or why there is none.

    Attributes:
        matter: the matter in the regions.
        anywhere: whether any masses whatever balance, if that was asked.
    """

    matter: Counterweights
    anywhere: Feasibility | None

    @property
    def reason(self) -> str:
        """Why matter in the regions does not balance, in one line."""
        if self.anywhere is not None and self.anywhere.verdict == "infeasible":
            return f"no masses whatever: {self.anywhere.reason}"
        return self.matter.words

    def rim_text(self, links: Sequence[str]) -> str:
        """Say on which links matter lies at the rim of its region; see `rim_text`."""
        return rim_text(self.matter.weights, links)

    @property
    def places_text(self) -> str:
        """How much matter is where on each link; see `places_text`."""
        return places_text(self.matter.weights)

    @property
    def proof(self) -> dict[str, object] | None:
        """The certificate against it and its check, as plain data; None without one."""
        matter, anywhere = self.matter, self.anywhere
        if anywhere is not None and anywhere.certificate and anywhere.residuals:
            matrices = [matrix.tolist() for matrix in anywhere.certificate]
            return {"matrices": matrices, "check": anywhere.residuals._asdict()}
        if matter.certificate is None or matter.check is None:
            return None
        return {"functional": matter.certificate.tolist(), "check": matter.check._asdict()}


def places_text(weights: Sequence[Counterweight]) -> str:
    """Say how much matter is where on each link, g and mm, as the end of a sentence.

    Places are the centres of mass in the frames of the links, as in the file.
    """
    parts = []
    for weight in weights:
        size = WORKSHOP * weight.region.size
        at = vector_digits(WORKSHOP * weight.com, PLACE_DIGITS, size)
        grams = number_text(WORKSHOP * weight.mass, MASS_FORM)
        parts.append(f"{weight.link} {grams} g at ({at})")
    return f"; centres in link frames of the file, mm: {', '.join(parts)}" if parts else ""


def rim_text(
    weights: Iterable[Counterweight], links: Sequence[str], gain: str = "take less"
) -> str:
    """Say on which links matter lies at the rim of its region, which bounds its lever.

    Args:
        links: those that are looked at: rotors are at their radius, which is said for all.
        gain: what larger regions do.

    Returns:
        The end of a sentence; empty if there are none.
    """
    at_rim = [
        weight.link for weight in weights if weight.link in links and _reach(weight) > AT_RIM
    ]
    if not at_rim:
        return ""
    return f"{RIM}{', '.join(at_rim)}: larger ones {gain}"


def rim_of(reason: str) -> str:
    """Take from a reason what it says of a rim, for another reason with the same matter."""
    _, rim, links = reason.partition(RIM)
    return rim + links


def _reach(weight: Counterweight) -> float:
    """Compute how far matter is from the middle of its region, 1 at the rim."""
    places = np.array([lump.position for lump in weight.lumps]).reshape(-1, 3)
    return float(weight.region.gauge(weight.region.to_unit(places)).max(initial=0.0))


def least_matter(
    space: DesignSpace,
    links: Sequence[str],
    regions: Mapping[str, Region | str],
    density: float | None = None,
    thickness: float | None = None,
    whole: DesignSpace | None = None,
    prove: bool = True,
) -> LeastMatter:
    """Find the least matter in some regions, or in wider ones if these are too small.

    A verdict against it is given only after the integers of the space are certified; without
    proofs it is undecided. Who finds matter verifies the file with it.

    Args:
        links: links that may get matter.
        regions: where, by name of the link; see `balance.counterweights`.
        density: density that the matter nowhere exceeds, kg/m³; None for point masses.
        thickness: that of plates on a planar linkage, m; None for other matter.
        whole: the space with all components of the momentum, if it is known.
        prove: whether the gap is proved, and a verdict against it.
    """
    flat = space.planar and space.balance == "dynamic" and thickness is None
    fill = partial(
        counterweights, density=density, thickness=thickness, relax=False, prove=prove
    )
    # The space of all components of the momentum, once for all programs.
    if whole is None or not flat:
        whole = recompute_spatial(space) if flat else space
    matter = fill(whole, links, regions)
    if matter.verdict == "feasible":
        return LeastMatter(matter, None)
    wide = {**regions, **wide_regions(space, matter.chosen)}
    narrow = not prove and matter.verdict == "infeasible" and bool(matter.chosen)
    if narrow and feasible(space).verdict != "infeasible":
        wider = fill(whole, links, wide)
        if wider.verdict != "feasible":
            wider = wider.undecided(UNPROVED, certificate=None, check=None)
        return LeastMatter(wider, None)
    given, rounded, whole = space, whole, certify(whole)
    matter = fill(whole, links, regions)
    if matter.verdict != "infeasible":
        return LeastMatter(matter, None)
    space = certify(space) if flat else whole
    anywhere = feasible(space)
    # Lengths that are special but for their last digits have a condition more, exactly.
    special = anywhere.verdict == "infeasible" or whole.rank > rounded.rank
    if special and feasible(given).verdict == "feasible":
        wider = fill(rounded, links, wide)
        none = matter.undecided(ROUNDED, certificate=None, check=None)
        return LeastMatter(wider if wider.verdict == "feasible" else none, None)
    if anywhere.verdict == "infeasible" or not matter.chosen:
        return LeastMatter(matter, anywhere)
    return LeastMatter(fill(whole, links, wide), anywhere)


def wide_regions(space: DesignSpace, links: Iterable[str]) -> dict[str, Region]:
    """Return the wider regions of links whose own ones are too small; see `wide_region`."""
    return {name: wide_region(space, space.bodies.index(name)) for name in links}


def least_matter_or_none(
    space: DesignSpace,
    links: Sequence[str],
    regions: Mapping[str, Region | str],
    density: float | None = None,
    thickness: float | None = None,
) -> Counterweights | None:
    """Find the least matter as `least_matter` does, without a proof where there is none.

    Args:
        space: the space with all components of the momentum, or for plates that of the plane.
        links: links that may get matter.
        regions: where, by name of the link.
        density: see `least_matter`.
        thickness: see `least_matter`.
    """
    fill = partial(
        counterweights, space, links, density=density, thickness=thickness, relax=False
    )
    matter = fill(regions)
    if matter.verdict != "feasible" and matter.chosen:
        matter = fill({**regions, **wide_regions(space, matter.chosen)})
    return matter if matter.verdict == "feasible" else None
