"""A linkage with two sets of masses along the same motions: the loads before and after."""

from __future__ import annotations

from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from balance.motion.verification.comparison import peak_change
from balance.motion.verification.crank_revolution import crank_of
from balance.motion.verification.given_motions import Motions
from balance.motion.verification.verification import Verification
from balance.motion.verification.verify_motions import verify
from balance.support.options import Balance
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion


@dataclass(frozen=True, eq=False)
class BeforeAfter:
    """Loads along the same motions with the masses before and after a change.

    Attributes:
        before: the verification with the masses of the file.
        after: that with the new masses.
    """

    before: Verification
    after: Verification

    @property
    def pair(self) -> tuple[Verification, Verification]:
        """Both, the one before first."""
        return self.before, self.after

    @property
    def words(self) -> str:
        """The change in a sentence without its end: ``Shaking force …, moment …``."""
        force, moment = (peak_change(self.pair, part) for part in ("force", "moment"))
        return f"Shaking force {force}, moment {moment}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON: the motions, and the peaks before and after."""
        before, after = (
            {
                "force": check.force,
                "moment": check.moment,
                "bearing": check.bearing,
                "torque": check.drive_peaks,
            }
            for check in self.pair
        )
        crank = self.before.crank
        speed = {"input": crank.joint, "rate": crank.speed, "rpm": crank.rpm} if crank else None
        motions = {"motions": len(self.before.runs), "seed": self.before.seed, "speed": speed}
        return {**motions, "before": before, "after": after}


def compare_masses(
    linkage: Linkage,
    z: ArrayLike,
    *,
    motions: Motions | None = None,
    motion: Motion | None = None,
    balance: Balance = "dynamic",
    about: ArrayLike | None = None,
) -> BeforeAfter:
    """Compute the loads of a linkage with the masses of its file and with others.

    Args:
        linkage: the linkage.
        z: the other masses, parameters as in `balance.verify`.
        motions: motions; by default the random ones of `balance.verify`.
        motion: restriction of random motions.
        balance: ``"dynamic"``, or ``"force"`` for a verdict on the force alone.
        about: point for moments, as in `balance.verify`.

    Returns:
        Both verifications; they show the same motion.

    Raises:
        LinkageError: see `balance.verify`.
    """
    before = verify(linkage, motion=motion, balance=balance, motions=motions, about=about)
    followed = before.motions
    after = verify(linkage, z, balance=balance, motions=followed, about=about)
    crank = crank_of(linkage, followed[0]) if len(followed) == 1 else None
    return BeforeAfter(
        replace(before, crank=crank),
        replace(after, crank=crank, shown=before.plotted, seed=before.seed),
    )
