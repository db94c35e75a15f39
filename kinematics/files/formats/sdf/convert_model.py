"""Convert an SDF file to the elements of a URDF file with loops, and say what was decided.

A part ``x`` of a nested model ``m`` is called ``m::x``. Its pose is relative to the frame
``m``, which is at the pose of the nested model, unless it names another one. Parts of a merged
model keep their names.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace

from kinematics.error_text import clean, closest_names, quoted
from kinematics.files.formats.sdf.fields import is_true
from kinematics.files.formats.sdf.find_model import find_model, is_scenery, version_of
from kinematics.files.formats.sdf.frames import MODEL, WORLD, read_frames
from kinematics.files.formats.sdf.inertials import has_inertial, uses_defaults
from kinematics.files.formats.sdf.model_joints import LinkNames, ModelJoint, read_joint
from kinematics.files.formats.sdf.spanning_tree import choose_root, span_all
from kinematics.files.formats.sdf.tags import check_tags
from kinematics.files.formats.sdf.write_model import ModelWriter
from kinematics.files.urdf.xml_tree import MAX_ELEMENTS, Refusal, build_tree, read_bytes
from kinematics.model.document.element import Element

# Most models inside one another.
MAX_NESTED = 50
_PARTS = ("link", "joint", "frame")
MERGED = "merge"
"""The attribute of a model whose parts become those of the model around it."""


def convert_sdf(
    root: Element, wanted: str | None = None, path: str | None = None
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Convert an SDF file.

    The ground is the world, if joints fix the model to it, and else the link that the user
    names, the root of a tree, or the canonical link. Links that joints connect to one another
    and not to the ground float.

    Args:
        root: the ``<sdf>`` element.
        wanted: name of the link that is the ground; None for the default.
        path: the file, beside which included models are; None for a stream.

    Returns:
        The ``<robot>`` element, and code and message of each remark.

    Raises:
        Refusal: the file has something that cannot be converted.
    """
    version = version_of(root)
    model = _flatten_models(find_model(_expand_sdf_includes(root, path)))
    check_tags(model)
    frames, names = read_frames(model), LinkNames(model)
    if not names.links:
        raise Refusal(model.label, "no <link>", "give a model with links and joints")
    joints = [read_joint(item, names, frames, version) for item in model.every("joint")]
    pairs = [(joint.parent, joint.child) for joint in joints]
    ground = _choose_ground(names, pairs, wanted)
    tree, roots = span_all(list(names.links), pairs, ground)
    floating = [root for root in roots if any(root in pair for pair in pairs)]
    writer = ModelWriter(names.links, frames, joints, ground, tree, floating)
    attributes = {"name": model.name} if model.name else {}
    robot = Element("robot", attributes, writer.parts(model.line), model.line)
    moved = writer.moved_links()
    links = list(names.links.values())
    return robot, tuple(_remarks(links, joints, ground, moved, wanted is not None))


def _choose_ground(
    names: LinkNames, pairs: Sequence[tuple[str, str]], wanted: str | None
) -> str:
    """Choose the ground: the world, the wanted link, or the root or canonical link.

    Raises:
        Refusal: there is no such link, or the ground is the world.
    """
    world = any(WORLD in pair for pair in pairs)
    if wanted is None or wanted == WORLD:
        if world:
            return WORLD
        return choose_root(list(names.links), pairs, names.canonical)
    label = f"ground '{clean(wanted)}'"
    if wanted not in names.links:
        remedy = f"choose from {closest_names(wanted, names.links)}"
        raise Refusal(label, "there is no such link", remedy)
    if world:
        remedy = "leave --ground out, or remove the joints whose parent is world"
        raise Refusal(label, "joints fix the model to the world, which is the ground", remedy)
    return wanted


def _remarks(
    links: Sequence[Element],
    joints: Sequence[ModelJoint],
    ground: str,
    moved: Sequence[str],
    chosen: bool,
) -> Iterator[tuple[str, str]]:
    """Remarks on what the file leaves to its reader."""
    if ground != WORLD and not chosen:
        text = f"no joint fixes the model to the world: its link {quoted([ground])} is taken "
        yield "base_taken_as_fixed", f"{text}as the ground; --ground LINK takes another"
    still = _still_links(joints, ground)
    carrying = [link for link in links if link.name not in still]
    bare = [link.name for link in carrying if not has_inertial(link)]
    if bare:
        text = "links without <inertial> have no mass here, where Gazebo takes 1 kg and 1 kg m²"
        yield "no_inertial", f"{text}: {quoted(bare)}"
    filled = [link.name for link in carrying if has_inertial(link) and uses_defaults(link)]
    if filled:
        text = "masses of 1 kg or moments of 1 kg m², the defaults of SDF, are taken for what "
        yield "default_inertial", f"{text}the <inertial> leaves out: {quoted(filled)}"
    locked = [joint.name for joint in joints if joint.locked]
    if locked:
        text = "joints move here, though their limits are one position; write type fixed if "
        yield "locked_joints", f"{text}they are to be fixed: {quoted(locked)}"
    if moved:
        text = "link frames are those of the joints that carry the links, not those of the file"
        yield "link_frames", f"{text}: {quoted(moved)}"


