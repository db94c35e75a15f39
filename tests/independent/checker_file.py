"""Whether the chain in a proof is that of a URDF file, read here in rational numbers.

The reading is a third one, and small: decimals are fractions, and angles of axes are 0 or
multiples of π/2. Screws are the same if one is a positive multiple of the other, exactly;
only the pitch of a thread, a length over 2π, is compared to 1e-15. Joints of several
freedoms are chains of screws through one point, or in one plane.
"""

import math
from fractions import Fraction
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from tests.independent.checker import fractions, same_span
from tests.independent.checker_form import Rejected, need
from tests.independent.second_words import FREEDOMS, Strange, names_of

# An angle this near to a multiple of π/2 is one: 1.5708 is.
RIGHT = 1e-4


class Freedom(NamedTuple):
    """A coordinate: of which joint and which of it, the one before, and what it may be."""

    name: str
    place: int
    before: str
    kind: str
    point: np.ndarray
    n: np.ndarray
    u: np.ndarray | None
    pitch: float


class File(NamedTuple):
    """Coordinates by name, welds, mimics, links with a mass, and inputs."""

    freedoms: dict[str, Freedom]
    welds: list[set[str]]
    mimics: dict[str, tuple[str, Fraction]]
    heavy: set[str]
    inputs: list[str]


def check_file(proof, data, motion=(), inputs=()):
    """Raise `Rejected` unless the chain of a proof that was checked is that of a file.

    Args:
        proof: the proof.
        data: the bytes of the file.
        motion: relations of the inputs, each a mapping from names to coefficients: their sum
            of displacements is zero. The axes that they name must have one length.
        inputs: coordinates that drive the linkage, where they are not those of the file.
    """
    try:
        file = _read(data)
    except (Strange, ElementTree.ParseError) as error:
        raise Rejected(f"file: {error}") from None
    chain = fractions(proof["chain"])
    names = _named(chain, file, {})
    need(names is not None, "chain", "its joints are not those of the file")
    at = {name: j for j, name in enumerate(names)} | {"": -1}
    welds = sorted(sorted(at[name] for name in weld) for weld in file.welds)
    need(sorted(map(sorted, chain["ends"])) == welds, "ends", "not the loops of the file")
    need(set(chain["links"]) == {at[n] for n in file.heavy}, "links", "not those with a mass")
    _same_mimics(chain, file, at)
    driving = [at[name] for name in inputs or file.inputs]
    free = [j for j in range(len(names)) if j not in chain["dependent"]]
    need(not driving or sorted(driving) == free, "dependent", "not those of the file")
    relations = np.zeros((len(motion), len(names)), object)
    for row, relation in zip(relations, motion, strict=True):
        for name, factor in relation.items():
            row[at[name]] = Fraction(factor)
        lengths = {_square(chain["screws"][at[name]]) for name in relation}
        plain = all(len(file.freedoms[name].kind) == 1 for name in relation)
        need(plain and len(lengths) == 1, "motion", "of axes that the file does not compare")
    columns = chain["columns"]
    need(columns.shape[1] == len(free) - len(motion), "columns", "not the whole motion")
    need(not (relations @ columns).any(), "columns", "not the motion that is meant")


def _named(chain, file, found):
    """A name for each joint, so that screws and what they follow fit; None if there is none."""
    j = len(found)
    if j == len(chain["parent"]):
        return list(found) if j == len(file.freedoms) else None
    before = [*found, ""][chain["parent"][j]]
    for name, freedom in file.freedoms.items():
        taken = name in found or freedom.before != before
        if not taken and _fits(chain["screws"][j], freedom, found):
            known = _named(chain, file, found | {name: chain["screws"][j]})
            if known is not None:
                return known
    return None


def _fits(screw, freedom, found):
    """Whether a screw is that of a freedom, given those of the joint that come before it."""
    w, v, n = screw[:3], screw[3:], freedom.n
    kind, k = freedom.kind, freedom.place
    axis = v if kind[k] == "P" else w
    moment = 0 * w if kind[k] == "P" else v - np.cross(freedom.point, w)
    if kind == "PPR" and k == 2:
        # The axis of a planar joint is anywhere.
        moment = np.array([v @ n], object)
    if freedom.pitch and w.any():
        pitch = moment @ w / (w @ w)
        moment = moment - pitch * w
        if abs(float(pitch) - freedom.pitch) > 1e-15:
            return False
    if moment.any() or (kind[k] == "P" and w.any()) or not axis.any():
        return False
    earlier = [found[freedom.name + f".{i}"] for i in range(k)]
    axes = [s[3:] if kind[i] == "P" else s[:3] for i, s in enumerate(earlier)]
    if kind in ("R", "P", "RP") or (kind == "PPR" and k == 2) or (kind == "RR" and k == 0):
        return same_span([axis], [n]) and axis @ n > 0
    if kind == "RR" and freedom.u is not None:
        across = freedom.u * (n @ n) - n * (freedom.u @ n)
        return same_span([axis], [across]) and axis @ across > 0
    flat = kind == "RRR" or axis @ n == 0
    return bool(flat and all(axis @ other == 0 for other in axes))


