"""Find and remove round-off in the axes of a file, such as ``3.23109e-15 -2.88922e-15 1``.

Exporters compose rotations in double precision, and write what is left, in the exponent
notation of a program. A component so written and below 1e-12 of the largest one turns the axis
by less than the angle within which an angle of the file is a multiple of π/12: it is zero,
unless the user chooses ``as_written``. A remark names the axes. A component with as many
decimals, ``0.00000000000003``, is within the digits of the file, and stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from kinematics.error_text import clean
from kinematics.tolerances import EXACT_ANGLE_ERROR
from kinematics.urdf_elements.element import Element

__all__ = ["AXIS_NOISE", "remove_axis_noise"]

AXIS_NOISE = "axis_noise"
"""The code of the remark on such axes."""

# Number of axes that a remark names.
MAX_NAMED = 3
_TAGS = ("axis", "axis2")


def remove_axis_noise(
    tree: Element, source: str
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Write zeros for the components of axes that are round-off.

    Args:
        tree: checked tree of the file.
        source: name of the file in messages.

    Returns:
        The tree, the same if there is no round-off, and code and message of the remark.
    """
    children = tuple(_without_noise(item) for item in tree.children)
    changed = [
        before.label for before, after in zip(tree.children, children, strict=True)
        if before is not after
    ]  # fmt: skip
    if not changed:
        return tree, ()
    more = f" and {len(changed) - MAX_NAMED} more" if len(changed) > MAX_NAMED else ""
    text = (
        f"{clean(source, 1000)}: components of axes below {float(EXACT_ANGLE_ERROR):.0e} of "
        f"the largest are read as zero: {', '.join(changed[:MAX_NAMED])}{more}; --as-written "
        "(angles='as_written') takes them"
    )
    return replace(tree, children=children), ((AXIS_NOISE, text),)


def _without_noise(item: Element) -> Element:
    """Return a joint or loop without round-off in its axes, or the same element."""
    if item.tag not in ("joint", "loop"):
        return item
    new = {k: axis for k, child in enumerate(item.children) for axis in _clean_axis(child)}
    if not new:
        return item
    return replace(
        item, children=tuple(new.get(k, child) for k, child in enumerate(item.children))
    )


def _clean_axis(axis: Element) -> Iterator[Element]:
    """Yield an axis with zeros in place of round-off, if it has any."""
    if axis.tag not in _TAGS:
        return
    words = axis.attributes["xyz"].split()
    sizes = [abs(float(word)) for word in words]
    least = float(EXACT_ANGLE_ERROR) * max(sizes)
    noise = [
        0.0 < size < least and "e" in word.lower()
        for word, size in zip(words, sizes, strict=True)
    ]
    if any(noise):
        kept = ["0" if is_noise else word for word, is_noise in zip(words, noise, strict=True)]
        yield replace(axis, attributes={**axis.attributes, "xyz": " ".join(kept)})
