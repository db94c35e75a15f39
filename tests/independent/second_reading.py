"""A second reading of a URDF file, by the standard library's XML parser and plain formulas.

It shares nothing with the product but NumPy, and it is strict: what it does not know, and
what a file says twice, it does not read. :func:`differences` compares it with what the
product made of the same file.
"""

from __future__ import annotations

import math
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from tests.independent.second_words import FREEDOMS, Strange, names_of, strict
from tests.independent.second_yaml import beside

Tree = ElementTree.Element


class Joint(NamedTuple):
    """A joint of the file: names of its coordinates, where it is, and how it moves."""

    names: tuple[str, ...]
    kind: str
    parent: str
    point: np.ndarray
    n: np.ndarray
    u: np.ndarray | None
    pitch: float


class Weld(NamedTuple):
    """A loop: its joint, the link at its far side, and how far it is open: metres, radians."""

    joint: Joint
    successor: str
    after: np.ndarray
    distance: float
    angle: float


class Reading(NamedTuple):
    """What a file says, link poses (4, 4) included; ``carrier``: last moving joint."""

    places: dict[str, np.ndarray]
    carrier: dict[str, str]
    joints: list[Joint]
    welds: dict[str, Weld]
    mimics: dict[str, tuple[str, float, float]]
    inertias: dict[str, tuple[float, np.ndarray, np.ndarray]]
    inputs: list[str]
    extent: float


def read(data: bytes, yaml: bytes | None = None) -> Reading:
    """The reading of a file, with the YAML file beside it.

    Raises:
        Strange: there is something in it that this reading does not know.
    """
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise Strange(f"no XML: {error}") from None
    if root.tag != "robot":
        raise Strange("no <robot>")
    strict(root)
    inputs = beside(root, yaml) if yaml is not None and not root.findall("loop") else []
    return _of_tree(root, inputs)


def _vector(item: Tree | None, name: str, default: str) -> np.ndarray:
    words = default if item is None else item.get(name, default)
    try:
        numbers = [float(word) for word in words.split()]
    except ValueError:
        raise Strange(f"{name}={words}") from None
    if not all(map(math.isfinite, numbers)) or len(numbers) != len(default.split()):
        raise Strange(f"{name}={words}")
    return np.array(numbers)


def _number(item: Tree, name: str, default: str) -> float:
    return float(_vector(item, name, default)[0])


def _pose(origin: Tree | None) -> np.ndarray:
    """Entries of the rotation by fixed angles r, p, y written out, and the position."""
    r, p, y = _vector(origin, "rpy", "0 0 0")
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (r, p, y))
    x = _vector(origin, "xyz", "0 0 0")
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x[0]],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, x[1]],
            [-sp, cp * sr, cp * cr, x[2]],
            [0, 0, 0, 1],
        ]
    )


def _unit(a: np.ndarray) -> np.ndarray:
    size = math.hypot(*a)
    if not size:
        raise Strange("an axis of zero")
    return a / size


