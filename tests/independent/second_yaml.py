"""The second reading of a YAML file beside a robot: its loops go into the tree."""

from __future__ import annotations

from xml.etree import ElementTree

from tests.independent.second_words import FREEDOMS, Strange, names_of

Tree = ElementTree.Element


def beside(root: Tree, yaml: bytes) -> list[str]:
    """Put the loops of a YAML file into the tree; the coordinates that it names as inputs."""
    from yaml import BaseLoader, YAMLError, load

    words = ("closed_loop", "name_mot", "joint_name", "joint_type", "rotule_name")
    if not any(word.encode() in yaml for word in words):
        return []
    try:
        keys = load(yaml, BaseLoader)
    except (YAMLError, ValueError) as error:
        raise Strange(f"no YAML: {error}") from None
    if not isinstance(keys, dict) or not set(keys) <= {*words, "type", "Lidmot", "Lidvmot"}:
        raise Strange("unknown keys")
    keys = {key: value for key, value in keys.items() if value not in ("", "~", "null")}
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    _retyped(keys, joints)
    after = {name: j.find("child").get("link") for name, j in joints.items()}
    after |= {link.get("name", ""): link.get("name", "") for link in root.findall("link")}
    pairs = keys.get("closed_loop", [])
    for pair, kind in zip(pairs, _listed(keys.get("type", "6d"), len(pairs)), strict=True):
        attributes = {"name": "/".join(pair), "type": {"3d": "spherical"}.get(kind, "fixed")}
        loop = ElementTree.SubElement(root, "loop", attributes)
        for role, name in zip(("predecessor", "successor"), pair, strict=True):
            ElementTree.SubElement(loop, role, {"link": after[name]})
    named = keys.get("name_mot", [])
    if isinstance(named, str):
        named = _like(named, joints)
    return [name for joint in named for name in names_of(joints[joint])]


def _listed(value: str | list, count: int) -> list[str]:
    return [word.lower() for word in ([value] * count if isinstance(value, str) else value)]


def _like(word: str, joints: dict[str, Tree]) -> list[str]:
    """The moving joint of this name, or those whose names hold the word."""
    moving = [name for name, joint in joints.items() if joint.get("type") != "fixed"]
    return [word] if word in moving else [name for name in moving if word in name]


def _retyped(keys: dict, joints: dict[str, Tree]) -> None:
    """Replace joints as the keys tell."""
    names = keys.get("joint_name", [])
    kinds = dict(zip(names, _listed(keys.get("joint_type", []), len(names)), strict=True))
    if "rotule_name" in keys:
        kinds = dict.fromkeys(_like(keys["rotule_name"], joints), "spherical") | kinds
    for name, kind in kinds.items():
        joint = joints[name]
        for tag in ("axis", "axis2", *(["screw_thread_pitch"] if kind == "fixed" else [])):
            if (item := joint.find(tag)) is not None:
                joint.remove(item)
        joint.set("type", kind if kind in FREEDOMS else "universal")
        letters = "x" if kind in FREEDOMS else kind.replace("cardan", "ujoint_xy")[-2:]
        for tag, letter in zip(("axis", "axis2"), letters, strict=False):
            unit = " ".join(str(int(letter == other)) for other in "xyz")
            ElementTree.SubElement(joint, tag, {"xyz": unit})
