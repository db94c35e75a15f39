"""Variants of a linkage: a remedy is built in, with new masses still to be found."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from balance.masses.counterweights.regions import Region
from balance.masses.designs.write_urdf import append_to_file
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document.element import Document, Element


@dataclass(frozen=True, eq=False)
class Variant:
    """A linkage with a remedy built in.

    Attributes:
        remedy: name of the remedy in `balance.masses.remedies.catalogue`.
        words: what is built in where, in one line.
        urdf: the linkage. New links without an ``<inertial>`` carry no mass yet.
        free: links to which matter may be added, new and old.
        regions: where, for new links; see `balance.counterweights`.
        massless: new links that never carry mass.
        motion: relations between inputs besides those of the request.
        new_links: links that the remedy adds.
        new_joints: joints and loops that it adds.
        inputs: names of the inputs; None for those of the linkage.
        details: plain data about it.
    """

    remedy: str
    words: str
    urdf: Document
    free: tuple[str, ...]
    regions: Mapping[str, Region | str] = field(default_factory=dict)
    massless: tuple[str, ...] = ()
    motion: tuple[str, ...] = ()
    new_links: tuple[str, ...] = ()
    new_joints: tuple[str, ...] = ()
    inputs: tuple[str, ...] | None = None
    details: Mapping[str, object] = field(default_factory=dict)


def append_elements(document: Document, elements: Iterable[Element]) -> Document:
    """Append elements before the end tag of a URDF file; every other byte stays.

    Args:
        elements: links, joints and loops, in order.

    Returns:
        The new file, of the same name.
    """
    data = append_to_file(document.data, build_tree(document.data), elements)
    return Document(document.name, data)


def names_taken(document: Document) -> set[str]:
    """List the names of all links, joints and loops of a URDF file."""
    return {
        item.name
        for item in build_tree(document.data).children
        if item.tag in ("link", "joint", "loop")
    }


def free_name(wanted: str, taken: Collection[str]) -> str:
    """Return a name that is not taken: ``wanted``, or with the first free number behind it.

    Args:
        taken: names that are taken.
    """
    count, name = 1, wanted
    while name in taken:
        count += 1
        name = f"{wanted}_{count}"
    return name
