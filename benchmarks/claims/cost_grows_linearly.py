"""Claim: closure and momentum cost in proportion to the bodies, and to the order squared.

Cases: a spatial serial chain with one input, and planar coupled four-bars, whose loop matrix is
factorised within its skyline. Exponents are fitted to the shortest of several times. The errors
are those of the rows of 20 bodies against finite poses in mpmath, and of the rates of 200
bodies against a dense factorisation by LAPACK, or for the serial chain against sums of its
screws. Peak memory is the increase of a process from 10 to 1,000 bodies at order 12 (Linux).
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import numpy as np

from balance.space.momentum.regressor import RegressorSeries
from benchmarks.harness.processes import python
from benchmarks.inputs.rows import coupled_four_bars, serial
from benchmarks.references import reference
from kinematics.closure.series import expand, loop_matrix
from kinematics.model.arrays import Chain

BODIES = (10, 50, 100, 200, 400, 800, 1000)
ORDERS = (1, 2, 3, 4, 6, 8, 10, 12)
INPUTS = (1, 2, 4, 8, 12)
ROWS = {"serial": serial, "four-bars": lambda bodies: coupled_four_bars(bodies // 2)}

# Prints the increase of the peak memory of a process, kilobytes.
PEAK = """
from sys import argv
from benchmarks.claims.cost_grows_linearly import ROWS, kernels

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))

kernels(ROWS[argv[1]](10), 12)
before = peak()
kernels(ROWS[argv[1]](1000), 12)
print(peak() - before)
"""


def kernels(chain: Chain, order: int) -> np.ndarray:
    """Compute closure and momentum along one ray: rows of all orders."""
    ray = np.ones((1, chain.width)) / np.sqrt(chain.width)
    return RegressorSeries(chain, expand(chain, ray, order)).rows(order)[:, 0]


def _shortest(chains: list[Chain], orders: list[int], repetitions: int = 9) -> np.ndarray:
    """Measure the shortest time of each interleaved case, seconds (cases,)."""
    times = np.full((repetitions, len(chains)), np.inf)
    for turn in times:
        for case, (chain, order) in enumerate(zip(chains, orders, strict=True)):
            start = perf_counter()
            kernels(chain, order)
            turn[case] = perf_counter() - start
    return times[1:].min(axis=0)


def _exponent(sizes: list[int], times: np.ndarray, least: int) -> float:
    """Fit the slope of the logarithms, for sizes from ``least`` on."""
    fitted = np.array(sizes) >= least
    return float(np.polyfit(np.log(np.array(sizes)[fitted]), np.log(times[fitted]), 1)[0])


class SerialChain:
    """Numbers of bodies at order 3; orders and numbers of inputs with 100 bodies."""

    params = (("serial",),)
    claims = (
        ("track_exponent_in_bodies", 1.15),
        ("track_exponent_in_order", 2.1),
        ("track_error", 1e-12),
        ("track_error_of_rates", 1e-11),
    )

    def setup(self, kind: str) -> None:
        """Measure the shortest times."""
        rows = ROWS[kind]
        self.bodies = _shortest([rows(bodies) for bodies in BODIES], [3] * len(BODIES))
        self.orders = _shortest([rows(100)] * len(ORDERS), list(ORDERS))
        self.inputs = np.empty(0)
        if kind == "serial":
            self.inputs = _shortest([serial(100, width) for width in INPUTS], [3] * len(INPUTS))
        self.hundred = rows(100)

    def time_hundred_bodies(self, kind: str) -> None:
        """Order 3, 100 bodies."""
        kernels(self.hundred, 3)

    def track_exponent_in_bodies(self, kind: str) -> float:
        """From 50 to 800 bodies."""
        return _exponent(list(BODIES[:-1]), self.bodies[:-1], 50)

    def track_exponent_in_order(self, kind: str) -> float:
        """From order 2 to 12."""
        return _exponent(list(ORDERS), self.orders, 2)

    def track_error(self, kind: str) -> float:
        """Error of the rows to order 3, relative to the largest entry by order, 20 bodies."""
        chain = ROWS[kind](20)
        ray = np.ones(chain.width) / np.sqrt(chain.width)
        return reference.off(kernels(chain, 3), reference.momentum(chain, ray, 3))

    def track_error_of_rates(self, kind: str) -> float:
        """Relative error of the link twists of order 0, with 200 bodies."""
        chain = ROWS[kind](200)
        found = expand(chain, np.ones((1, chain.width)), 0)
        C = chain.columns.copy()
        if chain.dependent.size:
            A = loop_matrix(chain)
            C[chain.dependent] = np.linalg.solve(A[:, chain.dependent], -A @ C)
            return float(np.abs(found.C[0, 0] - C).max() / np.abs(C).max())
        T = np.cumsum(chain.screws * C, axis=0)
        return float(np.abs(found.T[0, 0, :, 0] - T).max() / np.abs(T).max())

    def row(self, kind: str) -> dict[str, str]:
        """Microseconds by bodies, then by order and by inputs; memory."""
        cases = [(f"n={n}", t) for n, t in zip(BODIES, self.bodies, strict=True)]
        cases += [(f"k={k}", t) for k, t in zip(ORDERS, self.orders, strict=True)]
        cases += [(f"w={w}", t) for w, t in zip(INPUTS, self.inputs, strict=False)]
        has_status = Path("/proc/self/status").exists()
        peak = f"{int(python('-c', PEAK, kind)) / 1024:.1f}" if has_status else "-"
        return {**{name: f"{1e6 * t:.0f}" for name, t in cases}, "peak MiB": peak}


class CoupledFourBars(SerialChain):
    """Coupled four-bars with one input; the loop matrix is factorised within its skyline."""

    slow = True
    params = (("four-bars",),)
    claims = (("track_exponent_in_bodies", 1.3), *SerialChain.claims[1:])
