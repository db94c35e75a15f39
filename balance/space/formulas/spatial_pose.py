"""Poses of a spatial linkage modulo a prime or its power: frames of parts, from half-angles.

A loop is closed by its ground: the dimensions of the moving links and all angles between them
are drawn, and the ground is the link that fits. It has no place in the conditions, for it does
not move.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from typing import NamedTuple

from balance.space.formulas.interpolation import cosine_sine
from balance.space.formulas.spatial_parts import SpatialParts

ModularVector = tuple[int, int, int]
CosineSine = tuple[int, int]


class ModularFrame(NamedTuple):
    """A frame: its axes and its origin, in the frame of the ground."""

    x: ModularVector
    y: ModularVector
    z: ModularVector
    o: ModularVector


def mixed(a: ModularVector, x: int, b: ModularVector, y: int, p: int) -> ModularVector:
    """Compute ``x a + y b``."""
    return (
        (a[0] * x + b[0] * y) % p,
        (a[1] * x + b[1] * y) % p,
        (a[2] * x + b[2] * y) % p,
    )


def modular_cross(a: ModularVector, b: ModularVector, p: int) -> ModularVector:
    """Compute the vector product."""
    return (
        (a[1] * b[2] - a[2] * b[1]) % p,
        (a[2] * b[0] - a[0] * b[2]) % p,
        (a[0] * b[1] - a[1] * b[0]) % p,
    )


def identity() -> ModularFrame:
    """Return the frame of the ground."""
    return ModularFrame((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0))


# Values of dimensions: a number, or cosine and sine.
Value = int | CosineSine
RIGHT_ANGLE: CosineSine = (0, 1)
X, Z = 0, 2


class Move(NamedTuple):
    """A move of a frame along or about one of its own axes.

    Attributes:
        axis: 0, 1, 2 for x, y, z.
        turn: cosine and sine of the angle; None for a displacement.
        shift: the displacement.
    """

    axis: int
    turn: CosineSine | None = None
    shift: int = 0


# Moves of each joint, one after the other.
JointValues = list[tuple[Move, ...]]


def moved(frame: ModularFrame, moves: Sequence[Move], p: int) -> ModularFrame:
    """Move a frame."""
    for axis, turn, shift in moves:
        if turn is None:
            frame = frame._replace(o=mixed(frame.o, 1, frame[axis], shift, p))
            continue
        c, s = turn
        i, j = (axis + 1) % 3, (axis + 2) % 3
        vectors = list(frame)
        vectors[i] = mixed(frame[i], c, frame[j], s, p)
        vectors[j] = mixed(frame[j], c, frame[i], -s, p)
        frame = ModularFrame(*vectors)
    return frame


class SpatialPose(NamedTuple):
    """A pose.

    Attributes:
        parts: frames of the parts; the ground is the first.
        last: frame of the last joint of a loop on its moving link, before it turns.
    """

    parts: tuple[ModularFrame, ...]
    last: ModularFrame | None


def draw_joint_values(
    parts: SpatialParts, p: int, rng: random.Random, tangent: Callable[[int], int | None]
) -> JointValues:
    """Draw positions of joints.

    Args:
        parts: the linkage.
        p: the prime.
        rng: draws.
        tangent: half-angle tangent that a joint must have; None for any.
    """
    out: JointValues = []
    for k, joint in enumerate(parts.joints):
        if joint.kind == "prismatic":
            out.append((Move(Z, shift=rng.randrange(1, p)),))
            continue
        moves = []
        for axis in (Z, X, Z) if joint.kind == "spherical" else (Z,):
            t = tangent(k)
            moves.append(Move(axis, cosine_sine(rng.randrange(1, p) if t is None else t, p)))
        out.append(tuple(moves))
    return out


def place_parts(
    parts: SpatialParts, values: Sequence[Value], joints: JointValues, p: int
) -> SpatialPose:
    """Compute the frames of all parts."""
    frames: list[ModularFrame] = [identity()]
    last = None
    for k, joint in enumerate(parts.joints):
        base, part = joint.parts
        frame = frames[base]
        if base:
            frame = axis_frame(parts, values, frame, base, k, p)
        if not part:
            last = frame
            continue
        frames.append(moved(frame, _constant(parts, values, k) + joints[k], p))
    return SpatialPose(tuple(frames), last)


def axis_frame(
    parts: SpatialParts,
    values: Sequence[Value],
    frame: ModularFrame,
    base: int,
    k: int,
    p: int,
) -> ModularFrame:
    """Compute the frame of a further joint on its part."""
    place = parts.parts[base].places[k]
    moves = []
    if place.turn is not None:
        moves.append(Move(Z, _angle(values[place.turn])))
    moves.append(Move(Z, shift=_number(values, place.along)))
    moves.append(Move(X, shift=_number(values, place.normal)))
    if place.perpendicular:
        moves.append(Move(X, RIGHT_ANGLE))
    elif place.twist is not None:
        moves.append(Move(X, _angle(values[place.twist])))
    return moved(frame, moves, p)


def _constant(parts: SpatialParts, values: Sequence[Value], k: int) -> tuple[Move, ...]:
    """Return the move of a joint that does not change."""
    joint = parts.joints[k]
    if joint.constant is None:
        return ()
    if joint.kind == "prismatic":
        return (Move(Z, _angle(values[joint.constant])),)
    return (Move(Z, shift=_number(values, joint.constant)),)


def _number(values: Sequence[Value], index: int | None) -> int:
    if index is None:
        return 0
    value = values[index]
    assert isinstance(value, int)
    return value


def _angle(value: Value) -> CosineSine:
    assert not isinstance(value, int)
    return value
