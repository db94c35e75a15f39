"""Payloads: a mass at a point of a link that is not in the file, or a range of masses.

What vanishes is linear in the load. Least squares over a range ``low … high`` of loads, all as
likely, are those at the mean load, and beside them a constant:

    1/(b - a) ∫ |r + m p|² dm = |r + m̄ p|² + (b - a)²/12 |p|².

Matter that does not move is therefore best for the mean load.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.support.units import read_quantity
from kinematics.closure.joint_positions import with_bodies
from kinematics.error_text import did_you_mean
from kinematics.errors import BodyError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import GROUND, Body, Linkage, Notice
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, vector_text

FORM = "write tool=2, tool@0,0,0.1=0.5 or tool=0:2"
# Largest load, kg, and largest coordinate, metres.
MAX_LOAD, MAX_COORDINATE = 1e9, 1e6
# Name of the body that a payload is beside the bodies of the file.
PAYLOAD_BODY = "payload"


class Payload(NamedTuple):
    """A load at a point of a link.

    Attributes:
        text: the text that asked for it.
        link: name of the link.
        point: in the frame of the link (3,), metres.
        low: least load, kg.
        high: greatest load, kg; that of `low` for one load.
    """

    text: str
    link: str
    point: tuple[float, float, float]
    low: float
    high: float

    def __repr__(self) -> str:
        """Give one line: load, link and point."""
        return f"Payload: {self.words}"

    @property
    def mean(self) -> float:
        """The load in the middle of the range, kg."""
        return 0.5 * (self.low + self.high)

    @property
    def varies(self) -> bool:
        """Whether it is a range of loads."""
        return self.low < self.high

    @property
    def words(self) -> str:
        """The load in words."""
        loads = number_text(self.low)
        if self.varies:
            loads += f" to {number_text(self.high)}"
        return f"{loads} kg at {self.link} {vector_text(self.point)}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "link": self.link,
            "point": list(self.point),
            "low": self.low,
            "high": self.high,
            "mean": self.mean,
        }


def read_payload(text: str) -> Payload:
    """Read a payload.

    Args:
        text: ``LINK=KG``, ``LINK@X,Y,Z=KG`` or ``LINK=LOW:HIGH``, with units or without; the
            point is in the frame of the link, its origin by default.

    Raises:
        UsageError: the text has another form, a load is negative, or the range is empty.

    Example:
        >>> from balance.masses import read_payload
        >>> read_payload("tool@0,0,100mm=0:2")
        Payload: 0 to 2 kg at tool (0, 0, 0.1)
    """
    name, _, loads = text.rpartition("=")
    link, at, place = name.strip().partition("@")
    words = place.split(",") if at else ["0", "0", "0"]
    parts = loads.split(":")
    if not link or len(words) != 3 or len(parts) > 2:
        raise UsageError(f"payload '{text}' has no known form: {FORM}")
    try:
        x, y, z = (read_quantity(word, "length") for word in words)
        low, high = (read_quantity(part, "mass") for part in (parts[0], parts[-1]))
    except UsageError as error:
        raise UsageError(f"payload '{text}': {error}; {FORM}") from None
    if not max(map(abs, (x, y, z))) <= MAX_COORDINATE:
        raise UsageError(f"payload '{text}': a coordinate is beyond {MAX_COORDINATE:g} m")
    if low < 0.0:
        raise UsageError(f"payload '{text}': a load is not negative: give 0 kg or more")
    if not (low <= high and 0.0 < high <= MAX_LOAD):
        raise UsageError(
            f"payload '{text}': give a load above 0 and up to {MAX_LOAD:g} kg, or a range "
            "low:high of them"
        )
    return Payload(text, link, (x, y, z), low, high)


def carrying(
    linkage: LinkageLike,
    payload: Payload | str,
    load: float | None = None,
    *,
    apart: bool = False,
) -> Linkage:
    """Add a payload to the masses of a linkage, for all that is computed with it.

    The file of the linkage does not change, nor what is written from it, as long as masses are
    not merged into those of the link.

    Args:
        linkage: the linkage, or what `kinematics.load` accepts.
        payload: the payload, or its text.
        load: kg; by default its mean.
        apart: whether it becomes a body of its own, of the name ``payload``, on the same link:
            for designs, which keep it; otherwise it is part of the body of the link.

    Raises:
        BodyError: the link is unknown, is the ground, or carries no parameters.

    Example:
        >>> import balance, kinematics
        >>> linkage = balance.masses.carrying(kinematics.load("robot.urdf"), "crank=0.5")
        >>> balance.counterweights(linkage, ["crank", "rocker"]).verdict
        'infeasible'
    """
    linkage = as_linkage(linkage)
    asked = read_payload(payload) if isinstance(payload, str) else payload
    b = _body_of(linkage, asked)
    mass = asked.mean if load is None else load
    z = point_parameters(linkage, asked, mass)
    notice = Notice("payload", f"a payload of {number_text(mass)} kg is carried: {asked.words}")
    body = linkage.bodies[b]
    if apart:
        planar, spatial = (
            replace(chain, links=freeze([*chain.links, chain.links[b]], np.int64))
            for chain in (linkage.chain, linkage.spatial_chain)
        )
        return replace(
            linkage,
            bodies=(*linkage.bodies, Body(PAYLOAD_BODY, body.link, freeze(z), body.frame)),
            frames=freeze([*linkage.frames, linkage.frames[b]]),
            chain=planar,
            spatial_chain=spatial,
            notices=(*linkage.notices, notice),
        )
    told = replace(linkage, notices=(*linkage.notices, notice))
    return with_parameters(told, {b: body.inertia + z})


def point_parameters(linkage: Linkage, payload: Payload, load: float) -> Array:
    """Compute parameters (10,) of a load at its point, about the inertial origin, SI units."""
    pose = linkage.places[payload.link].pose
    p = np.append(pose[:3, :3] @ np.array(payload.point) + pose[:3, 3], 1.0)
    return from_pseudo_inertia(load * np.outer(p, p))


def with_parameters(linkage: Linkage, parameters: Mapping[int, Array]) -> Linkage:
    """Replace parameters (10,) of bodies, by their positions."""
    bodies = [
        replace(body, inertia=freeze(parameters[b])) if b in parameters else body
        for b, body in enumerate(linkage.bodies)
    ]
    return with_bodies(linkage, bodies)


def _body_of(linkage: Linkage, payload: Payload) -> int:
    """Find the body of the link that carries a payload.

    Raises:
        BodyError: the link is unknown, is the ground, or carries no parameters.
    """
    name = payload.link
    if name not in linkage.places:
        raise BodyError(
            linkage.source,
            name,
            f"there is no such link{did_you_mean(name, linkage.places)}; "
            f"the links are {', '.join(linkage.places)}",
        )
    link = linkage.places[name].link
    if link == GROUND:
        raise BodyError(
            linkage.source,
            name,
            "is part of the ground, which carries any payload: name a link that moves",
        )
    for b, body in enumerate(linkage.bodies):
        if body.link == link:
            return b
    raise BodyError(
        linkage.source,
        name,
        "carries no inertial parameters, so none of a payload: use --bodies all, or give it a "
        "mass",
    )
