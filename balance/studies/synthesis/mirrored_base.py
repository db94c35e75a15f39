"""Antiparallelograms through four and more positions, in closed form.

An antiparallelogram is symmetric about a line at every pose: the coupler is the mirror image of
the base. So there is one mirror image ``σ(z) = e^(iω) z̄ + c`` of the base in the plane of the
tool of which every displacement makes a reflection ``D_i σ``, and not a glide reflection:

    Re(e^(iθ_i/2) c' + e^(-iθ_i/2) t_i p) = 0        p = e^(-iω/2), c' = p c

These are linear in the four real numbers c', p: three positions have one σ, and four have none
unless a determinant vanishes. With σ, the mirror lines are tangents of a conic (a hyperbola)
whose foci are the pivots on the base: linear in the six numbers of the dual conic, so that four
lines leave a pencil of them, and five one.

Source: symmetric motions, O. Bottema, B. Roth, Theoretical Kinematics, 1979.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import SYNTHESIS_MET
from balance.studies.synthesis.four_bars import FourBarDesign
from balance.studies.synthesis.positions import Displacement, Position, displacements, size_of
from kinematics.numerics.array_types import Array

KIND = "antiparallelogram"
# Members of the pencil of conics of four lines; bounds of the ratio of base and crank.
MEMBERS, LOWEST, HIGHEST = 360, 1.42, 12.0


class MirrorLines(NamedTuple):
    """Lines ``n·z = h`` in which the base is mirrored at each position.

    Attributes:
        normals: n of length 1 (p,), complex.
        offsets: h (p,), in sizes of the positions from the first one.
        image: ω and c of σ.
    """

    normals: NDArray[np.complex128]
    offsets: Array
    image: tuple[float, complex]


def antiparallelograms_through(positions: Sequence[Position]) -> tuple[FourBarDesign, ...]:
    """Find the antiparallelograms whose coupler passes through four or more positions.

    Returns:
        Those with masses, in no order; of a family of them, for four positions, some members.
    """
    places = tuple(positions)
    lines = mirror_lines(places)
    if lines is None:
        return ()
    designs = (_design(places, lines, G, H) for G, H in _foci(lines))
    return tuple(each for each in designs if each is not None)


def mirror_lines(positions: Sequence[Position]) -> MirrorLines | None:
    """Find the mirror lines of a coupler that is the image of its base; None if there are none.

    Args:
        positions: four or more.
    """
    size, origin = size_of(positions), positions[0].point
    points = [(each.point - origin) / size for each in positions]
    moved = [
        Position(z.real, z.imag, each.angle) for z, each in zip(points, positions, strict=True)
    ]
    steps = (Displacement(0.0, 0j), *displacements(moved))
    half = np.array([cmath.exp(0.5j * step.turn) for step in steps])
    shifts = np.array([step.shift for step in steps])
    u = shifts / half
    _, sigma, v = np.linalg.svd(np.column_stack([half.real, -half.imag, u.real, -u.imag]))
    if sigma[3] > SYNTHESIS_MET * math.sqrt(len(steps)):
        return None
    shift, p = complex(*v[3, :2]), complex(*v[3, 2:])
    if abs(p) < SYNTHESIS_MET:
        return None
    shift, p = shift / p, p / abs(p)
    # D_i σ mirrors 0 in e^(iθ_i) c + t_i, along the normal.
    images = half**2 * shift + shifts
    normals = 1j * half / p
    return MirrorLines(
        normals, 0.5 * (normals.conj() * images).real, (-2.0 * cmath.phase(p), shift)
    )


def _foci(lines: MirrorLines) -> Iterator[tuple[complex, complex]]:
    """Yield the foci of conics that touch lines, in the units of the lines."""
    n, h = lines.normals, lines.offsets
    x, y = n.real, n.imag
    rows = np.column_stack([x * x, 2 * x * y, y * y, -2 * h * x, -2 * h * y, h * h])
    _, sigma, v = np.linalg.svd(rows)
    if len(h) == 4:
        turns = np.pi * np.arange(MEMBERS) / MEMBERS
        conics = np.outer(np.cos(turns), v[4]) + np.outer(np.sin(turns), v[5])
    elif len(h) == 5 or sigma[5] <= SYNTHESIS_MET * sigma[0]:
        conics = v[5:]
    else:
        return
    for conic in conics:
        if abs(conic[5]) < SYNTHESIS_MET:
            continue
        xx, xy, yy, mx, my, _ = conic / conic[5]
        # The conic is (n·m - h)² = nᵀ S n; its foci are m ± √(Sxx - Syy + 2 i Sxy).
        focus = cmath.sqrt((mx * mx - xx) - (my * my - yy) + 2j * (mx * my - xy))
        yield complex(mx, my) + focus, complex(mx, my) - focus
        yield complex(mx, my) - focus, complex(mx, my) + focus


def _design(
    positions: tuple[Position, ...], lines: MirrorLines, G: complex, H: complex
) -> FourBarDesign | None:
    """Make the antiparallelogram of two foci; None if it has no masses or folds on the way."""
    size, origin = size_of(positions), positions[0].point
    images = H - 2.0 * ((lines.normals.conj() * H).real - lines.offsets) * lines.normals
    arms = (images - G) / (H - G)
    ratio = 1.0 / float(np.abs(arms).mean())
    alpha = np.angle(arms)
    if not LOWEST < ratio < HIGHEST or len(set(np.sign(alpha).tolist())) > 1:
        return None
    scale = size * (H - G) / ratio
    return FourBarDesign(
        KIND, positions, ratio, tuple(alpha.tolist()), scale, origin + size * G, positions[0]
    )
