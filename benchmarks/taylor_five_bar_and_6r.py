"""Claim: Taylor motions cost little more than those of compilers made for one mechanism.

Inverse kinematics of a five-bar, two inputs, and of a 6R arm along a line, one input: all
coefficients. The time is at most 3 times heyoka's at orders 5 and 7 of the five-bar, 2.5 times
at order 10 of both, a thirtieth of daceypy's, and 1/5000 of that of Kronecker products; in a
new process, 1.2 times heyoka's, which has its equations by hand, ours from the assembled
linkage on. Ours, from joint screws to coefficients, has another geometry
at every call, as has none of the others. Errors are relative, the largest of a coefficient,
against mpmath with 110 digits.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.peers import jobs, library
from benchmarks.peers.measured import Against, Rows, start

ROOT = Path(__file__).parents[1]
# Seconds from after the imports to the first coefficients.
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
    claims = (("time_ours", "time_theirs", 1 / 5000),)
    repetitions = 5


class Error:
    """Largest relative error of a coefficient."""

    params = (("five_bar", 10),)
    claims = (("track_error", 2e-14),)

    def setup(self, job: str, order: int) -> None:
        library("mpmath")
        self.run, self.read = start("ours", job, order)

    def track_error(self, job: str, order: int) -> float:
        return jobs.error(job, self.read(self.run()), order)


class HeyokaAtLowOrders(Against):
    """Jets along a batch of directions, and one product."""

    peer = "heyoka_jets"
    params = (("five_bar", 5), ("five_bar", 7))
    claims = (("time_ours", "time_theirs", 3.0),)


class HeyokaAtOrderTen(Against):
    """The same; the geometry of the 6R arm at run time."""

    peer = "heyoka_jets"
    params = (("five_bar", 10), ("six_r", 10))
    claims = (("time_ours", "time_theirs", 2.5),)


class Daceypy(Against):
    """Truncated polynomials."""

    peer = "dace"
    params = (("five_bar", 10),)
    claims = (("time_ours", "time_theirs", 1 / 30),)


class FirstCall:
    """A new process each: from the equations, or the linkage, to the first coefficients."""

    params = (("five_bar", 7),)
    claims = (("track_ours", "track_heyoka", 1.2),)
    count = 5

    def setup(self, job: str, order: int) -> None:
        library("heyoka")
        self._seconds(OURS, order)

    def _seconds(self, task: tuple[str, str], order: int) -> float:
        code = FIRST.format(before=task[0], call=task[1].format(order=order))
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        return float(done.stdout)

    def _median(self, task: tuple[str, str], order: int) -> float:
        return sorted(self._seconds(task, order) for _ in range(self.count))[self.count // 2]

    def track_ours(self, job: str, order: int) -> float:
        """From the assembled linkage; kernels from the disk cache."""
        return self._median(OURS, order)

    def track_ours_with_assembly(self, job: str, order: int) -> float:
        """From the joints: the linkage is analysed and given its tool first."""
        return self._median(ASSEMBLED, order)

    def track_heyoka(self, job: str, order: int) -> float:
        """The equations, their compilation without a disk cache, and one step."""
        return self._median(HEYOKA, order)


class FiveBarByOrder(Rows):
    """Every library, as far as it is there and as its expressions can be compiled."""

    peers = ("ours", "heyoka_jets", "casadi_derivatives", "jax_jets", "dace", "kronecker")
    params = tuple(("five_bar", order) for order in range(1, 11))


class SixRByOrder(Rows):
    """The same for the arm."""

    peers = ("ours", "heyoka_jets", "dace")
    params = tuple(("six_r", order) for order in range(1, 11))
