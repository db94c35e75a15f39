"""Find the model of an SDF file: the only one that can move."""

from __future__ import annotations

import re

from kinematics.error_text import clean, quoted
from kinematics.files.formats.sdf.fields import is_true
from kinematics.files.formats.sdf.tags import check_plugin
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

# Minor numbers of the first and the last version 1.x that is read.
FIRST, LAST = 4, 12
# Models of nearly every world, which do not move.
_SCENERY = ("sun", "ground_plane")


def version_of(root: Element) -> int:
    """Return the minor number of the version of SDF.

    Raises:
        Refusal: it is missing, or not one that is read.
    """
    text = root.attributes.get("version", "")
    version = re.fullmatch(r"1\.(\d{1,3})(\.\d{1,3})?", text, re.ASCII)
    if version is None or not FIRST <= int(version[1]) <= LAST:
        problem = f"version '{clean(text)}' of SDF" if text else "no version"
        remedy = f"give SDF 1.{FIRST} to 1.{LAST}; 'gz sdf -p FILE' converts older files"
        raise Refusal(root.label, problem, remedy)
    return int(version[1])


def find_model(root: Element) -> Element:
    """Return the only model that can move, in the file or in its world.

    Raises:
        Refusal: there is none, there are several, or something else may move.
    """
    worlds = root.every("world")
    if len(worlds) > 1:
        raise Refusal(worlds[1].label, "more than one world", "give a file with one model")
    models = []
    for host in (root, *worlds):
        for item in host.children:
            if item.tag == "model":
                models.append(item)
            elif item.tag == "plugin":
                check_plugin(item)
            elif item.tag == "joint":
                remedy = "move it into the model, and both of its links with it"
                raise Refusal(item.label, f"a joint in <{host.tag}> is not read", remedy)
    moving = [model for model in models if not is_true(model, model.first("static"))]
    if len(moving) == 1:
        return moving[0]
    if moving:
        problem = f"more than one model: {quoted(model.name for model in moving)}"
        raise Refusal(moving[1].label, problem, "give a file with one of them")
    if models:
        remedy = "remove <static>, and fix its base with a joint whose parent is world"
        raise Refusal(models[0].label, "a static model does not move", remedy)
    raise Refusal(root.label, "no <model>", "give an SDF file with a model")


def is_scenery(include: Element) -> bool:
    """Whether an ``<include>`` names a model of nearly every world, which does not move."""
    uri = include.first("uri")
    name = uri.text.rstrip("/").rpartition("/")[2] if uri is not None else ""
    return name.lower().replace(" ", "_") in _SCENERY
