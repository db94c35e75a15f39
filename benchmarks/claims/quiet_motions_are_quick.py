"""Claim: the quiet motion of two joints is planned in two seconds, that of a UR5e in twenty.

The peak of force and moment together is minimised, between the poses of the tests. The error is
what the plan shakes over the quieter of the quintic and the trapezoidal law.
"""

from __future__ import annotations

from balance import quiet_motion
from tests.support.planned_arms import TASKS


class _QuietMotion:
    """A plan in 0.8 s, without the limits of the file."""

    repetitions = 3

    def setup(self, model: str) -> None:
        """Load the linkage; a first plan compiles the kernels."""
        build, self.start, self.end = TASKS[model]
        self.linkage = build()
        self.time_plan(model)

    def time_plan(self, model: str) -> None:
        """Peak of force and moment."""
        given = {"minimise": "both", "measure": "peak", "file_limits": False}
        self.plan = quiet_motion(self.linkage, self.start, self.end, 0.8, **given)

    def track_error(self, model: str) -> float:
        """Over the quieter law."""
        return self.plan.after.value / min(law.figures.value for law in self.plan.laws)


class QuietMotionOfTwoJoints(_QuietMotion):
    """Two links in a plane."""

    params = (("planar_2r",),)
    claims = (("time_plan", 2.0), ("track_error", 1.0))


class QuietMotionOfSixJoints(_QuietMotion):
    """The UR5e of the studies."""

    params = (("ur5e",),)
    claims = (("time_plan", 20.0), ("track_error", 1.0))
