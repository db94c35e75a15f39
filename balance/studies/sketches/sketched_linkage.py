"""Planar linkages that were built from sketches, with their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import NamedTuple

from balance.support.result_files import write_file
from kinematics.model.linkage import Linkage, Notice
from kinematics.wording import count_noun, number_text, repr_lines

SKETCH_SCHEMA = "balance.new/1"
BASE = "base"
"""Name of the link that does not move."""


class SketchedLink(NamedTuple):
    """A link of a sketch that moves.

    Attributes:
        name: of the link.
        points: that it carries.
        length: the largest distance of two of them, metres; 0 for a slider.
        section: of its bars in words, mm; empty without one.
        mass: kg; None without ``<inertial>``.
    """

    name: str
    points: tuple[str, ...]
    length: float
    section: str
    mass: float | None


class SketchedJoint(NamedTuple):
    """A joint of a sketch.

    Attributes:
        name: of the joint.
        kind: ``"revolute"`` or ``"prismatic"``.
        parent: link that carries it.
        child: link that it carries.
        point: where it is.
        closes_loop: whether it closes a loop.
        is_input: whether it is an input.
    """

    name: str
    kind: str
    parent: str
    child: str
    point: str
    closes_loop: bool = False
    is_input: bool = False


@dataclass(frozen=True, eq=False)
class SketchedLinkage:
    """Result of `balance.studies.linkage_from_sketch`.

    Attributes:
        linkage: read from the file.
        points: by name, metres, inertial frame, complex.
        base: points of the base.
        base_by_rule: whether these are the points of one link alone, because none are given.
        links: that move.
        joints: those of the tree, and those that close loops.
        urdf: the file.
        notices: remarks on the linkage and its inputs.
    """

    linkage: Linkage
    points: Mapping[str, complex]
    base: tuple[str, ...]
    base_by_rule: bool
    links: tuple[SketchedLink, ...]
    joints: tuple[SketchedJoint, ...]
    urdf: bytes
    notices: tuple[Notice, ...] = ()

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the linkage.

        Args:
            path: file to write it to; None for none.

        Raises:
            FileError: it cannot be written.
        """
        return write_file(path, self.urdf)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/new.schema.json``."""
        return {
            "schema": SKETCH_SCHEMA,
            "linkage": self.linkage.name,
            "mobility": self.linkage.mobility,
            "inputs": list(self.linkage.inputs),
            "base": list(self.base),
            "base_by_rule": self.base_by_rule,
            "points": {name: [z.real, z.imag] for name, z in self.points.items()},
            "links": [link._asdict() for link in self.links],
            "joints": [joint._asdict() for joint in self.joints],
        }

    def __repr__(self) -> str:
        """A line for the linkage, and one for each link."""
        lines = (
            f"{link.name} {'-'.join(link.points)}: {number_text(1e3 * link.length)} mm"
            + ("" if link.mass is None else f", {number_text(link.mass)} kg")
            for link in self.links
        )
        return repr_lines(f"SketchedLinkage {self.linkage.name}: {self.words}", *lines)

    @property
    def words(self) -> str:
        """What it is, in words: ``5 moving links, 2 loops, mobility 1, inputs A``."""
        loops = sum(joint.closes_loop for joint in self.joints)
        counts = f"{count_noun(len(self.links), 'moving link')}, {count_noun(loops, 'loop')}"
        inputs = f"inputs {', '.join(self.linkage.inputs)}"
        return f"{counts}, mobility {self.linkage.mobility}, {inputs}"
