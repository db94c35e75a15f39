"""Write a tree of elements as text, and numbers and poses as attributes of elements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from kinematics.model.document.element import Element
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import ROTATION_ROUND_OFF

# Characters that are written otherwise. In text, beside those of XML, only the end of a line
# that a parser would convert; in attributes all that it would turn into blanks. The library's
# `xml.sax.saxutils` does the same, and imports what opens addresses of the web.
_IN_TEXT = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
_IN_ATTRIBUTES = _IN_TEXT | str.maketrans({'"': "&quot;", "\n": "&#10;", "\t": "&#9;"})


def number_words(values: Iterable[float]) -> str:
    """Write numbers with all their digits, separated by blanks: ``0.5 0 -1``."""
    texts = (repr(float(value) + 0.0) for value in values)
    return " ".join(text.removesuffix(".0") for text in texts)


def element_text(tree: Element) -> str:
    """Write a tree of elements as the text of an XML file, indented by two blanks."""
    return "\n".join(['<?xml version="1.0"?>', *element_lines(tree, "")]) + "\n"


def element_lines(item: Element, margin: str) -> Iterator[str]:
    """Yield the lines of an element, indented by two blanks.

    Its text stands in the line of its begin tag, before its children, with its own line breaks.

    Args:
        margin: text before each line.
    """
    pairs = (
        f' {key}="{value.translate(_IN_ATTRIBUTES)}"' for key, value in item.attributes.items()
    )
    head = f"{margin}<{item.tag}{''.join(pairs)}"
    text = item.text.translate(_IN_TEXT)
    if not item.children:
        yield f"{head}>{text}</{item.tag}>" if text else f"{head}/>"
        return
    yield f"{head}>{text}"
    for child in item.children:
        yield from element_lines(child, f"{margin}  ")
    yield f"{margin}</{item.tag}>"


def roll_pitch_yaw(R: Array) -> list[float]:
    """Compute roll, pitch and yaw of a rotation ``Rz(yaw) Ry(pitch) Rx(roll)``; radians.

    Where the pitch is nearly a right angle, roll and yaw turn about nearly the same axis and
    neither is determined well; the yaw is taken from ``R Rx(roll)ᵀ``, so that it compensates
    the error of the roll, and the rotation is reproduced to round-off.

    Args:
        R: rotation matrix (3, 3).
    """
    R = np.where(np.abs(R) <= ROTATION_ROUND_OFF, 0.0, R)
    flat = float(np.hypot(R[2, 1], R[2, 2]))
    roll = float(np.arctan2(R[2, 1], R[2, 2])) if flat else 0.0
    pitch = float(np.arctan2(-R[2, 0], flat))
    across = np.cos(roll) * R[:, 1] - np.sin(roll) * R[:, 2]
    return [roll, pitch, float(np.arctan2(-across[0], across[1]))]
