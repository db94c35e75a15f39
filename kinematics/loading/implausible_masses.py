"""Masses and moments of inertia that no machine of this size has: grams, or millimetres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinematics.error_text import clean
from kinematics.model.linkage import Body, Notice, UnassembledLinkage
from kinematics.wording import number_text

if TYPE_CHECKING:
    from kinematics.numerics.array_types import Array

# Density that no machine reaches as a whole, half of solid steel, kg/m³: links of known
# machines and robots have at most 900, a short crank with its web 1800.
DENSEST = 4000.0
# Mass of one link, kg, above which it is compared with water in a cube of the size.
HEAVY_LINK, WATER = 1000.0, 1000.0
# Radii of gyration over the size of the linkage: of half of its links, and of any.
WIDE_LINKS, WIDEST_LINK = 1.5, 30.0
# Links lighter than this part of the heaviest are placeholders.
PLACEHOLDER = 0.01


def implausible_masses(draft: UnassembledLinkage) -> list[Notice]:
    """Note masses that look like grams, and moments of inertia that look like kg mm² or g mm².

    Of all bodies of mass M and density ρ, a ball of radius R is the least spread about its
    centre of mass, with the mean square distance 3R²/5. What is less spread than that ball
    is denser than ρ somewhere, wherever its links are and however many they are.

    Args:
        draft: a linkage at the pose of its file.
    """
    bodies = [body for body in draft.bodies if body.inertia[0] > 0]
    if not bodies:
        return []
    centres = np.array([body.inertia[1:4] / body.inertia[0] for body in bodies])
    radii = np.array([_radius_of_gyration(body) for body in bodies])
    points = [place.pose[:3, 3] for place in draft.places.values()]
    points += [joint.point for joint in draft.joints]
    wide = _wide_links(bodies, radii, _diagonal(np.vstack([*points, centres])))
    return wide or _heavy_links(bodies, centres, radii, np.array(points))


def _diagonal(points: Array) -> float:
    """Return the diagonal of the box about points (n, 3)."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _radius_of_gyration(body: Body) -> float:
    """Return the mean distance √(tr(I) / 2m) from the centre of mass, quadratic; 0 if none."""
    mass, first, second = body.inertia[0], body.inertia[1:4], body.inertia[4:7]
    return float(np.sqrt(max(second.sum() / 2 - first @ first / mass, 0.0) / mass))


def _wide_links(bodies: list[Body], radii: Array, size: float) -> list[Notice]:
    """Note links whose mass would be far beyond the linkage."""
    masses = np.array([body.inertia[0] for body in bodies])
    told = (masses > PLACEHOLDER * masses.max()) & (radii > 0)
    ratios = np.where(told, radii, 0.0) / size if size > 0 else np.zeros(len(bodies))
    widest = int(ratios.argmax())
    many = np.count_nonzero(ratios > WIDE_LINKS)
    if not (ratios[widest] > WIDEST_LINK or 2 <= np.count_nonzero(told) <= 2 * many):
        return []
    text = (
        f"link '{clean(bodies[widest].name)}' has the moments of inertia of a mass "
        f"{number_text(float(radii[widest]), '.2g')} m about its centre, in a linkage of "
        f"{number_text(size, '.2g')} m: <inertia> is in kg m²; multiply kg mm² by 1e-6, "
        "g mm² by 1e-9, and grams in <mass> by 0.001"
    )
    return [Notice("wide_inertia", text)]


def _heavy_links(
    bodies: list[Body], centres: Array, radii: Array, points: Array
) -> list[Notice]:
    """Note links that are too dense together, or one too heavy for the size."""
    masses = np.array([body.inertia[0] for body in bodies])
    total, heaviest = float(masses.sum()), int(masses.argmax())
    middle = masses @ centres / total
    spread = masses @ (((centres - middle) ** 2).sum(axis=1) + radii**2) / total
    ball = 4 / 3 * np.pi * (5 / 3 * spread) ** 1.5
    reach = np.vstack([points, centres - radii[:, None], centres + radii[:, None]])
    cube = _diagonal(reach) ** 3
    heavy = masses[heaviest] > max(HEAVY_LINK, WATER * cube) and cube > 0
    # Point masses in one place, without an extent, are a model and no machine.
    if not heavy and not (radii.any() and total > DENSEST * ball > 0):
        return []
    size = _diagonal(np.vstack([points, centres]))
    kilograms, most, metres = (
        number_text(float(x), ".2g") for x in (total, masses[heaviest], size)
    )
    text = (
        f"its links weigh {kilograms} kg, '{clean(bodies[heaviest].name)}' alone {most} kg, "
        f"more than a machine of {metres} m: <mass> is in kg; multiply grams by 0.001, and "
        "moments of inertia in g m² too"
    )
    return [Notice("heavy_links", text)]
