"""Convert an MJCF file to the elements of a URDF file, equalities to loops and mimic joints."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from kinematics.error_text import clean
from kinematics.files.formats.mjcf.body_tree import BodyTree
from kinematics.files.formats.mjcf.compile_file import compile_file
from kinematics.files.formats.mjcf.includes import expand_includes
from kinematics.files.formats.mjcf.reduce_file import reduce_file
from kinematics.files.formats.mjcf.write_words import round_to, write_origin
from kinematics.files.urdf.validate_fields import MAX_NUMBER
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element, unused_name
from kinematics.model.document.write_numbers import number_words

NOT_READ = "not_read"
"""The code of remarks on what a file has and a linkage does not."""

Remarks = tuple[tuple[str, str], ...]

_CONNECT, _WELD, _JOINT = range(3)
_NAMES = {_CONNECT: "connect", _WELD: "weld", _JOINT: "joint"}
_NO_TURN = (1.0, 0.0, 0.0, 0.0)
# Object type of a constraint between sites: ``mjOBJ_SITE``.
_SITE = 6


def convert_mjcf(root: Element, path: str | None) -> tuple[Element, Remarks]:
    """Convert the elements of an MJCF file to those of a URDF file.

    The reference pose is ``qpos0``; joint positions count from there. A connect becomes a
    spherical loop, a weld a fixed loop, and a linear constraint between joints a ``<mimic>``.

    Args:
        root: the ``<mujoco>`` element.
        path: its file; None for a stream.

    Returns:
        The ``<robot>`` element, and code and message of each remark.

    Raises:
        PackageError: MuJoCo is not installed.
        Refusal: the file cannot be converted, or MuJoCo refuses it.
    """
    root = expand_includes(root, path)
    file = reduce_file(root)
    compiled = compile_file(file, None if path is None else os.path.dirname(path))
    tree = BodyTree(compiled)
    equalities = EqualityReader(tree, file.disabled)
    equalities.couple_joints()
    parts = list(tree.parts())
    parts += equalities.loops()
    parts += _transmissions(root, set(tree.joints))
    stem = os.path.splitext(os.path.basename(path or ""))[0]
    name = root.attributes.get("model", "").strip() or stem or "mjcf"
    texts = (*file.remarks, *equalities.remarks, *compiled.warnings)
    place = path or "MJCF"
    remarks = [(NOT_READ, f"{place}: {text}") for text in texts]
    return make_elements.robot(name, parts), tuple(remarks)


def _transmissions(root: Element, joints: set[str]) -> Iterator[Element]:
    """Make a ``<transmission>`` for every joint with an actuator: a preferred input."""
    seen: set[str] = set()
    for section in root.every("actuator"):
        for item in section.children:
            joint = item.attributes.get("joint") or item.attributes.get("jointinparent", "")
            if joint in joints and joint not in seen:
                seen.add(joint)
                inside = (Element("joint", {"name": joint}),)
                yield Element("transmission", {"name": item.name or f"{joint}_drive"}, inside)


class EqualityReader:
    """The equality constraints of a compiled file.

    Attributes:
        remarks: what is said of constraints that are left out, or that hold a mocap body.
    """

    def __init__(self, tree: BodyTree, disabled: bool) -> None:
        """Choose the active constraints.

        Args:
            disabled: whether the file switches all constraints off.
        """
        self.tree, self.model = tree, tree.model
        self.remarks: list[str] = []
        self.active: list[int] = []
        if not np.abs(self.model.eq_data).max(initial=0.0) <= MAX_NUMBER:
            problem = "an equality constraint has a number that is not finite, or out of range"
            raise Refusal("<equality>", problem, "correct its numbers")
        idle: list[int] = []
        for e in range(self.model.neq):
            on = bool(self.model.eq_active0[e]) and not disabled
            if on and self._is_inside_one_body(e):
                self.remarks.append(
                    f"{self._label(e)}: its bodies cannot move apart without it, left out"
                )
            else:
                (self.active if on else idle).append(e)
        if idle:
            more = f" and {len(idle) - 1} more" if len(idle) > 1 else ""
            self.remarks.append(
                f"{self._label(idle[0])}{more}: not active in the file, left out"
            )

    def couple_joints(self) -> None:
        """Enter the constraints between joints into the tree, which holds or couples them."""
        relations = []
        for e in self.active:
            if self.model.eq_type[e] == _JOINT:
                relations += list(self._read_relation(e))
        self.tree.relations.update(_follow_relations(relations))

    def loops(self) -> Iterator[Element]:
        """Make a ``<loop>`` for every other constraint; two connects of two bodies make one."""
        hinges = self._find_hinges()
        for e in self.active:
            kind = int(self.model.eq_type[e])
            if e in hinges.values():
                continue
            if e in hinges:
                yield self._hinge(e, hinges[e])
                continue
            if kind in (_CONNECT, _WELD):
                yield self._loop(e, kind)
            elif kind != _JOINT:
                problem = "an equality constraint of this type is not read"
                raise Refusal(self._label(e), problem, "write it as connect, weld or joint")

    def _is_inside_one_body(self, e: int) -> bool:
        """Whether no joint moves the bodies of a connect or a weld against each other."""
        if self.model.eq_type[e] not in (_CONNECT, _WELD):
            return False
        roots = set()
        for body in self._bodies(e):
            while body and not self.model.body_jntnum[body]:
                body = int(self.model.body_parentid[body])
            roots.add(body)
        return len(roots) == 1

    def _label(self, e: int) -> str:
        model = self.model
        kind = _NAMES.get(int(model.eq_type[e]), "equality")
        if name := model.eq(e).name:
            return f"{kind} '{clean(name)}'"
        ends = [clean(name) for name in self._ends(e)]
        return f"{kind} of {' and '.join(ends)}"

    def _ends(self, e: int) -> list[str]:
        """Names of the joints or bodies of a constraint."""
        model = self.model
        if model.eq_type[e] == _JOINT:
            both = (model.eq_obj1id[e], model.eq_obj2id[e])
            return [f"'{self.tree.joints[j]}'" for j in both if j >= 0]
        if model.eq_type[e] in (_CONNECT, _WELD):
            return [f"'{self.tree.bodies[body]}'" for body in self._bodies(e)]
        return []

    def _bodies(self, e: int) -> list[int]:
        both = [int(self.model.eq_obj1id[e]), int(self.model.eq_obj2id[e])]
        if self.model.eq_objtype[e] == _SITE:
            return [int(self.model.site_bodyid[site]) for site in both]
        return both

    def _read_relation(self, e: int) -> Iterator[_Relation]:
        """Read a constraint between joints: ``q1 = offset + multiplier q2``."""
        model, names = self.model, self.tree.joints
        offset, multiplier, *higher = (float(c) for c in model.eq_data[e][:5])
        first, second = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if second >= 0 and any(higher):
            problem = "its polycoef is not linear, and a <mimic> is"
            raise Refusal(self._label(e), problem, "write a linear relation, or remove it")
        if second >= 0 and multiplier:
            yield _Relation(names[first], names[second], multiplier, offset, self._label(e))
            return
        if offset:
            problem = f"it holds a joint at {offset:g} beside its reference position"
            remedy = "let polycoef begin with 0, and move the body or the ref of the joint"
            raise Refusal(self._label(e), problem, remedy)
        self.tree.held.add(names[first])

    def _find_hinges(self) -> dict[int, int]:
        """Find pairs of connects of the same two bodies at two points: first to second."""
        model: Any = self.model
        first: dict[tuple[int, int], int] = {}
        hinges: dict[int, int] = {}
        for e in self.active:
            if model.eq_type[e] != _CONNECT or model.eq_objtype[e] == _SITE:
                continue
            body, other = self._bodies(e)
            before = first.setdefault((body, other), e)
            if before in hinges or before == e:
                continue
            apart = model.eq_data[e][:6] - model.eq_data[before][:6]
            if min(np.linalg.norm(apart[:3]), np.linalg.norm(apart[3:])) > 0.0:
                hinges[before] = e
        return hinges

    def _hinge(self, e: int, second: int) -> Element:
        """Make the revolute ``<loop>`` of two connects: its axis goes through both points.

        Its frames have the axes of the first body at the reference pose, where the points of
        the two bodies coincide.
        """
        data, bodies = self.model.eq_data[e], self._bodies(e)
        axis = self.model.eq_data[second][:3] - data[:3]
        size = self._size([data[:6]])
        places = [write_origin(data[:3], _NO_TURN, size)]
        turns = self.tree.turns
        places.append(write_origin(data[3:6], turns[bodies[1]].T @ turns[bodies[0]], size))
        ends = [self.tree.carriers[body] for body in bodies]
        self._remark_mocap(e, bodies)
        words = number_words(round_to(axis, size))
        sides = list(zip(ends, places, strict=True))
        return make_elements.loop(self._name(e, _CONNECT), "revolute", sides, (words, ""))

    def _name(self, e: int, kind: int) -> str:
        return unused_name(self.model.eq(e).name or f"{_NAMES[kind]}{e}", self.tree.moving)

    def _loop(self, e: int, kind: int) -> Element:
        """Make the ``<loop>`` of a connect or a weld."""
        model: Any = self.model
        data, bodies = model.eq_data[e], self._bodies(e)
        turns = [_NO_TURN, _NO_TURN]
        if model.eq_objtype[e] == _SITE:
            both = (model.eq_obj1id[e], model.eq_obj2id[e])
            points = [model.site_pos[site] for site in both]
            turns = [model.site_quat[site] for site in both]
        elif kind == _CONNECT:
            points = [data[:3], data[3:6]]
        else:
            points, turns[0] = [data[3:6], data[:3]], data[6:10]
        loose = kind == _CONNECT or data[10] == 0.0
        if loose:
            turns = [_NO_TURN, _NO_TURN]
        self._remark_mocap(e, bodies)
        sides = [
            (self.tree.carriers[body], write_origin(point, turn, self._size(points)))
            for body, point, turn in zip(bodies, points, turns, strict=True)
        ]
        shape = "spherical" if loose else "fixed"
        return make_elements.loop(self._name(e, kind), shape, sides)

    def _size(self, points: list[Any]) -> float:
        return max(self.tree.size, float(np.abs(points).max()))

    def _remark_mocap(self, e: int, bodies: list[int]) -> None:
        """Say that a constraint holds a body at one that the user moves in MuJoCo."""
        for body in bodies:
            if self.model.body_mocapid[body] >= 0:
                self.remarks.append(
                    f"{self._label(e)}: '{clean(self.tree.bodies[body])}' is a mocap body, "
                    'taken as fixed to the ground; write active="false" to leave it out'
                )


class _Relation(NamedTuple):
    """A relation ``first = offset + multiplier × second`` of joint positions.

    Attributes:
        first: name of a joint.
        second: name of another.
        multiplier: not zero.
        offset: rad or m.
        label: the constraint, in messages.
    """

    first: str
    second: str
    multiplier: float
    offset: float
    label: str


def _follow_relations(relations: Iterable[_Relation]) -> dict[str, tuple[str, float, float]]:
    """Let every joint follow at most one other, without circles.

    A relation is used as it stands if possible, otherwise solved for its second joint.

    Args:
        relations: in the order of the file.

    Returns:
        Source, multiplier and offset of each joint that follows another, by its name.

    Raises:
        Refusal: relations form a circle.
    """
    waiting: list[_Relation] = []
    groups: dict[str, set[str]] = {}
    for relation in relations:
        group, other = (groups.setdefault(end, {end}) for end in relation[:2])
        if group is other:
            problem = "it couples joints that other constraints couple already"
            raise Refusal(relation.label, problem, "remove one of them")
        group |= other
        groups.update(dict.fromkeys(other, group))
        waiting.append(relation)
    firsts = {relation.first for relation in waiting}
    reached: set[str] = set()
    follows: dict[str, tuple[str, float, float]] = {}
    while waiting:
        r = next((r for r in waiting if r.first in reached or r.second in reached), None)
        if r is None:
            reached.add(next((r for r in waiting if r.second not in firsts), waiting[0]).second)
            continue
        waiting.remove(r)
        if r.second in reached:
            follows[r.first] = (r.second, r.multiplier, r.offset)
        else:
            follows[r.second] = (r.first, 1.0 / r.multiplier, -r.offset / r.multiplier)
        reached |= {r.first, r.second}
    return follows
