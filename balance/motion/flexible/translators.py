"""A translator on two flexible arms, and its counter-translator: simulate both, and compare.

Blocks that translate join the arms of two hubs; a similar block on the other side balances
them. The pitch of the hubs is common to both sides, so that the balance is not perfect (J. P.
Meijaard, V. van der Wijk, Mechanism and Machine Theory 172, 104784, 2022, Sec. 3).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from balance.motion.flexible.arm_mechanisms import Block, translator_mechanism
from balance.motion.flexible.build_beam import BeamOptions
from balance.motion.flexible.drives import moment_rise
from balance.motion.flexible.similarity import Arm
from balance.motion.flexible.simulate import FlexibleMotion, simulate
from kinematics.errors import LinkageError

FIRST_BLOCK = 2
"""Index of the first block among the parts of a translator, after both hubs."""
INTEGRATION_ACCURACY = 1e-7


@dataclass(frozen=True)
class Translator:
    """A block on two hubs, and the moment that drives them.

    Attributes:
        block: the block that translates.
        pitch: distance of the hubs, in metres.
        hub_mass: mass of a hub, a uniform disc with the radius of the arm's root, in kg.
        moment: total moment at the end, in N m.
        rise: duration of its rise, in seconds.
        both: whether both hubs are driven, each by half of it; otherwise the lower one is.
    """

    block: Block
    pitch: float
    hub_mass: float
    moment: float
    rise: float
    both: bool = False

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            LinkageError: one is out of range.
        """
        named = {
            "pitch": self.pitch,
            "mass": self.block.mass,
            "length": self.block.length,
            "breadth": self.block.breadth,
        }
        for name, value in named.items():
            if not 0.0 < value < np.inf:
                raise LinkageError(f"translator: {name} {value:g} is not positive")
        if not 0.0 <= self.hub_mass < np.inf:
            raise LinkageError(f"translator: mass of a hub {self.hub_mass:g} is negative")


@dataclass(frozen=True, eq=False)
class TranslatorMotion:
    """A translator with its counter-translator, and without it.

    Attributes:
        translator: what was asked.
        blocks: its block, and that of the counter-translator.
        pair: motion of both on the same hubs.
        alone: motion of the translator alone, driven by the part of the moment that it takes
            in the pair, so that both have one amplitude.
    """

    translator: Translator
    blocks: tuple[Block, Block]
    pair: FlexibleMotion
    alone: FlexibleMotion

    @property
    def displacement(self) -> tuple[float, float]:
        """Least and largest displacement of the block across its arms, in metres."""
        return _displacement(self.pair)

    @property
    def reduction(self) -> float:
        """Peak shaking force of the translator alone, at equal amplitude, over the pair's."""
        amplitude = np.ptp(self.displacement) / np.ptp(_displacement(self.alone))
        return float(self.alone.peak_force * amplitude / self.pair.peak_force)


def _similar_block(block: Block, scale: float) -> Block:
    """Compute the block of a counter-translator: breadth f, mass 1/f, length as it is.

    Args:
        block: the block that it balances.
        scale: f, length of a counter-arm over that of an arm.
    """
    return Block(block.mass / scale, block.length, scale * block.breadth)


def simulate_translator(
    translator: Translator,
    arms: Sequence[Arm],
    duration: float,
    options: BeamOptions | None = None,
    *,
    samples: int = 501,
    rtol: float = INTEGRATION_ACCURACY,
    progress: Callable[[int, int], None] | None = None,
) -> TranslatorMotion:
    """Simulate a translator with its counter-translator, and alone.

    Args:
        translator: block, hubs and moment.
        arms: the arm and its counter-arm, each used twice; their tip bodies are left out.
        duration: in seconds.
        options: elements and modes of each beam; 4 elements, 3 modes and 1 of stretch by
            default.
        samples: number of instants of the motions.
        rtol: relative tolerance of the integrator.
        progress: is called with the instants done and of all.

    Raises:
        LinkageError: a number is out of range, or the integration fails.
    """
    first, second = arms
    scale = second.beam.length / first.beam.length
    blocks = (translator.block, _similar_block(translator.block, scale))
    stiffness = [arm.beam.bending / arm.beam.length for arm in arms]
    share = stiffness[0] / sum(stiffness)

    def motion(count: int, part: float, done: int) -> FlexibleMotion:
        hubs = 2 if translator.both else 1
        moments = [moment_rise(part * translator.moment / hubs, translator.rise)] * hubs
        moment_of_hub = 0.5 * translator.hub_mass * first.hub_radius**2
        mechanism = translator_mechanism(
            arms[:count],
            blocks[:count],
            translator.pitch,
            moments,
            options or BeamOptions(4, 3, 1),
            (translator.hub_mass, moment_of_hub),
        )
        told = progress and (lambda k, n: progress(done + k, 2 * n))
        return simulate(mechanism, duration, samples, rtol=rtol, method="Radau", progress=told)

    alone = motion(1, share, 0)
    return TranslatorMotion(translator, blocks, motion(2, 1.0, samples), alone)


def _displacement(motion: FlexibleMotion) -> tuple[float, float]:
    """Find the extremes of the displacement of the first block across its arms."""
    y = motion.positions[:, motion.mechanism.slices[FIRST_BLOCK]][:, 1]
    return float(y.min()), float(y.max())
