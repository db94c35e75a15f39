"""``<loop_joint>`` of old versions of Drake and of Isaac Sim: frames on two links, one axis."""

from __future__ import annotations

from kinematics.error_text import clean
from kinematics.files.formats.loop_dialects.draft import (
    ZERO,
    Draft,
    check_spelling,
    end_name,
    write_instead,
)
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM


def translate_loop_joint(draft: Draft, item: Element) -> None:
    """Translate a ``<loop_joint>``: the axis is given in the frame on the first link.

    Args:
        draft: the tree of the file, which gets the loop.

    Raises:
        Refusal: it does not say enough, or has no equal among loops.
    """
    check_spelling(item, item, "link1", "link2", "axis", "name", "type", "independent")
    kind = item.attributes.get("type", "revolute").strip()
    kind = "spherical" if kind == "ball" else kind
    names = [end_name(item, role) for role in ("link1", "link2")]
    if kind not in DEGREES_OF_FREEDOM or kind == "universal":
        problem = f"it closes a loop, and no loop is of type '{clean(kind)}' with one axis"
        raise Refusal(item.label, problem, write_instead("…", *names))
    sides = []
    for role, name in zip(("link1", "link2"), names, strict=True):
        link, side = draft.link(item, name, kind, grounded=True), check_only(item, role)
        if side is None:
            problem = f'no <{role} link="…" xyz="…"/>: the place of the loop is not given'
            raise Refusal(item.label, problem, write_instead(kind, *names))
        check_spelling(item, side, "link", "xyz", "rpy")
        given = side.attributes
        sides.append((link, draft.origin(item, given.get("xyz", ZERO), given.get("rpy", ZERO))))
    axis = check_only(item, "axis")
    axes = {"axis": axis.attributes.get("xyz", "")} if axis is not None else {}
    if kind in ("fixed", "spherical"):
        axes = {}
    draft.add_loop(item, "loop_joint", kind, sides, axes)
