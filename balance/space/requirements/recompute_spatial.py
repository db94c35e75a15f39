"""A design space again, with all ten parameters of each body."""

from __future__ import annotations

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.requirements.require import require
from balance.space.requirements.required_space import RequiredSpace
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace


def recompute_spatial(space: DesignSpace, max_order: int | None = None) -> DesignSpace:
    """Compute a design space again in space, where it was one in a plane.

    Args:
        space: the space, for its linkage and what it asks for.
        max_order: highest order of derivative; None for as many as needed.

    Returns:
        The space on ten parameters of each body; certified if ``space`` is.
    """
    if isinstance(space, RequiredSpace):
        gravity = [float(x) for x in space.common.gravity]
        return require(space.linkage, space.texts, spatial=True, gravity=gravity)
    wider = design_space(space.linkage, space.motion, max_order=max_order, spatial=True)
    return certify(wider) if isinstance(space, CertifiedSpace) else wider
