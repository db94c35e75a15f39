"""Reduce an MJCF file to what concerns its linkage, before MuJoCo compiles it.

Bodies, joints, sites, defaults and equality constraints stay, and the geoms that give a body
its inertia. Files of meshes are therefore needed only for those geoms, and nothing else that
a file may hold (textures, height fields, plugins, actuators, sensors, keyframes) is compiled.
Names that are not known stay too: MuJoCo refuses them.

A fixed tendon has the length ``L = a q₁ + b q₂``. Its equality holds it at ``c`` beyond the
length at the reference pose, so that one joint follows the other:
``q₁ - q₁⁰ = c/a - (b/a)(q₂ - q₂⁰)``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from kinematics.error_text import clean
from kinematics.files.urdf.validate_fields import are_numbers
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words

# Largest number of elements once those that repeat are written out.
MAX_REPEATED = 20_000
_IDLE_SECTIONS = frozenset(
    (
        "size",
        "statistic",
        "visual",
        "contact",
        "actuator",
        "sensor",
        "keyframe",
        "custom",
        "extension",
        "tendon",
        "deformable",
        "option",
        "asset",
    )
)
_IDLE_PARTS = frozenset((
    "light", "camera", "plugin", "flexcomp", "material", "pair", "tendon", "general", "motor",
    "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion",
    "dcmotor", "pid", "lengthrange", "texture",
))  # fmt: skip
_IDLE_SETTINGS = frozenset(
    (
        "meshdir",
        "assetdir",
        "texturedir",
        "strippath",
        "discardvisual",
        "fusestatic",
        "usethread",
        "saveinertial",
        "savecompiled",
    )
)
_JOINTS = frozenset(("joint", "freejoint", "composite"))
_REFUSED = {
    "attach": "save the whole model with MjSpec.to_xml() of MuJoCo",
    "model": "save the whole model with MjSpec.to_xml() of MuJoCo",
}
_DEFORMING = ("flexcomp", "deformable")
# Attributes that the equality of a tendon and that of joints share.
_SHARED = ("name", "class", "active")


class Reduced(NamedTuple):
    """A file without what does not concern its linkage.

    Attributes:
        root: the ``<mujoco>`` element.
        meshes: the ``<mesh>`` elements that give inertia to bodies.
        compiler: attributes of all its ``<compiler>`` elements.
        remarks: what was left out although it acts on the linkage.
        disabled: whether the file switches all its equality constraints off.
    """

    root: Element
    meshes: tuple[Element, ...]
    compiler: dict[str, str]
    remarks: tuple[str, ...]
    disabled: bool


def reduce_file(root: Element) -> Reduced:
    """Reduce a file to what concerns its linkage.

    Args:
        root: the ``<mujoco>`` element, without includes.

    Returns:
        The reduced file.

    Raises:
        Refusal: it has something that cannot be converted, or repeats too much.
    """
    compiler: dict[str, str] = {}
    for item in root.every("compiler"):
        compiler.update(item.attributes)
    root, coupling = _replace_tendons(root)
    _check_parts(root)
    reduction = _Reduction(compiler.get("inertiafromgeom", "auto"))
    sections = tuple(
        reduction.section(item) for item in root.children if item.tag not in _IDLE_SECTIONS
    )
    reduced = replace(root, children=sections)
    wanted = {item.attributes["mesh"] for item in reduced.walk() if "mesh" in item.attributes}
    meshes = [item for asset in root.every("asset") for item in asset.every("mesh")]
    needed = tuple(item for item in meshes if mesh_name(item) in wanted)
    _count_repeated(reduced)
    flags = [flag for option in root.every("option") for flag in option.every("flag")]
    disabled = any(flag.attributes.get("equality") == "disable" for flag in flags)
    return Reduced(reduced, needed, compiler, tuple(_find_unread(root, coupling)), disabled)


def mesh_name(mesh: Element) -> str:
    """Return the name of a mesh: its file without folder and ending, if it has no name."""
    file = mesh.attributes.get("file", "").replace("\\", "/").rpartition("/")[2]
    return mesh.name or file.rpartition(".")[0] or file


class _Reduction:
    """The reduction of one file, with its rule for inertias of geoms."""

    def __init__(self, from_geoms: str) -> None:
        self.from_geoms = from_geoms

    def section(self, item: Element) -> Element:
        """Reduce a child of ``<mujoco>``."""
        if item.tag == "compiler":
            kept = {k: v for k, v in item.attributes.items() if k not in _IDLE_SETTINGS}
            return replace(item, attributes=kept, children=())
        if item.tag == "worldbody":
            return replace(item, children=tuple(self._reduce_parts(item, False, False)))
        if item.tag == "default":
            return _without_idle_parts(item)
        return item

    def _reduce_parts(self, owner: Element, moving: bool, geoms: bool) -> Iterator[Element]:
        """Reduce what is inside a body or a frame.

        Args:
            owner: the body, or a frame or repetition inside it.
            moving: whether a joint carries the body.
            geoms: whether its geoms give it its inertia.
        """
        for item in owner.children:
            if item.tag == "body":
                yield self._reduce_body(item, moving)
            elif item.tag in ("frame", "replicate"):
                if parts := tuple(self._reduce_parts(item, moving, geoms)):
                    yield replace(item, children=parts)
            elif item.tag == "geom":
                if geoms and moving:
                    yield _plain_geom(item)
            elif item.tag == "composite":
                yield _without_idle_parts(item)
            elif item.tag not in _IDLE_PARTS:
                yield item

    def _reduce_body(self, body: Element, moving: bool) -> Element:
        parts = list(_inside(body))
        moving = moving or any(item.tag in _JOINTS for item in parts)
        has_inertial = any(item.tag == "inertial" for item in parts)
        geoms = self.from_geoms != "false" and (self.from_geoms == "true" or not has_inertial)
        return replace(body, children=tuple(self._reduce_parts(body, moving, geoms)))


def _inside(body: Element) -> Iterator[Element]:
    """Yield the parts of a body, those in frames included, without other bodies."""
    for item in body.children:
        if item.tag in ("frame", "replicate"):
            yield from _inside(item)
        elif item.tag != "body":
            yield item


def _plain_geom(geom: Element) -> Element:
    """Copy a geom without its material and height field."""
    kept = {k: v for k, v in geom.attributes.items() if k not in ("material", "hfield")}
    return replace(geom, attributes=kept, children=())


def _without_idle_parts(item: Element) -> Element:
    """Copy defaults or a composite without the parts that do not concern the linkage."""
    children = tuple(
        _without_idle_parts(child) for child in item.children if child.tag not in _IDLE_PARTS
    )
    return _plain_geom(item) if item.tag == "geom" else replace(item, children=children)


def _check_parts(root: Element) -> None:
    """Refuse what cannot be converted."""
    for item in root.walk():
        if item.tag in _REFUSED:
            problem = f"<{clean(item.tag)}> of another model is not read"
            raise Refusal(item.label, problem, _REFUSED[item.tag])
    for section in root.every("equality"):
        for item in section.children:
            if item.tag == "tendon" or item.tag.startswith("flex"):
                problem = f"an equality constraint of a {clean(item.tag)} is not read"
                remedy = "write it as <joint>, <connect> or <weld>, or remove it"
                raise Refusal(item.label, problem, remedy)


def _find_unread(root: Element, read: Collection[str]) -> Iterator[str]:
    """Say what acts on the linkage and is not read; some tendons are read."""
    every = (item for section in root.every("tendon") for item in section.children)
    tendons = [item for item in every if item.name not in read]
    if tendons:
        yield f"{_name_first(tendons)}: tendons are not read: they close no loop here"
    soft = [item for item in root.walk() if item.tag in _DEFORMING]
    if soft:
        yield f"{_name_first(soft)}: deformable bodies are left out"


def _name_first(items: list[Element]) -> str:
    more = f" and {len(items) - 1} more" if len(items) > 1 else ""
    return f"{items[0].label}{more}"


def _count_repeated(item: Element) -> int:
    """Count the elements once those that repeat are written out.

    Raises:
        Refusal: there are more than `MAX_REPEATED`.
    """
    count = 1 + sum(_count_repeated(child) for child in item.children)
    if item.tag in ("replicate", "composite"):
        for word in item.attributes.get("count", "1").split():
            try:
                count *= max(1, int(float(word)))
            except (ValueError, OverflowError):
                problem = f'count="{clean(word)}" is not a number'
                raise Refusal(item.label, problem, "write a whole number") from None
            if count > MAX_REPEATED:
                problem = f"repeats to more than {MAX_REPEATED} elements"
                raise Refusal(item.label, problem, "repeat less")
    return count


def _replace_tendons(root: Element) -> tuple[Element, frozenset[str]]:
    """Replace every equality of one fixed tendon over two joints.

    Args:
        root: the ``<mujoco>`` element, without includes.

    Returns:
        The element, and the names of the tendons that are read like this.
    """
    tendons = {
        item.name: item for section in root.every("tendon") for item in section.every("fixed")
    }
    used: set[str] = set()
    children = []
    for section in root.children:
        if section.tag == "equality":
            parts = tuple(_replaced(item, tendons, used) for item in section.children)
            section = replace(section, children=parts)
        children.append(section)
    return replace(root, children=tuple(children)), frozenset(used)


def _replaced(item: Element, tendons: Mapping[str, Element], used: set[str]) -> Element:
    """Return the equality of two joints, or the same element."""
    tendon = tendons.get(item.attributes.get("tendon1", ""))
    if item.tag != "tendon" or tendon is None or "tendon2" in item.attributes:
        return item
    joints = tendon.every("joint")
    words = [joint.attributes.get("coef", "") for joint in joints]
    given = item.attributes.get("polycoef", "0").split() or ["0"]
    if len(joints) != 2 or not all(are_numbers(word, 1) for word in (*words, given[0])):
        return item
    (a, b), c = map(float, words), float(given[0])
    names = [joint.attributes.get("joint", "") for joint in joints]
    if not a or not b or not all(math.isfinite(x) for x in (c / a, b / a)) or not all(names):
        return item
    used.add(tendon.name)
    attributes = {key: item.attributes[key] for key in _SHARED if key in item.attributes}
    attributes |= {"joint1": names[0], "joint2": names[1]}
    attributes["polycoef"] = number_words([c / a, -b / a, 0.0, 0.0, 0.0])
    return replace(item, tag="joint", attributes=attributes, children=())
