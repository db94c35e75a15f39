"""Mend what some exporters write, where only one meaning is possible; a remark names it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import PurePath

from kinematics.error_text import clean
from kinematics.model.document.element import Element

Change = Callable[[Element, list[str], str], Element]

ODDITIES = "oddities"
"""The code of the remark."""

# Number of oddities that a remark names.
MAX_NAMED = 4
# Zeros as exporters write them.
ZEROS = {"0", "0.0", "-0", "-0.0"}
_TRUTHS = ("true", "false")
_MIRRORED = {"iyx": "ixy", "izx": "ixz", "izy": "iyz"}


def mend_oddities(robot: Element, source: str) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Mend the oddities of a robot, before it is checked.

    - A ``<robot>`` without a name gets that of its file.
    - An ``<inertial>`` directly in ``<robot>`` belongs to no link, and is dropped.
    - ``rpy="0 0 0"`` of an ``<axis>`` turns nothing, and is dropped. Old files have it.
    - An ``<axis>`` of a fixed joint turns nothing, and is dropped if it is not three numbers.
    - Several ``<origin>`` of a joint with the same numbers are one.
    - ``iyx``, ``izx`` and ``izy`` of an ``<inertia>`` are ``ixy``, ``ixz`` and ``iyz``.
    - ``independent="True"`` is ``independent="true"``, in any case.
    - Limits of one position lock no joint: limits are not read, and the remark says so.

    Args:
        robot: the ``<robot>`` element, not yet checked.
        source: path of the file.

    Returns:
        The element, the same if there are no oddities, and code and message of the remark.
    """
    oddities: list[str] = []
    attributes = dict(robot.attributes)
    if robot.tag == "robot" and not robot.name.strip():
        stem = "".join(c for c in PurePath(source).stem if c.isprintable()).strip("<> ")
        attributes["name"] = stem or "robot"
        oddities.append(f"{robot.label} has no name, that of the file is taken")
    children = tuple(item for child in robot.children for item in _mend_child(child, oddities))
    if not oddities:
        return robot, ()
    more = f"; and {len(oddities) - MAX_NAMED} more" if len(oddities) > MAX_NAMED else ""
    text = f"{clean(source, 1000)}: {'; '.join(oddities[:MAX_NAMED])}{more}"
    return replace(robot, attributes=attributes, children=children), ((ODDITIES, text),)


def _mend_child(item: Element, oddities: list[str]) -> Iterator[Element]:
    """Yield a child of the robot as it is meant, and append what was odd about it."""
    if item.tag == "inertial":
        oddities.append(f"{item.label} is in no link, and is not read")
        return
    if item.tag == "link":
        yield _map_path(item, ("inertial", "inertia"), _mend_inertia, oddities)
    elif item.tag in ("joint", "loop"):
        _note_empty_range(item, oddities)
        item = _drop_idle_axis(_mend_mark(item, oddities), oddities)
        item = _drop_repeated_origins(item, oddities)
        yield _map_path(item, ("axis",), _mend_axis, oddities)
    else:
        yield item


def _note_empty_range(item: Element, oddities: list[str]) -> None:
    """Append that limits of one position are not read."""
    limit = item.first("limit")
    given = {} if limit is None else limit.attributes
    try:
        empty = float(given["lower"]) == float(given["upper"])
    except (KeyError, ValueError):
        return
    if empty and item.attributes.get("type") in ("revolute", "prismatic"):
        oddities.append(
            f"{item.label} has limits of one position, which are not read: it moves; write "
            'type="fixed" to lock it'
        )


def _map_path(
    item: Element, path: Sequence[str], change: Change, oddities: list[str], label: str = ""
) -> Element:
    """Change the elements at the end of a path of tags, and keep all others."""
    label = label or item.label
    if not path:
        return change(item, oddities, label)
    children = tuple(
        _map_path(child, path[1:], change, oddities, label) if child.tag == path[0] else child
        for child in item.children
    )
    same = all(a is b for a, b in zip(children, item.children, strict=True))
    return item if same else replace(item, children=children)


def _mend_inertia(inertia: Element, oddities: list[str], label: str) -> Element:
    """Rename the entries below the diagonal, unless they contradict those above it."""
    given = inertia.attributes
    below = {name: above for name, above in _MIRRORED.items() if name in given}
    if not below or any(
        given.get(above, given[name]) != given[name] for name, above in below.items()
    ):
        return inertia
    oddities.append(f"{label} has {', '.join(f'{a} for {b}' for a, b in below.items())}")
    return replace(inertia, attributes={below.get(name, name): given[name] for name in given})


def _mend_axis(axis: Element, oddities: list[str], label: str) -> Element:
    """Drop angles of zero."""
    angles = axis.attributes.get("rpy")
    if angles is None or not set(angles.split()) <= ZEROS:
        return axis
    oddities.append(f"{label} has an <axis rpy> of zeros")
    kept = {name: value for name, value in axis.attributes.items() if name != "rpy"}
    return replace(axis, attributes=kept)


def _drop_idle_axis(item: Element, oddities: list[str]) -> Element:
    """Drop axes of a fixed joint that are numbers, but not three of them."""
    if item.tag != "joint" or item.attributes.get("type") != "fixed":
        return item
    idle = [child for child in item.children if child.tag == "axis" and _is_idle(child)]
    if not idle:
        return item
    oddities.append(f"{item.label} is fixed, and its <axis> is not three numbers, nor read")
    return replace(item, children=tuple(c for c in item.children if c not in idle))


def _is_idle(axis: Element) -> bool:
    """Whether the only attribute of an axis is a list of numbers that are not three."""
    words = axis.attributes.get("xyz", "").split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return False
    return set(axis.attributes) == {"xyz"} and len(numbers) != 3


def _drop_repeated_origins(item: Element, oddities: list[str]) -> Element:
    """Keep the first of several origins of a joint, if all have the same numbers."""
    first, *others = [child for child in item.children if child.tag == "origin"] or [item]
    place = _place(first)
    if not others or place is None or any(_place(other) != place for other in others):
        return item
    oddities.append(f"{item.label} has the same <origin> {len(others) + 1} times")
    kept = tuple(c for c in item.children if c.tag != "origin" or c is first)
    return replace(item, children=kept)


def _place(origin: Element) -> tuple[list[float], ...] | None:
    """Return the numbers of an origin; None if it is no origin, or holds anything else."""
    strange = origin.children or not set(origin.attributes) <= {"xyz", "rpy"}
    if origin.tag != "origin" or strange:
        return None
    try:
        return tuple(
            [float(word) for word in origin.attributes.get(name, "0 0 0").split()]
            for name in ("xyz", "rpy")
        )
    except ValueError:
        return None


def _mend_mark(item: Element, oddities: list[str]) -> Element:
    """Write the mark of inputs in lower case."""
    value = item.attributes.get("independent", "true")
    meant = value.strip().lower()
    if value in _TRUTHS or meant not in _TRUTHS:
        return item
    oddities.append(f'{item.label} has independent="{clean(value)}" for "{meant}"')
    return replace(item, attributes={**item.attributes, "independent": meant})