def _turned(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * K + 2 * math.sin(angle / 2) ** 2 * K @ K


def _link(item: Tree, role: str, places: dict) -> str:
    side = item.find(role)
    name = None if side is None else side.get("link")
    if name not in places:
        raise Strange(f"{role} {name}")
    return name


def _of_tree(root: Tree, inputs: list[str]) -> Reading:
    links = [link.get("name", "") for link in root.findall("link")]
    elements = {joint.get("name", ""): joint for joint in root.findall("joint")}
    mimics = {}
    for name, joint in elements.items():
        if (follow := joint.find("mimic")) is not None and joint.get("type") != "fixed":
            numbers = _number(follow, "multiplier", "1"), _number(follow, "offset", "0")
            mimics[name] = (follow.get("joint", ""), *numbers)
    reading = Reading({}, {}, [], {}, mimics, {}, inputs, 0.0)
    known = dict.fromkeys(links)
    above = {_link(joint, "child", known): joint for joint in elements.values()}
    if len(known) < len(links) or len(elements) < len(root.findall("joint")):
        raise Strange("a name twice")
    if len(above) < len(elements) or len(links) - len(above) != 1:
        raise Strange("no tree")
    for link in root.findall("link"):
        _place(link.get("name", ""), reading, above, known, [])
        _weigh(link, reading)
    extent = max(float(np.abs(pose[:3, 3]).max()) for pose in reading.places.values())
    for loop in root.findall("loop"):
        weld = _weld(loop, reading)
        reading.welds[loop.get("name", "")] = weld
        extent = max(extent, *np.abs(weld.after[:3, 3]), *np.abs(weld.joint.point))
    coordinates = [name for joint in reading.joints for name in joint.names]
    coordinates += [name for weld in reading.welds.values() for name in weld.joint.names]
    if len(set(coordinates)) < len(coordinates) or len(reading.welds) < len(
        root.findall("loop")
    ):
        raise Strange("a coordinate twice")
    if not inputs:
        for item in [*root.findall("joint"), *root.findall("loop")]:
            mark = item.get("independent", "false").strip().lower()
            if mark not in ("true", "false"):
                raise Strange("independent")
            inputs.extend(names_of(item) if mark == "true" else ())
    return reading._replace(extent=extent)


def _place(name: str, reading: Reading, above: dict, known: dict, path: list[str]) -> None:
    """The pose of a link, after those of the links before it."""
    if name in reading.places:
        return
    if name not in above:
        reading.places[name], reading.carrier[name] = np.eye(4), ""
        return
    if name in path:
        raise Strange("a cycle")
    joint = above[name]
    parent = _link(joint, "parent", known)
    _place(parent, reading, above, known, [*path, name])
    pose = reading.places[parent] @ _pose(joint.find("origin"))
    names = names_of(joint)
    first, second = joint.find("axis"), joint.find("axis2")
    n = pose[:3, :3] @ _unit(_vector(first, "xyz", "1 0 0")) if names else np.zeros(3)
    u = None if second is None else pose[:3, :3] @ _unit(_vector(second, "xyz", "0 0 0"))
    thread = joint.find("screw_thread_pitch")
    pitch = 0.0 if thread is None else _number(thread, "value", "0") / math.tau
    carrier = reading.carrier[parent]
    if names:
        kind = FREEDOMS[joint.get("type", "")]
        reading.joints.append(Joint(names, kind, carrier, pose[:3, 3], n, u, pitch))
        carrier = names[-1]
    position = _position(joint.get("name", ""), reading.mimics) if len(names) == 1 else 0.0
    pose = pose.copy()
    if joint.get("type") == "prismatic":
        pose[:3, 3] += position * n
    elif position:
        pose[:3, :3] = _turned(n, position) @ pose[:3, :3]
        pose[:3, 3] += pitch * position * n
    reading.places[name], reading.carrier[name] = pose, carrier


def _position(name: str, mimics: dict) -> float:
    if name not in mimics:
        return 0.0
    source, ratio, offset = mimics[name]
    return ratio * _position(source, mimics) + offset


def _product(inertia: Tree, name: str) -> float:
    """A product of inertia, above the diagonal or below."""
    other = f"i{name[2]}{name[1]}"
    given = {inertia.get(each) for each in (name, other)} - {None}
    if len(given) > 1:
        raise Strange(f"{name} and {other}")
    return _number(inertia, name if inertia.get(name) else other, "0")


def _weigh(link: Tree, reading: Reading) -> None:
    """Add mass, first moment and inertia about the inertial origin to the rigid body."""
    inertial = link.find("inertial")
    if inertial is None or not len(inertial):
        return
    pose = reading.places[link.get("name", "")] @ _pose(inertial.find("origin"))
    parts = inertial.find("mass"), inertial.find("inertia")
    if any(part is None for part in parts):
        raise Strange("half an inertial")
    m = _number(parts[0], "value", "0")
    xx, yy, zz = (_number(parts[1], name, "0") for name in ("ixx", "iyy", "izz"))
    xy, xz, yz = (_product(parts[1], name) for name in ("ixy", "ixz", "iyz"))
    inertia, c = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), pose[:3, 3]
    E = pose[:3, :3] @ inertia @ pose[:3, :3].T
    for i in range(3):
        for j in range(3):
            E[i, j] += m * (
                sum(c[k] ** 2 for k in range(3) if k != i) if i == j else -c[i] * c[j]
            )
    old = reading.inertias.get(reading.carrier[link.get("name", "")], (0.0, 0.0, 0.0))
    reading.inertias[reading.carrier[link.get("name", "")]] = tuple(
        a + b for a, b in zip(old, (m, m * c, E), strict=True)
    )


def _weld(loop: Tree, reading: Reading) -> Weld:
    ends = [_link(loop, role, reading.places) for role in ("predecessor", "successor")]
    before, after = (
        reading.places[end] @ _pose(loop.find(f"{role}/origin"))
        for end, role in zip(ends, ("predecessor", "successor"), strict=True)
    )
    names, kind = names_of(loop), loop.get("type")
    if reading.carrier[ends[0]] == reading.carrier[ends[1]]:
        raise Strange("a loop in one body")
    axis = _unit(_vector(loop.find("axis"), "xyz", "1 0 0"))
    n, d = before[:3, :3] @ axis, after[:3, 3] - before[:3, 3]
    Q = after[:3, :3] @ before[:3, :3].T
    along = float(n @ d) * n
    distance = {"prismatic": d - along, "cylindrical": d - along, "planar": along}.get(kind, d)
    lean = math.atan2(math.hypot(*np.cross(n, Q @ n)), n @ (Q @ n))
    twist = np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]]) / 2
    angle = lean
    if kind == "spherical":
        angle = 0.0
    elif kind in ("fixed", "prismatic"):
        angle = math.atan2(math.hypot(*twist), (np.trace(Q) - 1) / 2)
    elif kind == "universal":
        angle = math.nan
        if loop.find("axis2") is not None:
            second = after[:3, :3] @ _unit(_vector(loop.find("axis2"), "xyz", "0 0 0"))
            angle = abs(math.atan2(n @ second, math.hypot(*np.cross(n, second))))
    parent = reading.carrier[ends[0]]
    joint = Joint(names, FREEDOMS[kind], parent, before[:3, 3], n, None, 0.0)
    return Weld(joint, reading.carrier[ends[1]], after, math.hypot(*distance), angle)
