"""Random planar linkages: on a grid, special and nearly special, small loops, gears."""

from __future__ import annotations

from fractions import Fraction

from tests.independent.plain_linkage import AXES, Joint, Mimic, Vector, vector

Z = AXES[2]
# Directions along which planar joints slide.
SLIDES = (AXES[0], AXES[1], vector(3, 4, 0), vector(1, 1, 0), vector(1, -2, 0))


def chained(joints: list[Joint], before: int, after: int, kinds, points, axes) -> None:
    """Add a chain of new links from one link to another; the last joint closes a loop.

    With ``after`` -1 the chain ends in a link of its own.
    """
    at = before
    for k, (kind, point, axis) in enumerate(zip(kinds, points, axes, strict=True)):
        closing = after >= 0 and k == len(kinds) - 1
        new = max((joint.after for joint in joints), default=0) + 1
        to = after if closing else new
        first, second = AXES[:2] if kind == "S" else (axis, AXES[0])
        joints.append(Joint(kind, at, to, point, first, second, closing))
        at = to


def ring(points: list[Vector], kinds: str = "", axes=()) -> tuple[Joint, ...]:
    """One loop through the ground; revolute about z unless told otherwise."""
    joints: list[Joint] = []
    kinds = kinds or "R" * len(points)
    chained(joints, 0, 0, kinds, points, axes or [Z] * len(points))
    return tuple(joints)


def _whole(rng, low: int, high: int) -> Vector:
    return vector(*rng.integers(low, high + 1, 2), 0)


def _decimals(rng, digits: int = 2, reach: int = 3) -> Vector:
    scale = 10**digits
    x, y = rng.integers(-reach * scale, reach * scale + 1, 2).tolist()
    return Fraction(x, scale), Fraction(y, scale), Fraction(0)


def _kinds(rng, count: int) -> tuple[str, list[Vector]]:
    """Mostly revolute joints, and their axes."""
    kinds = "".join(rng.choice(["R", "P"], count, p=[0.82, 0.18]))
    axes = [Z if kind == "R" else SLIDES[rng.integers(len(SLIDES))] for kind in kinds]
    return kinds, axes


def grid(rng):
    """Two to six loops on small whole numbers."""
    joints: list[Joint] = []
    loops, reach = int(rng.integers(2, 7)), int(rng.integers(1, 4))
    freedom = 0
    for loop in range(loops):
        links = max((joint.after for joint in joints), default=0)
        least = 3 if loop == 0 or freedom == 0 else 2
        new = int(rng.choice([2, 3, 4], p=[0.62, 0.33, 0.05]))
        new = max(new, least) if loop == 0 else new
        before, after = (int(x) for x in rng.integers(0, links + 1, 2))
        if before == after:
            before, after = 0, links
        kinds, axes = _kinds(rng, new + 1)
        points = [_whole(rng, -reach, reach) for _ in kinds]
        chained(joints, before, after, kinds, points, axes)
        freedom += new - 2
    return tuple(joints), ()


def corners(rng, kind: str) -> list[Vector]:
    """Corners of a special quadrilateral, in the order of its joints."""
    a, b, h = (Fraction(int(x), 10) for x in rng.integers(3, 25, 3))
    zero = Fraction(0)
    if kind == "parallelogram":
        points = [(zero, zero), (a, h), (a + b, h), (b, zero)]
    elif kind == "rhombus":
        points = [(zero, zero), (4 * a, 3 * a), (9 * a, 3 * a), (5 * a, zero)]
    elif kind == "kite":
        points = [(zero, zero), (a, h), (a + b, zero), (a, -h)]
    elif kind == "antiparallelogram":
        points = [(-a, zero), (b, h), (a, zero), (-b, h)]
    else:
        points = [_decimals(rng)[:2] for _ in range(4)]
    shift = _decimals(rng)
    turn = int(rng.integers(4))
    c, s = ((1, 0), (Fraction(3, 5), Fraction(4, 5)))[int(rng.integers(2))]
    points = points[turn:] + points[:turn]
    return [(c * x - s * y + shift[0], s * x + c * y + shift[1], zero) for x, y in points]


def nudged(rng, points: list[Vector]) -> list[Vector]:
    """Points, one of which is moved by a power of ten; or none."""
    power = int(rng.integers(0, 17))
    if power == 0:
        return points
    at, axis = int(rng.integers(len(points))), int(rng.integers(2))
    moved = list(points[at])
    moved[axis] += Fraction(int(rng.choice([-1, 1])), 10**power)
    return [*points[:at], tuple(moved), *points[at + 1 :]]


