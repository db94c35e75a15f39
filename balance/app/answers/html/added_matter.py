"""HTML page of a linkage with added matter: what shakes before and after.

One sentence on top, then the moving linkage with the weights inside their regions, then the
loads along motions before and after on common axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import pi

import numpy as np

from balance.app.answers.html.before_after import comparison_charts, comparison_section
from balance.app.answers.html.design import block
from balance.app.answers.html.filled_surface import filled_surface
from balance.app.answers.html.render import linkage_stage, render_page, rows_table
from balance.app.answers.html.scene import scene
from balance.app.answers.text.counterweights import (
    NONE_NEEDED,
    WORKSHOP,
    counterweight_rows,
)
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.dimensions import whole_dimensions
from balance.masses.counterweights.regions import Region
from balance.masses.designs.density import STEEL
from balance.motion.verification.before_after import BeforeAfter
from balance.space.spaces.design_space import DesignSpace
from balance.support.linkage_names import linkage_title
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, vector_text

SCRIPTS = ("drawing", "masses", "additions", "weights", "comparison")
# Points of a drawn circle.
AROUND = 48
# Names of the two sets of masses.
NAMES = ("before", "after")


def added_matter_page(
    space: DesignSpace,
    z: Array,
    regions: Mapping[str, Region],
    weights: Sequence[Counterweight],
    along: BeforeAfter,
    *,
    summary: str,
    report: object,
    facts: str,
    front: str = "",
    nothing: str = NONE_NEEDED,
    how: str = "",
) -> str:
    """Render the page.

    Args:
        z: parameters with the matter (bodies, 10), inertial origin, SI units.
        regions: where matter may be, by link.
        along: loads along motions before and after.
        summary: the sentence on top.
        report: what ``--json`` prints.
        facts: list of facts as HTML.
        front: table of other designs as HTML.
        nothing: what stands in place of no weights.
        how: a word before the part of a region that a weight fills.
    """
    by_link = {weight.link: weight for weight in weights}
    return render_page(
        "counterweights.html",
        stage=linkage_stage("The linkage, regions and lumps"),
        title=linkage_title(space.linkage),
        summary=summary,
        report=report,
        data={
            "scene": scene(space.linkage, space.motion, space.idle),
            "masses": [
                {"name": body.name, "given": block(body.inertia), "designed": block(p)}
                for body, p in zip(space.linkage.bodies, z, strict=True)
            ],
            "additions": [
                _addition(
                    name, region, space.frames[space.bodies.index(name)], by_link.get(name)
                )
                for name, region in regions.items()
            ],
            "comparison": comparison_charts(along.pair, NAMES),
        },
        scripts=SCRIPTS,
        facts=facts,
        lumps=rows_table(_rows_with_parts(weights, regions, nothing, how), [1, 2, 3, 4], 0),
        front=front,
        comparison=comparison_section(along.pair, NAMES),
    )


def _rows_with_parts(
    weights: Sequence[Counterweight], links: Iterable[str], nothing: str, how: str
) -> list[tuple[str, ...]]:
    """Build the table of weights, with the part of its region that each fills, if any does."""
    head, *rows = counterweight_rows(weights, links, WORKSHOP, 6, nothing)
    parts = [each for each in weights if each.form is not None]
    filled = {each.link: f"{how}{_part_in_mm(each)}" for each in parts}
    if not filled:
        return [head, *rows]
    return [(*head, "fills"), *((*row, filled.get(row[0], "")) for row in rows)]


def _part_in_mm(weight: Counterweight) -> str:
    """Say which part of its region a weight fills, in mm as in its table."""
    whole = whole_dimensions(weight)
    if whole is not None:
        return f"all of {whole.words}{_web_in_mm(weight)}"
    share = number_text(100.0 * weight.share, ".3g")
    if weight.cut is None:
        return f"{share} % of its region"
    normal, distance = weight.cut
    place = f"beyond {number_text(1e3 * distance)} mm along {vector_text(normal)}"
    return f"{share} % of its region: {place}"


def _web_in_mm(weight: Counterweight) -> str:
    """Say after a shape which web joins it to its joint; empty without one."""
    if weight.web is None:
        return ""
    length, width = (1e3 * size for size in weight.web_sizes)
    return f", and a web {number_text(width)} mm wide, {number_text(length, '.3g')} mm long"


def _addition(
    name: str, region: Region, frame: Array, weight: Counterweight | None
) -> dict[str, object]:
    """Build the drawing data of a region and the weight in it, in the inertial frame."""

    def placed(points: Array) -> list[list[float]]:
        return (points @ frame[:3, :3].T + frame[:3, 3]).round(9).tolist()

    balls = [(lump.mass, lump.position) for lump in weight.lumps] if weight else []
    if weight and not balls:
        balls = [(weight.mass, weight.com)]
    surface = None if weight is None else filled_surface(weight)
    return {
        "name": name,
        "paths": [placed(path) for path in outlines(region)],
        "lumps": [
            {
                "mass": mass,
                "at": placed(np.array([at]))[0],
                "radius": 0.0 if surface else (0.75 * mass / (pi * STEEL)) ** (1.0 / 3.0),
            }
            for mass, at in balls
        ],
        "surface": None
        if surface is None
        else {"points": placed(surface.points), "faces": surface.faces.tolist()},
    }


def outlines(region: Region) -> list[Array]:
    """Compute lines (n, 3) that show a region, in the link frame.

    Args:
        region: the region; of a hull, the edges of its triangles are drawn.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(AROUND + 1)])
    if region.kind == "sector":
        turn = region.half_angle * np.linspace(-1.0, 1.0, AROUND + 1)
        rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(AROUND + 1)])
        loop = np.vstack([np.zeros(3), rim, np.zeros(3)])
        rings = [loop + [0.0, 0.0, z] for z in (-1.0, 1.0)]
        corners = [np.array([ring[k] for ring in rings]) for k in (0, 1, AROUND + 1)]
        return [region.to_link(path) for path in (*rings, *corners)]
    if region.kind == "cylinder":
        rings = [circle + [0.0, 0.0, z] for z in (-1.0, 1.0)]
        sides = [np.array([ring[k] for ring in rings]) for k in range(0, AROUND, AROUND // 4)]
        return [region.to_link(path) for path in (*rings, *sides)]
    if region.ellipsoidal:
        return [region.to_link(np.roll(circle, k, axis=1)) for k in range(3)]
    v = region.vertices
    if region.kind == "box":
        pairs = [(a, b) for a in v for b in v if a.sum() < b.sum() and np.sum(a != b) == 1]
        return [region.to_link(np.array(pair)) for pair in pairs]
    return [region.to_link(v[[*facet, facet[0]]]) for facet in region.triangles]
