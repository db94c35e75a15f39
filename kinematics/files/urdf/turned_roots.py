"""Joints of a linkage in a frame in which their numbers are roots, sines and cosines.

Programs write a robot with threefold symmetry in a frame that is turned at random: then no
number is a root. In the frame of two of its axes they are, but for round-off. A displacement of
the whole linkage changes no rank.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import islice

import numpy as np

from kinematics.files.urdf.closed_forms import NumberVector, NumberWord, read_closed_forms
from kinematics.model.chain import extent
from kinematics.model.linkage import Joint, Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.cyclotomic import degree_of_field
from kinematics.numerics.linalg.rational import Vector, cross

# Most pairs of axes whose frames are tried, and the least sine of the angle between two.
MAX_FRAMES, LEAST_SINE = 4, 0.1
# Errors of directions, and of places in parts of the size: products of a dozen rotations.
ROUND_OFF = 2.0**-49
# Most joints.
MAX_JOINTS = 200


def turned_screws(linkage: Linkage) -> Iterator[tuple[tuple[Vector, ...], int]]:
    """Yield the screws of a linkage in frames of two of its axes, read as roots.

    Args:
        linkage: an assembled linkage without screw joints.

    Yields:
        Screws ``[n; r × n]`` or ``[0; n]`` (n, 6) in one field, in that frame, and how many
        numbers were read.
    """
    joints = linkage.joints
    if len(joints) > MAX_JOINTS or any(joint.kind == "helical" for joint in joints):
        return
    size = max(extent(linkage).length, 1e-300)
    for R in islice(_frames([joint.direction for joint in joints]), MAX_FRAMES):
        vectors = []
        for j, joint in enumerate(joints):
            place = R @ (joint.point - joints[0].point)
            vectors.append(_make_vector((j, "n"), R @ joint.direction, ROUND_OFF))
            vectors.append(_make_vector((j, "p"), place, ROUND_OFF * size))
        forms = read_closed_forms(vectors)
        if degree_of_field(forms.conductor) == 1:
            continue
        read = {
            vector.key: tuple(
                forms.numbers.get((vector.key, k), x) for k, x in enumerate(vector.values)
            )
            for vector in vectors
        }
        yield (
            tuple(_make_screw(x, read[j, "n"], read[j, "p"]) for j, x in enumerate(joints)),
            len(forms.numbers),
        )


def _frames(axes: list[Array]) -> Iterator[Array]:
    """Yield rotations to frames with x along one axis and z across it and another."""
    first = axes[0]
    seen: list[Array] = []
    for other in axes[1:]:
        z = np.cross(first, other)
        sine = float(np.linalg.norm(z))
        if sine < LEAST_SINE:
            continue
        z /= sine
        if any(abs(float(z @ normal)) > 1.0 - ROUND_OFF * 8 for normal in seen):
            continue
        seen.append(z)
        yield np.array([first, np.cross(z, first), z])


def _make_vector(key: tuple[int, str], values: Array, error: float) -> NumberVector:
    """Make a vector of numbers that may each be off by an error."""
    numbers = tuple(Fraction(float(x)) for x in values)
    width = Fraction(error)
    words = tuple(NumberWord((key, k), x, width, width) for k, x in enumerate(numbers))
    return NumberVector(key, numbers, words)


def _make_screw(joint: Joint, n: Vector, point: Vector) -> Vector:
    """Make the screw of a joint from its direction and a point."""
    return (Fraction(0),) * 3 + n if joint.kind == "prismatic" else n + cross(point, n)
