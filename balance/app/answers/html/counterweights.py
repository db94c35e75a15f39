"""HTML page of counterweights: the moving linkage with regions, lumps and masses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.design import ellipsoid
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.scene import scene
from balance.app.answers.text.counterweights import counterweight_rows, counterweights_facts
from balance.masses.counterweights.answer import Counterweights
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.regions import Region

Array = NDArray[np.float64]

SCRIPTS = ("drawing", "masses", "additions", "weights")
# Points of a drawn circle.
AROUND = 48


def counterweights_page(counterweights: Counterweights) -> str:
    """Render counterweights as one HTML file.

    The page shows the linkage in 3D, with a slider for each degree of freedom of the motion,
    the regions as outlines, the lumps, and the masses before and after as ellipsoids. The
    element ``report`` contains `Counterweights.to_dict` as JSON.

    Returns:
        The text of the file.
    """
    assert counterweights.z is not None
    space = counterweights.space
    masses = [
        {"name": body.name, "given": ellipsoid(body.inertia), "designed": ellipsoid(z)}
        for body, z in zip(space.linkage.bodies, counterweights.z, strict=True)
    ]
    weights = {weight.link: weight for weight in counterweights.weights}
    additions = [
        _addition(name, region, space.frames[space.bodies.index(name)], weights.get(name))
        for name, region in counterweights.regions.items()
    ]
    wrench = "force and moment" if space.balance == "dynamic" else "force"
    return render_page(
        "counterweights.html",
        title=space.linkage.name,
        summary=f"Matter added inside regions of links that cancels the shaking {wrench}.",
        report=counterweights.to_dict(),
        data={
            "scene": scene(space.linkage, space.motion, space.idle),
            "masses": masses,
            "additions": additions,
        },
        scripts=SCRIPTS,
        facts=facts_list(counterweights_facts(counterweights)),
        lumps=rows_table(counterweight_rows(counterweights.weights), [1, 2, 3, 4], 0),
    )


def _addition(
    name: str, region: Region, frame: Array, weight: Counterweight | None
) -> dict[str, object]:
    """Build the drawing data of a region and its lumps, in the inertial frame."""
    lumps = [(lump.mass, lump.position) for lump in weight.lumps] if weight else []
    if weight and not lumps:
        lumps = [(weight.mass, weight.com)]
    return {
        "name": name,
        "paths": [
            (path @ frame[:3, :3].T + frame[:3, 3]).round(9).tolist()
            for path in outlines(region)
        ],
        "lumps": [
            {"mass": mass, "at": (frame[:3, :3] @ at + frame[:3, 3]).round(9).tolist()}
            for mass, at in lumps
        ],
    }


def outlines(region: Region) -> list[Array]:
    """Compute lines (n, 3) that show a region, in the link frame.

    Args:
        region: the region; of a hull, the edges of its triangles are drawn.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(AROUND + 1)])
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
