"""Refuse elements of an SDF model that would be lost: unread, misspelt, or closing loops."""

from __future__ import annotations

from collections.abc import Iterator

from kinematics.error_text import clean
from kinematics.files.urdf.validate_misplaced import intended_word
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_NUMBERS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# What is read of each element, at the places where it is read.
_READ = {
    "model": ("link", "joint", "frame", "pose", "static"),
    "link": ("inertial", "pose"),
    "joint": ("parent", "child", "pose", "axis", "axis2", "thread_pitch", "screw_thread_pitch"),
    "frame": ("pose",),
    "axis": ("xyz", "use_parent_model_frame", "mimic"),
    "axis2": ("xyz", "use_parent_model_frame"),
    "mimic": ("multiplier", "offset", "reference"),
    "inertial": ("pose", "mass", "inertia"),
    "inertia": _NUMBERS,
}
# What SDF has besides, which does not change the linkage.
_IDLE = {
    "model": ("plugin", "self_collide", "allow_auto_disable", "enable_wind", "audio_source"),
    "link": ("visual", "collision", "sensor", "plugin", "gravity", "kinematic", "light",
             "projector", "audio_source", "audio_sink", "battery", "particle_emitter",
             "self_collide", "enable_wind", "must_be_base_link", "velocity_decay", "material"),
    "joint": ("physics", "sensor", "plugin", "dynamics", "gearbox_ratio", "limit",
              "gearbox_reference_body"),
    "axis": ("dynamics", "initial_position", "limit"),
    "axis2": ("dynamics", "initial_position", "limit", "mimic"),
    "inertial": ("density", "auto_inertia_params", "fluid_added_mass", "frame"),
}  # fmt: skip
_REFUSED = {
    "gripper": "remove it, and write a fixed joint to what it holds, if it holds something",
}
_ATTRIBUTES = {
    "pose": ("relative_to", "degrees", "rotation_format", "frame"),
    "xyz": ("expressed_in",),
    "frame": ("name", "attached_to"),
    "mimic": ("joint", "axis"),
    "joint": ("name", "type"),
}
# Words of elements of other tools, behind a prefix, that move or close something.
_MOVING = ("joint", "constraint", "bushing", "coupl", "loop", "weld", "mimic", "equality")
# Those that name links and do neither.
_HARMLESS = ("collision_filter_group", "linear_spring_damper", "joint_actuator")
# Parts of plugins that join two links.
_JOINING = ("child_link", "mimicjoint", "mimic_joint", "second_link", "link2")
# Elements in which other tools write theirs.
_OPEN = ("model", "link", "joint")


def check_tags(model: Element) -> None:
    """Check the elements of a model, as deep as they are read.

    Raises:
        Refusal: an element is unread, misspelt, or may close a loop.
    """
    links = {link.name for link in model.every("link")}
    hosts = [model]
    while hosts:
        host = hosts.pop()
        _check_attributes(host)
        for item in host.children:
            if item.tag in _READ.get(host.tag, ()):
                hosts.append(item)
            elif item.tag == "plugin":
                check_plugin(item)
            elif item.tag not in _IDLE.get(host.tag, ()):
                _check_unknown(host, item, links)


def check_plugin(plugin: Element) -> None:
    """Reject a plugin that joins two links, or couples two joints.

    Raises:
        Refusal: it does; the remedy is the element to write.
    """
    words = plugin.attributes.get("filename", "") + plugin.name
    inside = [item.tag.lower() for item in plugin.walk() if item.tag.lower() in _JOINING]
    mimics = "mimic" in words.lower() or any("mimic" in tag for tag in inside)
    if inside or mimics or "DetachableJoint" in words:
        remedy = "write a fixed joint in its place, or remove it"
        if mimics:
            remedy = "write a <mimic> into the <axis> of the joint in its place, or remove it"
        raise Refusal(plugin.label, "a plugin that joins links is not read", remedy)


def _check_attributes(item: Element) -> None:
    attributes = _ATTRIBUTES.get(item.tag)
    for name in item.attributes if attributes else ():
        if ":" not in name and name != "xmlns" and name not in (attributes or ()):
            problem = f"<{item.tag} {clean(name)}> is not read"
            close = intended_word(name, attributes or ())
            if item.tag != "joint" or close:
                remedy = f"write {close or ' or '.join(attributes or ())}, or remove it"
                raise Refusal(item.label, problem, remedy)


def _check_unknown(host: Element, item: Element, links: set[str]) -> None:
    """Reject an element that is not of SDF, if it may have a meaning for the linkage."""
    where = f"<{clean(item.tag)}> in <{host.tag}>"
    prefix, _, word = item.tag.rpartition(":")
    if item.tag in _REFUSED and host.tag == "model":
        raise Refusal(item.label, f"{where} is not supported", _REFUSED[item.tag])
    if prefix:
        if word in _HARMLESS:
            return
        named = {name for inner in item.walk() for name in _names(inner) if name in links}
        if len(named) > 1 or any(part in word for part in _MOVING):
            remedy = "write it as <joint> elements of SDF, or remove it"
            if "mimic" in word:
                remedy = "write a <mimic> of SDF into the <axis>, or remove it"
            raise Refusal(item.label, f"{where} is not read", remedy)
        return
    tags = _READ.get(host.tag, ())
    if not tags:
        remedy = f"remove it: <{host.tag}> holds a text only"
        raise Refusal(item.label, f"{where} is not read", remedy)
    close = intended_word(item.tag, tags)
    if close or host.tag not in _OPEN:
        remedy = f"write {f'<{close}>' if close else ' or '.join(tags)}, or remove it"
        raise Refusal(item.label, f"{where} is not read", remedy)
    inner = next(
        (i for i in item.walk() if i.tag in ("link", "joint", "inertial", "pose")), None
    )
    if inner is not None:
        problem = f"inside <{clean(item.tag)}> (line {item.line}), where it is not read"
        raise Refusal(inner.label, problem, f"move it out of <{clean(item.tag)}>")


def _names(item: Element) -> Iterator[str]:
    """Texts of an element that may be names."""
    yield item.text
    yield from item.attributes.values()
