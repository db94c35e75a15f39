"""Mechanisms of arms: an arm or a balanced pair on one hub, and translators of two such pairs.

The hubs turn about the origin, or about two points of the y axis; arms point along +x, their
counter-arms along -x (J. P. Meijaard, V. van der Wijk, Mechanism and Machine Theory 172, 2022,
Secs. 2 and 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.motion.flexible.beam_part import Marker, MovingPart, RigidPart
from balance.motion.flexible.build_beam import BeamModel, BeamOptions, model_beam
from balance.motion.flexible.drives import Profile
from balance.motion.flexible.mechanism import PlanarMechanism
from balance.motion.flexible.mechanism_types import JointDrive, MechanismJoint, On
from balance.motion.flexible.similarity import Arm
from balance.motion.flexible.supported_beam_modes import Clamp, EndBody, Support
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array


class Block(NamedTuple):
    """A rigid rectangular block that joins two arms.

    Attributes:
        mass: in kg.
        length: in the plane, across the arms, in metres.
        breadth: in the plane, along the arms, in metres.
    """

    mass: float
    length: float
    breadth: float

    @property
    def moment(self) -> float:
        """Moment of inertia about the centre, in kg m²."""
        return self.mass * (self.length**2 + self.breadth**2) / 12.0


def arm_mechanism(arms: Sequence[Arm], drive: Profile, options: BeamOptions) -> PlanarMechanism:
    """Build one arm, or an arm and its counter-arm, on a hub with prescribed rotation.

    Args:
        arms: one or two arms; the second points the other way.
        drive: rotation of the hub over time.
        options: elements and modes of the beams.

    Raises:
        LinkageError: there are no arms, or more than two.
    """
    if not 1 <= len(arms) <= 2:
        raise LinkageError(f"{len(arms)} arms on a hub: give one or two")
    parts: list[MovingPart] = [RigidPart("hub", 0.0, 0.0)]
    joints = [_pivot("hub", 0, 0.0)]
    start = [np.zeros(3)]
    for k, arm in enumerate(arms):
        body = EndBody(arm.tip_mass, arm.tip_radius, arm.tip_inertia)
        model = _clamped_beam(f"arm{k + 1}", arm, options, body, None)
        joints.append(_root(model, arm, 0, len(parts), k * np.pi))
        parts.append(model.part)
        start.append(_start(model, arm, 0.0, k * np.pi))
    size = max(arm.beam.length for arm in arms)
    return PlanarMechanism(
        tuple(parts), tuple(joints), np.concatenate(start), (), (JointDrive(0, drive),), size
    )


def translator_mechanism(
    arms: Sequence[Arm],
    blocks: Sequence[Block],
    pitch: float,
    moments: Sequence[Profile],
    options: BeamOptions,
    hub: tuple[float, float] = (0.0, 0.0),
) -> PlanarMechanism:
    """Build one translator, or a balanced pair of translators, on two hubs.

    Args:
        arms: one arm per translator, used twice; their tip bodies are left out.
        blocks: the block that each pair of arms moves.
        pitch: distance of the hubs, in metres; they are at y = ± pitch / 2.
        moments: moment on the lower hub, and on the upper hub, if that is driven, over time.
        options: elements and modes of the beams.
        hub: mass and moment of inertia of a hub, in kg and kg m².

    Raises:
        LinkageError: numbers of arms, blocks or moments do not fit, or the pitch is not
            positive.
    """
    if not 1 <= len(arms) == len(blocks) <= 2 or not 1 <= len(moments) <= 2:
        raise LinkageError("a translator needs one or two arms, as many blocks, 1 or 2 moments")
    if not 0.0 < pitch < np.inf:
        raise LinkageError(f"pitch {pitch:g} m is not positive")
    heights = (-0.5 * pitch, 0.5 * pitch)
    parts: list[MovingPart] = [RigidPart(name, *hub) for name in ("lower_hub", "upper_hub")]
    joints = [_pivot(name, k, heights[k]) for k, name in enumerate(("lower_hub", "upper_hub"))]
    start = [np.array([0.0, y, 0.0]) for y in heights]
    for k, (arm, block) in enumerate(zip(arms, blocks, strict=True)):
        angle, side = k * np.pi, 1.0 - 2.0 * k
        centre = side * (arm.hub_radius + arm.beam.length + 0.5 * block.breadth)
        at = len(parts)
        parts.append(RigidPart(f"block{k + 1}", block.mass, block.moment))
        start.append(np.array([centre, 0.0, 0.0]))
        load = EndBody(0.5 * block.mass, 0.5 * block.breadth, 0.25 * block.moment)
        for h, y in enumerate(heights):
            model = _clamped_beam(f"arm{k + 1}{'ab'[h]}", arm, options, None, load)
            joints.append(_root(model, arm, h, len(parts), angle))
            edge = Marker(np.array([-side * 0.5 * block.breadth, y]))
            end = On(len(parts), model.marker(arm.beam.length))
            joints.append(
                MechanismJoint(
                    f"{model.part.name}_end", "fixed", On(at, edge), end, angle=angle
                )
            )
            parts.append(model.part)
            start.append(_start(model, arm, y, angle))
    drives = tuple(JointDrive(h, moment, moment=True) for h, moment in enumerate(moments))
    return PlanarMechanism(
        tuple(parts), tuple(joints), np.concatenate(start), (), drives, pitch
    )


def _pivot(name: str, part: int, y: float) -> MechanismJoint:
    """Join a hub to the ground at (0, y)."""
    ground = On(-1, Marker(np.array([0.0, y])))
    return MechanismJoint(name, "revolute", ground, On(part, Marker(np.zeros(2))))


def _clamped_beam(
    name: str, arm: Arm, options: BeamOptions, body: EndBody | None, load: EndBody | None
) -> BeamModel:
    """Model the beam of an arm; its frame follows the chord."""
    chord = [Support((0.0,)), Support((arm.beam.length,))]
    return model_beam(name, arm.beam, chord, options, body, load, [Clamp(0.0)])


def _root(model: BeamModel, arm: Arm, hub: int, part: int, angle: float) -> MechanismJoint:
    """Fix the root of a beam to the edge of its hub."""
    edge = arm.hub_radius * np.array([np.cos(angle), np.sin(angle)])
    root = On(part, model.marker(0.0))
    return MechanismJoint(
        f"{model.part.name}_root", "fixed", On(hub, Marker(edge)), root, angle=angle
    )


def _start(model: BeamModel, arm: Arm, y: float, angle: float) -> Array:
    """Place an undeformed arm."""
    edge = arm.hub_radius * np.array([np.cos(angle), np.sin(angle)])
    return np.concatenate([edge + [0.0, y], [angle], np.zeros(model.part.size)])
