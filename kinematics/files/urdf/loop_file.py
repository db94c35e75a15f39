"""Merge loops from a YAML file into the tree of the URDF file beside it.

The format is that of Gepetto's example-parallel-robots: ``closed_loop`` pairs frames; a pair
shares a point if its ``type`` is ``3d``, and a pose if it is ``6d``; ``joint_name`` and
``joint_type`` replace joints of the file by types that URDF lacks; ``name_mot`` names the
inputs. The tree gets ``<loop>`` elements and changed joints, so that the later steps are the
same for both kinds of files.

Only the event parser of PyYAML runs; no objects are constructed. Aliases, tags, nested mappings
and deep lists are rejected: loop files do not need them, and an attacker could use them.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError
from kinematics.files.urdf.read_options import RobotFile
from kinematics.files.urdf.validate import validate_tree
from kinematics.files.urdf.validate_fields import check_needed
from kinematics.files.urdf.validate_inertias import find_unphysical
from kinematics.files.urdf.xml_tree import Refusal, name_file, read_bytes
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM, coordinate_names

if TYPE_CHECKING:
    from yaml.events import Event

# Largest YAML file: one of a robot has a few kilobytes.
MAX_BYTES = 2**17
_KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type", "rotule_name")
# Keys that may have a part of the names of several joints.
_GENERIC = ("name_mot", "rotule_name")
# Indices into the state vectors of another program, in files of 2023.
_IDLE = ("Lidmot", "Lidvmot")
# Frames by a pattern, likewise.
_RETIRED = dict.fromkeys(
    ("name_closedloop", "closed_loop_number"),
    "pair the frames by name: closed_loop: [[frame1, frame2]]",
)
_LOOPS = {"3d": "spherical", "6d": "fixed"}
_AXES = {"X": "1 0 0", "Y": "0 1 0", "Z": "0 0 1"}
_UNIVERSAL = {f"UJOINT_{a}{b}": (a, b) for a in _AXES for b in _AXES if a != b}
_UNIVERSAL["CARDAN"] = ("X", "Y")
_JOINTS = ("SPHERICAL", "FIXED", *_UNIVERSAL)
# Deepest nesting of lists.
MAX_DEPTH = 3
_NULLS = ("", "~", "null", "Null", "NULL")
_EXAMPLE = "write keys with lists, such as name: [first, second]"


def loop_file_of(source: str) -> str | None:
    """Find the YAML file beside a robot file, with the same stem, if it describes loops.

    Both ``x.urdf.yaml`` and ``x.yaml`` are beside ``x.urdf.xacro``.
    """
    stems = [Path(source)]
    if stems[0].suffix == ".xacro" and stems[0].stem.endswith(".urdf"):
        stems.append(stems[0].with_suffix(""))
    for path in (stem.with_suffix(end) for stem in stems for end in (".yaml", ".yml")):
        if path.is_file():
            with name_file(str(path)):
                data = read_bytes(str(path), MAX_BYTES)
            if any(key.encode() in data for key in _KEYS if key != "type"):
                return str(path)
    return None


def merge_loop_file(
    tree: Element,
    source: str,
    loops: str | os.PathLike[str] | None = None,
    search: bool = True,
    translated: Collection[str] = (),
) -> RobotFile:
    """Merge loops from a YAML file into the tree of a URDF file.

    Args:
        tree: checked tree of the URDF file.
        loops: path of the YAML file; by default the one beside the URDF file, if there is
            one, unless the tree has ``<loop>`` elements.
        search: whether to search beside the URDF file.
        translated: names of the loops that the URDF file gives in the words of other tools.

    Returns:
        The tree with the loops, the named inputs and the remarks.

    Raises:
        FileError: the YAML file cannot be read or does not fit the tree, or both hold
            loops.
    """
    loop_elements = (loop for loop in tree.every("loop") if loop.name not in translated)
    side = _find_and_merge(tree, source, loops, search, next(loop_elements, None))
    return side._replace(remarks=(*side.remarks, *find_unphysical(tree, source)))


def _find_and_merge(
    tree: Element,
    source: str,
    loops: str | os.PathLike[str] | None,
    search: bool,
    inline: Element | None,
) -> RobotFile:
    """Merge as `merge_loop_file`, without remarks on the URDF file; ``inline`` is its loop."""
    if loops is None:
        file = loop_file_of(source) if search else None
        if file is None:
            return RobotFile(tree)
        if inline is not None:
            text = f"'{clean(file)}' is not read: the URDF file has <loop> elements"
            return RobotFile(tree, None, (("loops_ignored", text),))
    else:
        file = os.fsdecode(loops)
        if inline is not None:
            problem = f"there are loops here and in '{clean(file)}'"
            remedy = "remove the <loop> elements, or do without the other file"
            raise FileError(clean(source, 1000), inline.label, problem, remedy)
    with name_file(file):
        return _merge(tree, _YamlMapping(read_bytes(file, MAX_BYTES), _KEYS + _IDLE, _RETIRED))


def _merge(tree: Element, keys: _YamlMapping) -> RobotFile:
    """Change joints, add loops and name inputs."""
    remarks = [*_unmatched_words(tree, keys)]
    tree = _validate(_replace_joints(tree, keys), "joint_type")
    inputs = _inputs(tree, keys)
    tree = _validate(_add_loops(tree, keys), "closed_loop")
    if idle := [key for key in _IDLE if key in keys.items]:
        remarks.append(("keys_ignored", f"keys without a meaning here: {', '.join(idle)}"))
    return RobotFile(tree, inputs, tuple(remarks))


def _validate(tree: Element, key: str) -> Element:
    """Check the tree after the change that a key makes to it."""
    try:
        validate_tree(tree)
    except Refusal as refusal:
        element, *rest = refusal.args
        raise Refusal(f"{key}: {element}", *rest) from None
    return tree


def _matching_joints(tree: Element, keys: _YamlMapping, key: str) -> list[str]:
    """Find the moving joint named by a key, or else all those whose names contain it."""
    word = keys.text(key) or ""
    moving = [j.name for j in tree.every("joint") if DEGREES_OF_FREEDOM[j.attributes["type"]]]
    if not word:
        remedy = f"list names; the joints that move are {closest_names(word, moving)}"
        raise keys.wrong(key, "no part of a name", remedy)
    return [word] if word in moving else [name for name in moving if word in name]


def _unmatched_words(tree: Element, keys: _YamlMapping) -> Iterator[tuple[str, str]]:
    """Remarks on parts of names that are in no name of a moving joint: they mean no joint."""
    for key in _GENERIC:
        if (word := keys.text(key)) and not _matching_joints(tree, keys, key):
            line = keys.items[key].line
            text = f"{key} (line {line}): no moving joint is called like '{clean(word)}'"
            yield "keys_ignored", text


def _check_names(
    keys: _YamlMapping, key: str, names: Iterable[str], candidates: Collection[str]
) -> None:
    """Check that every name of a key is known."""
    for name in names:
        if name not in candidates:
            remedy = f"correct the name; there are {closest_names(name, candidates)}"
            raise keys.wrong(key, f"'{clean(name)}' does not exist", remedy)


def _replace_joints(tree: Element, keys: _YamlMapping) -> Element:
    """Replace the joints that the keys name by joints of other types."""
    joints = {joint.name: joint for joint in tree.every("joint")}
    names = keys.names("joint_name")
    _check_names(keys, "joint_name", names, joints)
    if names and "joint_type" not in keys.items:
        raise keys.wrong("joint_name", "no joint_type", f"add it: {', '.join(_JOINTS)}")
    kinds: dict[str, str] = {}
    if "rotule_name" in keys.items:
        kinds = dict.fromkeys(_matching_joints(tree, keys, "rotule_name"), "SPHERICAL")
    if "joint_type" in keys.items:
        types = keys.kinds("joint_type", "joint_name", _JOINTS)
        kinds |= dict(zip(names, types, strict=True))
    return _map_joints(tree, lambda j: _retype(j, kinds[j.name]) if j.name in kinds else j)


def _map_joints(tree: Element, change: Callable[[Element], Element]) -> Element:
    """Apply a change to every joint of a tree."""
    children = (change(item) if item.tag == "joint" else item for item in tree.children)
    return replace(tree, children=tuple(children))


def _retype(joint: Element, kind: str) -> Element:
    """Change the type of a joint in place, with axes along those of its own frame."""
    axes = _UNIVERSAL.get(kind, ("X",))
    lines = [
        Element(tag, {"xyz": _AXES[axis]}, (), joint.line)
        for tag, axis in zip(("axis", "axis2"), axes, strict=False)
    ]
    idle = ("axis", "axis2", "screw_thread_pitch") if kind == "FIXED" else ("axis", "axis2")
    others = [item for item in joint.children if item.tag not in idle]
    name = "universal" if kind in _UNIVERSAL else kind.lower()
    attributes = {**joint.attributes, "type": name}
    return replace(joint, attributes=attributes, children=(*others, *lines))


def _inputs(tree: Element, keys: _YamlMapping) -> tuple[str, ...] | None:
    """Coordinates of the joints that the file marks as inputs."""
    types = {joint.name: joint.attributes["type"] for joint in tree.every("joint")}
    is_text = keys.text("name_mot") is not None
    names = _matching_joints(tree, keys, "name_mot") if is_text else keys.names("name_mot")
    _check_names(keys, "name_mot", names, types)
    for name in names:
        if not DEGREES_OF_FREEDOM[types[name]]:
            raise keys.wrong("name_mot", f"'{clean(name)}' is fixed", "name joints that move")
    coordinates = [name for joint in names for name in coordinate_names(joint, types[joint])]
    return tuple(coordinates) or None


def _add_loops(tree: Element, keys: _YamlMapping) -> Element:
    """Add the loops to the tree, with names ``frame1/frame2``."""
    links = {link.name: link.name for link in tree.every("link")}
    after = {j.name: check_needed(j, "child", "link") for j in tree.every("joint")}
    frames = after | links
    pairs = keys.entries("closed_loop")
    kinds = ["6d"] * len(pairs)
    if "type" in keys.items:
        kinds = keys.kinds("type", "closed_loop", _LOOPS)
    loops: list[Element] = []
    taken: dict[str, str] = {}
    for pair, kind in zip(pairs, kinds, strict=True):
        names = keys.names("closed_loop", pair)
        if len(names) != 2:
            problem = f"{len(names)} names at line {pair.line} in place of a pair"
            raise keys.wrong("closed_loop", problem, "write pairs: [[frame1, frame2]]")
        _check_names(keys, "closed_loop", names, frames)
        for name in names:
            if after.get(name, frames[name]) != frames[name]:
                problem = f"'{clean(name)}' is a link, and a joint that carries another link"
                raise keys.wrong("closed_loop", problem, "rename one of them")
        title = "/".join(names)
        for name in names:
            if taken.get(frames[name], title) != title:
                problem = f"'{clean(name)}' of '{clean(title)}' is a frame of "
                problem += f"'{clean(taken[frames[name]])}' too"
                remedy = "give each pair frames of its own, on links fixed in the same place"
                raise keys.wrong("closed_loop", problem, remedy)
            taken[frames[name]] = title
        roles = zip(("predecessor", "successor"), names, strict=True)
        sides = tuple(Element(role, {"link": frames[name]}) for role, name in roles)
        attributes = {"name": title, "type": _LOOPS[kind]}
        loops.append(Element("loop", attributes, sides, pair.line))
    return replace(tree, children=(*tree.children, *loops))


class _YamlItem(NamedTuple):
    """A text or a list, and the line where it begins."""

    line: int
    text: str | None
    parts: list[_YamlItem]


class _YamlMapping:
    """The keys of a YAML file; every error names the key and its line."""

    def __init__(
        self, data: bytes, accepted: Collection[str], retired: Mapping[str, str]
    ) -> None:
        """Read the bytes of a file.

        Args:
            accepted: keys that may come, each at most once.
            retired: rejected keys of old files, and the remedy for each.

        Raises:
            Refusal: the file is not YAML, or not a mapping from accepted keys to text and
                lists.
        """
        self.items: dict[str, _YamlItem] = {}
        top = _parse_document(data)
        for key, value in zip(top.parts[::2], top.parts[1::2], strict=True):
            name = key.text or ""
            if name in self.items:
                raise self.wrong(name, "the key comes twice", "keep one of them")
            self.items[name] = value._replace(line=key.line)
            if name in retired:
                raise self.wrong(name, "this old key is not supported", retired[name])
            if name not in accepted:
                raise self.wrong(name, "unknown key", f"the keys are {', '.join(accepted)}")

    def wrong(self, key: str, problem: str, remedy: str) -> Refusal:
        """Compose the refusal of the value of a key.

        Args:
            problem: what is wrong with its value.
        """
        return Refusal(f"{clean(key)} (line {self.items[key].line})", problem, remedy)

    def text(self, key: str) -> str | None:
        """Read the text of a key, None if it is absent or holds a list."""
        return self.items[key].text if key in self.items else None

    def entries(self, key: str) -> list[_YamlItem]:
        """Read the entries of the list of a key; none if the key is absent."""
        if self.text(key) is not None:
            raise self.wrong(key, "not a list", f"put it in brackets: {key}: [ … ]")
        return self.items[key].parts if key in self.items else []

    def names(self, key: str, item: _YamlItem | None = None) -> list[str]:
        """Read a list of different names.

        Args:
            item: an entry of the key that is a list; the list of the key by default.

        Raises:
            Refusal: it is not a list of names, or a name occurs twice.
        """
        parts = item.parts if item else self.entries(key)
        names = [part.text or "" for part in parts]
        if not all(names) or (item and item.text is not None):
            form = "[[first, second]]" if item else "[first, second]"
            raise self.wrong(key, "not a list of names", f"write it as in {key}: {form}")
        (name, count), *_ = Counter(names).most_common(1) or [("", 0)]
        if count > 1:
            raise self.wrong(key, f"'{clean(name)}' comes twice", "name each once")
        return names

    def kinds(self, key: str, owner: str, accepted: Collection[str]) -> list[str]:
        """Read a type for each entry of another key.

        Args:
            key: the key, with one type for all entries or a list of types.
            accepted: types to choose from; case does not matter.

        Raises:
            Refusal: the number of types is another one, or a type is unknown.
        """
        count, common = len(self.entries(owner)), self.text(key)
        if common is not None:
            words = [common] * count
        else:
            words = [part.text or "" for part in self.entries(key)]
        if len(words) != count:
            problem = f"{len(words)} types for the {count} entries of {owner}"
            raise self.wrong(key, problem, f"give a type for each entry of {owner}")
        exact = {name.lower(): name for name in accepted}
        for word in words:
            if word.lower() not in exact:
                remedy = f"choose from {', '.join(accepted)}"
                raise self.wrong(key, f"unknown type '{clean(word)}'", remedy)
        return [exact[word.lower()] for word in words]


def _parse_document(data: bytes) -> _YamlItem:
    """Parse the mapping of a YAML document to a list of keys and values in turn.

    Scalars stay text, so that a joint may have the name ``on`` or ``1``.
    An empty value, or a null, is an empty list.
    """
    import yaml

    try:
        top = _collect_items(yaml.parse(data, Loader=yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        problem = f"not readable as YAML{where} ({clean(str(reason))})"
        raise Refusal("", problem, _EXAMPLE) from None
    if not top:
        raise Refusal("", "no keys", _EXAMPLE)
    return top[0]


def _collect_items(events: Iterable[Event]) -> list[_YamlItem]:
    """Collect the top value of the only document, if there is one."""
    stack = [_YamlItem(0, None, [])]
    for event in events:
        line = event.start_mark.line + 1
        kind = type(event).__name__.removesuffix("Event")
        if kind in ("Alias", "Scalar", "SequenceStart", "MappingStart"):
            _check_event(event, kind, len(stack) - 1, f"line {line}")
            if stack[0].parts:
                raise Refusal(f"line {line}", "a second document", "keep one document")
        if kind == "Scalar":
            null = event.style is None and event.value in _NULLS
            stack[-1].parts.append(_YamlItem(line, None if null else event.value, []))
        elif kind in ("MappingStart", "SequenceStart"):
            stack.append(_YamlItem(line, None, []))
        elif kind in ("MappingEnd", "SequenceEnd"):
            done = stack.pop()
            stack[-1].parts.append(done)
    return stack[0].parts


def _check_event(event: Event, kind: str, depth: int, where: str) -> None:
    """Check for a mapping at the top, text and lists in it, no aliases and no tags."""
    if getattr(event, "anchor", None) is not None:
        raise Refusal(where, "an anchor or an alias", "write the names out")
    if getattr(event, "tag", None) is not None:
        raise Refusal(where, f"the tag '{clean(event.tag)}'", "write plain names")
    if (kind == "MappingStart") != (depth == 0):
        raise Refusal(where, "a mapping inside" if depth else "no mapping of keys", _EXAMPLE)
    if depth > MAX_DEPTH:
        raise Refusal(where, "lists too deep", _EXAMPLE)
