"""HTML page of a design: the moving linkage with the masses of the file and of the design.

A body is drawn as a homogeneous solid of its mass and inertia, in scale: as the ellipsoid or
the plate of the answer if its density is limited, else as a block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from balance.app.answers.html.render import facts_list, linkage_stage, render_page, rows_table
from balance.app.answers.html.scene import scene
from balance.app.answers.html.verification import verification_picture
from balance.app.answers.text.design import body_rows, design_facts, solid_rows
from balance.masses.designs.best_design import Design
from balance.masses.designs.density import solid_of
from balance.motion.verification.before_after import compare_masses
from balance.space.certification.certify_space import certify
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.linkage_names import linkage_title
from kinematics.model.arrays import freeze
from kinematics.model.motion import while_text
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

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
    masses = "with the masses given", "with the designed masses"
    return verification_picture(*loads.pair, kind=kind, masses=masses)


def block(z: Array) -> dict[str, object] | None:
    """Compute the homogeneous block of parameters z (10,); None if there is none.

    A uniform bar is its own block: it ends where the bar ends.

    Returns:
        ``shape``, ``mass`` in kg, ``centre`` (3,) and ``axes``, whose rows are the three
        semi-axes (3, 3), in metres, in the frame and about the origin of z.
    """
    solid = solid_of(mass_properties(z)) if z[0] > 0.0 else None
    if solid is None:
        return None
    # Second moments m a²/5 of an ellipsoid, and m a²/3 of a block.
    return _solid_data("block", solid.mass, solid.centre, np.sqrt(0.6) * solid.axes)


def _solid_data(shape: str, mass: float, centre: Array, axes: Array) -> dict[str, object]:
    """Return a solid as plain data."""
    return {"shape": shape, "mass": mass, "centre": centre.tolist(), "axes": axes.tolist()}


def _solids_of(design: Design) -> list[dict[str, object] | None]:
    """List the solids of the bodies, in the inertial frame.

    Bodies whose density is limited are the ellipsoids or plates of the answer, in their sizes;
    others are blocks.
    """
    assert design.z is not None
    shapes = [block(z) for z in design.z]
    space = design.space
    solids = zip(space.bodies, design.solids, space.frames, strict=True)
    for k, (name, solid, frame) in enumerate(solids):
        if solid is not None and name in design.density:
            R, origin = frame[:3, :3], frame[:3, 3]
            centre, axes = R @ solid.centre + origin, solid.axes @ R.T
            shapes[k] = _solid_data(solid.shape, solid.mass, centre, axes)
    return shapes


def design_page(design: Design) -> str:
    """Render a design as one HTML file.

    The page shows the linkage in 3D, with a slider for each degree of freedom of the motion,
    and the masses of the design and of the file as solids and centres of mass. The element
    ``report`` contains `Design.to_dict` as JSON.

    Returns:
        The text of the file.
    """
    assert design.z is not None
    given = [body.inertia for body in design.space.linkage.bodies]
    shapes = [
        {"name": name, "given": block(before), "designed": after}
        for name, before, after in zip(
            design.space.bodies, given, _solids_of(design), strict=True
        )
    ]
    return render_page(
        "design.html",
        stage=linkage_stage("The linkage and its masses"),
        title=linkage_title(design.space.linkage),
        summary=_summary(design),
        report=design.to_dict(),
        data={
            "scene": scene(design.space.linkage, design.space.motion, design.space.idle),
            "masses": shapes,
        },
        scripts=SCRIPTS,
        facts=facts_list(design_facts(_with_certainty(design))),
        designed=_table(design.bodies, design.space.length) + _solids_table(design),
        given=_table(replace(design, z=freeze(given)).bodies, design.space.length),
    )


def _with_certainty(design: Design) -> Design:
    """Return a design whose space is as certain as that of the command, if it is the same."""
    space = design.space
    if space.requirements:
        return design
    certified = certify(space)
    return replace(design, space=certified) if certified.rank == space.rank else design


def _solids_table(design: Design) -> str:
    """Render the table of the solids whose density is limited; empty without a limit."""
    if not design.density:
        return ""
    return f"<h3>Solids of their inertia</h3>\n{rows_table(solid_rows(design), [3, 4])}"


def _summary(design: Design) -> str:
    """Summarise the page in one sentence."""
    assert design.z is not None
    when = while_text(design.space.motion) or " in every motion"
    wrench = "force and moment" if design.space.balance == "dynamic" else "force"
    best = f", with the least {MINIMISED[design.minimise]}" if design.minimise else ""
    designed, given = (
        number_text(sum(float(z[0]) for z in parameters), ".4g")
        for parameters in (design.z, [body.inertia for body in design.space.linkage.bodies])
    )
    return (
        f"Masses that bodies can have and that exert no shaking {wrench}{when}{best}: "
        f"{designed} kg in all, {given} kg in the file."
    )


def _table(bodies: Sequence[BodyInertia], length: float) -> str:
    """Render the table of mass, centre of mass and principal moments of each body."""
    return rows_table(body_rows(bodies, length), [1, 2, 3], 1)
