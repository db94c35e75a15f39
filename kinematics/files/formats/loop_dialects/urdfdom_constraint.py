"""``<constraint>``, as proposed to urdfdom: frames and axes on a parent and a child link."""

from __future__ import annotations

from kinematics.files.formats.loop_dialects.draft import (
    ZERO,
    Draft,
    check_spelling,
    end_name,
    read_numbers,
    write_instead,
)
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM

_PARTS = (
    "parent",
    "parent_origin",
    "parent_axis",
    "child",
    "child_origin",
    "child_axis",
    "name",
    "type",
)
# Loops about or along one axis that leave the rotation about it free: any frame of the child
# with that axis will do.
_TURNING = ("revolute", "continuous", "cylindrical", "planar")


def translate_constraint(draft: Draft, item: Element) -> None:
    """Translate a ``<constraint>`` with a parent and a child link.

    Args:
        draft: the tree of the file, which gets the loop.

    Raises:
        Refusal: it does not say enough, or has no equal among loops.
    """
    check_spelling(item, item, *_PARTS)
    names = [end_name(item, role) for role in ("parent", "child")]
    kind = item.attributes.get("type", "").strip().removesuffix("_joint")
    kind = "spherical" if kind == "ball" else kind
    if kind not in DEGREES_OF_FREEDOM:
        problem = "it closes a loop of a type that is not known"
        raise Refusal(item.label, problem, write_instead("…", *names))
    links = [draft.link(item, name, kind) for name in names]
    origins = []
    for role in ("parent_origin", "child_origin"):
        given = check_only(item, role)
        attributes = given.attributes if given is not None else {}
        if given is not None:
            check_spelling(item, given, "xyz", "rpy")
        origins.append(
            draft.origin(item, attributes.get("xyz", ZERO), attributes.get("rpy", ZERO))
        )
    axes = _axes(item, kind)
    first, second = axes.get("axis"), axes.get("axis2")
    if kind != "universal" and second is not None:
        del axes["axis2"]
        if first is not None and first.split() != second.split():
            origins[1] = _turn(draft, item, kind, origins[1], (first, second))
    sides = list(zip(links, origins, strict=True))
    draft.add_loop(item, "urdfdom", kind, sides, axes)


def _axes(item: Element, kind: str) -> dict[str, str]:
    """Find the axes of parent and child; one that is missing is that of the other."""
    if kind in ("fixed", "spherical"):
        return {}
    axes: dict[str, str] = {}
    for tag, role in (("axis", "parent_axis"), ("axis2", "child_axis")):
        axis = check_only(item, role)
        if axis is not None:
            text = " ".join(read_numbers(item, axis, axis.attributes.get("xyz", ""), 3))
            axes[tag] = text
            if not any(float(word) for word in text.split()):
                problem = f"<{role}> (line {axis.line}) is zero"
                raise Refusal(item.label, problem, 'give it a direction, such as "0 0 1"')
    if not axes or (kind == "universal" and len(axes) < 2):
        problem = f"a {kind} constraint without <parent_axis> or <child_axis>"
        raise Refusal(item.label, problem, "add both axes")
    if kind != "universal" and "axis" not in axes:
        axes["axis"] = axes["axis2"]
    return axes


def _turn(
    draft: Draft, item: Element, kind: str, origin: Element, axes: tuple[str, str]
) -> Element:
    """Turn the frame on the child so that its axis has the numbers of the parent's."""
    if kind not in _TURNING:
        problem = f"a {kind} constraint with two different axes says no relative rotation"
        remedy = "turn <child_origin> so that <child_axis> is written like <parent_axis>"
        raise Refusal(item.label, problem, remedy)
    from kinematics.files.formats.loop_dialects.file_poses import turn_between

    turned = draft.origin(item, ZERO, turn_between(*axes))
    pose = draft.poses.pose(draft.nominal_origin(origin)) @ draft.poses.pose(turned)
    return draft.poses.origin_of(pose, item.line)
