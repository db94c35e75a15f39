"""Write a linkage's URDF file with counterweights and no other change."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from os import PathLike
from typing import Protocol

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.regions import Region
from balance.masses.designs.density import STEEL
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.designs.write_urdf import append_to_file, replace_inertials
from balance.space.inertial_parameters.body_inertia import inertial_element, written_inertia
from balance.space.inertial_parameters.conversions import mass_properties
from balance.space.spaces.design_space import DesignSpace
from balance.support.result_files import write_file
from balance.support.tolerances import PART_ROUND_OFF, SHARE_ZERO
from kinematics.errors import UsageError
from kinematics.files.urdf.edit_xml import read_source
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.numerics.array_types import Array
from kinematics.wording import without_round_off


class WithCounterweights(Protocol):
    """Counterweights of a linkage, balanced or not."""

    @property
    def space(self) -> DesignSpace:
        """A design space of the linkage."""

    @property
    def weights(self) -> tuple[Counterweight, ...]:
        """The counterweights."""

    @property
    def words(self) -> str:
        """The verdict in one line."""

    @property
    def z(self) -> Array | None:
        """Parameters with them (bodies, 10), inertial origin, SI units."""

    @property
    def moved(self) -> Mapping[str, float]:
        """Mass taken from links, kg, by name."""


def counterweights_file(
    answer: WithCounterweights, path: str | PathLike[str] | None, merge: bool
) -> bytes:
    """Return the file of a linkage with counterweights, and write it if there is a path.

    Raises:
        UsageError: there are none: nothing balances the linkage, or keeps the caps.
        FileError: the linkage has no file, or the new one cannot be written.
    """
    if answer.z is None:
        name = answer.space.linkage.name
        raise UsageError(f"{name}: no counterweights to write: {answer.words}")
    return write_file(path, with_counterweights(answer, merge=merge))


def with_counterweights(
    answer: WithCounterweights,
    *,
    merge: bool | Collection[str] = False,
    meshes: Mapping[str, str] | None = None,
) -> bytes:
    """Return the linkage's URDF file with counterweights.

    Each lump is a link of its own on a fixed joint, without inertia about its centre. A
    counterweight of more lumps than are listed is one link with its inertia. A whole disc,
    cylinder, block or ball is drawn as it is, with its web, and any other as a ball of its
    volume, of steel if it has no density. These elements stand before the end tag of the file.
    With ``merge``, the counterweights are in the ``<inertial>`` of their links instead; see
    `replace_inertials`. One that has a mesh is a link with ``<visual>`` and ``<collision>``,
    merged ones too; a whole ball, box or cylinder is that primitive. A link from which a share
    of its mass is moved keeps the rest of it; one from which all of it is moved has the mass of
    its counterweight.

    Args:
        merge: whether they go into the masses of their links, for all of them or for these
            links.
        meshes: path of the mesh of counterweights by link, in mm about the centre of mass.

    Returns:
        The bytes of the new file.

    Raises:
        FileError: the linkage was not read from a file, or it can no longer be read.
    """
    linkage = answer.space.linkage
    every = {weight.link for weight in answer.weights}
    merged = every & set(merge) if not isinstance(merge, bool) else every if merge else set()
    unmoved = _unmoved_parameters(answer)
    merged |= {name for name, z in unmoved.items() if not z.any()}
    meshes = meshes or {}
    apart = [weight for weight in answer.weights if weight.link not in merged - set(meshes)]
    if merged or unmoved:
        frames, length = answer.space.frames, answer.space.length
        inertials = {
            name: _link_inertial(z, frames[answer.space.bodies.index(name)], length)
            for name, z in unmoved.items()
            if name not in merged
        }
        inertials |= _merged_inertials(answer, merged)
        data = replace_inertials(linkage, inertials)
        root = build_tree(data)
    else:
        data, root = read_source(linkage, "link", "to which links could be added")
    names = {item.name for tag in ("link", "joint") for item in root.every(tag)}
    elements = [
        element
        for weight in apart
        for element in _own_links(weight, names, meshes.get(weight.link), weight.link in merged)
    ]
    return append_to_file(data, root, elements) if elements else data


def _unmoved_parameters(answer: WithCounterweights) -> dict[str, Array]:
    """Compute what stays of links from which something is moved: parameters (10,), by name."""
    moved = {name: mass for name, mass in answer.moved.items() if mass}
    if not moved:
        return {}
    file, bodies = given_parameters(answer.space), answer.space.bodies
    parts = {}
    for name, mass in moved.items():
        z = file[bodies.index(name)]
        stays = 1.0 - mass / float(z[0])
        parts[name] = (stays if stays > SHARE_ZERO else 0.0) * z
    return parts


def _merged_inertials(
    answer: WithCounterweights, links: Collection[str]
) -> Iterator[tuple[str, str]]:
    """Yield the element ``<inertial>`` of some bodies with their counterweights, by name."""
    assert answer.z is not None
    for name in links:
        b = answer.space.bodies.index(name)
        yield name, _link_inertial(answer.z[b], answer.space.frames[b], answer.space.length)


def _link_inertial(z: Array, frame: Array, length: float) -> str:
    """Write the element ``<inertial>`` of parameters (10,) in a link frame (4, 4).

    Args:
        length: that of the linkage, m.
    """
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = frame[:3, :3].T, -frame[:3, :3].T @ frame[:3, 3]
    mass, com, inertia = mass_properties(displace_parameters(z, back))
    return inertial_element(mass, com, inertia, length)


def _own_links(
    weight: Counterweight, names: set[str], mesh: str | None, merged: bool
) -> Iterator[Element]:
    """Yield links and joints of a counterweight, and add their names to those taken.

    Args:
        mesh: path of its mesh, if it has one.
        merged: whether its mass is in that of its link.
    """
    parts = [(lump.mass, lump.position, np.zeros((3, 3))) for lump in weight.lumps]
    for mass, position, inertia in parts or [(weight.mass, weight.com, weight.inertia)]:
        name = _free_name(f"{weight.link}_counterweight", names)
        at, pose = make_elements.origin(np.eye(4)), np.eye(4)
        size = max(float(np.abs(position).max()), weight.region.size)
        pose[:3, 3] = without_round_off(position, size)
        tensor = written_inertia(inertia)
        inertial = None if merged else make_elements.inertial(mass, tensor, at)
        link = make_elements.link(name, inertial)
        yield Element("link", link.attributes, (*link.children, *_shapes(weight, mesh, mass)))
        ends = (
            make_elements.origin(pose),
            Element("parent", {"link": weight.link}),
            Element("child", {"link": name}),
        )
        yield Element("joint", {"name": f"{name}_joint", "type": "fixed"}, ends)


def _shapes(weight: Counterweight, mesh: str | None, mass: float) -> tuple[Element, ...]:
    """Make ``<visual>`` and ``<collision>`` about the centre of mass of a counterweight.

    Args:
        mesh: path of its mesh; without one it is drawn alone, and collides with nothing.
        mass: kg, of the counterweight or of the lump.
    """
    shape = _primitive(weight.region, weight.com) if _fills_its_region(weight) else None
    web = None if weight.web is None else _primitive(weight.web, weight.com)
    if mesh is None:
        drawn = [x for x in (shape, web) if x] if shape else [(np.eye(4), _ball(weight, mass))]
        return tuple(Element("visual", {}, _placed(*each)) for each in drawn)
    if shape is None or weight.web is not None:
        scale = number_words([1e-3] * 3)
        shape = np.eye(4), Element("mesh", {"filename": mesh, "scale": scale})
    return Element("visual", {}, _placed(*shape)), Element("collision", {}, _placed(*shape))


def _placed(pose: Array, shape: Element) -> tuple[Element, ...]:
    """Make the origin and the geometry of a shape at a pose (4, 4)."""
    return make_elements.origin(pose), Element("geometry", {}, (shape,))


def _ball(weight: Counterweight, mass: float) -> Element:
    """Make the ball of the volume of a counterweight or of a lump; of points, in steel."""
    radius = (0.75 * mass / (weight.density or STEEL) / np.pi) ** (1.0 / 3.0)
    return Element("sphere", {"radius": f"{radius:.4g}"})


def _fills_its_region(weight: Counterweight) -> bool:
    """Whether it is the whole of its region, besides a web."""
    return weight.form is not None and not weight.form[:, :3].any()


def _primitive(region: Region, centre: Array) -> tuple[Array, Element] | None:
    """Make the sphere, box or cylinder that a region is, and its pose (4, 4).

    Args:
        centre: point of the link frame (3,), m, from which it is placed.
    """
    sizes = np.linalg.norm(region.place[:3, :3], axis=0)
    away = region.centre - centre
    pose = np.eye(4)
    pose[:3, :3] = region.place[:3, :3] / sizes
    pose[:3, 3] = np.where(np.abs(away) <= PART_ROUND_OFF * region.size, 0.0, away)
    if np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max() > PART_ROUND_OFF:
        return None
    if region.kind != "box" and pose[2, 2] >= 1.0 - PART_ROUND_OFF:
        # It is round about the axis.
        pose[:3, :3] = np.eye(3)
    if region.kind == "box":
        return pose, Element("box", {"size": number_words(2.0 * sizes)})
    if abs(sizes[0] - sizes[1]) > PART_ROUND_OFF * sizes[0]:
        return None
    radius = {"radius": number_words(sizes[:1])}
    if region.kind == "ball":
        return pose, Element("sphere", radius)
    if region.kind != "cylinder":
        return None
    return pose, Element("cylinder", radius | {"length": number_words(2.0 * sizes[2:])})


def _free_name(wanted: str, names: set[str]) -> str:
    """Return a name that neither it nor its joint has been given to, and take both."""
    count, name = 1, wanted
    while {name, f"{name}_joint"} & names:
        count += 1
        name = f"{wanted}_{count}"
    names |= {name, f"{name}_joint"}
    return name
