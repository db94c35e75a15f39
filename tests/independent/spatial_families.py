"""Random spatial linkages: overconstrained, nearly so, trees with tilted axes, platforms."""

from __future__ import annotations

from fractions import Fraction

from tests.independent.plain_linkage import AXES, Joint, Vector, cross, vector
from tests.independent.planar_families import chained, corners, grid, nudged, ring

# Right-handed axes at right angles, of one length, in whole numbers.
FRAMES = (
    AXES,
    (AXES[1], AXES[2], AXES[0]),
    (vector(1, 2, 2), vector(2, 1, -2), vector(-2, 2, -1)),
    (vector(2, 3, 6), vector(3, -6, 2), vector(6, 2, -3)),
)
# Tangents of quarter angles: cosines and sines of all are short decimals or near to it.
HALVES = [Fraction(a, b) for a, b in ((1, 2), (1, 3), (2, 1), (3, 1), (3, 4), (4, 3), (1, 7))]


def _combined(frame, *weights: Fraction) -> Vector:
    return tuple(sum(w * e[i] for w, e in zip(weights, frame, strict=True)) for i in range(3))


def _point(rng, reach: int = 2, digits: int = 1) -> Vector:
    scale = 10**digits
    return tuple(
        Fraction(int(x), scale) for x in rng.integers(-reach * scale, reach * scale + 1, 3)
    )


def _axis(rng) -> Vector:
    """A direction in small whole numbers."""
    while True:
        n = vector(*rng.integers(-2, 3, 3))
        if any(n):
            return n


def _tilted(rng, axis: Vector, power: int) -> Vector:
    """A coordinate axis, tilted by a power of ten in some direction; not at all for 0."""
    if power == 0:
        return axis
    small = Fraction(1, 10**power)
    return tuple(x + small * int(k) for x, k in zip(axis, rng.integers(-1, 2, 3), strict=True))


def embedded(rng):
    """Planar loops in any plane; axes may be shifted along themselves, and one tilted."""
    frame = FRAMES[rng.integers(len(FRAMES))]
    if rng.random() < 0.3:
        flat, _ = grid(rng)
        flat = flat[: next(k for k, joint in enumerate(flat) if joint.loop) + 1]
    else:
        kind = str(rng.choice(["general", "parallelogram", "kite", "antiparallelogram"]))
        flat = ring(nudged(rng, corners(rng, kind)))
    turned, tilt = [], int(rng.integers(len(flat))) if rng.random() < 0.1 else -1
    for k, joint in enumerate(flat):
        height = Fraction(int(rng.integers(-2, 3)), 2)
        x, y, _ = joint.point
        axis = _combined(frame, *joint.axis)
        if k == tilt:
            axis = _tilted(rng, axis, int(rng.integers(1, 17)))
        turned.append(joint._replace(point=_combined(frame, x, y, height), axis=axis))
    return tuple(turned), ()


def overconstrained(rng):
    """Bennett's linkage, Sarrus's, and spherical loops."""
    kind = int(rng.integers(3))
    if kind == 0:
        return _bennett(rng), ()
    return (_sarrus if kind == 1 else _spherical)(rng), ()


def _bennett(rng) -> tuple[Joint, ...]:
    """Four axes with ``a / sin α = b / sin β`` and rational half-angle tangents.

    The tangents of half the joint angles have the product ``(t_β + t_α) / (t_β - t_α)``.
    """
    ta, tb = rng.choice(len(HALVES), 2, replace=False)
    ta, tb, first = HALVES[ta], HALVES[tb], HALVES[rng.integers(len(HALVES))]
    if rng.random() < 0.5:
        first = -first
    second = (tb + ta) / (tb - ta) / first
    a, b = _sine(ta)[1], _sine(tb)[1]
    # Each joint turns about z by its angle, then comes the link: along x, and tilted about x.
    frame, axes, points = AXES, [], []
    place = vector(0, 0, 0)
    for length, twist, turn in (
        (a, ta, first),
        (b, tb, second),
        (a, ta, -first),
        (b, tb, -second),
    ):
        points.append(place)
        axes.append(frame[2])
        c, s = _sine(turn)
        x = _combined(frame, c, s, Fraction(0))
        y = _combined(frame, -s, c, Fraction(0))
        place = tuple(p + length * e for p, e in zip(place, x, strict=True))
        c, s = _sine(twist)
        frame = (
            x,
            _combined((x, y, frame[2]), Fraction(0), c, s),
            _combined((x, y, frame[2]), Fraction(0), -s, c),
        )
    assert not any(place) and frame[2] == AXES[2], "not a closed loop"
    return ring(_whole(points), "RRRR", [_whole([axis])[0] for axis in axes])


def _sine(t: Fraction) -> tuple[Fraction, Fraction]:
    """Cosine and sine of an angle from the tangent of its half."""
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


