"""Linkages with a dyad built in, and their design spaces."""

from __future__ import annotations

from functools import lru_cache

from balance.masses.remedies.dyads.dyad_geometry import Dyad, dyad_document
from balance.masses.remedies.dyads.known_dyads import DyadSeed, dyad_seeds, hinges_of
from balance.masses.remedies.request import RemedyRequest
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Links of a dyad: the last bodies of a linkage with one.
DYAD_LINKS = 2
# Spaces that are kept: of the known geometries of one request, for the remedies with dyads.
KEPT = 64


def why_no_dyad(request: RemedyRequest) -> str:
    """Say why no dyad is searched for; empty if one is."""
    if not request.linkage.planar or request.spatial:
        return "dyads are searched for in planar linkages, with the parameters of a plane"
    if request.balance == "force":
        return "a dyad adds no freedom to balance forces: see counter-masses"
    return "" if hinges_of(request.linkage) else "the linkage has no hinge that moves"


def load_with_dyad(request: RemedyRequest, dyad: Dyad, numbers: Array) -> Linkage:
    """Load a linkage with a dyad, all of whose links carry parameters.

    Raises:
        LinkageError: it does not assemble.
    """
    document, _, _ = dyad_document(request.base, dyad, numbers, request.linkage.chain.frame)
    return load(
        document,
        None,
        request.linkage.inputs,
        bodies="all",
        massless=request.massless,
        angles=request.angles,
    )


def is_like(linkage: Linkage, given: Linkage) -> bool:
    """Whether a linkage with a dyad is planar and has the mobility of the one without."""
    return linkage.planar and linkage.mobility == given.mobility


@lru_cache(maxsize=1)
def known_seeds(request: RemedyRequest) -> tuple[DyadSeed, ...]:
    """List the known geometries of dyads, once for all remedies of a request.

    `dyad_space` knows a geometry again only if it is the same object.
    """
    return tuple(dyad_seeds(request.linkage))


@lru_cache(maxsize=KEPT)
def dyad_space(request: RemedyRequest, seed: DyadSeed) -> DesignSpace | None:
    """Compute the design space of a linkage with a dyad; None if it is singular with it."""
    try:
        linkage = load_with_dyad(request, seed.dyad, seed.numbers)
        if not is_like(linkage, request.linkage):
            return None
        return design_space(linkage, request.motion or None)
    except LinkageError:
        return None
