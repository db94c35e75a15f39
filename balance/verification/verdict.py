"""What a verification found: loads along the motions, the verdict, and the report."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from balance.answer import Balance
from balance.verification.trajectory import Trajectory
from kinematics.linkage import Linkage, Notice

__all__ = ["AGREE", "SCHEMA", "Run", "Verification"]

Array = NDArray[np.float64]

SCHEMA = "balance.verify/1"
# Both programs must agree to this part of the inertia forces for a verdict.
AGREE = 1e-9
# Where loops hold by less, relative to the reference pose, round-off shows.
SINGULAR = 0.02


@dataclass(frozen=True, eq=False)
class Run:
    """Loads along one motion; wrenches are ``[moment; force]`` in inertial axes, SI units.

    Attributes:
        trajectory: the motion.
        shaking: base reaction from Pinocchio, about the inertial origin (N, 6).
        own: the same from our own series (N, 6).
        momentum: total momentum ``[ξ; p]`` from Pinocchio (N, 6).
        middle: ``shaking`` with moments about the middle of the mechanism (N, 6).
        rate_difference: ``shaking - own``, likewise about the middle (N, 6).
        momentum_difference: momentum from Pinocchio less ours, likewise (N, 6).
        inertia: sum over the bodies of the sizes of their own inertia wrenches, moments
            about the middle divided by the characteristic length (N,), newtons.
        impulse: the same of their momenta (N,), newton seconds.
        bearing: forces in the joints (N, n), newtons.
        open: components of the loop wrenches that rigid bodies leave undetermined.
    """

    trajectory: Trajectory
    shaking: Array
    own: Array
    momentum: Array
    middle: Array
    rate_difference: Array
    momentum_difference: Array
    inertia: Array
    impulse: Array
    bearing: Array
    open: int


@dataclass(frozen=True, eq=False)
class Verification:
    """The verdict of `verify` and what it rests on.

    Attributes:
        linkage: the linkage.
        balance: ``"dynamic"``, or ``"force"`` if only the force counts.
        tolerance: residuals up to this one count as balanced.
        length: characteristic length, metres.
        seed: seed of the random motions; None if the motions were given.
        runs: the loads along each motion.
        notices: what the reader had to tell.
    """

    linkage: Linkage
    balance: Balance
    tolerance: float
    length: float
    seed: int | None
    runs: tuple[Run, ...]
    notices: tuple[Notice, ...]

    @property
    def model(self) -> str:
        """Name of the linkage."""
        return self.linkage.name

    @cached_property
    def scale(self) -> float:
        """Peak of the sum of the sizes of the bodies' own inertia wrenches, newtons."""
        return self._largest("inertia")

    @property
    def force(self) -> float:
        """Peak shaking force, newtons."""
        return self._peak("middle", slice(3, 6))

    @property
    def moment(self) -> float:
        """Peak shaking moment about the middle of the mechanism, N m."""
        return self._peak("middle", slice(0, 3))

    @property
    def force_residual(self) -> float:
        """Peak shaking force relative to ``scale``."""
        return self._relative(self.force)

    @property
    def moment_residual(self) -> float:
        """Peak shaking moment relative to ``scale`` times the characteristic length."""
        return self._relative(self.moment / self.length)

    @property
    def bearing(self) -> float:
        """Peak force in any joint, newtons."""
        return self._largest("bearing")

    @property
    def force_ratio(self) -> float:
        """Peak shaking force over peak bearing force; 0 if no joint carries a force."""
        return self.force / self.bearing if self.bearing > 0.0 else 0.0

    @property
    def moment_ratio(self) -> float:
        """Peak shaking moment over peak bearing force times characteristic length."""
        return self.moment / (self.bearing * self.length) if self.bearing > 0.0 else 0.0

    @property
    def closure(self) -> float:
        """Largest mismatch of the loops, radians and characteristic lengths."""
        return max((run.trajectory.closure for run in self.runs), default=0.0)

    @property
    def agreement(self) -> float:
        """Largest difference of Pinocchio and our series, in momentum or in its rate.

        Relative to the sum of the sizes of the bodies' parts at its peak.
        """
        found = [0.0]
        for name, size in (("rate", "inertia"), ("momentum", "impulse")):
            moment = self._peak(f"{name}_difference", slice(0, 3))
            force = self._peak(f"{name}_difference", slice(3, 6))
            if (scale := self._largest(size)) > 0.0:
                found.append(max(moment / self.length, force) / scale)
        return max(found)

    @property
    def agreed(self) -> bool:
        """Whether both programs agree to 1e-9."""
        return self.agreement <= AGREE

    @property
    def balanced(self) -> bool:
        """Whether what shakes the base is within the tolerance."""
        moment = self.moment_residual if self.balance == "dynamic" else 0.0
        return max(self.force_residual, moment) <= self.tolerance

    @property
    def verdict(self) -> str:
        """``"balanced"``, ``"not balanced"``, or ``"no verdict"`` if the programs disagree."""
        if not self.agreed:
            return "no verdict"
        return "balanced" if self.balanced else "not balanced"

    @property
    def brief(self) -> str:
        """The answer in short, in words."""
        return (
            f"{self.verdict}, shaking force {self.force_residual:.1e} and moment "
            f"{self.moment_residual:.1e} of inertia"
        )

    def _peak(self, name: str, part: slice) -> float:
        """Largest size of a part of a wrench in any run."""
        sizes = (np.linalg.norm(getattr(run, name)[:, part], axis=1) for run in self.runs)
        return max((float(size.max(initial=0.0)) for size in sizes), default=0.0)

    def _largest(self, name: str) -> float:
        """Largest number of that name in any run."""
        found = (float(getattr(run, name).max(initial=0.0)) for run in self.runs)
        return max(found, default=0.0)

    def _relative(self, force: float) -> float:
        return force / self.scale if self.scale > 0.0 else 0.0

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the user should know of the bearing forces and of the routes."""
        found = []
        if self.scale == 0.0:
            found.append("nothing with mass moves")
        if self.runs and self.runs[0].open:
            found.append(
                f"the linkage is overconstrained: {self.runs[0].open} components of its loop "
                "wrenches are not determined by rigid bodies; bearing forces are those of "
                "least norm"
            )
        if min((run.trajectory.firmness for run in self.runs), default=1.0) < SINGULAR:
            found.append(
                "the motion passes near a singularity, where round-off is amplified: what "
                "little is left to shake there may be no more than that"
            )
        if not self.agreed:
            found.append(f"Pinocchio and our series differ by {self.agreement:.1e}: no verdict")
        return tuple(found)

    def to_dict(self) -> dict[str, object]:
        """The report as plain data, ready for JSON.

        ``balance/schemas/verify.schema.json`` describes it.
        """
        return {
            "schema": SCHEMA,
            "model": self.model,
            "at": self.linkage.at,
            "balance": self.balance,
            "balanced": self.balanced if self.agreed else None,
            "tolerance": self.tolerance,
            "trajectories": len(self.runs),
            "samples": sum(run.trajectory.time.size for run in self.runs),
            "seed": self.seed,
            "inputs": list(self.linkage.inputs),
            "length": self.length,
            "shaking": {"force": self.force, "moment": self.moment},
            "residual": {"force": self.force_residual, "moment": self.moment_residual},
            "inertia": self.scale,
            "bearing": {
                "force": self.bearing,
                "joint": self._most_loaded(),
                "undetermined": self.runs[0].open if self.runs else 0,
            },
            "ratio": {"force": self.force_ratio, "moment": self.moment_ratio},
            "agreement": self.agreement,
            "closure": self.closure,
            "remarks": list(self.remarks),
            "warnings": [notice._asdict() for notice in self.notices],
        }

    def _most_loaded(self) -> str | None:
        """Name of the joint with the largest force."""
        if self.bearing == 0.0:
            return None
        peaks = np.max([run.bearing.max(axis=0) for run in self.runs], axis=0)
        return self.linkage.joints[int(np.argmax(peaks))].name

    def facts(self) -> list[tuple[str, str]]:
        """The report as pairs of a label and a value."""
        samples = sum(run.trajectory.time.size for run in self.runs)
        origin = "given" if self.seed is None else f"random, seed {self.seed}"
        ratio = f"{self.force_ratio:.1e} (force), {self.moment_ratio:.1e} (moment)"
        joint = self._most_loaded()
        return [
            ("linkage", f"{self.model}, {self.balance} balance"),
            *([("pose", self.linkage.pose)] if self.linkage.at else []),
            ("inputs", _names(self.linkage.inputs)),
            ("motions", f"{len(self.runs)} {origin}; {samples} samples"),
            ("shaking force", f"{self.force:.3g} N, {self.force_residual:.1e} of inertia"),
            ("shaking moment", f"{self.moment:.3g} N m, {self.moment_residual:.1e} of inertia"),
            ("inertia", f"{self.scale:.3g} N, the bodies' own at its peak"),
            ("bearing force", f"{self.bearing:.3g} N" + (f" in {joint}" if joint else "")),
            ("to bearing", ratio),
            ("agreement", f"{self.agreement:.1e}, Pinocchio and our series"),
            ("closure", f"{self.closure:.1e} radians, characteristic lengths"),
            *(("note", remark) for remark in self.remarks),
            ("verdict", f"{self.verdict} (tolerance {self.tolerance:.1e})"),
        ]


def _names(inputs: tuple[str, ...]) -> str:
    return ", ".join(inputs[:6]) + (" …" if len(inputs) > 6 else "")
