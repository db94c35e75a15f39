"""The words of a URDF file as a second reader knows them: strictly."""

from __future__ import annotations

from xml.etree import ElementTree

Tree = ElementTree.Element

FREEDOMS = {
    "fixed": "",
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "universal": "RR",
    "cylindrical": "RP",
    "planar": "PPR",
    "spherical": "RRR",
    "floating": "PPPRRR",
}
# What each element may hold, and its attributes.
PARTS = {
    "robot": ("link joint loop", "name version"),
    "link": ("inertial", "name type"),
    "inertial": ("origin mass inertia", ""),
    "joint": (
        "parent child origin axis axis2 mimic screw_thread_pitch",
        "name type independent",
    ),
    "loop": ("predecessor successor axis axis2", "name type independent"),
    "predecessor": ("origin", "link"),
    "successor": ("origin", "link"),
    "parent": ("", "link"),
    "child": ("", "link"),
    "origin": ("", "xyz rpy"),
    "axis": ("", "xyz"),
    "axis2": ("", "xyz"),
    "mass": ("", "value"),
    "inertia": ("", "ixx ixy ixz iyy iyz izz iyx izx izy"),
    "mimic": ("", "joint multiplier offset"),
    "screw_thread_pitch": ("", "value"),
}
SEVERAL = {"link", "joint", "loop"}
# Without a meaning for masses and joints, wherever they are.
FOREIGN = set(
    "calibration collision dynamics gazebo limit material note safety_controller sensor "
    "transmission visual".split()
)


class Strange(Exception):
    """Something that has no meaning, and should not have been accepted."""


def strict(item: Tree) -> None:
    """Every element is known, every attribute too, nothing is there twice."""
    parts, attributes = (words.split() for words in PARTS[item.tag])
    for name in item.attrib:
        if (item.tag, name) == ("axis", "rpy") and set(item.attrib[name]) <= set("-0. \t\n"):
            continue
        if name not in attributes and not name.startswith("{"):
            raise Strange(f"attribute {name} of <{item.tag}>")
    seen: set[str] = set()
    text = "".join([item.text or "", *(child.tail or "" for child in item)]).strip()
    if text and (not parts or "<" in text):
        raise Strange(f"text {text} in <{item.tag}>")
    for child in item:
        if child.tag.rpartition("}")[2] in FOREIGN:
            if any(inner.tag == "predecessor" for inner in child.iter()):
                raise Strange(f"<predecessor> in <{child.tag}>")
        elif (item.tag, child.tag.rpartition("}")[2]) == ("link", "origin"):
            continue
        elif (item.tag, child.tag) == ("robot", "inertial"):
            continue
        elif child.tag not in parts and not _resembles(child):
            continue
        elif child.tag not in parts:
            raise Strange(f"<{child.tag}> in <{item.tag}>")
        elif child.tag in seen and not _same_origin(item, child):
            raise Strange(f"<{child.tag}> twice")
        else:
            strict(child)
            seen |= {child.tag} - SEVERAL


def _same_origin(joint: Tree, origin: Tree) -> bool:
    """Whether all origins of a joint have the numbers of this one, which are then said once."""
    places = {
        tuple(float(word) for key in ("xyz", "rpy") for word in each.get(key, "0 0 0").split())
        for each in joint.findall(origin.tag)
    }
    return (joint.tag, origin.tag) == ("joint", "origin") and len(places) == 1


def _resembles(item: Tree) -> bool:
    """Whether an element, or one inside it, is a known one but for a slip."""
    return any(
        _slip(inner.tag.rpartition("}")[2].lower(), word)
        for inner in item.iter()
        for word in [*PARTS, "coupling", "loop_joint"]
    )


def _slip(word: str, meant: str) -> bool:
    """Whether a letter more or less, or two that changed places, make a word of another."""
    if sorted(word) == sorted(meant):
        return sum(a != b for a, b in zip(word, meant, strict=True)) <= 2
    short, long = sorted((word, meant), key=len)
    return any(short == long[:i] + long[i + 1 :] for i in range(len(long)))


def names_of(item: Tree) -> tuple[str, ...]:
    name, kind = item.get("name", ""), item.get("type", "")
    if not name.strip() or kind not in FREEDOMS:
        raise Strange(f"name {name!r}, type {kind!r}")
    count = len(FREEDOMS[kind])
    return (name,) * count if count == 1 else tuple(f"{name}.{k}" for k in range(count))
