"""What matter for the mean load of a range leaves for its least and its greatest load.

The matter is that of the least mean square over all loads; see `balance.masses.payload`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.partial_balance.budgets import single
from balance.masses.partial_balance.least_violation import LeastViolation, missed_by
from balance.masses.partial_balance.partial_balance import ParetoFront
from balance.masses.partial_balance.shaking_problem import ShakingOptions
from balance.masses.payload import Payload, carrying, point_parameters, with_parameters
from kinematics.wording import number_text, repr_lines, size_text


class LoadsLeft(NamedTuple):
    """What is left for some loads of a range.

    Attributes:
        payload: the range.
        quantity: what is left, with its unit: ``"shaking (N, rms)"``.
        values: for the least load, the mean and the greatest.
    """

    payload: Payload
    quantity: str
    values: tuple[float, float, float]

    def __repr__(self) -> str:
        """Two lines: the range, and what is left."""
        return repr_lines(f"LoadsLeft for {self.payload.words}", self.words)

    @property
    def words(self) -> str:
        """What is left, in words."""
        loads = (self.payload.low, self.payload.mean, self.payload.high)
        scale = max(self.values)
        listed = (
            f"{size_text(x, '.4g', scale, 1e-6)} for {number_text(load)} kg"
            for x, load in zip(self.values, loads, strict=True)
        )
        return f"{self.quantity}: {', '.join(listed)}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        low, mean, high = self.values
        by_load = {"low": low, "mean": mean, "high": high}
        return {**self.payload.to_dict(), "quantity": self.quantity, "left": by_load}


def shaking_left(
    front: ParetoFront, payload: Payload, links: tuple[str, ...], options: ShakingOptions
) -> LoadsLeft | None:
    """Compute the shaking that the last design of a front leaves for loads of a range.

    Args:
        front: designs for the mean load.
        payload: the range.
        links: the links that may get matter.
        options: those of the designs; limits do not count.

    Returns:
        None without a design.
    """
    best = front.designs[-1]
    if best.z is None or best.shaking is None:
        return None
    bare = replace(options, max_bearing=None, max_torque=None)
    linkage = with_parameters(best.space.linkage, dict(enumerate(best.z)))
    figures = []
    for load in (payload.low, payload.high):
        there = replace(best.space, linkage=carrying(linkage, payload, load - payload.mean))
        figures.append(single(there, links, 0.0, bare).designs[0].given.objective)
    unit = "N" if front.frame is None else "m"
    quantity = f"{front.objective} ({unit}, rms)"
    return LoadsLeft(payload, quantity, (figures[0], best.shaking.objective, figures[1]))


def violation_left(answer: LeastViolation, payload: Payload) -> LoadsLeft:
    """Compute what the matter of a least violation misses for loads of a range.

    Args:
        answer: the least violation for the mean load.
        payload: the range.
    """
    space = answer.space
    b = next(
        k
        for k, body in enumerate(space.linkage.bodies)
        if body.link == space.linkage.places[payload.link].link
    )
    missed = []
    for load in (payload.low, payload.high):
        z = np.array(answer.z)
        z[b] += point_parameters(space.linkage, payload, load - payload.mean)
        missed.append(missed_by(answer, z))
    return LoadsLeft(
        payload, "root of the sum of squares", (missed[0], answer.total, missed[1])
    )
