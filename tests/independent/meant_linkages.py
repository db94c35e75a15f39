"""Special linkages at random poses, in random frames, written with so many digits.

Numbers are those of mpmath with 60 digits, so that a file has all the digits it is asked for.
Nothing of the product is used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf

mp.dps = 60


class MeantJoint(NamedTuple):
    """A joint at the reference pose: links by number, 0 for the ground."""

    kind: str
    before: int
    after: int
    point: tuple
    axis: tuple
    loop: bool = False


class MeantLinkage(NamedTuple):
    """Joints of a linkage, those of the tree before those of loops."""

    family: str
    joints: tuple[MeantJoint, ...]

    @property
    def links(self) -> int:
        """Number of moving links."""
        return max(joint.after for joint in self.joints)


def _vector(*x):
    return tuple(mpf(y) for y in x)


def add(a, b, factor=1):
    """``a + factor b``."""
    return tuple(x + factor * y for x, y in zip(a, b, strict=True))


def dot(a, b):
    """Scalar product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def unit(a):
    """Vector of length 1."""
    length = mp.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def turned(R, a):
    """``R a`` for rows R."""
    return tuple(dot(row, a) for row in R)


def transposed(R):
    """Transpose of rows."""
    return tuple(zip(*R, strict=True))


def times(A, B):
    """Product of matrices, by rows."""
    return tuple(tuple(dot(row, column) for column in transposed(B)) for row in A)


def random_rotation(rng):
    """A random rotation, by a unit quaternion."""
    w, x, y, z = unit(_vector(*rng.standard_normal(4)))
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def about(n, angle):
    """Rotation about a unit vector."""
    c, s = mp.cos(angle), mp.sin(angle)
    columns = [
        add(add(tuple(c * x for x in e), cross(n, e), s), n, (1 - c) * dot(n, e))
        for e in (_vector(1, 0, 0), _vector(0, 1, 0), _vector(0, 0, 1))
    ]
    return transposed(columns)


def _polar(length, angle):
    return (length * mp.cos(angle), length * mp.sin(angle), mpf(0))


def _uniform(rng, low, high):
    return mpf(float(rng.uniform(low, high)))


def _circles(a, r, b, s, sign):
    """A point at distances r from a and s from b, in the plane; None if there is none."""
    d = add(b, a, -1)
    square = dot(d, d)
    x = (r * r - s * s + square) / (2 * square)
    h = r * r / square - x * x
    if h <= mpf("0.02"):
        return None
    h = sign * mp.sqrt(h)
    return (a[0] + x * d[0] - h * d[1], a[1] + x * d[1] + h * d[0], mpf(0))


Z = _vector(0, 0, 1)


def _four_bar(rng, a, b, c, d):
    """Pins O, A, B, C of a four-bar with crank a, coupler b, rocker c, base d.

    Of both places of B, it is the one away from O, where a kite would be folded.
    """
    origin, C = _vector(0, 0, 0), _polar(d, _uniform(rng, 0, 6.28))
    while True:
        A = _polar(a, _uniform(rng, 0, 6.28))
        B = max(
            (x for x in (_circles(A, b, C, c, sign) for sign in (1, -1)) if x is not None),
            key=lambda x: dot(x, x),
            default=None,
        )
        if B is not None:
            return origin, A, B, C


def _pins(origin, A, B, C):
    return (
        MeantJoint("continuous", 0, 1, origin, Z),
        MeantJoint("continuous", 1, 2, A, Z),
        MeantJoint("continuous", 0, 3, C, Z),
        MeantJoint("revolute", 2, 3, B, Z, True),
    )


def _two(rng):
    return _uniform(rng, 0.3, 0.9), _uniform(rng, 1.0, 2.0)


def kite(rng, off):
    """Two neighbours of one length, and the other two of another."""
    a, b = _two(rng)
    if rng.random() < 0.5:  # crank and base are equal
        return _pins(*_four_bar(rng, b, a, a, b + off))
    return _pins(*_four_bar(rng, a, a + off, b, b))


def _opposite(rng, off, crossed):
    a, d = _two(rng)
    while True:
        first, second = _uniform(rng, 0, 6.28), _uniform(rng, 0, 6.28)
        if abs(mp.sin(first - second)) > 0.3:
            break
    A, C = _polar(a, first), _polar(d, second)
    B = add(A, C)
    if crossed:  # mirrored in the line through A and C
        along = unit(add(C, A, -1))
        w = add(B, A, -1)
        B = add(add(A, along, 2 * dot(w, along)), w, -1)
    return (
        _pins(_vector(0, 0, 0), A, B, C)
        if not off
        else _pins(_vector(0, 0, 0), A, add(B, (off, off / 3, 0)), C)
    )


