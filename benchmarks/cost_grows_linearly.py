"""Claim: closure and momentum cost in proportion to the bodies, and to the order squared.

A serial chain in space that one input moves, and coupled four-bars in a plane whose loop
matrix is factorised within its profile. Exponents are fitted to the shortest of several
times. The error is that of the rates against a full factorisation by LAPACK, and for the
serial chain against sums of its screws.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np

from balance.momentum import RegressorSeries, room
from benchmarks.rows import coupled_four_bars, serial
from kinematics.closure import expand, loop_matrix
from kinematics.linkage import Chain

BODIES = (10, 50, 100, 200, 400, 800, 1000)
ORDERS = (1, 2, 3, 4, 6, 8, 10, 12)
INPUTS = (1, 2, 4, 8, 12)
ROWS = {"serial": serial, "four-bars": lambda bodies: coupled_four_bars(bodies // 2)}


def kernels(chain: Chain, order: int) -> int:
    """Closure and momentum along one ray; bytes of what they fill."""
    ray = np.ones((1, chain.width)) / np.sqrt(chain.width)
    series = expand(chain, ray, order)
    X = RegressorSeries(chain, series).rows(order)
    screws, work = series.V, room(series.V, chain.links, chain.moves)
    return sum(array.nbytes for array in (*series, screws, work, X))


def _shortest(chains: list[Chain], orders: list[int], repetitions: int = 9) -> np.ndarray:
    """Seconds of each case, the cases in turn; (cases,)."""
    times = np.full((repetitions, len(chains)), np.inf)
    for turn in times:
        for case, (chain, order) in enumerate(zip(chains, orders, strict=True)):
            start = perf_counter()
            kernels(chain, order)
            turn[case] = perf_counter() - start
    return times[1:].min(axis=0)


def _exponent(sizes: list[int], times: np.ndarray, least: int) -> float:
    """Slope of the logarithms, of sizes from ``least`` on."""
    kept = np.array(sizes) >= least
    return float(np.polyfit(np.log(np.array(sizes)[kept]), np.log(times[kept]), 1)[0])


class CostGrowsLinearly:
    """Bodies at order 3; orders and inputs with 100 bodies."""

    params = (("serial", 1.15), ("four-bars", 1.3))
    claims = (
        ("track_excess_in_bodies", 0.0),
        ("track_exponent_in_order", 2.1),
        ("track_error", 1e-11),
    )

    def setup(self, kind: str, limit: float) -> None:
        """Shortest times."""
        rows = ROWS[kind]
        chains = [rows(bodies) for bodies in BODIES]
        self.bodies = _shortest(chains, [3] * len(BODIES))
        self.orders = _shortest([rows(100)] * len(ORDERS), list(ORDERS))
        self.inputs = np.empty(0)
        if kind == "serial":
            self.inputs = _shortest([serial(100, width) for width in INPUTS], [3] * len(INPUTS))
        self.memory = kernels(chains[-1], 3) / 2.0**20
        self.exponent = _exponent(list(BODIES[:-1]), self.bodies[:-1], 50)

    def time_hundred_bodies(self, kind: str, limit: float) -> None:
        """Order 3, 100 bodies."""
        kernels(ROWS[kind](100), 3)

    def track_excess_in_bodies(self, kind: str, limit: float) -> float:
        """By how much the exponent from 50 to 800 bodies exceeds its limit."""
        return self.exponent - limit

    def track_exponent_in_order(self, kind: str, limit: float) -> float:
        """From order 2 to 12."""
        return _exponent(list(ORDERS), self.orders, 2)

    def track_error(self, kind: str, limit: float) -> float:
        """Of the link twists of order 0, relative, with 200 bodies."""
        chain = ROWS[kind](200)
        found = expand(chain, np.ones((1, chain.width)), 0)
        C = chain.columns.copy()
        if chain.dependent.size:
            A = loop_matrix(chain)
            C[chain.dependent] = np.linalg.solve(A[:, chain.dependent], -A @ C)
            return float(np.abs(found.C[0, 0] - C).max() / np.abs(C).max())
        T = np.cumsum(chain.screws * C, axis=0)
        return float(np.abs(found.T[0, 0, :, 0] - T).max() / np.abs(T).max())

    def row(self, kind: str, limit: float) -> dict[str, str]:
        """Microseconds by bodies, then by order and by inputs; the exponents; memory."""
        by_bodies = zip(BODIES, self.bodies, strict=True)
        by_order = zip(ORDERS, self.orders, strict=True)
        by_inputs = zip(INPUTS, self.inputs, strict=bool(self.inputs.size))
        inputs = {f"w={w}": f"{1e6 * t:.0f}" for w, t in by_inputs}
        return {
            **{f"n={n}": f"{1e6 * t:.0f}" for n, t in by_bodies},
            **{f"k={k}": f"{1e6 * t:.0f}" for k, t in by_order},
            **{f"w={w}": "-" for w in INPUTS}, **inputs,
            "exponent": f"{self.exponent:.2f}", "MiB": f"{self.memory:.1f}",
        }  # fmt: skip
