"""Result of a verification: residuals over all motions, and the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from balance.motion.motion_tolerances import (
    AGREEMENT_RELATIVE,
    CONDITIONING_NOTICE,
    SINGULAR_MOTION_DETERMINED,
)
from balance.motion.verification.crank_revolution import Crank
from balance.motion.verification.harmonics import harmonic_peaks
from balance.motion.verification.run import PARTS, Run
from balance.motion.verification.trajectory import Trajectory, input_reach, singularity_remark
from balance.support.options import Balance
from balance.support.result_files import WithPage, WithPicture
from kinematics.model.linkage import Linkage, Notice
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.tolerances import SIZE_DETERMINED, TIE_RELATIVE
from kinematics.wording import (
    count_noun,
    html_facts,
    outward_text,
    repr_lines,
    size_text,
    unit_text,
)

VERIFY_SCHEMA = "balance.verify/1"
# Units of shaking loads.
UNITS = {"force": "N", "moment": "N m"}
# Harmonics of a revolution that are listed.
HARMONICS = 4


@dataclass(frozen=True, eq=False)
class Verification(WithPage, WithPicture):
    """Result of `verify`: the verdict and the loads along the motions.

    Attributes:
        linkage: the linkage.
        balance: ``"dynamic"``, or ``"force"`` if only the force counts.
        tolerance: largest residual of a balanced linkage.
        length: characteristic length, metres.
        seed: seed of the random motions; None if the motions were given.
        runs: the loads along each motion.
        notices: notices of the linkage.
        point: point of the inertial frame that the moments which are reported are about (3,),
            metres. The verdict is on moments about the middle of the mechanism.
        crank: the joint that turns at constant speed; its revolution is the only motion. None
            for other motions.
        shown: index of the motion to plot; by default the worst one.
        motion: restriction of the inputs, as it was asked for.
    """

    page_maker = "verification_page:verification_page"
    picture_maker = "verification:verification_picture"

    linkage: Linkage
    balance: Balance
    tolerance: float
    length: float
    seed: int | None
    runs: tuple[Run, ...]
    notices: tuple[Notice, ...]
    point: Array
    crank: Crank | None = None
    shown: int | None = None
    motion: Motion | str | Sequence[str] | None = None

    def __repr__(self) -> str:
        """Four lines: the motions, the peaks, and the verdict."""
        count = count_noun(len(self.runs), "motion")
        return repr_lines(
            f"Verification of {self.model}, {self.balance} balance, over {count}",
            f"shaking force {self.force_text}",
            f"shaking moment {self.moment_text}",
            f"{self.verdict} (tolerance {self.tolerance:.1e})",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"Verification of {self.model}",
            ("balance", self.balance),
            ("motions", str(len(self.runs))),
            ("shaking force", self.force_text),
            ("shaking moment", self.moment_text),
            ("verdict", f"{self.verdict} (tolerance {self.tolerance:.1e})"),
        )

    @property
    def model(self) -> str:
        """Name of the linkage."""
        return self.linkage.name

    @cached_property
    def scale(self) -> float:
        """Peak of the sum of the norms of the inertia wrenches of the bodies, newtons."""
        return self._largest("inertia")

    @property
    def force(self) -> float:
        """Peak shaking force, newtons."""
        return self._peak("about", PARTS["force"])

    @property
    def moment(self) -> float:
        """Peak shaking moment about the point, N m."""
        return self._peak("about", PARTS["moment"])

    @property
    def force_residual(self) -> float:
        """Peak shaking force relative to ``scale``."""
        return self._relative(self.force)

    @property
    def moment_residual(self) -> float:
        """Peak moment about the middle over ``scale`` times the characteristic length."""
        return self._relative(self._peak("middle", PARTS["moment"]) / self.length)

    @property
    def bearing(self) -> float:
        """Peak force in any joint, newtons."""
        return self._largest("bearing")

    @property
    def drive_peaks(self) -> dict[str, float]:
        """Largest drive torque, N m, or force, N, of each input without gravity, by name."""
        peaks = np.max(
            [np.abs(run.drive).max(axis=0, initial=0.0) for run in self.runs], axis=0
        )
        return dict(zip(self.linkage.inputs, peaks.tolist(), strict=True))

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
        """Largest closure residual, radians and characteristic lengths."""
        return max((run.trajectory.closure for run in self.runs), default=0.0)

    @property
    def agreement(self) -> float:
        """Largest difference between Pinocchio and our series, in momentum or in its rate.

        It is relative to the peak sum of the norms of the parts of the bodies.
        """
        differences = [0.0]
        for name, size in (("rate", "inertia"), ("momentum", "impulse")):
            moment = self._peak(f"{name}_difference", PARTS["moment"])
            force = self._peak(f"{name}_difference", PARTS["force"])
            if (scale := self._largest(size)) > 0.0:
                differences.append(max(moment / self.length, force) / scale)
        return max(differences)

    @property
    def agreed(self) -> bool:
        """Whether both programs agree to 1e-9."""
        return self.agreement <= AGREEMENT_RELATIVE

    @property
    def balanced(self) -> bool:
        """Whether the residuals are within the tolerance."""
        moment = self.moment_residual if self.balance == "dynamic" else 0.0
        return max(self.force_residual, moment) <= self.tolerance

    @property
    def conditioning(self) -> float:
        """Least conditioning of the loops over all motions; 0 at a singularity."""
        return min((run.trajectory.conditioning for run in self.runs), default=1.0)

    @property
    def decided(self) -> bool:
        """Whether there is a verdict.

        There is none if the programs disagree, if the rounding of a table decides it, or if the
        motions pass near a singularity and
        at most samples no more is left to shake than the tolerance allows: round-off, which
        a singularity amplifies, looks like that.
        """
        if self.rounding_decides:
            return False
        if not self.agreed or self.balanced or self.conditioning >= CONDITIONING_NOTICE:
            return self.agreed
        moment = self._median("moment") / self.length if self.balance == "dynamic" else 0.0
        return self._relative(max(self._median("force"), moment)) > self.tolerance

    @property
    def rounding_decides(self) -> bool:
        """Whether the rounding of a table leaves open whether the linkage is balanced."""
        ends = [self.peak_range("force")]
        if self.balance == "dynamic":
            arm = self.length + self.lever
            low, high = self.peak_range("moment")
            ends.append((low / arm, high / arm))
        least, most = (max(end[k] for end in ends) for k in (0, 1))
        return self._relative(least) <= self.tolerance < self._relative(most)

    def peak_range(self, part: str) -> tuple[float, float]:
        """Compute the range that holds the peak ``"force"`` or ``"moment"``, N or N m.

        Rounded tables determine it up to their rounding; see `Run.peak_range`.
        """
        ranges = [run.peak_range(part) for run in self.runs] or [(0.0, 0.0)]
        return max(least for least, _ in ranges), max(most for _, most in ranges)

    @property
    def decimals(self) -> int | None:
        """Fewest decimals of the tables that the motions come from; None if there are none."""
        errors = (run.trajectory.errors for run in self.runs)
        return min((error.decimals for error in errors if error is not None), default=None)

    def range_text(self, part: str) -> str:
        """Write the range of the peak ``"force"`` or ``"moment"``, round-off as a bound."""
        least, most = self.peak_range(part)
        if most <= self.round_off * self.part_scale(part):
            return self.load_text(part, most)
        return f"{outward_text(least, most)} {UNITS[part]}"

    @property
    def verdict(self) -> str:
        """``"balanced"`` or ``"not balanced"``, ``"no verdict"`` unless it is `decided`.

        With force balance it begins with ``"forces"``: the moment does not count.
        """
        if not self.decided:
            return "no verdict"
        words = "balanced" if self.balanced else "not balanced"
        return f"forces {words}" if self.balance == "force" else words

    @property
    def outcome(self) -> str:
        """Which loads are cancelled, in words; empty if both are left to shake."""
        if not self.decided:
            return "no verdict"
        force, moment = (
            residual <= self.tolerance
            for residual in (self.force_residual, self.moment_residual)
        )
        if self.balance == "force":
            return "the force is cancelled, the moment does not count" * force
        if force and moment:
            return "no shaking is left"
        if force or moment:
            names = ("force", "moment") if force else ("moment", "force")
            return f"the {names[0]} is cancelled, the {names[1]} is not"
        return ""

    @property
    def brief(self) -> str:
        """Summary in one line."""
        return (
            f"{self.verdict}, shaking force {size_text(self.force_residual)} and moment "
            f"{size_text(self.moment_residual)} of inertia"
        )

    def worst(self, part: str) -> int:
        """Return the index of the first motion with the peak ``"force"`` or ``"moment"``."""
        return first_largest([run.peak(part) for run in self.runs], self.part_scale(part))

    def part_scale(self, part: str) -> float:
        """Return what the shaking ``"force"`` or ``"moment"`` is relative to, N or N m."""
        return self.scale if part == "force" else self.scale * (self.length + self.lever)

    @property
    def lever(self) -> float:
        """Distance of the point of the moments from the middle of the mechanism, metres."""
        return float(np.linalg.norm(self.point - self.linkage.spatial_chain.frame.origin))

    @property
    def about_middle(self) -> bool:
        """Whether the point of the moments is the middle of the mechanism."""
        return self.lever <= TIE_RELATIVE * self.length

    def rms(self, part: str) -> float:
        """Compute the root mean square of ``"force"`` or ``"moment"`` over all motions."""
        return float(np.sqrt(np.mean([run.rms(part) ** 2 for run in self.runs])))

    def load_text(self, part: str, load: float) -> str:
        """Write a shaking ``"force"`` or ``"moment"`` with its unit; round-off as a bound.

        Args:
            part: ``"force"`` or ``"moment"``.
            load: its size, N or N m.
        """
        return unit_text(load, UNITS[part], ".3g", self.part_scale(part), self.round_off)

    @property
    def round_off(self) -> float:
        """Size relative to inertia up to which round-off decides it; large at a singularity."""
        near = self.conditioning < CONDITIONING_NOTICE
        return SINGULAR_MOTION_DETERMINED if near else SIZE_DETERMINED

    @property
    def force_text(self) -> str:
        """The peak shaking force, and its residual, in words."""
        load = self.load_text("force", self.force)
        return f"{load}, {size_text(self.force_residual, floor=self.round_off)} of inertia"

    @property
    def moment_text(self) -> str:
        """The peak shaking moment, and its residual, in words."""
        load = self.load_text("moment", self.moment)
        return f"{load}, {size_text(self.moment_residual, floor=self.round_off)} of inertia"

    @property
    def plotted(self) -> int:
        """Index of the motion that figures show.

        By default it has the peak that decides the verdict: the largest force, or moment over
        the characteristic length. If both are round-off, the force counts.
        """
        if self.shown is not None:
            return self.shown
        ahead = self.moment_residual - self.force_residual
        if self.balance == "force" or ahead <= TIE_RELATIVE * max(1.0, self.force_residual):
            return self.worst("force")
        return self.worst("moment")

    @property
    def duration(self) -> float:
        """Time that the longest motion takes, seconds."""
        return max(run.trajectory.duration for run in self.runs)

    @property
    def motions(self) -> list[Trajectory]:
        """The motions of all runs."""
        return [run.trajectory for run in self.runs]

    @property
    def amplitude(self) -> dict[str, float]:
        """Largest displacement of each input from the reference pose, radians or metres."""
        return input_reach(self.linkage, self.motions)

    def _peak(self, name: str, part: slice) -> float:
        """Compute the largest norm of a part of a wrench in all runs."""
        sizes = (np.linalg.norm(getattr(run, name)[:, part], axis=1) for run in self.runs)
        return max((float(size.max(initial=0.0)) for size in sizes), default=0.0)

    def _median(self, part: str) -> float:
        """Compute the median over all samples of the force, or moment about the middle."""
        loads = np.concatenate([run.middle[:, PARTS[part]] for run in self.runs])
        return float(np.median(np.linalg.norm(loads, axis=1)))

    def _largest(self, name: str) -> float:
        """Compute the largest entry of an attribute in all runs."""
        peaks = (float(getattr(run, name).max(initial=0.0)) for run in self.runs)
        return max(peaks, default=0.0)

    def _relative(self, force: float) -> float:
        """Divide a force by the peak inertia force; 0 if nothing moves."""
        return force / self.scale if self.scale > 0.0 else 0.0

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the joint forces, on singularities, and on the agreement."""
        remarks = []
        if self.scale == 0.0:
            remarks.append("nothing with mass moves")
        if self.runs and self.runs[0].open:
            remarks.append(
                f"the linkage is overconstrained: {self.runs[0].open} components of its loop "
                "wrenches are not determined by rigid bodies; bearing forces are those of "
                "least norm over all joints"
            )
        if near := singularity_remark(self.motions):
            way_out = "" if self.decided else "; verify motions that stay clear of it"
            remarks.append(near + way_out)
        if self.crank is not None and not self.crank.periodic:
            remarks.append(
                f"one revolution of {self.crank.joint} does not bring all joints back: the "
                "next one may shake otherwise"
            )
        if self.rounding_decides:
            remarks.append(
                "the digits of the table leave open whether it is balanced: write more of them"
            )
        if not self.agreed:
            remarks.append(
                f"Pinocchio and our series differ by {size_text(self.agreement)}: no verdict"
            )
        return tuple(remarks)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/verify.schema.json``."""
        return {
            "schema": VERIFY_SCHEMA,
            "model": self.model,
            "file": self.linkage.source,
            "at": self.linkage.at,
            "balance": self.balance,
            "balanced": self.balanced if self.decided else None,
            "tolerance": self.tolerance,
            "trajectories": len(self.runs),
            "samples": sum(run.trajectory.time.size for run in self.runs),
            "seed": self.seed,
            "inputs": list(self.linkage.inputs),
            "duration": self.duration,
            "amplitude": self.amplitude,
            "speed": self._speed(),
            "length": self.length,
            "about": self.point.tolist(),
            "shaking": {"force": self.force, "moment": self.moment},
            "rms": {part: self.rms(part) for part in PARTS},
            "range": self._range(),
            "worst": {part: self.worst(part) + 1 for part in PARTS},
            "plotted": {
                "motion": self.plotted + 1,
                **{part: self.runs[self.plotted].peak(part) for part in PARTS},
            },
            "residual": {"force": self.force_residual, "moment": self.moment_residual},
            "inertia": self.scale,
            "bearing": {
                "force": self.bearing,
                "joint": self.most_loaded(),
                "undetermined": self.runs[0].open if self.runs else 0,
                "least": self.least_bearing,
                "preload": self.preload,
            },
            "ratio": {"force": self.force_ratio, "moment": self.moment_ratio},
            "agreement": self.agreement,
            "closure": self.closure,
            "remarks": list(self.remarks),
            "warnings": [notice.to_dict() for notice in self.notices],
        }

    @property
    def least_bearing(self) -> float:
        """Least peak force that preload leaves of that of the most loaded joint, newtons."""
        if (name := self.most_loaded()) is None:
            return 0.0
        at = self.linkage.positions_of([name])[0]
        return max(float(run.least_bearing[:, at].max(initial=0.0)) for run in self.runs)

    @property
    def preload(self) -> bool:
        """Whether preload changes the force of the most loaded joint, without limit."""
        if (name := self.most_loaded()) is None:
            return False
        return bool(self.runs[0].preloaded[self.linkage.positions_of([name])[0]])

    def most_loaded(self) -> str | None:
        """Return the name of the joint with the largest force; None if there is no force."""
        if self.bearing == 0.0:
            return None
        peaks = np.max([run.bearing.max(axis=0) for run in self.runs], axis=0)
        return self.linkage.joints[first_largest(peaks)].name

    def _range(self) -> dict[str, object] | None:
        """Return the entry ``range`` of the data."""
        if self.decimals is None:
            return None
        return {"decimals": self.decimals, **{part: self.peak_range(part) for part in PARTS}}

    def _speed(self) -> dict[str, object] | None:
        """Return the entry ``speed`` of the data."""
        if self.crank is None:
            return None
        (run,) = self.runs
        loads = {part: {"peak": run.peak(part), "rms": run.rms(part)} for part in PARTS}
        crank = {"input": self.crank.joint, "rate": self.crank.speed, "rpm": self.crank.rpm}
        steady = {"periodic": self.crank.periodic, "harmonics": self.harmonics(HARMONICS)}
        return {**crank, **loads, **steady}

    def harmonics(self, count: int) -> dict[str, list[float]] | None:
        """Compute the largest force and moment of the first harmonics of a revolution.

        What round-off decides is 0.

        Args:
            count: number of harmonics, from that of the speed on.

        Returns:
            Sizes of ``"force"``, N, and of ``"moment"`` about the point, N m, in order; None
            without a crank, or if not all joints return to their start.
        """
        if self.crank is None or not self.crank.periodic:
            return None
        (run,) = self.runs
        sizes: dict[str, list[float]] = {}
        for part, columns in PARTS.items():
            peaks = harmonic_peaks(run.about[:, columns], count)
            least = self.round_off * self.part_scale(part)
            sizes[part] = np.where(peaks > least, peaks, 0.0).tolist()
        return sizes
