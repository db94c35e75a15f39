"""What the least shaking is the minimum of: loads and caps as functions of added matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from balance.masses.counterweights.moved_matter import Taken
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.partial_balance.motion_loads import AddedParameters
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.support.tolerances import CAP_EXCEEDED, FIXED_RANK_RELATIVE
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array

NO_SAMPLES = freeze(np.empty((0, 0, 0)))


@dataclass(frozen=True, eq=False)
class Cap:
    """A bound on the size of a load at every sample.

    Attributes:
        name: name of the joint.
        most: the bound, N or N m.
        columns: the load as an affine function ``columns @ [s; 1]`` (N, k, count + 1).
    """

    name: str
    most: float
    columns: Array

    def sizes(self, s: Array) -> Array:
        """Compute the size of the load at every sample (N,)."""
        return np.asarray(np.linalg.norm(self.columns @ np.append(s, 1.0), axis=1))


@dataclass(frozen=True, eq=False)
class ShakingProgram:
    """What `least_shaking` minimises over.

    Attributes:
        matter: regions of the links and parameters.
        factor: triangular factor R (rows, count + 1).
        single: sum of the loads of the single bodies of the file, if none cancelled another.
        taken: what may be taken from the links, kg; s is what is placed less what is taken.
        caps: bounds on loads.
        stocks: matter of limited density in the regions; empty for point masses.
        samples: loads at samples (N, k, count + 1), of which the largest is minimised instead;
            empty for the root of the mean.
    """

    matter: AddedParameters
    factor: Array
    single: float
    taken: Taken
    caps: tuple[Cap, ...] = ()
    stocks: tuple[Stock, ...] = ()
    samples: Array = field(default_factory=lambda: NO_SAMPLES)

    @property
    def given(self) -> float:
        """Load of the file."""
        return self.value(np.zeros(self.matter.count))

    @property
    def balanced(self) -> bool:
        """Whether the masses of the file leave round-off only, as `balance.verify` has it."""
        return self.given <= SHAKING_RELATIVE * self.single

    @property
    def scale(self) -> float:
        """The load that others are compared with: that of the file, unless it is round-off."""
        return (self.single if self.balanced else self.given) or 1.0

    @property
    def least_anywhere(self) -> float | None:
        """The least of ``|R [s; 1]|`` over all s, which bounds that of matter anywhere.

        None if the largest load is minimised.
        """
        if self.samples.size:
            return None
        columns = _without_round_off(self.factor[:, :-1])
        s = np.linalg.lstsq(columns, -self.factor[:, -1], rcond=FIXED_RANK_RELATIVE)[0]
        return float(np.linalg.norm(columns @ s + self.factor[:, -1]))

    def value(self, s: Array) -> float:
        """Compute ``|R [s; 1]|``, or the largest load of the samples."""
        if self.samples.size:
            return float(self._sizes(s).max())
        return float(np.linalg.norm(self.load(s)))

    def exceeded_caps(self, s: Array) -> list[str]:
        """List the joints whose caps are exceeded."""
        return [
            cap.name
            for cap in self.caps
            if cap.sizes(s).max() > cap.most * (1.0 + CAP_EXCEEDED)
        ]

    def load(self, s: Array) -> Array:
        """Compute ``R [s; 1]`` (rows,), whose size is the root of the mean."""
        return np.asarray(self.factor @ np.append(s, 1.0))

    @property
    def unit(self) -> float:
        """Mass of the bodies of the file, kg, a unit of mass; 1 if they have none."""
        return float(self.matter.given[:, 0].sum()) or 1.0

    def restate_over(
        self, matter: AddedParameters, T: Array, stocks: tuple[Stock, ...]
    ) -> ShakingProgram:
        """Return the program over matter in other regions.

        Args:
            matter: these regions.
            T: ``[s; 1]`` of this program as a function of that one (count + 1, count + 1).
            stocks: densities in them.
        """
        samples = self.samples @ T if self.samples.size else self.samples
        return replace(
            self, matter=matter, factor=self.factor @ T, stocks=stocks, samples=samples
        )

    def blocks(self, samples: Sequence[int]) -> list[Array]:
        """List rows (k, count + 1) of cones: R, or the loads of samples."""
        return list(self.samples[list(samples)]) if self.samples.size else [self.factor]

    def largest_samples(self, s: Array, count: int) -> list[int]:
        """List samples of the largest loads, the largest first; none for the mean."""
        if not self.samples.size:
            return []
        order: list[int] = np.argsort(-self._sizes(s))[:count].tolist()
        return order

    def _sizes(self, s: Array) -> Array:
        """Compute the loads of the samples (N,)."""
        return np.asarray(np.linalg.norm(self.samples @ np.append(s, 1.0), axis=1))


def _without_round_off(columns: Array) -> Array:
    """Scale columns (rows, count) to a norm of 1, and leave out those that are round-off."""
    norms = np.linalg.norm(columns, axis=0)
    kept = norms > FIXED_RANK_RELATIVE * norms.max(initial=0.0)
    return np.asarray(columns[:, kept] / norms[kept])


def quadratic_factor(rows: Sequence[Array]) -> Array:
    """Compute the factor R with ``|R x| = |rows x|`` for every x, one block after the other.

    Args:
        rows: blocks of rows (any number, columns).
    """
    R = np.empty((0, rows[0].shape[1]))
    for block in rows:
        R = np.asarray(np.linalg.qr(np.concatenate([R, block]), mode="r"))
    return R