def parallelogram(rng, off):
    """Opposite links of one length, not crossed."""
    return _opposite(rng, off, False)


def antiparallelogram(rng, off):
    """Opposite links of one length, crossed."""
    return _opposite(rng, off, True)


def slider_crank(rng, off):
    """Crank and coupler of one length, in line with the slide."""
    a, angle = _uniform(rng, 0.4, 1.5), _uniform(rng, 0.3, 1.2)
    along = _uniform(rng, 0, 6.28)
    A, d = _polar(a, along + angle), _polar(1, along)
    B = add(_polar(2 * a * mp.cos(angle), along), d, off)
    return (
        MeantJoint("continuous", 0, 1, _vector(0, 0, 0), Z),
        MeantJoint("continuous", 1, 2, A, Z),
        MeantJoint("continuous", 2, 3, B, Z),
        MeantJoint("prismatic", 0, 3, B, d, True),
    )


def pantograph(rng, off):
    """Two bars, prolonged, and two more that make a parallelogram with them."""
    a, b = _two(rng)
    first, second = _uniform(rng, 0, 6.28), 0
    while True:
        second = _uniform(rng, 0, 6.28)
        if abs(mp.sin(first - second)) > 0.3:
            break
    ratio = _uniform(rng, 0.3, 0.8)
    u, v = _polar(a, first), _polar(b, second)
    origin, P = _vector(0, 0, 0), u
    K, M = tuple(ratio * x for x in u), add(u, tuple(ratio * x for x in v))
    Q = add(add(K, M), P, -1)
    Q = add(Q, (off, 0, 0))
    return (
        MeantJoint("continuous", 0, 1, origin, Z),
        MeantJoint("continuous", 1, 2, P, Z),
        MeantJoint("continuous", 1, 3, K, Z),
        MeantJoint("continuous", 3, 4, Q, Z),
        MeantJoint("revolute", 4, 2, M, Z, True),
    )


def bennett(rng, off):
    """Twists α, β and lengths a, b of opposite links, ``a sin β = b sin α``, no offsets."""
    a, alpha, beta = _uniform(rng, 0.5, 1.5), _uniform(rng, 0.4, 1.1), _uniform(rng, 1.3, 2.2)
    b, theta = a * mp.sin(beta) / mp.sin(alpha), _uniform(rng, 0.5, 2.4)
    k = mp.sin((beta + alpha) / 2) / mp.sin((beta - alpha) / 2)
    other = 2 * mp.atan(k / mp.tan(theta / 2))
    R, x = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), _vector(0, 0, 0)
    R = tuple(tuple(mpf(y) for y in row) for row in R)
    axes = []
    for angle, twist, length in (
        (theta, alpha, a),
        (other, beta, b),
        (-theta, alpha, a),
        (-other, beta, b),
    ):
        axes.append((x, tuple(row[2] for row in R)))
        R = times(R, about(Z, angle))
        x = add(x, tuple(row[0] for row in R), length)
        R = times(R, about(_vector(1, 0, 0), twist))
    (p1, n1), (p2, n2), (p3, n3), (p4, n4) = axes
    p3 = add(p3, (off, 0, 0))
    return (
        MeantJoint("continuous", 0, 1, p1, n1),
        MeantJoint("continuous", 1, 2, p2, n2),
        MeantJoint("continuous", 0, 3, p4, n4),
        MeantJoint("revolute", 2, 3, p3, n3, True),
    )


def _spherical(axes):
    o = _vector(0, 0, 0)
    a, b, c, d = axes
    return (
        MeantJoint("continuous", 0, 1, o, a),
        MeantJoint("continuous", 1, 2, o, b),
        MeantJoint("continuous", 0, 3, o, d),
        MeantJoint("revolute", 2, 3, o, c, True),
    )


def _directions(rng, count):
    while True:
        found = [unit(_vector(*rng.standard_normal(3))) for _ in range(count)]
        if all(abs(dot(a, b)) < 0.8 for i, a in enumerate(found) for b in found[:i]):
            return found


def spherical_kite(rng, off):
    """The second axis mirrored in the plane of the first and the third."""
    a, b, c = _directions(rng, 3)
    m = unit(cross(a, c))
    d = unit(add(add(b, m, -2 * dot(b, m)), (off, 0, 0)))
    return _spherical((a, b, c, d))


def spherical_opposite(rng, off):
    """The second axis turned by half a turn about the middle of the first and the third."""
    a, b, c = _directions(rng, 3)
    m = unit(add(a, c, 1 if rng.random() < 0.5 else -1))
    d = unit(add(add(tuple(-x for x in b), m, 2 * dot(b, m)), (off, 0, 0)))
    return _spherical((a, b, c, d))


