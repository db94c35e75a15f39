"""Find and remove round-off in the numbers of a file, such as ``3.23109e-15 -2.88922e-15 1``.

Exporters compose displacements in double precision, and write what is left, in the exponent
notation of a program. A component of an axis so written and below 1e-12 of the largest one
turns the axis by less than the angle within which an angle of the file is a multiple of π/12:
it is zero, and so is such an angle of an origin, and a coordinate below 3e-14 of the largest of
all origins, unless the user chooses ``as_written``. Remarks name the places. A number with as
many decimals, ``0.00000000000003``, is within the digits of the file, and stays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from kinematics.error_text import clean
from kinematics.model.document.element import Element
from kinematics.numerics.tolerances import EXACT_ANGLE_ERROR, ORIGIN_ROUND_OFF

AXIS_NOISE = "axis_noise"
"""The code of the remark on such axes."""

ORIGIN_NOISE = "origin_noise"
"""The code of the remark on such origins."""

# Number of axes that a remark names.
MAX_NAMED = 3
_TAGS = ("axis", "axis2")


def remove_exporter_noise(
    tree: Element, source: str
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Write zeros for the components of axes and origins that are round-off.

    Args:
        tree: checked tree of the file.
        source: name of the file in messages.

    Returns:
        The tree, the same if there is no round-off, and codes and messages of the remarks.
    """
    remarks = []
    axes = f"components of axes below {float(EXACT_ANGLE_ERROR):.0e} of the largest"
    origins = (
        f"coordinates of origins below {ORIGIN_ROUND_OFF:.0e} of the largest, and angles below "
        f"{float(EXACT_ANGLE_ERROR):.0e},"
    )
    for code, what, clean_part in (
        (AXIS_NOISE, axes, _clean_axis),
        (ORIGIN_NOISE, origins, _origin_cleaner(tree)),
    ):
        children = tuple(_without_noise(item, clean_part) for item in tree.children)
        changed = [
            before.label
            for before, after in zip(tree.children, children, strict=True)
            if before is not after
        ]
        if not changed:
            continue
        tree = replace(tree, children=children)
        more = f" and {len(changed) - MAX_NAMED} more" if len(changed) > MAX_NAMED else ""
        remarks.append(
            (
                code,
                (
                    f"{clean(source, 1000)}: {what} are read as zero: "
                    f"{', '.join(changed[:MAX_NAMED])}{more}; --as-written "
                    "(angles='as_written') takes them"
                ),
            )
        )
    return tree, tuple(remarks)


def _without_noise(item: Element, clean_part: Callable[[Element], Element]) -> Element:
    """Return a joint or loop without round-off in parts of it, or the same element."""
    if item.tag not in ("joint", "loop", "predecessor", "successor"):
        return item
    children = tuple(_without_noise(clean_part(child), clean_part) for child in item.children)
    if all(a is b for a, b in zip(children, item.children, strict=True)):
        return item
    return replace(item, children=children)


def _clean_axis(axis: Element) -> Element:
    """Return an axis with zeros in place of round-off, or the same element."""
    if axis.tag not in _TAGS:
        return axis
    words = axis.attributes["xyz"].split()
    return _with_zeros(
        axis, "xyz", float(EXACT_ANGLE_ERROR) * max(abs(float(x)) for x in words)
    )


def _origin_cleaner(tree: Element) -> Callable[[Element], Element]:
    """Make what returns an origin with zeros in place of round-off, or the same element."""
    lengths = [
        abs(float(word))
        for item in tree.children
        if item.tag in ("joint", "loop")
        for part in item.walk()
        if part.tag == "origin"
        for word in part.attributes.get("xyz", "").split()
    ]
    least = ORIGIN_ROUND_OFF * max(lengths, default=0.0)

    def clean_origin(origin: Element) -> Element:
        if origin.tag != "origin":
            return origin
        shifted = _with_zeros(origin, "xyz", least)
        return _with_zeros(shifted, "rpy", float(EXACT_ANGLE_ERROR))

    return clean_origin


def _with_zeros(item: Element, name: str, least: float) -> Element:
    """Write zeros for numbers of an attribute in exponent notation that are below a size."""
    words = item.attributes.get(name, "").split()
    kept = ["0" if "e" in x.lower() and 0.0 < abs(float(x)) < least else x for x in words]
    if kept == words:
        return item
    return replace(item, attributes={**item.attributes, name: " ".join(kept)})
