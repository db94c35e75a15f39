"""HTML page of a design: the moving linkage with the masses of the file and of the design.

A body is drawn as the homogeneous solid ellipsoid of its mass and inertia; see
`balance.masses.designs.density.solid_of`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.scene import scene
from balance.app.answers.html.verification import verification_picture
from balance.app.answers.text.design import body_rows, design_facts
from balance.masses.designs.best_design import Design
from balance.masses.designs.density import solid_of
from balance.motion.verification.before_after import compare_masses
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.inertial_parameters.conversions import mass_properties
from kinematics.model.arrays import freeze

Array = NDArray[np.float64]

SCRIPTS = ("drawing", "masses", "weights")
MINIMISED = {
    "mass": "total mass",
    "inertia": "largest inertia",
    "rotor": "inertia felt by the inputs",
    "change": "change of the masses in the file",
}


def design_picture(design: Design, kind: str = "png") -> bytes:
    """Draw the loads along motions with the masses of the file and with those of a design."""
    assert design.z is not None
    space = design.space
    loads = compare_masses(space.linkage, design.z, motion=space.motion, balance=space.balance)
    return verification_picture(*loads.pair, kind=kind)


def ellipsoid(z: Array) -> dict[str, object] | None:
    """Compute the homogeneous ellipsoid of parameters z (10,); None if there is none.

    Returns:
        ``mass`` in kg, ``centre`` (3,) and ``axes``, whose rows are the three semi-axes
        (3, 3), in metres, in the frame and about the origin of z.
    """
    solid = solid_of(mass_properties(z)) if z[0] > 0.0 else None
    if solid is None:
        return None
    mass, centre, axes = solid.mass, solid.centre, solid.axes
    return {"mass": mass, "centre": centre.tolist(), "axes": axes.tolist()}


def design_page(design: Design) -> str:
    """Render a design as one HTML file.

    The page shows the linkage in 3D, with a slider for each degree of freedom of the motion,
    and the masses of the design and of the file as ellipsoids and centres of mass. The element
    ``report`` contains `Design.to_dict` as JSON.

    Returns:
        The text of the file.
    """
    assert design.z is not None
    given = [body.inertia for body in design.space.linkage.bodies]
    shapes = [
        {"name": name, "given": ellipsoid(before), "designed": ellipsoid(after)}
        for name, before, after in zip(design.space.bodies, given, design.z, strict=True)
    ]
    return render_page(
        "design.html",
        title=design.space.linkage.name,
        summary=_summary(design),
        report=design.to_dict(),
        data={
            "scene": scene(design.space.linkage, design.space.motion, design.space.idle),
            "masses": shapes,
        },
        scripts=SCRIPTS,
        facts=facts_list(design_facts(design)),
        designed=_table(design.bodies, design.space.length),
        given=_table(replace(design, z=freeze(given)).bodies, design.space.length),
    )


def _summary(design: Design) -> str:
    """Summarise the page in one sentence."""
    motion = design.space.motion
    when = f"with {', '.join(motion.relations)}" if motion else "in every motion"
    wrench = "force and moment" if design.space.balance == "dynamic" else "force"
    best = f", with the least {MINIMISED[design.minimise]}" if design.minimise else ""
    return f"Masses that bodies can have and that exert no shaking {wrench} {when}{best}."


def _table(bodies: Sequence[BodyInertia], length: float) -> str:
    """Render the table of mass, centre of mass and principal moments of each body."""
    return rows_table(body_rows(bodies, length), [1, 2, 3], 1)