def _still_links(joints: Sequence[ModelJoint], ground: str) -> set[str]:
    """Find the links that fixed joints connect to the ground."""
    pairs = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    beside: dict[str, list[str]] = {}
    for start, other in (*pairs, *((child, parent) for parent, child in pairs)):
        beside.setdefault(start, []).append(other)
    still, ready = {ground}, [ground]
    while ready:
        for link in beside.get(ready.pop(), ()):
            if link not in still:
                still.add(link)
                ready.append(link)
    return still


def _flatten_models(model: Element, depth: int = 0) -> Element:
    """Write the parts of all nested models into a model.

    Args:
        model: the ``<model>``, without includes.
        depth: number of models around it.

    Returns:
        The model, the same if none is nested in it.

    Raises:
        Refusal: models are nested too deeply, or two have one name.
    """
    if not model.every("model"):
        return model
    if depth > MAX_NESTED:
        problem = f"more than {MAX_NESTED} models in one another"
        raise Refusal(model.label, problem, "write their parts into one model")
    children: list[Element] = []
    canonical: dict[str, str] = {}
    for child in model.children:
        if child.tag != "model":
            children.append(child)
            continue
        inner = _flatten_models(child, depth + 1)
        merged = is_true(child, child, MERGED)
        scope = _Scope(child.name, merged, len(children))
        if not merged:
            if not child.name or child.name in canonical:
                problem = f"two nested models '{clean(child.name)}', or one without a name"
                raise Refusal(child.label, problem, "give each nested model a name of its own")
            canonical[child.name] = scope.name_outside(_canonical_link(inner))
        pose = inner.first("pose")
        placed = () if pose is None else (pose,)
        children.append(Element("frame", {"name": scope.frame}, placed, child.line))
        children += [
            scope.move_part(part) if part.tag in _PARTS else part
            for part in inner.children
            if part.tag not in ("pose", "static")
        ]
    return replace(model, children=tuple(_with_links(x, canonical) for x in children))


def _canonical_link(model: Element) -> str:
    """Name the link that stands for a flat model: the named one, or its first."""
    named = model.attributes.get("canonical_link", "")
    links = model.every("link")
    return named or (links[0].name if links else MODEL)


def _with_links(joint: Element, canonical: dict[str, str]) -> Element:
    """Let a joint to a nested model be one to the link that stands for it."""
    if joint.tag != "joint":
        return joint
    return replace(
        joint,
        children=tuple(
            replace(x, text=canonical.get(x.text, x.text))
            if x.tag in ("parent", "child")
            else x
            for x in joint.children
        ),
    )


class _Scope:
    """The names and the frame of a nested model in the model around it."""

    def __init__(self, name: str, merged: bool, number: int) -> None:
        """Name the frame: that of the model, or of a number for a merged one."""
        self.frame = f"__merged_{number}__" if merged else name
        self._prefix = "" if merged else f"{name}::"

    def name_outside(self, name: str) -> str:
        """Write a name of the nested model as one of the model around it."""
        if name == WORLD:
            return name
        return self.frame if name == MODEL else f"{self._prefix}{name}"

    def move_part(self, part: Element) -> Element:
        """Write a link, joint or frame of the nested model as one of the model around it."""
        attributes = {**part.attributes, "name": self.name_outside(part.name)}
        if attributes.get("attached_to"):
            attributes["attached_to"] = self.name_outside(attributes["attached_to"])
        children = tuple(self._move_child(x) for x in part.children)
        free = part.tag == "link" or (
            part.tag == "frame" and not part.attributes.get("attached_to")
        )
        if free and part.first("pose") is None:
            children += (
                Element("pose", {"relative_to": self.frame}, (), part.line, "0 0 0 0 0 0"),
            )
        elif free:
            children = tuple(
                replace(x, attributes={**x.attributes, "relative_to": self.frame})
                if x.tag == "pose" and not _base_of(x)
                else x
                for x in children
            )
        return replace(part, attributes=attributes, children=children)

    def _move_child(self, item: Element) -> Element:
        """Write the names inside a part as those of the model around it."""
        if item.tag in ("parent", "child"):
            return replace(item, text=self.name_outside(item.text))
        if item.tag == "pose" and _base_of(item):
            attributes = {k: v for k, v in item.attributes.items() if k != "frame"}
            return replace(
                item,
                attributes={**attributes, "relative_to": self.name_outside(_base_of(item))},
            )
        if item.tag in ("axis", "axis2"):
            return self._move_axis(item)
        return item

    def _move_axis(self, axis: Element) -> Element:
        """Write the names inside an axis, and the frame in which it is expressed."""
        old = axis.first("use_parent_model_frame")
        in_model = old is not None and is_true(axis, old)
        children = []
        for item in axis.children:
            attributes = dict(item.attributes)
            if item.tag == "use_parent_model_frame":
                continue
            if item.tag == "xyz" and (in_model or attributes.get("expressed_in")):
                named = attributes.get("expressed_in") or MODEL
                attributes["expressed_in"] = self.name_outside(named)
            if item.tag == "mimic" and attributes.get("joint"):
                attributes["joint"] = self.name_outside(attributes["joint"])
            children.append(replace(item, attributes=attributes))
        return replace(axis, children=tuple(children))


def _base_of(pose: Element) -> str:
    """Name the frame that a pose is relative to, empty for the default."""
    return pose.attributes.get("relative_to", "") or pose.attributes.get("frame", "")


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


def _expand_sdf_includes(root: Element, path: str | None) -> Element:
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
