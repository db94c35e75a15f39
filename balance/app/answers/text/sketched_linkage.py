"""Text of a linkage from a sketch for ``balance new``.

`SketchedLinkage.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import shlex

from balance.app.answers.answer import MISSING, AnswerBody, AnswerTable, Facts
from balance.studies.sketches.sketched_linkage import SketchedJoint, SketchedLinkage
from kinematics.wording import number_text

LINK_HEAD = ("link", "points", "length (mm)", "section (mm)", "mass (g)")
JOINT_HEAD = ("joint", "x (mm)", "y (mm)", "links", "type")


def sketch_body(sketch: SketchedLinkage, path: str) -> AnswerBody:
    """Build what is printed on a linkage from a sketch, and the commands that come next.

    Args:
        path: of its file.
    """
    base = ", ".join(sketch.base) or MISSING
    rule = " (the points that one link alone has; base=… in --links sets others)"
    file = shlex.quote(path)
    links: list[tuple[str, ...]] = [LINK_HEAD]
    for link in sketch.links:
        mass = MISSING if link.mass is None else _thousandfold(link.mass)
        length = _thousandfold(link.length) if link.length else MISSING
        links.append((link.name, ", ".join(link.points), length, link.section, mass))
    joints = [JOINT_HEAD, *(_joint_row(sketch, joint) for joint in sketch.joints)]
    massless = all(link.mass is None for link in sketch.links)
    return [
        Facts(
            [
                ("written", path),
                ("linkage", f"{sketch.linkage.name}, {sketch.words}"),
                ("base", base + rule * sketch.base_by_rule),
            ]
        ),
        "",
        AnswerTable(links, "<<><>"),
        "",
        AnswerTable(joints, "<>><"),
        "",
        Facts(
            [
                ("next", f"balance report {file}"),
                ("", f"balance {'design' if massless else 'verify'} {file}"),
            ]
        ),
    ]


def _joint_row(sketch: SketchedLinkage, joint: SketchedJoint) -> tuple[str, ...]:
    """Build the row of a joint."""
    point = sketch.points[joint.point]
    notes = (", closes a loop" * joint.closes_loop) + (", input" * joint.is_input)
    return (
        joint.name,
        *(_thousandfold(x) for x in (point.real, point.imag)),
        f"{joint.parent}, {joint.child}",
        f"{joint.kind}{notes}",
    )


def _thousandfold(value: float) -> str:
    """Write metres in millimetres, or kilograms in grams."""
    return number_text(1e3 * value, ".6g")
