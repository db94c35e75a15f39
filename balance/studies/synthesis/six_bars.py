"""Six-bars through positions: a four-bar, and a dyad with which it can be balanced.

The coupler of a four-bar passes through the positions (`general_four_bars`). A dyad between the
base and the crank, or the base and the rocker, repeats its loop, reflected and half as large,
or the parallelogram of that (`balance.masses.remedies.dyads.added_dyad`); all six links then
take the masses that balance them. About a fifth of the four-bars with a coupler shorter than
their base have such masses.

The dyad must not fold either: the distance of its outer hinges stays clear of the sum and the
difference of its links on the way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from itertools import islice

import numpy as np

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.dyads.added_dyad import buildable_space
from balance.masses.remedies.dyads.known_dyads import DyadSeed, dyad_seeds
from balance.masses.remedies.request import RemedyRequest
from balance.space.spaces.design_space import DesignSpace
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.general_four_bars import LEAST, GeneralFourBar
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

KIND = "six-bar"
# Most four-bars to which dyads are added; dyads of each: those on the base, which come first.
TRIED, DYADS = 60, 4
# Angles of the crank, from the first position to the last, at which the dyad is judged.
SAMPLES = 200


@dataclass(frozen=True)
class SixBar(GeneralFourBar):
    """A four-bar with a dyad, whose coupler carries the tool through positions.

    Attributes:
        dyad: its hinge on the base, that between its links, and that on the other side, at the
            first position; metres, inertial frame.
        side: link of the four-bar that carries the last of them: ``"crank"`` or ``"rocker"``.
        words: what the dyad is.
    """

    dyad: tuple[complex, complex, complex] = (0j, 0j, 0j)
    side: str = "crank"
    words: str = ""

    kind = KIND

    @property
    def numbers(self) -> dict[str, float]:
        """Those of the four-bar; the transmission angle is the least of both loops."""
        angle = min(self.transmission, self.dyad_transmission)
        return super().numbers | {"transmission_angle": angle}

    def pivots(self, index: int = 0) -> dict[str, complex]:
        """Compute the pivots at a position, metres, inertial frame."""
        start, between, end = self._dyad_at(index)
        dyad = {"dyad_base": start, "dyad_middle": between, f"dyad_{self.side}": end}
        return super().pivots(index) | dyad

    @property
    def dyad_transmission(self) -> float:
        """Least angle between the links of the dyad, or its supplement, on the way, radians."""
        start, middle, _ = self.dyad
        turns = np.linspace(self.crank_angles[0], self.crank_angles[-1], SAMPLES)
        gap = np.abs(self._ends(turns) - start)
        first, second = self._lengths()
        cosine = np.abs(first**2 + second**2 - gap**2) / (2.0 * first * second)
        return float(np.arccos(min(1.0, float(cosine.max()))))

    def outline(self, index: int) -> tuple[complex, ...]:
        """Compute a line along the links of the four-bar, and one along those of the dyad."""
        gap, end = complex(np.nan, np.nan), super().pivots()[f"{self.side}_base"]
        return (*super().outline(index), gap, *self._dyad_at(index), end)

    def _dyad_at(self, index: int) -> tuple[complex, complex, complex]:
        """Compute the hinges of the dyad at a position, in the assembly of the first."""
        start, middle, end = self.dyad
        moved = complex(self._ends(np.array([self.crank_angles[index]]))[0])
        first, second = self._lengths()
        gap = moved - start
        along = (first**2 - second**2 + abs(gap) ** 2) / (2.0 * abs(gap))
        side = np.sign(((middle - start) * (end - start).conjugate()).imag)
        beside = side * np.sqrt(max(first**2 - along**2, 0.0))
        return start, complex(start + (along + 1j * beside) * gap / abs(gap)), moved

    def _lengths(self) -> tuple[float, float]:
        start, middle, end = self.dyad
        return abs(middle - start), abs(end - middle)

    def _ends(self, crank_angles: Array) -> Array:
        """Compute the hinge on crank or rocker for angles of the crank."""
        tips = self._tips(crank_angles)
        firsts = self.crank_tip, self.rocker_tip
        bases = self.crank_base, self.rocker_base
        k = int(self.side == "rocker")
        turned = (tips[k] - bases[k]) / (firsts[k] - bases[k])
        return np.asarray(bases[k] + turned * (self.dyad[2] - bases[k]))


def six_bars(
    designs: Sequence[GeneralFourBar], progress: Callable[[int, int], None] | None = None
) -> tuple[tuple[SixBar, DesignSpace], ...]:
    """Add dyads to four-bars, and find those with masses that balance them.

    Args:
        designs: four-bars through positions; of many some are tried, of all sizes.
        progress: called with the number of four-bars tried and of all that are.

    Returns:
        Six-bars and their design spaces; those whose masses have the largest margin first: they
        are light.
    """
    short = [each for each in designs if _lengths_fit(each)]
    tried = short[:: len(short) // TRIED + 1]
    pairs: list[tuple[SixBar, DesignSpace]] = []
    for done, four_bar in enumerate(tried, 1):
        linkage = load(Document(KIND, four_bar_urdf(four_bar, name=KIND)), bodies="all")
        request = RemedyRequest(linkage)
        for seed in islice(dyad_seeds(linkage), DYADS):
            space = buildable_space(request, seed)
            design = space and _six_bar(four_bar, seed, space)
            if space and design and design.dyad_transmission > LEAST:
                pairs.append((design, space))
        if progress is not None:
            progress(done, len(tried))
    ranks = rank_least_first([-feasible(space).margin for _, space in pairs])
    return tuple(pairs[k] for k in ranks)


def _lengths_fit(four_bar: GeneralFourBar) -> bool:
    """Whether the coupler is shorter than the base: no others were met that have masses."""
    base = abs(four_bar.rocker_base - four_bar.crank_base)
    return abs(four_bar.rocker_tip - four_bar.crank_tip) < base


def _six_bar(four_bar: GeneralFourBar, seed: DyadSeed, space: DesignSpace) -> SixBar | None:
    """Read where the hinges of a dyad are; None if it is not on the base and a moving side."""
    first, second = (side.name for side in seed.dyad.sides)
    if first != "base" or second not in ("crank", "rocker"):
        return None
    points = {joint.name: complex(*joint.point[:2]) for joint in space.linkage.joints}
    ends = [points[name] for name in ("dyad_joint_1", "dyad_joint_2", "dyad_loop")]
    given = {each.name: getattr(four_bar, each.name) for each in fields(four_bar)}
    words = f"dyad between base and {second}: {seed.words}, half as large"
    return SixBar(**given, dyad=(ends[0], ends[1], ends[2]), side=second, words=words)