def single(rng):
    """One loop, special, nearly so or general."""
    kind = str(
        rng.choice(
            [
                "general",
                "parallelogram",
                "rhombus",
                "kite",
                "antiparallelogram",
                "five",
                "slider",
            ],
            p=[0.08, 0.2, 0.12, 0.2, 0.2, 0.1, 0.1],
        )
    )
    if kind == "five":
        points = [_decimals(rng, 1) for _ in range(5)]
        if rng.random() < 0.6:
            points[3] = tuple(
                p + q - r for p, q, r in zip(points[2], points[0], points[1], strict=True)
            )
        return ring(nudged(rng, points)), ()
    if kind == "slider":
        x, y, h = (Fraction(int(k), 10) for k in rng.integers(1, 20, 3))
        far = 2 * x if rng.random() < 0.7 else 2 * x + h
        points = [vector(0, 0, 0), (x, y, x * 0), (far, x * 0, x * 0), (far, x * 0, x * 0)]
        points = nudged(rng, points)
        turn = int(rng.integers(4))
        kinds, axes = "RRRP", [Z, Z, Z, AXES[0]]
        return ring(
            points[turn:] + points[:turn],
            kinds[turn:] + kinds[:turn],
            axes[turn:] + axes[:turn],
        ), ()
    return ring(nudged(rng, corners(rng, kind))), ()


def small_loop(rng):
    """A four-bar of 1 to 10⁻⁶ of the size of the arm that carries it."""
    joints: list[Joint] = []
    scale = Fraction(10 ** int(rng.integers(0, 7)))
    if rng.random() < 0.5:
        scale = 1 / scale
        arm, size = Fraction(1), scale
    else:
        arm, size = scale, Fraction(1)
    kind = str(rng.choice(["general", "parallelogram", "kite", "antiparallelogram"]))
    inner = [tuple(size * x for x in p) for p in corners(rng, kind)]
    base = (-arm, arm * int(rng.integers(0, 2)), arm * 0)
    arms = int(rng.integers(1, 3))
    chained(joints, 0, -1, "R" * arms, [base, tuple(x / 2 for x in base)][:arms], [Z] * arms)
    last = joints[-1].after
    chained(joints, last, last, "RRRR", inner, [Z] * 4)
    return tuple(joints), ()


def mimic(rng):
    """Gears, geared five-bars, and arms whose joints follow each other."""
    kind, ratio = int(rng.integers(4)), Fraction(int(rng.choice([-3, -2, -1, 1, 2])))
    if rng.random() < 0.3:
        ratio /= 2
    if kind == 0:
        points, joints = [_decimals(rng, 1) for _ in range(5)], []
        chained(joints, 0, -1, "RR", points[:2], [Z, Z])
        chained(joints, 0, 2, "RRR", points[2:], [Z] * 3)
        return tuple(joints), (Mimic(2, 0, ratio),)
    if kind == 1:
        joints = []
        for _ in range(int(rng.integers(2, 4))):
            before = int(rng.integers(0, len(joints) + 1))
            chained(joints, before, -1, "R", [_decimals(rng, 1)], [Z])
        return tuple(joints), (Mimic(len(joints) - 1, 0, ratio),)
    if kind == 2:
        joints = []
        for _ in range(int(rng.integers(2, 5))):
            before, turn = int(rng.integers(0, len(joints) + 1)), rng.random() < 0.75
            chained(
                joints,
                before,
                -1,
                "R" if turn else "P",
                [vector(*rng.integers(-2, 3, 3))],
                [AXES[rng.integers(3)]],
            )
        return tuple(joints), (
            Mimic(len(joints) - 1, int(rng.integers(len(joints) - 1)), ratio),
        )
    joints = list(ring(corners(rng, str(rng.choice(["general", "parallelogram", "kite"])))))
    chained(joints, int(rng.integers(0, 4)), -1, "R", [_decimals(rng, 1)], [Z])
    return tuple(joints), (Mimic(len(joints) - 1, int(rng.integers(0, 3)), ratio),)


def special_inside(points, decimals):
    """Yield the corners of kites, parallelograms and antiparallelograms next to a four-bar.

    One corner is moved by up to two units of the last decimal, to the image of the corner
    opposite to it, or of a neighbour: under the reflection in a diagonal, in the middle of a
    diagonal, or in its bisector.
    """
    width = Fraction(2, 10**decimals)
    for k in range(4):
        P, Q, R, S = (points[(k + i) % 4] for i in range(4))
        for image in _images(P, Q, R):
            if max(abs(x - y) for x, y in zip(image, S, strict=True)) <= width:
                at = (k + 3) % 4
                yield [*points[:at], image, *points[at + 1 :]]


def _images(P, Q, R):
    """Images of Q in the line through P and R, in their middle, and in their bisector."""
    (px, py), (qx, qy), (rx, ry) = P, Q, R
    dx, dy = rx - px, ry - py
    square = dx * dx + dy * dy
    if not square:
        return
    along = 2 * ((qx - px) * dx + (qy - py) * dy) / square
    across = 2 * ((qx - px) * dy - (qy - py) * dx) / square
    yield qx - across * dy, qy + across * dx
    yield px + rx - qx, py + ry - qy
    yield qx + (1 - along) * dx, qy + (1 - along) * dy