def _square(screw):
    """Square of the length of an axis."""
    return (screw[:3] @ screw[:3]) or (screw[3:] @ screw[3:])


def _same_mimics(chain, file, at):
    """A mimic relates coordinates; the rates of screws are those over the axes' lengths."""
    wanted = {at[name]: (at[source], ratio) for name, (source, ratio) in file.mimics.items()}
    need(len(chain["mimics"]) == len(wanted), "mimics", "not those of the file")
    squares = [
        _square(s) * math.prod(numbers)
        for s, numbers in zip(chain["screws"], chain["radicands"], strict=True)
    ]
    for row in chain["mimics"]:
        fits = False
        for j, (source, ratio) in wanted.items():
            rest = [c for i, c in enumerate(row) if i not in (j, source)]
            a, b = row[j], row[source]
            # a q̇_j / |s_j| + b q̇_source / |s_source| = 0, with q̇_j = ratio q̇_source.
            size = a * a * ratio * ratio * squares[source] == b * b * squares[j]
            fits |= bool(a and not any(rest) and size and a * b * ratio <= 0)
        need(fits, "mimics", "not those of the file")
    need(len({tuple(row) for row in chain["mimics"]}) == len(wanted), "mimics", "one twice")


def _read(data):
    """What a file says."""
    root = ElementTree.fromstring(data)
    above = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
    links = [link.get("name") for link in root.findall("link")]
    file, places = File({}, [], {}, set(), []), {}

    def place(name):
        """Pose of a link, and the coordinate that carries it."""
        if name not in places:
            joint = above.get(name)
            if joint is None:
                places[name] = np.eye(3, dtype=int).astype(object), _numbers("0 0 0"), ""
            else:
                R, x, carrier = place(joint.find("parent").get("link"))
                R, x = _moved(R, x, joint.find("origin"))
                places[name] = R, x, _add(file, joint, R, x, carrier)
        return places[name]

    for name in links:
        place(name)
    for loop in root.findall("loop"):
        ends = []
        for role in ("predecessor", "successor"):
            R, x, carrier = places[loop.find(role).get("link")]
            ends.append((*_moved(R, x, loop.find(f"{role}/origin")), carrier))
        here = _add(file, loop, *ends[0])
        file.welds.append({here, ends[1][2]})
    for link in root.findall("link"):
        mass = link.find("inertial/mass")
        carrier = places[link.get("name")][2]
        if mass is not None and _numbers(mass.get("value"))[0] and carrier:
            file.heavy.add(carrier)
    return file


def _add(file, item, R, x, carrier):
    """Add the freedoms of a joint to a file; the coordinate of what it carries."""
    names, kind = names_of(item), FREEDOMS[item.get("type")]
    thread = item.find("screw_thread_pitch")
    pitch = 0.0 if thread is None else float(thread.get("value")) / math.tau
    n, u = (
        None if axis is None else R @ _numbers(axis.get("xyz"))
        for axis in (item.find("axis"), item.find("axis2"))
    )
    n = R @ _numbers("1 0 0") if n is None else n
    for i, name in enumerate(names):
        # A coordinate of several has the name of its joint, a dot and its number.
        file.freedoms[name] = Freedom(item.get("name"), i, carrier, kind, x, n, u, pitch)
        carrier = name
    follow = item.find("mimic")
    if follow is not None and kind:
        ratio = _numbers(follow.get("multiplier", "1"))[0]
        if _numbers(follow.get("offset", "0")).any():
            raise Strange("an offset of a mimic")
        file.mimics[item.get("name")] = follow.get("joint"), ratio
    if item.get("independent") == "true":
        file.inputs.extend(names)
    return carrier


def _moved(R, x, origin):
    """A frame moved by an element ``origin``."""
    if origin is None:
        return R, x
    roll, pitch, yaw = (_right(angle) for angle in origin.get("rpy", "0 0 0").split())
    turned = R
    for (c, s), a, b in ((yaw, 0, 1), (pitch, 2, 0), (roll, 1, 2)):
        Q = np.eye(3, dtype=int).astype(object)
        Q[a, a], Q[a, b], Q[b, a], Q[b, b] = c, -s, s, c
        turned = turned @ Q
    return turned, x + R @ _numbers(origin.get("xyz", "0 0 0"))


def _right(angle):
    """Cosine and sine of a multiple of a right angle."""
    quarters = round(float(angle) / (math.pi / 2))
    if abs(float(angle) - quarters * math.pi / 2) > RIGHT * bool(quarters):
        raise Strange(f"an angle of {angle}: its sine is not rational")
    return ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]


def _numbers(text):
    try:
        return np.array([Fraction(word) for word in text.split()], object)
    except ValueError:
        raise Strange(f"numbers {text}") from None
