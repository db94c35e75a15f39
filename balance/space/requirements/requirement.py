"""A requirement as text: what must vanish, and where.

    QUANTITY [AXES] [about POINT] [REGION]

``QUANTITY`` is ``dynamic``, ``force``, ``moment``, ``decoupled`` or ``gravity``; ``AXES`` are
some of ``x,y,z``, of a force or a moment; ``POINT`` is ``x,y,z`` in metres or ``com``, of a
moment. ``REGION`` is ``everywhere`` (the default), ``at u1=0.3``, ``along u2=u3``, ``along
FILE.csv`` or ``up to order 2 [about u1=0.3]``. Displacements count from the reference pose, in
radians and metres.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from math import isfinite
from typing import NamedTuple

from kinematics.errors import UsageError

QUANTITIES = ("dynamic", "force", "moment", "decoupled", "gravity")
EXAMPLES = (
    "write 'force; dynamic at u1=0.3; moment about 0,0,0.2 along u2=u3; dynamic up to order 2 "
    "about u1=0.3; gravity; force x,y; decoupled'"
)
# Highest order of a region, as of a design space.
MAX_ORDER = 20
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_POINT = rf"{_NUMBER}\s*,\s*{_NUMBER}\s*,\s*{_NUMBER}"
_FORM = re.compile(
    rf"(?P<quantity>{'|'.join(QUANTITIES)})"
    r"(?:\s+(?P<axes>[xyz](?:\s*,\s*[xyz])*))?"
    rf"(?:\s+about\s+(?P<about>com|{_POINT}))?"
    r"(?:\s+(?:(?P<everywhere>everywhere)|at\s+(?P<pose>\S.*)|along\s+(?P<along>\S.*)"
    r"|up\s+to\s+order\s+(?P<order>\d+)(?:\s+about\s+(?P<near>\S.*))?))?"
)

Point = tuple[Fraction, Fraction, Fraction]


class Requirement(NamedTuple):
    """A requirement: what vanishes, and where.

    Attributes:
        text: the requirement as it was written, with single spaces.
        quantity: one of ``QUANTITIES``.
        axes: components that count, such as ``"xy"``; empty for all.
        about: point of a moment (3,), metres, inertial frame; ``"com"`` for the centre of mass;
            None for the inertial origin.
        pose: displacements of inputs, by name, of the pose of the region; None without a pose.
        order: highest order of derivative at that pose, or at the reference pose; None where
            all orders count.
        relations: those of a motion, each ``"sum = sum"`` or ``"input = expression"``.
        path: file of a path; empty without one.
    """

    text: str
    quantity: str
    axes: str = ""
    about: Point | str | None = None
    pose: tuple[tuple[str, float], ...] | None = None
    order: int | None = None
    relations: tuple[str, ...] = ()
    path: str = ""

    def __repr__(self) -> str:
        """One line: the text."""
        return f"Requirement: {self.text}"

    @property
    def region(self) -> tuple[object, ...]:
        """What tells the region from others."""
        return self.pose, self.order, self.relations, self.path

    @property
    def masses_alone(self) -> bool:
        """Whether masses and first moments are all that it is about."""
        return self.quantity in ("force", "gravity")

    @property
    def whole(self) -> bool:
        """Whether all components of the momentum count, or all of the linear one."""
        return self.quantity in ("dynamic", "force") and not self.axes


def read_requirements(texts: str | Sequence[str]) -> tuple[Requirement, ...]:
    """Read requirements, in a canonical order and each once.

    Args:
        texts: one or several texts, each of one requirement or several with ``;`` between.

    Raises:
        UsageError: a text is none, or a moment about the centre of mass stands alone.
    """
    parts = [
        part
        for text in ([texts] if isinstance(texts, str) else texts)
        for part in text.split(";")
    ]
    read = {item.text: item for item in map(_read_requirement, parts)}
    listed = tuple(read[text] for text in sorted(read))
    if not listed:
        raise UsageError(f"there is no requirement: {EXAMPLES}")
    for item in listed:
        if item.about == "com" and not _force_vanishes(item, listed):
            raise UsageError(
                f"requirement '{item.text}': a moment about the centre of mass is linear "
                "in the masses only where no force is left: require force there too, or give a "
                "point"
            )
    return listed


def _force_vanishes(item: Requirement, listed: Sequence[Requirement]) -> bool:
    """Whether another requirement says that no force is left in a region."""
    everywhere = (None, None, (), "")
    return any(other.whole and other.region in (everywhere, item.region) for other in listed)


def _read_requirement(text: str) -> Requirement:
    """Read one requirement; see the module."""
    words = " ".join(text.split())
    form = _FORM.fullmatch(words)
    if form is None:
        raise UsageError(f"requirement '{words[:80]}' cannot be read: {EXAMPLES}")
    quantity, about, order = form["quantity"], form["about"], form["order"]
    axes = "".join(axis for axis in "xyz" if axis in (form["axes"] or ""))
    if axes and quantity not in ("force", "moment"):
        raise _refusal(words, f"'{quantity}' has no axes: they are those of force and moment")
    if about and quantity != "moment":
        raise _refusal(words, f"'{quantity}' is about no point: only a moment is")
    point = about and (about if about == "com" else _point(about))
    pose = form["pose"] or form["near"]
    place = None if pose is None else _displacements(words, pose)
    if order and int(order) > MAX_ORDER:
        raise _refusal(words, f"the highest order is {MAX_ORDER}")
    highest = int(order) if order else 0 if form["pose"] else None
    along = form["along"] or ""
    path = along if along.lower().endswith(".csv") else ""
    relations = () if path or not along else tuple(part.strip() for part in along.split(","))
    if quantity == "decoupled" and (path or highest is not None):
        raise _refusal(words, "decoupling is asked for everywhere, or along linear relations")
    return Requirement(words, quantity, axes, point, place, highest, relations, path)


def _refusal(text: str, problem: str) -> UsageError:
    """Build the exception for a requirement that cannot be used."""
    return UsageError(f"requirement '{text}': {problem}")


def _point(text: str) -> Point:
    """Read a point ``x,y,z``."""
    x, y, z = (Fraction(word.strip()) for word in text.split(","))
    return x, y, z


def _displacements(text: str, pose: str) -> tuple[tuple[str, float], ...]:
    """Read displacements ``u1=0.3,u2=-0.1`` of inputs; all others stay at 0."""
    pairs = [word.rpartition("=") for word in pose.split(",")]
    try:
        values = {name.strip(): float(value) for name, _, value in pairs}
    except ValueError:
        values = {}
    if len(values) < len(pairs) or not all(values) or not all(map(isfinite, values.values())):
        raise _refusal(text, f"'{pose}' is no pose: write u1=0.3,u2=-0.1 with each input once")
    return tuple(sorted(values.items()))
