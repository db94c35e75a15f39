"""URDF text of a linkage in any plane, with frames turned at random, in so many digits.

Numbers are those of mpmath with 60 digits, so that a file has all the digits it is asked for.
Nothing of the product is used.
"""

from __future__ import annotations

from mpmath import mp, mpf

from tests.independent.meant_linkages import (
    add,
    angles_of,
    cross,
    dot,
    random_rotation,
    times,
    transposed,
    turned,
    unit,
    written,
)
from tests.independent.plain_linkage import TYPES, Joint, Linkage

mp.dps = 60
ZERO = mpf("1e-45")
IDENTITY = tuple(tuple(mpf(int(i == j)) for j in range(3)) for i in range(3))


def _exactly(vector):
    """A rational vector in many digits."""
    return tuple(mpf(x.numerator) / x.denominator for x in vector)


def _words(values, digits: int) -> str:
    return " ".join(written(x if abs(x) > ZERO else mpf(0), digits) for x in values)


def turned_text(linkage: Linkage, rng, digits: int, oblique: bool, frames: str) -> str:
    """Write a linkage as URDF.

    Args:
        linkage: the linkage; of joints R, P, U and S.
        rng: of the rotation of the whole, of frames, and of places along axes.
        digits: significant digits; 17 for the shortest text of a double.
        oblique: whether the whole is turned and shifted at random.
        frames: ``"turned"`` at random, ``"axes"`` with z along the joint, or ``"plain"``.
    """
    return _Writer(linkage, rng, digits, oblique, frames).text()


class _Writer:
    """A file of a linkage; poses of links are filled as their joints are written."""

    def __init__(self, linkage: Linkage, rng, digits: int, oblique: bool, frames: str) -> None:
        self.linkage, self.rng, self.digits, self.frames = linkage, rng, digits, frames
        self.R = random_rotation(rng) if oblique else IDENTITY
        shift = [mpf(float(x)) for x in rng.uniform(-1, 1, 3)]
        self.shift = tuple(shift) if oblique else (mpf(0),) * 3
        self.oblique = oblique
        self.poses = {0: (IDENTITY, (mpf(0),) * 3)}

    def text(self) -> str:
        """The text of the file."""
        lines = ['<robot name="m">', '<link name="L0"/>']
        lines += [self._link(k) for k in range(1, self.linkage.links + 1)]
        lines += [self._joint(k, joint) for k, joint in enumerate(self.linkage.joints)]
        return "\n".join([*lines, "</robot>\n"])

    def _link(self, k: int) -> str:
        if k in self.linkage.bare:
            return f'<link name="L{k}"/>'
        centre = " ".join(f"{x:.3f}" for x in self.rng.uniform(-0.3, 0.3, 3))
        return (
            f'<link name="L{k}"><inertial><origin xyz="{centre}"/><mass value="1.{k:02d}"/>'
            '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial>'
            "</link>"
        )

    def _joint(self, number: int, joint: Joint) -> str:
        n = unit(turned(self.R, _exactly(joint.axis)))
        u = unit(turned(self.R, _exactly(joint.second)))
        point = add(turned(self.R, _exactly(joint.point)), self.shift)
        if self.oblique and joint.kind == "R":
            point = add(point, n, mpf(float(self.rng.uniform(-0.5, 0.5))))
        F = self._frame(n)
        axis = f'<axis xyz="{self._axis(F, n)}"/>' if joint.kind != "S" else ""
        if joint.kind == "U":
            axis += f'<axis2 xyz="{_words(turned(transposed(F), u), self.digits)}"/>'
        name, kind = f"j{number}", TYPES[joint.kind]
        named = {x.partition(".")[0] for x in self.linkage.inputs}
        mark = ' independent="true"' if name in named else ""
        near = self._origin(joint.before, point, F)
        if joint.loop:
            if joint.kind == "P":
                point = add(point, n, mpf(float(self.rng.uniform(-0.5, 0.5))))
            far = self._origin(joint.after, point, F)
            return (
                f'<loop name="{name}" type="{kind}"{mark}><predecessor link="L{joint.before}">'
                f'{near}</predecessor><successor link="L{joint.after}">{far}</successor>{axis}'
                "</loop>"
            )
        self.poses[joint.after] = F, point
        follows = "".join(
            f'<mimic joint="j{mimic.source}" multiplier="{float(mimic.ratio)!r}"/>'
            for mimic in self.linkage.mimics
            if mimic.joint == number
        )
        return (
            f'<joint name="{name}" type="{kind}"{mark}>{near}<parent link="L{joint.before}"/>'
            f'<child link="L{joint.after}"/>{axis}{follows}</joint>'
        )

    def _frame(self, n):
        """Axes of the frame of a joint with the direction n."""
        if self.frames == "plain":
            return IDENTITY
        if self.frames == "turned":
            return random_rotation(self.rng)
        helper = unit(cross(n, IDENTITY[0 if abs(n[0]) < 0.8 else 1]))
        return transposed((helper, cross(n, helper), n))

    def _axis(self, F, n) -> str:
        if self.frames == "axes":
            return "0 0 1"
        return _words(turned(transposed(F), n), self.digits)

    def _origin(self, link: int, point, F) -> str:
        """The frame F at a point, in that of a link."""
        G, x = self.poses[link]
        relative = times(transposed(G), F)
        place = _words(turned(transposed(G), add(point, x, -1)), self.digits)
        if all(abs(dot(a, b)) > 1 - mpf("1e-50") for a, b in zip(G, F, strict=True)):
            return f'<origin xyz="{place}"/>'
        return f'<origin xyz="{place}" rpy="{_words(angles_of(relative), self.digits)}"/>'