FAMILIES: dict[str, Callable] = {
    "kite": kite,
    "parallelogram": parallelogram,
    "antiparallelogram": antiparallelogram,
    "slider_crank": slider_crank,
    "pantograph": pantograph,
    "bennett": bennett,
    "spherical_kite": spherical_kite,
    "spherical_opposite": spherical_opposite,
}


def meant_linkage(family: str, seed: int, off: float = 0.0) -> MeantLinkage:
    """A linkage of a family at a random pose; one of its joints is off by so many metres."""
    rng = np.random.default_rng([seed, len(family)])
    return MeantLinkage(family, FAMILIES[family](rng, mpf(off)))


def angles_of(R):
    """Roll, pitch and yaw of a rotation."""
    pitch = mp.atan2(-R[2][0], mp.sqrt(R[0][0] ** 2 + R[1][0] ** 2))
    return mp.atan2(R[2][1], R[2][2]), pitch, mp.atan2(R[1][0], R[0][0])


def written(x, digits):
    """A number with so many significant digits; 17 for the shortest text of a double."""
    return repr(float(x)) if digits >= 17 else f"{float(x):.{digits}g}"


def _words(values, digits):
    return " ".join(written(x, digits) for x in values)


def _any_frame(rng, n, frames):
    """A rotation; its third axis is n, unless frames are turned at random."""
    if frames == "turned":
        return random_rotation(rng)
    helper = unit(cross(n, _vector(1, 0, 0) if abs(n[0]) < 0.8 else _vector(0, 1, 0)))
    return transposed((helper, cross(n, helper), n))


def meant_text(
    linkage: MeantLinkage, seed: int, digits: int, frames: str = "turned", plane: str = "any"
) -> str:
    """Write a linkage as URDF.

    Args:
        linkage: the linkage.
        seed: of the frames.
        digits: significant digits; 17 for the shortest text of a double.
        frames: ``"turned"`` at random, ``"axes"`` with z along the joint, or ``"plain"``,
            parallel to that of the base.
        plane: ``"any"`` turns the linkage at random, ``"xy"`` does not.
    """
    rng = np.random.default_rng([seed, 77])
    R = random_rotation(rng)
    if plane == "xy":
        R = tuple(tuple(mpf(int(i == j)) for j in range(3)) for i in range(3))
    identity = tuple(tuple(mpf(int(i == j)) for j in range(3)) for i in range(3))
    shift = _vector(*rng.uniform(-1, 1, 3)) if plane != "xy" else _vector(0, 0, 0)
    poses = {0: (identity, _vector(0, 0, 0))}
    lines = ['<robot name="m">', '<link name="L0"/>']
    for k in range(1, linkage.links + 1):
        mass = _words(rng.uniform(0.5, 2, 1).round(3), 6)
        com = _words(rng.uniform(-0.3, 0.3, 3).round(3), 6)
        lines.append(
            f'<link name="L{k}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>'
            '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial>'
            "</link>"
        )

    def local(link, point, rotation):
        F, x = poses[link]
        there = times(transposed(F), rotation)
        words = _words(turned(transposed(F), add(point, x, -1)), digits)
        angles = "" if there == identity else f' rpy="{_words(angles_of(there), digits)}"'
        return f'<origin xyz="{words}"{angles}/>'

    for k, joint in enumerate(linkage.joints):
        n, point = turned(R, joint.axis), add(turned(R, joint.point), shift)
        if plane != "xy" and joint.kind != "prismatic":
            point = add(point, n, _uniform(rng, -0.5, 0.5))
        F = identity if frames == "plain" else _any_frame(rng, n, frames)
        axis = _words(turned(transposed(F), n), digits)
        if frames == "axes":
            axis = "0 0 1"
        if joint.loop:
            if joint.kind == "prismatic":
                point = add(point, n, _uniform(rng, -0.5, 0.5))
            lines.append(
                f'<loop name="j{k}" type="{joint.kind}"><predecessor link="L{joint.before}">'
                f"{local(joint.before, point, F)}</predecessor>"
                f'<successor link="L{joint.after}">'
                f'{local(joint.after, point, F)}</successor><axis xyz="{axis}"/></loop>'
            )
            continue
        origin = local(joint.before, point, F)
        poses[joint.after] = F, point
        lines.append(
            f'<joint name="j{k}" type="{joint.kind}">{origin}<parent link="L{joint.before}"/>'
            f'<child link="L{joint.after}"/><axis xyz="{axis}"/></joint>'
        )
    return "\n".join([*lines, "</robot>\n"])
