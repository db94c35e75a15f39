"""Claim: ten motions of 200 samples are verified in at most one and a half seconds.

The error is the largest difference of the shaking loads by Pinocchio and by our own series.
"""

from __future__ import annotations

from balance.motion.verification.verify_motions import verify
from kinematics.loading.model_gallery import load


class VerificationIsQuick:
    """Motions, loads by Pinocchio and by our own series, and bearing forces."""

    params = (("four_bar_kite_balanced",), ("three_rsr",), ("delta",), ("stewart_6ups",))
    claims = (("time_verify", 1.5), ("track_error", 1e-9))
    repetitions = 5

    def setup(self, model: str) -> None:
        """Prepare the linkage, load Pinocchio and compile the kernels."""
        self.linkage = load(model)
        verify(self.linkage, trajectories=1, samples=10)

    def time_verify(self, model: str) -> None:
        """Ten random motions."""
        verify(self.linkage)

    def track_error(self, model: str) -> float:
        """Relative to the largest load."""
        return verify(self.linkage, trajectories=1).agreement