def _whole(vectors: list[Vector]) -> list[Vector]:
    """Vectors scaled alike to whole numbers, and back by a power of ten to size 1."""
    scale = Fraction(1)
    for x in (x for v in vectors for x in v):
        scale *= (x * scale).denominator
    digits = len(str(int(max(abs(x) for v in vectors for x in v) * scale))) - 1
    return [tuple(x * scale / 10**digits for x in v) for v in vectors]


def _sarrus(rng) -> tuple[Joint, ...]:
    """Two chains of three parallel axes; their directions nearly at right angles or not."""
    n, m = AXES[1], _tilted(rng, AXES[0], int(rng.integers(0, 17)))
    if rng.random() < 0.3:
        n, m = _axis(rng), _axis(rng)
        if not any(cross(n, m)):
            m = next(axis for axis in AXES if any(cross(n, axis)))
    points = [_point(rng) for _ in range(6)]
    if rng.random() < 0.5:
        points = nudged(
            rng,
            [
                vector(1, 0, 0),
                vector("1.3", 0, "0.4"),
                vector(1, 0, "0.8"),
                vector(0, 1, "0.8"),
                vector(0, "1.3", "0.4"),
                vector(0, 1, 0),
            ],
        )
    return ring(points, "RRRRRR", [n] * 3 + [m] * 3)


def _spherical(rng) -> tuple[Joint, ...]:
    """Four or five axes through one point."""
    centre, count = _point(rng), int(rng.choice([4, 4, 4, 5]))
    axes = [_axis(rng) for _ in range(count)]
    points = [
        tuple(c + int(k) * x for c, x in zip(centre, axis, strict=True))
        for k, axis in zip(rng.integers(-1, 2, count), axes, strict=True)
    ]
    return ring(points, "R" * count, axes)


def tilted_loop(rng):
    """RSSR and RSRS with axes that are nearly parallel; a second loop at times."""
    power, z = int(rng.integers(0, 17)), AXES[2]
    plane = rng.random() < 0.5
    points = [_point(rng) for _ in range(4)]
    if plane:
        points = [(x, y, Fraction(0)) for x, y, _ in points]
    kinds = str(rng.choice(["RSSR", "RSRS", "RRSS", "RSCR"]))
    axes = [_tilted(rng, z, power) for _ in range(4)]
    joints = list(ring(points, kinds, axes))
    if rng.random() < 0.25:
        chained(
            joints,
            0,
            joints[-1].before,
            "RSS",
            [_point(rng) for _ in range(3)],
            [_tilted(rng, z, power)] * 3,
        )
    return tuple(joints), ()


def tilted_arm(rng):
    """An open arm or tree with axes that are nearly parallel or at right angles."""
    joints: list[Joint] = []
    for _ in range(int(rng.integers(2, 6))):
        power = int(rng.integers(0, 17))
        before = len(joints) if rng.random() < 0.7 else int(rng.integers(0, len(joints) + 1))
        kind = str(rng.choice(["R", "P", "U", "S"], p=[0.78, 0.12, 0.05, 0.05]))
        near = AXES[2] if rng.random() < 0.8 else AXES[int(rng.integers(3))]
        axis = near if kind == "U" else _tilted(rng, near, power)
        second = AXES[(AXES.index(near) + 1) % 3]
        if kind == "S":
            axis, second = AXES[:2]
        joints.append(Joint(kind, before, len(joints) + 1, _point(rng), axis, second))
    return tuple(joints), ()


def general(rng):
    """Single loops with spherical, universal and cylindrical joints; platforms on legs."""
    joints: list[Joint] = []
    if rng.random() < 0.7:
        kinds = str(rng.choice(["RSSR", "RRRS R", "RUSR", "RCCC", "RSSP", "RRSRR", "SRSR"]))
        kinds = kinds.replace(" ", "")
        for k, kind in enumerate(kinds):
            closing = k == len(kinds) - 1
            joints.append(_any_joint(rng, kind, k, 0 if closing else k + 1, closing))
        return tuple(joints), ()
    legs = [str(rng.choice(["RRS", "RPS", "PRS", "RSS"])) for _ in range(3)]
    legs = legs[: int(rng.integers(2, 4))]
    top = 0
    for number, leg in enumerate(legs):
        at = 0
        for k, kind in enumerate(leg):
            closing = number > 0 and k == 2
            to = top if closing else max((j.after for j in joints), default=0) + 1
            joints.append(_any_joint(rng, kind, at, to, closing))
            at = to
        top = top or at
    return tuple(joints), ()


def _any_joint(rng, kind: str, before: int, after: int, loop: bool) -> Joint:
    """A joint at whole numbers with axes in whole numbers."""
    axis = _axis(rng)
    if kind == "U":
        axis, second = (AXES[int(k)] for k in rng.permutation(3)[:2])
        return Joint(kind, before, after, vector(*rng.integers(-2, 3, 3)), axis, second, loop)
    axis, second = AXES[:2] if kind == "S" else (axis, AXES[0])
    return Joint(kind, before, after, vector(*rng.integers(-2, 3, 3)), axis, second, loop)
