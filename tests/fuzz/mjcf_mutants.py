"""Mutants of MJCF files: the gallery in all styles and random trees, with elements spoilt."""

from __future__ import annotations

import copy
import random
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

from kinematics import gallery
from tests.support.mjcf_text import STYLES, Unwritable, four_bar, mjcf_text, random_tree

NUMBERS = ("0", "-0", "1", "-1", "nan", "inf", "1e308", "-1e308", "1e-320", "1e30", "2,5", "",
    "x", "1e9", "2147483648", "99999999999999999999", "0 0 0", "1 2", "0 0 0 0", "0 " * 12,
    "1e-16", "1 2 3", "10 10 10", "0.1 0.2 0.3 0.4")  # fmt: skip
WORDS = ("ball", "free", "hinge", "slide", "box", "mesh", "sdf", "hfield", "plane", "capsule",
    "cable", "cloth", "grid", "particle", "true", "false", "auto", "world", "main", "xyz",
    "degree", "local", "global", "convex", "exact", "shell", "site", "body")  # fmt: skip
ATTRIBUTES = ("pos", "quat", "euler", "axisangle", "xyaxes", "zaxis", "fromto", "axis", "ref",
    "range", "type", "class", "childclass", "name", "joint1", "joint2", "body1", "body2",
    "site1", "site2", "polycoef", "relpose", "anchor", "mass", "size", "diaginertia",
    "fullinertia", "count", "offset", "mesh", "active", "torquescale", "mocap", "armature",
    "group", "sep", "prefix", "curve", "vertex", "builtin", "params", "file", "angle",
    "eulerseq", "inertiafromgeom", "inertiagrouprange", "boundmass", "settotalmass",
    "balanceinertia", "alignfree", "initial", "density", "user", "dim")  # fmt: skip
TAGS = ("body", "joint", "freejoint", "geom", "site", "frame", "replicate", "composite",
    "flexcomp", "inertial", "connect", "weld", "default", "asset", "mesh", "compiler",
    "include", "attach", "equality", "worldbody", "tendon", "flex", "model", "plugin",
    "option", "size", "pin", "light")  # fmt: skip


@cache
def sources() -> tuple[ElementTree.Element, ...]:
    """Good files: the gallery in all styles, random trees, and a four-bar linkage."""
    texts = [four_bar(), *(random_tree(seed) for seed in range(20))]
    for path in gallery().values():
        for style in STYLES:
            try:
                texts.append(mjcf_text(Path(path).read_text(encoding="utf-8"), style))
            except Unwritable:
                continue
    return tuple(ElementTree.fromstring(text) for text in texts)


def mjcf_mutant(seed: int) -> bytes:
    """The mutant of a seed: one to eight changes of a good file, now and then of its bytes."""
    rng = random.Random(seed)
    tree = copy.deepcopy(rng.choice(sources()))
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 8))):
        rng.choice(CHANGES)(rng, tree)
    data = bytearray(ElementTree.tostring(tree))
    for _ in range(rng.choice((0,) * 9 + (3,))):
        data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)


def change_word(rng, tree):
    item = rng.choice([item for item in tree.iter() if item.attrib] or [tree])
    key = rng.choice(list(item.attrib) or ["name"])
    words = item.get(key, "").split() or [""]
    words[rng.randrange(len(words))] = rng.choice((*NUMBERS, *WORDS))
    item.set(key, " ".join(words * rng.choice((1, 1, 1, 2, 50))))


def swap_value(rng, tree):
    one, other = (rng.choice([item for item in tree.iter()]) for _ in range(2))
    if one.attrib and other.attrib:
        one.set(rng.choice(list(one.attrib)), rng.choice(list(other.attrib.values())))


def drop_attribute(rng, tree):
    item = rng.choice(list(tree.iter()))
    if item.attrib:
        del item.attrib[rng.choice(list(item.attrib))]


def add_attribute(rng, tree):
    item = rng.choice(list(tree.iter()))
    item.set(rng.choice(ATTRIBUTES), rng.choice((*NUMBERS, *WORDS)))


def add_element(rng, tree):
    item = ElementTree.SubElement(rng.choice(list(tree.iter())), rng.choice(TAGS))
    item.set(rng.choice(ATTRIBUTES), rng.choice((*NUMBERS, *WORDS)))


def copy_element(rng, tree):
    items = list(tree.iter())
    if len(items) < 2000:
        rng.choice(items).append(copy.deepcopy(rng.choice(items)))


def drop_element(rng, tree):
    holder = rng.choice([item for item in tree.iter() if len(item)] or [tree])
    if len(holder):
        holder.remove(rng.choice(list(holder)))


def rename_element(rng, tree):
    rng.choice(list(tree.iter())).tag = rng.choice(TAGS)


def nest_deeply(rng, tree):
    item = rng.choice(list(tree.iter()))
    tag = rng.choice(("body", "frame", "default", "geom", "replicate", "composite"))
    for _ in range(rng.choice((3, 30, 180))):
        item = ElementTree.SubElement(item, tag, count="9")


CHANGES = (
    change_word,
    change_word,
    change_word,
    swap_value,
    drop_attribute,
    add_attribute,
    add_attribute,
    add_element,
    copy_element,
    drop_element,
    rename_element,
    nest_deeply,
)
