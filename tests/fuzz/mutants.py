"""Mutants of the gallery's files: changes that know what a URDF file consists of.

Everything follows from a seed. A mutant is one to four changes of a good file: most touch its
elements, attributes and numbers, some its bytes, and some the YAML file that takes over its
loops.
"""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from functools import cache
from typing import NamedTuple
from xml.etree import ElementTree

from kinematics import gallery
from tests.fuzz.mutant_bytes import TEXTS, YAMLS
from tests.fuzz.mutant_elements import ELEMENTS

Tree = ElementTree.Element


class Mutant(NamedTuple):
    """A robot, the YAML file beside it if there is one, and how they came about."""

    seed: int
    model: str
    changes: tuple[str, ...]
    urdf: bytes
    yaml: bytes | None


def mutant(seed: int) -> Mutant:
    """The mutant of a seed."""
    rng = random.Random(seed)
    model = rng.choice(sorted(gallery()))
    tree = copy.deepcopy(_tree(model))
    changes: list[Callable] = []
    yaml = None
    if rng.random() < 0.15:
        yaml = beside(rng, tree)
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 4))):
        change = rng.choice(ELEMENTS)
        change(rng, tree)
        changes.append(change)
    data = ElementTree.tostring(tree, encoding="unicode").encode()
    if rng.random() < 0.15:
        data = _of_text(rng, data, changes)
    if yaml is not None and rng.random() < 0.7:
        yaml = _of_yaml(rng, yaml, changes)
    names = tuple(change.__name__ for change in changes)
    return Mutant(seed, model, names, data, yaml)


@cache
def _tree(model: str) -> Tree:
    return ElementTree.parse(gallery()[model]).getroot()


def _of_text(rng: random.Random, data: bytes, changes: list[Callable]) -> bytes:
    change = rng.choice(TEXTS)
    changes.append(change)
    return change(rng, data)


def _of_yaml(rng: random.Random, data: bytes, changes: list[Callable]) -> bytes:
    change = rng.choice((*TEXTS, *YAMLS, *YAMLS))
    changes.append(change)
    return change(rng, data)


def beside(rng: random.Random, tree: Tree) -> bytes:
    """A YAML file with the loops of a tree, which loses them; they become pairs of frames."""
    pairs, kinds = [], []
    for loop in tree.findall("loop"):
        tree.remove(loop)
        names = []
        for side in loop:
            if side.tag in ("predecessor", "successor"):
                name = f"{loop.get('name')}_{side.tag}"
                ElementTree.SubElement(tree, "link", {"name": name})
                joint = ElementTree.SubElement(tree, "joint", {"name": f"to_{name}"})
                joint.set("type", "fixed")
                joint.extend(side)
                ElementTree.SubElement(joint, "parent", {"link": side.get("link", "")})
                ElementTree.SubElement(joint, "child", {"link": name})
                names.append(name)
        pairs.append(f"[{', '.join(names)}]")
        kinds.append(rng.choice(("3d", "3d", "6d")))
    moving = [j.get("name", "") for j in tree.findall("joint") if j.get("type") != "fixed"]
    lines = [f"closed_loop: [{', '.join(pairs)}]", f"type: [{', '.join(kinds)}]"]
    if rng.random() < 0.3:
        lines.append(f"name_mot: [{rng.choice(moving)}]")
    if rng.random() < 0.3:
        kind = rng.choice(("SPHERICAL", "FIXED", "UJOINT_XY", "UJOINT_ZX", "CARDAN"))
        lines += [f"joint_name: [{rng.choice(moving)}]", f"joint_type: [{kind}]"]
    return ("\n".join(lines) + "\n").encode()
