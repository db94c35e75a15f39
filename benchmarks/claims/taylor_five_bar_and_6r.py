"""Claim: Taylor motions cost little more than code that is compiled for one mechanism.

The jobs are the inverse kinematics of a five-bar (two inputs) and of a 6R arm along a line (one
input), with all coefficients. The time is at most 1.2 times that of heyoka at orders 5, 7 and
10 of the five-bar and at order 10 of the arm, 1/30 of that of daceypy, and 1/5000 of that of
Kronecker products; for 1000 poses in one call it is at most that of heyoka, which goes from
pose to pose. In a new process it is at most 1.2 times that of heyoka, whose equations are
written by hand; ours starts from the assembled linkage. Only ours has another geometry at every
call, from joint screws to coefficients. Errors are the largest relative ones of a coefficient,
against mpmath with 110 digits.
"""

from __future__ import annotations

import numpy as np

from benchmarks.harness.processes import python
from benchmarks.peers import jobs, library, ours
from benchmarks.peers.measured import Against, Rows, start

# Prints the seconds from the end of the imports to the first coefficients.
FIRST = """
import time
{before}
start = time.perf_counter()
{call}
print(time.perf_counter() - start)
"""
IMPORTS = "from benchmarks.peers.ours import linkage; from kinematics import taylor_motion"
OURS = (f"{IMPORTS}; made = linkage('five_bar')", "taylor_motion(made, {order})")
ASSEMBLED = (IMPORTS, "taylor_motion(linkage('five_bar'), {order})")
HEYOKA = (
    "import heyoka; from benchmarks.peers.heyoka_jets import five_bar",
    "five_bar({order})[0]()",
)


class Kronecker(Against):
    """Full tensors in NumPy."""

    peer = "kronecker"
    params = (("five_bar", 10),)
    claims = (("time_ours", "time_kronecker", 1 / 5000),)
    repetitions = 5

    def time_kronecker(self, job: str, order: int) -> None:
        """All derivatives."""
        self.theirs[0]()


class Error:
    """Largest relative error of a coefficient."""

    params = (("five_bar", 10), ("six_r", 10))
    claims = (("track_error", 2e-14),)

    def setup(self, job: str, order: int) -> None:
        self.run, self.read = start("ours", job, order)

    def track_error(self, job: str, order: int) -> float:
        return jobs.error(job, self.read(self.run()), order)


class HeyokaAtLowOrders(Against):
    """Jets along a batch of directions, and one product."""

    peer = "heyoka_jets"
    params = (("five_bar", 5), ("five_bar", 7))
    claims = (("time_ours", "time_heyoka", 1.2),)

    def time_heyoka(self, job: str, order: int) -> None:
        """All coefficients once more."""
        self.theirs[0]()


class HeyokaAtOrderTen(HeyokaAtLowOrders):
    """The same; the geometry of the 6R arm at run time."""

    params = (("five_bar", 10), ("six_r", 10))
    claims = (("time_ours", "time_heyoka", 1.2),)


class HeyokaAtManyPoses:
    """1000 poses: one call of ours, and a step of heyoka's for each."""

    params = (("five_bar", 10), ("six_r", 10))
    claims = (("time_all_poses", "time_heyoka_at_each", 1.0),)
    poses, repetitions = 1000, 15

    def setup(self, job: str, order: int) -> None:
        """Prepare closed poses, and run both once."""
        self.step = start("heyoka_jets", job, order)[0]
        self.run = ours.many_poses(job, order, self.poses)
        self.time_all_poses(job, order)
        self.step()

    def time_all_poses(self, job: str, order: int) -> None:
        """Coefficients at all poses."""
        self.run()

    def time_heyoka_at_each(self, job: str, order: int) -> None:
        """As many steps; for the five-bar a batch of directions each."""
        for _ in range(self.poses):
            self.step()


class Daceypy(Against):
    """Truncated polynomials."""

    peer = "dace"
    params = (("five_bar", 10),)
    claims = (("time_ours", "time_daceypy", 1 / 30),)

    def time_daceypy(self, job: str, order: int) -> None:
        """All coefficients once more."""
        self.theirs[0]()


class FirstCall:
    """First coefficients in a new process, from the equations or from the linkage."""

    params = (("five_bar", 7),)
    claims = (("track_ours", "track_heyoka", 1.2),)
    runs = 5

    def setup(self, job: str, order: int) -> None:
        library("heyoka")

    def _seconds(self, task: tuple[str, str], order: int) -> np.ndarray:
        code = FIRST.format(before=task[0], call=task[1].format(order=order))
        return np.array([float(python("-c", code)) for _ in range(self.runs)])

    def track_ours(self, job: str, order: int) -> np.ndarray:
        """Seconds from the assembled linkage; kernels from the disk cache."""
        return self._seconds(OURS, order)

    def track_ours_with_assembly(self, job: str, order: int) -> np.ndarray:
        """Seconds from the joints, with the assembly of the linkage and its tool."""
        return self._seconds(ASSEMBLED, order)

    def track_heyoka(self, job: str, order: int) -> np.ndarray:
        """The equations, their compilation without a disk cache, and one step."""
        return self._seconds(HEYOKA, order)

    def track_error(self, job: str, order: int) -> float:
        """Error of ours, as in `Error`."""
        run, read = start("ours", job, order)
        return jobs.error(job, read(run()), order)


class FiveBarByOrder(Rows):
    """Every installed library, up to the order at which its expressions compile."""

    peers = ("ours", "heyoka_jets", "casadi_derivatives", "jax_jets", "dace", "kronecker")
    params = tuple(("five_bar", order) for order in range(1, 11))


class SixRByOrder(Rows):
    """The same for the arm."""

    peers = ("ours", "heyoka_jets", "dace")
    params = tuple(("six_r", order) for order in range(1, 11))
