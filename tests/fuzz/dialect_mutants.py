"""Files with loops in the words of other tools, at random places with random content.

Everything follows from a seed: a file of the gallery, with its loops or without, gets one to
three elements. Most are right, many are damaged.
"""

from __future__ import annotations

import copy
import random
from functools import cache
from typing import NamedTuple
from xml.etree import ElementTree

from kinematics import gallery
from tests.fuzz.mutant_elements import KINDS, NAMES, NUMBERS, ODD_NUMBERS, ODD_TYPES, typo

Tree = ElementTree.Element

SDF = "<joint name='{N}' type='{T}'><parent>{A}</parent><child>{B}</child>{inner}</joint>"
POSE = "<pose{base}>{P} {R}</pose><axis><xyz{frame}>{P}</xyz></axis>"
TEMPLATES = (
    f"<gazebo>{SDF}</gazebo>",
    f"<gazebo>{SDF}{SDF}</gazebo>",
    f"<gazebo reference='{{A}}'>{SDF}</gazebo>",
    f"<gazebo><model>{SDF}</model></gazebo>",
    "<gazebo><plugin name='DetachableJoint'><parent_link>{A}</parent_link>"
    "<child_model>{M}</child_model><child_link>{B}</child_link></plugin></gazebo>",
    "<constraint name='{N}' type='{T}'><parent link='{A}'/><parent_origin xyz='{P}' rpy='{R}'/>"
    "<parent_axis xyz='{P}'/><child link='{B}'/><child_origin xyz='{P}' rpy='{R}'/>"
    "<child_axis xyz='{P}'/></constraint>",
    "<drake:ball_constraint xmlns:drake='http://drake.mit.edu'>"
    "<drake:ball_constraint_body_A name='{A}'/>"
    "<drake:ball_constraint_p_AP value='{P}'/><drake:ball_constraint_body_B name='{B}'/>"
    "<drake:ball_constraint_p_BQ value='{P}'/></drake:ball_constraint>",
    "<drake:linear_bushing_rpy xmlns:drake='http://drake.mit.edu'>"
    "<drake:bushing_frameA name='{A}'/><drake:bushing_frameC name='{B}'/>"
    "</drake:linear_bushing_rpy>",
    "<mujoco><equality><connect body1='{A}' body2='{B}' anchor='{P}'/></equality></mujoco>",
    "<mujoco><equality><weld body1='{A}' body2='{B}' relpose='{P} {X} {P}' anchor='{P}'/>"
    "</equality></mujoco>",
    "<mujoco><equality><weld body1='{A}' body2='{B}' torquescale='{X}'/></equality></mujoco>",
    "<mujoco><equality><joint joint1='{J}' joint2='{K}' polycoef='{X} {X}'/>"
    "<joint joint1='{K}' joint2='{J}'/></equality></mujoco>",
    "<mujoco><equality><joint joint1='{J}' polycoef='{X}'/></equality></mujoco>",
    "<loop_joint name='{N}' type='{T}'><link1 link='{A}' xyz='{P}' rpy='{R}'/>"
    "<link2 link='{B}' xyz='{P}' rpy='{R}'/><axis xyz='{P}'/></loop_joint>",
    "<coupling name='{N}'><predecessor link='{A}'/><successor link='{B}'/>"
    "<ratio value='{X}'/></coupling>",
    "<closure first='{A}' second='{B}'/>",
    "<pair-of><link name='closing_x_1'/><joint name='c1' type='fixed'><parent link='{A}'/>"
    "<child link='closing_x_1'/><origin xyz='{P}'/></joint><link name='closing_x_2'/>"
    "<joint name='c2' type='fixed'><parent link='{B}'/><child link='closing_x_2'/></joint>"
    "</pair-of>",
)
DRAKE = "http://drake.mit.edu"


