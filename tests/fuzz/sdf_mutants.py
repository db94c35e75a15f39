"""Mutants of SDF files: the gallery in all styles, with elements, numbers and frames spoilt.

Everything follows from a seed.
"""

from __future__ import annotations

import copy
import random
from functools import cache
from xml.etree import ElementTree

from kinematics import gallery
from tests.fuzz.mutant_elements import NAMES, NUMBERS, ODD_NUMBERS, typo
from tests.support.sdf_text import STYLES, sdf_of

TEXTS = ("pose", "xyz", "mass", "ixx", "multiplier", "offset", "screw_thread_pitch")
REFERENCES = ("relative_to", "expressed_in", "attached_to")
KINDS = (
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "ball",
    "universal",
    "screw",
    "revolute2",
    "gearbox",
    "Revolute",
    "",
)
FOREIGN = (
    "<model name='n'/>",
    "<include><uri>model://x</uri></include>",
    "<gripper/>",
    "<plugin filename='libmimic.so'/>",
    "<static>true</static>",
    "<static>x</static>",
    "<frame name='f' attached_to='f'/>",
    "<pose>1 2</pose>",
    "<pose degrees='1'>0 0 0 90 0 0</pose>",
    "<thread_pitch>0</thread_pitch>",
    "<axis2><xyz>0 1 0</xyz></axis2>",
    "<inertial/>",
    "<inertial auto='true'/>",
    "<a><link name='hidden'/></a>",
    "<mimic joint='x'/>",
    "<use_parent_model_frame>true</use_parent_model_frame>",
    "<limit><lower>x</lower></limit>",
    "<frame name='world'/>",
    "<link name='world'/>",
    "<frame name='__model__'/>",
)


@cache
def written(model: str, style: str) -> ElementTree.Element:
    return ElementTree.fromstring(sdf_of(gallery()[model], style))


def names(tree):
    return [item.get("name", "") for item in tree.iter() if item.get("name")] or ["x"]


def some(rng, tree, *tags):
    found = [item for item in tree.iter() if not tags or item.tag in tags]
    return rng.choice(found) if found else tree


def drop(rng, tree):
    holder = rng.choice([item for item in tree.iter() if len(item)] or [tree])
    if len(holder):
        holder.remove(rng.choice(list(holder)))


def repeat(rng, tree):
    holder = rng.choice([item for item in tree.iter() if len(item)] or [tree])
    if len(holder):
        holder.append(copy.deepcopy(rng.choice(list(holder))))


def move(rng, tree):
    """An element and all in it, to another place."""
    item, there = some(rng, tree), some(rng, tree)
    there.append(copy.deepcopy(item))


def swap(rng, tree):
    one, other = some(rng, tree), some(rng, tree)
    one.text, other.text = other.text, one.text


def misspell(rng, tree):
    item = some(rng, tree)
    item.tag = typo(rng, item.tag)


def misspell_attribute(rng, tree):
    item = some(rng, tree)
    for key in list(item.attrib)[:1]:
        item.set(typo(rng, key), item.attrib.pop(key))


def number(rng, tree):
    item = some(rng, tree, *TEXTS)
    words = (item.text or "").split() or ["0"]
    words[rng.randrange(len(words))] = rng.choice((*NUMBERS, *ODD_NUMBERS))
    item.text = " ".join(words)


def count(rng, tree):
    item = some(rng, tree, "pose", "xyz")
    item.text = " ".join(
        (item.text or "").split()[: rng.randrange(8)] + ["1"] * rng.randrange(3)
    )


def reference(rng, tree):
    """Frames in frames, often in a circle, and some that do not exist."""
    item = some(rng, tree, "pose", "xyz", "frame")
    known = (*names(tree), "world", "__model__", *NAMES)
    item.set(rng.choice(REFERENCES), rng.choice(known))


def other_link(rng, tree):
    some(rng, tree, "parent", "child").text = rng.choice((*names(tree), "world", *NAMES[:4]))


def rename(rng, tree):
    some(rng, tree, "link", "joint", "frame").set("name", rng.choice((*names(tree), *NAMES)))


def retype(rng, tree):
    some(rng, tree, "joint").set("type", rng.choice(KINDS))


def version(rng, tree):
    tree.set(
        "version", rng.choice(("1.4", "1.5", "1.7", "1.12", "1.3", "2.0", "1.9.0", "", "x"))
    )


def foreign(rng, tree):
    some(rng, tree, "model", "link", "joint", "axis").append(
        ElementTree.fromstring(rng.choice(FOREIGN))
    )


CHANGES = (drop, drop, repeat, move, swap, misspell, misspell_attribute, number, number, count,
           reference, reference, other_link, other_link, rename, retype, version,
           foreign)  # fmt: skip


def sdf_mutant(seed: int) -> bytes:
    """The bytes of the mutant of a seed."""
    rng = random.Random(seed)
    tree = copy.deepcopy(written(rng.choice(sorted(gallery())), rng.choice(STYLES)))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        rng.choice(CHANGES)(rng, tree)
    return ElementTree.tostring(tree, encoding="utf-8")
