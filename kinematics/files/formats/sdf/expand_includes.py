"""Replace the ``<include>`` elements of an SDF file by the models that they name."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace

from kinematics.error_text import clean
from kinematics.files.formats.sdf.fields import is_true
from kinematics.files.formats.sdf.find_model import is_scenery
from kinematics.files.urdf.xml_tree import MAX_ELEMENTS, Refusal, build_tree, read_bytes
from kinematics.model.document.element import Element

MERGED = "merge"
"""The attribute of a model whose parts become those of the model around it."""

# Where simulators look for models, each a list of folders.
_VARIABLES = (
    "GZ_SIM_RESOURCE_PATH",
    "GZ_SIM_MODEL_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
)
# Deepest chain of files that include one another.
MAX_FILES = 20
# Largest number of bytes of all included files.
MAX_INCLUDED = 64 * 2**20


def expand_sdf_includes(root: Element, path: str | None) -> Element:
    """Replace every ``<include>`` but scenery by the ``<model>`` of its file.

    A URI is a path relative to the file, or ``model://NAME``, which is looked for in the
    folders of the environment variables of Gazebo, and then beside the file and above it.

    Args:
        root: the ``<sdf>`` element.
        path: its file; None for a stream.

    Returns:
        The element without includes. Elements of other files have line 0.

    Raises:
        Refusal: a file is missing, not well-formed or without a model, or files include one
            another in a circle.
    """
    return _Expansion().expand(root, None if path is None else os.path.abspath(path), ())


class _Expansion:
    """Replaces includes, and counts the bytes and elements of the files included."""

    def __init__(self) -> None:
        self.bytes = self.elements = 0

    def expand(self, item: Element, path: str | None, above: tuple[str, ...]) -> Element:
        """Replace the includes of an ``<sdf>``, its worlds and its models."""
        children: list[Element] = []
        for child in item.children:
            if child.tag in ("model", "world"):
                children.append(self.expand(child, path, above))
            elif child.tag == "include" and item.tag != "model" and _is_static(child):
                continue
            elif child.tag == "include" and not is_scenery(child):
                children.append(self._include(child, path, above))
            else:
                children.append(child)
        return replace(item, children=tuple(children))

    def _include(self, item: Element, path: str | None, above: tuple[str, ...]) -> Element:
        """Read the model of an ``<include>``, with the name and pose that this gives it."""
        uri = item.first("uri")
        if uri is None or not uri.text:
            raise Refusal(item.label, "no <uri>", "write <uri>PATH</uri>, the file of a model")
        file = _find_file(item, uri.text, path)
        real = os.path.realpath(file)
        if real in above or len(above) >= MAX_FILES:
            problem = f"'{clean(uri.text)}' includes itself, by way of other files"
            raise Refusal(item.label, problem, "remove one of the includes")
        model = self._read_model(item, file, (*above, real))
        if _is_static(item):
            problem = f"the model '{clean(uri.text)}' is static"
            raise Refusal(item.label, problem, "remove the include: it carries no joint")
        if item.first("placement_frame") is not None:
            raise Refusal(
                item.label, "<placement_frame> is not read", "give the pose without it"
            )
        name, pose = item.first("name"), item.first("pose")
        attributes = dict(model.attributes)
        if name is not None:
            attributes["name"] = name.text
        if item.attributes.get("merge", "").lower() in ("1", "true"):
            attributes[MERGED] = "true"
        children = model.children
        if pose is not None:
            children = (pose, *(x for x in children if x.tag != "pose"))
        return replace(model, attributes=attributes, children=children, line=item.line)

    def _read_model(self, item: Element, file: str, above: tuple[str, ...]) -> Element:
        """Read the only model of a file, and what it includes."""
        try:
            data = read_bytes(file)
            self.bytes += len(data)
            if self.bytes > MAX_INCLUDED:
                problem = f"more than {MAX_INCLUDED // 2**20} MB of included files"
                raise Refusal("", problem, "include less")
            root = build_tree(data).without_lines()
            self.elements += sum(1 for _ in root.walk())
            if self.elements > MAX_ELEMENTS:
                problem = f"more than {MAX_ELEMENTS} elements in included files"
                raise Refusal("", problem, "include less")
            models = root.every("model") if root.tag == "sdf" else []
            if len(models) != 1:
                raise Refusal("", "not an SDF file with one model", "include a file with one")
            return self.expand(models[0], file, above)
        except Refusal as refusal:
            element, problem, remedy = refusal.args
            text = ": ".join(part for part in (clean(file, 1000), element, problem) if part)
            raise Refusal(item.label, text, remedy) from None


def _is_static(include: Element) -> bool:
    return is_true(include, include.first("static"))


def _find_file(item: Element, uri: str, path: str | None) -> str:
    """Find the file of a URI.

    Raises:
        Refusal: there is none.
    """
    scheme, colon, rest = uri.partition("://")
    if not colon:
        scheme, rest = "", uri
    if scheme not in ("", "file", "model", "package"):
        problem = f"'{clean(uri)}' is not on this machine"
        raise Refusal(item.label, problem, "download the model, and give its path")
    for place in _places(scheme, rest, path):
        if "\0" not in place and os.path.exists(place):
            file = _model_file(place) if os.path.isdir(place) else place
            if os.path.isfile(file):
                return file
    problem = f"no model '{clean(uri)}'"
    remedy = "correct the path"
    if scheme:
        remedy = "name its folder in GZ_SIM_RESOURCE_PATH, or put it beside the file"
    raise Refusal(item.label, problem, remedy)


def _places(scheme: str, rest: str, path: str | None) -> Iterator[str]:
    """Yield the paths that a URI may mean."""
    folder = None if path is None else os.path.dirname(path)
    if scheme in ("", "file"):
        if os.path.isabs(rest) or folder is not None:
            yield os.path.join(folder or "", rest)
        if scheme:
            return
    for variable in _VARIABLES:
        for place in os.environ.get(variable, "").split(os.pathsep):
            if place:
                yield os.path.join(place, rest)
    while folder is not None:
        yield os.path.join(folder, rest)
        above = os.path.dirname(folder)
        folder = above if above != folder else None


def _model_file(folder: str) -> str:
    """Name the SDF file of a folder: the last one in ``model.config``, or ``model.sdf``."""
    config = os.path.join(folder, "model.config")
    if os.path.isfile(config):
        files = [x.text for x in build_tree(read_bytes(config)).every("sdf") if x.text]
        if files:
            return os.path.join(folder, files[-1])
    return os.path.join(folder, "model.sdf")