class DialectMutant(NamedTuple):
    """A robot, and for each element that was added the links that it names."""

    seed: int
    model: str
    urdf: bytes
    named: tuple[frozenset[str], ...]


def dialect_mutant(seed: int) -> DialectMutant:
    """The mutant of a seed."""
    rng = random.Random(seed)
    model = rng.choice(sorted(gallery()))
    tree = copy.deepcopy(_tree(model))
    if rng.random() < 0.6:
        for loop in tree.findall("loop"):
            tree.remove(loop)
    links = [link.get("name", "") for link in tree.findall("link")]
    joints = [joint.get("name", "") for joint in tree.findall("joint")]
    named = []
    for _ in range(rng.choice((1, 1, 2, 3))):
        item = ElementTree.fromstring(_text(rng, tree.get("name", ""), links, joints))
        if rng.random() < 0.3:
            _damage(rng, item)
        named.append(frozenset(_values(item) & set(links)))
        host = tree if rng.random() < 0.9 else rng.choice(list(tree.iter()))
        parts = list(item) if item.tag == "pair-of" else [item]
        for part in parts:
            host.insert(rng.randrange(len(host) + 1), part)
    ElementTree.register_namespace("drake", DRAKE)
    return DialectMutant(seed, model, ElementTree.tostring(tree), tuple(named))


@cache
def _tree(model: str) -> Tree:
    return ElementTree.parse(gallery()[model]).getroot()


def _number(rng: random.Random) -> str:
    odd = rng.random() < 0.01
    return rng.choice(ODD_NUMBERS if odd else (*NUMBERS[:5], "0.25", "1.5708", "-2"))


def _text(rng: random.Random, robot: str, links: list[str], joints: list[str]) -> str:
    """An element: a template with its blanks filled in."""

    def name(known):
        return _escaped(rng.choice(NAMES if rng.random() < 0.05 else known))

    def vector():
        return " ".join(_escaped(_number(rng)) for _ in range(3))

    frames = ("", "", f" relative_to='{name(links)}'", " relative_to='__model__'")
    axes = ("", "", f" expressed_in='{name(links)}'", " expressed_in='__model__'")
    kinds = (*KINDS, "ball", "spherical_joint", *ODD_TYPES)
    inner = rng.choice((POSE, POSE, "")).format(
        base=rng.choice(frames), frame=rng.choice(axes), P=vector(), R=vector()
    )
    first, second = rng.sample(links, 2) if rng.random() < 0.9 else (name(links), name(links))
    return rng.choice(TEMPLATES).format(
        A=first,
        B=second,
        J=name(joints),
        K=name(joints),
        P=vector(),
        R=vector(),
        X=_escaped(_number(rng)),
        T=_escaped(rng.choice(kinds)),
        inner=inner,
        N=_escaped(rng.choice(("l", "m", "n", *NAMES[:3]))),
        M=rng.choice((robot, "", "box")),
    )


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("'", "&apos;")


def _damage(rng: random.Random, item: Tree) -> None:
    """Drop, repeat or misspell something inside an element."""
    part = rng.choice(list(item.iter()))
    what = rng.randrange(5)
    if what == 0 and len(part):
        part.remove(rng.choice(list(part)))
    elif what == 1 and len(part):
        part.append(copy.deepcopy(rng.choice(list(part))))
    elif what == 2 and part.attrib:
        del part.attrib[rng.choice(sorted(part.attrib))]
    elif what == 3 and part.attrib:
        name = rng.choice(sorted(part.attrib))
        part.attrib[typo(rng, name)] = part.attrib.pop(name)
    elif "}" not in part.tag:
        part.tag = typo(rng, part.tag)


def _values(item: Tree) -> set[str]:
    """Texts and attributes of an element."""
    return {
        value.strip()
        for part in item.iter()
        for name, value in (("", part.text or ""), *part.attrib.items())
        if name not in ("name", "reference", "relative_to", "expressed_in")
        or part.tag[0] == "{"
    }
