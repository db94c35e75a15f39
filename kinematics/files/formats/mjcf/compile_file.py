"""Compile a reduced MJCF file with the package ``mujoco``."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import PackageError
from kinematics.files.formats.mjcf.includes import find_file
from kinematics.files.formats.mjcf.reduce_file import Reduced, mesh_name
from kinematics.files.urdf.validate_fields import MAX_NUMBER
from kinematics.files.urdf.xml_tree import Refusal, read_bytes
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text

# Largest file of a mesh that gives a body its inertia.
MAX_MESH = 64 * 2**20
_QUANTITIES = {
    "body": ("pos", "quat", "mass", "ipos", "iquat", "inertia"),
    "jnt": ("pos", "axis"),
    "site": ("pos", "quat"),
}
_TAGS = {"body": "body", "jnt": "joint", "site": "site"}
_WITHOUT_MESH = "give the bodies that it shapes an <inertial>"
_PLACE = re.compile(
    r"\s*Element (?:name )?'(?P<name>.*?)'(?:, id \d+)?(?:, line (?P<line>\d+))?"
)


class Compiled(NamedTuple):
    """A compiled file.

    Attributes:
        model: the ``mujoco.MjModel``.
        axes: axis of each joint (n, 3) as the file has it, without frames around the joint.
        tensors: ``fullinertia`` (6,) of the bodies by name, nan where the file has none.
        warnings: what MuJoCo said of the file.
    """

    model: Any
    axes: list[list[float]]
    tensors: dict[str, list[float]]
    warnings: tuple[str, ...]


def compile_file(file: Reduced, folder: str | None) -> Compiled:
    """Compile a reduced file.

    Args:
        folder: of the file, with the meshes that give inertia; None for a stream.

    Returns:
        The model, and the axes of its joints.

    Raises:
        PackageError: MuJoCo is not installed.
        Refusal: MuJoCo refuses the file, or a mesh is missing.
    """
    try:
        import mujoco
    except ImportError:
        raise PackageError("an MJCF file", "MuJoCo", "pip install mujoco") from None
    elements, assets = _asset_section(file, folder)
    root = _without_texts(replace(file.root, children=(*elements, *file.root.children)))
    with _collected_warnings(mujoco) as said:
        try:
            spec = mujoco.MjSpec.from_string(element_text(root), assets=assets)
            axes = [joint.axis.tolist() for joint in spec.joints]
            model = spec.compile()
            tensors = {body.name: body.fullinertia.tolist() for body in spec.bodies}
        except (ValueError, TypeError, mujoco.FatalError) as error:
            raise _refusal(str(error), root) from None
    _check_numbers(model)
    return Compiled(model, axes, tensors, tuple(said))


def _without_texts(item: Element) -> Element:
    """Copy an element without texts, which MJCF does not have: each tag is a line."""
    return replace(item, children=tuple(map(_without_texts, item.children)), text="")


def _check_numbers(model: Any) -> None:
    """Refuse a model with numbers that are not finite, or out of range."""
    for owner, count in (("body", model.nbody), ("jnt", model.njnt), ("site", model.nsite)):
        for k in range(count):
            item = getattr(model, owner)(k)
            for quantity in _QUANTITIES[owner]:
                if not np.abs(getattr(item, quantity)).max() <= MAX_NUMBER:
                    label = (
                        f"{_TAGS[owner]} '{clean(item.name)}'" if item.name else _TAGS[owner]
                    )
                    problem = f"its {quantity} is not finite, or out of range"
                    raise Refusal(label, problem, "correct its numbers")


@contextmanager
def _collected_warnings(mujoco: Any) -> Iterator[list[str]]:
    """Collect the warnings of MuJoCo, which otherwise writes them to a file of its own."""
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: said.append(clean(str(text), 200)))
    try:
        with warnings.catch_warnings(record=True) as raised:
            warnings.simplefilter("always")
            yield said
    finally:
        mujoco.set_mju_user_warning(before)
    said.extend(clean(str(warning.message), 200) for warning in raised)


def _asset_section(file: Reduced, folder: str | None) -> tuple[list[Element], dict[str, bytes]]:
    """Make the ``<asset>`` of the needed meshes, and read their files by their new names."""
    meshes, assets = [], {}
    for k, mesh in enumerate(file.meshes):
        if mesh.first("plugin"):
            raise Refusal(mesh.label, "the mesh of a plugin is not read", _WITHOUT_MESH)
        kept = {key: value for key, value in mesh.attributes.items() if key != "material"}
        kept["name"] = mesh_name(mesh)
        if "file" in mesh.attributes:
            kept["file"] = f"mesh{k}{os.path.splitext(mesh.attributes['file'])[1]}"
            assets[kept["file"]] = _read_mesh(mesh, file.compiler, folder)
        meshes.append(replace(mesh, attributes=kept, children=()))
    return ([Element("asset", {}, tuple(meshes))] if meshes else []), assets


def _read_mesh(mesh: Element, compiler: dict[str, str], folder: str | None) -> bytes:
    """Read the file of a mesh."""
    name = mesh.attributes["file"]
    if compiler.get("strippath") == "true":
        name = os.path.basename(name)
    there = os.path.join(compiler.get("meshdir", compiler.get("assetdir", "")), name)
    try:
        return read_bytes(find_file(folder, [there, name], mesh), MAX_MESH)
    except Refusal as refusal:
        element, problem, _ = refusal.args
        text = problem if element else f"'{clean(there)}' is {problem}"
        raise Refusal(mesh.label, text, f"fetch the mesh, or {_WITHOUT_MESH}") from None


def _refusal(text: str, root: Element) -> Refusal:
    """Convert a message of MuJoCo, which names a line of the reduced file."""
    lines = text.strip().split("\n")
    place = _PLACE.fullmatch(lines[-1]) if len(lines) > 1 else None
    label = ""
    if place:
        lines.pop()
        at = int(place["line"] or 0)
        item = next((item for line, item in _elements_by_line(root) if line == at), None)
        label = item.label if item else f"'{clean(place['name'])}'"
    problem = re.sub(r"^((XML )?Error: )+", "", " ".join(lines))
    problem = clean(problem.strip().rstrip(".;"), 300) or "MuJoCo cannot compile it"
    return Refusal(label, f"{problem} (MuJoCo)", "correct the file so that MuJoCo compiles it")


def _elements_by_line(root: Element) -> Iterator[tuple[int, Element]]:
    """Number the lines of `element_text` at which elements begin."""
    line, stack = 2, [(root, False)]
    while stack:
        item, closing = stack.pop()
        if not closing:
            yield line, item
            if item.children:
                stack.append((item, True))
                stack.extend((child, False) for child in reversed(item.children))
        line += 1
