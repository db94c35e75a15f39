"""Links that bend, in the plane.

- ``simulate_flexible``: simulate a linkage of which named links bend, and its shaking
- ``supported_modes``: bending modes of a beam, free or on supports
- ``free_modes``: bending modes of a free beam, to full precision
- ``support_points``: points and weights on which a beam shakes its mount in no low mode
- ``similar_arm``: the counter-arm that bends like an arm
- ``similar_section``: the section of a beam that bends like another at a scale
- ``Section``: a rectangular section of a beam
- ``compare_arms``: conditions under which two arms bend alike
- ``static_deflection``: deflection of a beam on two points under its own weight
- ``Arm``: a beam clamped on a hub, with a body at its tip
- ``Beam``: a uniform beam
- ``Clamp``: a clamp of a beam
- ``EndBody``: a body at the end of a beam
- ``FlexibleSimulation``: result of ``simulate_flexible``
- ``FreeMode``: a mode of a free beam
- ``Similarity``: result of ``compare_arms``
- ``Support``: a pin of a beam, or a whippletree
- ``SupportPoints``: result of ``support_points``
- ``SupportedModes``: result of ``supported_modes``
"""

from __future__ import annotations

from balance.motion.flexible.beam import Beam
from balance.motion.flexible.free_beam_modes import FreeMode, free_modes
from balance.motion.flexible.linkage_motion import FlexibleSimulation, simulate_flexible
from balance.motion.flexible.similarity import (
    Arm,
    Section,
    Similarity,
    compare_arms,
    similar_arm,
    similar_section,
)
from balance.motion.flexible.support_points import (
    SupportPoints,
    static_deflection,
    support_points,
)
from balance.motion.flexible.supported_beam_modes import (
    Clamp,
    EndBody,
    Support,
    SupportedModes,
    supported_modes,
)

__all__ = [
    "Arm",
    "Beam",
    "Clamp",
    "EndBody",
    "FlexibleSimulation",
    "FreeMode",
    "Section",
    "Similarity",
    "Support",
    "SupportPoints",
    "SupportedModes",
    "compare_arms",
    "free_modes",
    "similar_arm",
    "similar_section",
    "simulate_flexible",
    "static_deflection",
    "support_points",
    "supported_modes",
]
