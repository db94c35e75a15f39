"""Random linkages on which integers are hard to find.

Relations between axes of any length, yokes at dead centres, and coupled loops of which one is
off by a power of ten.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from tests.independent.plain_linkage import (
    AXES,
    Joint,
    Linkage,
    Mimic,
    Vector,
    edges,
    vector,
)
from tests.independent.planar_families import chained, corners, ring, special_inside
from tests.independent.spatial_families import _bennett, _spherical
from tests.independent.true_ranks import independent

Z = AXES[2]
# Directions whose lengths are irrational, and some whose are not.
OBLIQUE = [
    vector(*x)
    for x in (
        (1, 1, 0),
        (1, 1, 1),
        (0, 1, 2),
        (1, 2, 3),
        (1, -1, 0),
        (2, 2, 0),
        (1, 0, 3),
        ("0.3", "0.4", 1),
        (3, 4, 0),
        (0, 0, 1),
    )
]
RATIOS = [Fraction(x) for x in ("1", "1", "-1", "2", "0.5", "-3", "0.3", "1.7")]
# Those whose inverses are short decimals too.
INVERTIBLE = [Fraction(x) for x in ("1", "1", "-1", "2", "-0.5", "1.6", "-0.04")]
SPECIAL = ("parallelogram", "rhombus", "kite", "antiparallelogram")


def _choose(rng, options):
    return options[int(rng.integers(len(options)))]


def _place(rng, digits: int = 1, reach: int = 2) -> Vector:
    scale = 10**digits
    return tuple(
        Fraction(int(x), scale) for x in rng.integers(-reach * scale, reach * scale + 1, 3)
    )


def special_joints(rng) -> list[Joint]:
    """One loop with a motion: planar, special or not, a Bennett linkage or a spherical one."""
    kind = int(rng.integers(5))
    if kind < 3:
        return list(ring(corners(rng, _choose(rng, (*SPECIAL, "general", "kite")))))
    return list(_bennett(rng) if kind == 3 else _spherical(rng))


def related(rng) -> Linkage:
    """Arms on any axes that follow joints of a loop or an arm, or are told to move alike."""
    joints: list[Joint] = special_joints(rng) if rng.random() < 0.6 else []
    mimics: list[Mimic] = []
    sources = [k for k, joint in enumerate(joints) if not joint.loop]
    for _ in range(int(rng.integers(1, 3)) if joints else int(rng.integers(2, 5))):
        links = max((joint.after for joint in joints), default=0)
        kind = _choose(rng, "RRRP")
        joints.append(
            Joint(
                kind,
                int(rng.integers(0, links + 1)),
                links + 1,
                _place(rng),
                _choose(rng, OBLIQUE),
            )
        )
        at = len(joints) - 1
        if sources and rng.random() < 0.65:
            mimics.append(Mimic(at, _choose(rng, sources), _choose(rng, RATIOS)))
        else:
            sources.append(at)
    # A joint of the tree comes before those that close loops.
    order = sorted(range(len(joints)), key=lambda k: joints[k].loop)
    place = {old: new for new, old in enumerate(order)}
    mimics = [m._replace(joint=place[m.joint], source=place[m.source]) for m in mimics]
    linkage = Linkage(
        tuple(joints[k] for k in order),
        tuple(mimics),
        spatial=True,
        force=bool(rng.random() < 0.15),
        as_written=bool(rng.random() < 0.5),
    )
    return _told(rng, linkage) if rng.random() < 0.6 else linkage


def _told(rng, linkage: Linkage) -> Linkage:
    """The linkage with named inputs, some of which move alike, whatever their axes."""
    names = tuple(str(x) for x in rng.permutation([edge.name for edge in edges(linkage)]))
    free, closed = independent(linkage, names)
    if not closed or len(free) < 2:
        return linkage
    rows = []
    for k in range(1, int(rng.integers(2, len(free) + 1))):
        row = [Fraction(0)] * len(free)
        row[k], row[int(rng.integers(k))] = Fraction(1), -_choose(rng, INVERTIBLE)
        rows.append(tuple(row))
    return replace(linkage, inputs=free, relations=tuple(rows))


def add_yoke(
    joints: list[Joint],
    mimics: list[Mimic],
    source: int,
    ratio: Fraction,
    place: Vector,
    pin: Vector,
    welded: bool,
) -> int:
    """Add a yoke whose crank follows a joint; return its slide.

    At a pin (r, 0, 0) it is at a dead centre: the slide moves with the square of the angle.
    """
    links, at = max((joint.after for joint in joints), default=0), len(joints)
    joints.append(Joint("R", 0, links + 1, place, Z))
    mimics.append(Mimic(at, source, ratio))
    pin = tuple(a + b for a, b in zip(place, pin, strict=True))
    last = 0
    if not welded:
        joints.append(Joint("P", 0, links + 2, pin, AXES[0]))
        last = links + 2
    joints.append(Joint("P", last, last + 1 if last else links + 2, pin, AXES[1]))
    joints.append(Joint("R", links + 1, joints[-1].after, pin, Z, loop=True))
    return at + 1


def yokes(rng) -> Linkage:
    """A joint, at times of a special loop, drives yokes at dead centres one by one."""
    joints = special_joints(rng) if rng.random() < 0.5 else [Joint("R", 0, 1, _place(rng), Z)]
    mimics: list[Mimic] = []
    source = _choose(rng, [k for k, joint in enumerate(joints) if not joint.loop])
    radius = Fraction(1, 10 ** int(rng.integers(0, 4)))
    first = max(joint.after for joint in joints)
    count = int(rng.choice([1, 2, 3, 4], p=[0.3, 0.35, 0.25, 0.1]))
    welded = bool(rng.random() < 0.12)
    for k in range(count):
        turned = rng.random() < 0.15
        pin = (
            (radius * 3 / 5, radius * 4 / 5, radius * 0)
            if turned
            else (radius,) + (radius * 0,) * 2
        )
        source = add_yoke(
            joints,
            mimics,
            source,
            _choose(rng, RATIOS[:5]),
            vector(0, 3 * k + 3, 0),
            pin,
            welded and k == count - 1,
        )
    if not welded and rng.random() < 0.5:
        mimics.append(Mimic(len(joints), source, _choose(rng, RATIOS)))
        links = max(joint.after for joint in joints)
        axis = _choose(rng, OBLIQUE) if rng.random() < 0.5 else Z
        joints.append(Joint("R", 0, links + 1, _place(rng), axis))
    links = max(joint.after for joint in joints)
    massive = {
        1,
        *rng.choice(range(first + 1, links + 1), min(3, links - first), False).tolist(),
    }
    massive |= {links} | (set(range(1, first + 1)) if rng.random() < 0.5 else set())
    bare = tuple(k for k in range(1, links + 1) if k not in massive)
    planar = all(joint.axis == Z or joint.kind == "P" for joint in joints)
    return Linkage(
        *loops_last(joints, mimics),
        bare=bare,
        spatial=not planar or bool(rng.random() < 0.2),
        as_written=bool(rng.random() < 0.5),
    )


def loops_last(joints: list[Joint], mimics: list[Mimic]):
    """Joints of the tree before those that close loops."""
    order = sorted(range(len(joints)), key=lambda k: joints[k].loop)
    place = {old: new for new, old in enumerate(order)}
    return tuple(joints[k] for k in order), tuple(
        m._replace(joint=place[m.joint], source=place[m.source]) for m in mimics
    )


def coupled(rng) -> tuple[Linkage, tuple[Linkage, ...], int]:
    """Two or three special loops that drive each other, one of them off by 10^-k.

    Returns:
        The linkage; special ones within two units of that decimal, first the one without the
        error; and k, 0 without an error.
    """
    count = int(rng.choice([2, 3], p=[0.7, 0.3]))
    loops = [corners(rng, _choose(rng, SPECIAL)) for _ in range(count)]
    power = int(rng.choice([0, *range(1, 18)]))
    off, corner, axis = (int(rng.integers(x)) for x in (count, 4, 2))
    how = [int(rng.integers(3)) for _ in range(count)]
    where = [float(rng.random()) for _ in range(count)]
    ratio = _choose(rng, RATIOS[:5])
    moved = [list(points) for points in loops]
    if power:
        point = list(moved[off][corner])
        point[axis] += Fraction(1, 10**power)
        moved[off][corner] = tuple(point)
    spatial, as_written = bool(rng.random() < 0.3), bool(rng.random() < 0.5)
    flat = [point[:2] for point in moved[off]]
    near = special_inside(flat, power) if power else ()
    found, *specials = (
        Linkage(*_coupled(shapes, how, where, ratio), spatial=spatial, as_written=as_written)
        for shapes in (
            moved,
            loops,
            *([*loops[:off], [(*p, Fraction(0)) for p in x], *loops[off + 1 :]] for x in near),
        )
    )
    return found, tuple(specials), power


def _coupled(loops, how, where, ratio):
    """Join loops: by a common link that turns, on a link of the one before, or by a gear."""
    joints, mimics = list(ring(loops[0])), []
    for k, points in enumerate(loops[1:], 1):
        if how[k] == 0:  # the crank is that of the first loop: points follow its pivot
            shift = tuple(a - b for a, b in zip(loops[0][0], points[0], strict=True))
            points = [tuple(a + b for a, b in zip(p, shift, strict=True)) for p in points]
            chained(joints, 1, 0, "RRR", points[1:], [Z] * 3)
        elif how[k] == 1:  # on the coupler
            base = 2 if where[k] < 0.5 else 3
            chained(joints, base, base, "RRRR", points, [Z] * 4)
        else:  # by a gear
            at = len(joints)
            chained(joints, 0, 0, "RRRR", points, [Z] * 4)
            mimics.append(Mimic(at, 0, ratio))
    return loops_last(joints, mimics)
