"""Claim: a front of twelve designs of a robot on a cycle takes at most ten seconds.

The robot has six revolute joints, three links get masses, and the pick-and-place cycle has 121
samples. The error is the number of designs that are not proved to be optimal.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from balance import design_space, pareto
from balance.motion.verification.given_motions import from_csv
from tests.support.pick_and_place import robot_arm, write_cycle


class TwelveDesigns:
    """Least shaking with 0 to 8 kg of added masses."""

    params = ((12,),)
    claims = (("time_front", 10.0), ("track_not_optimal", 0.0))
    repetitions = 3

    def setup(self, count: int) -> None:
        """Read the robot and its cycle."""
        with TemporaryDirectory() as name:
            self.space = design_space(robot_arm(Path(name)), max_order=0)
            linkage = self.space.linkage
            cycle = write_cycle(Path(name) / "cycle.csv", linkage.inputs)
            self.motion = from_csv(linkage, cycle)

    def time_front(self, count: int) -> None:
        """All designs."""
        bodies = self.space.bodies[:3]
        self.front = pareto(self.space, bodies, count, 8.0, motions=[self.motion])

    def track_not_optimal(self, count: int) -> int:
        """Designs of another verdict."""
        self.time_front(count)
        return sum(point.verdict != "optimal" for point in self.front.designs)
