"""Claim: the expansions of Table 4.1 of de Jong's thesis take at most a tenth of its time.

The table has the mean seconds of the Taylor expansion of a serial robot along a line, a
five-bar and a Bennett linkage, orders 1 to 7 (J. J. de Jong, PhD thesis, University of Twente,
2019; on a PC of 2014, in Matlab). Ours are measured on this machine, for the public call, from
an assembled linkage to all coefficients, and for its kernel, from joint screws. The lengths of
the first two linkages are not printed; ours are those of the other Taylor jobs. The claim is on
the public call, as geometric mean over the orders 2 to 7. The error is that of the polynomials
along a direction, against finite poses in mpmath, relative to the largest coefficient of each
degree.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.harness.show import seconds
from benchmarks.peers.measured import times
from benchmarks.peers.ours import LINE, linkage
from benchmarks.references.reference import off, positions
from kinematics import load, taylor_motion
from kinematics.closure.taylor.expansion_kernels import polynomials
from kinematics.closure.taylor.layout import packed_layout
from kinematics.closure.taylor.monomials import monomial_powers
from kinematics.closure.taylor.taylor_motion import TaylorMotion
from kinematics.model.linkage import Linkage

# Seconds, by order; the Bennett linkage with the closure of rotations only, and with all.
PRINTED = {
    "serial": (0.56e-3, 6.9e-3, 11e-3, 28e-3, 85e-3, 0.35, 2.6),
    "five_bar": (49e-6, 1.5e-3, 3.1e-3, 11e-3, 47e-3, 0.47, 5.4),
    "bennett_rotations": (2.1e-3, 3.6e-3, 4.7e-3, 11e-3, 27e-3, 38e-3, 81e-3),
    "bennett": (2.1e-3, 3.4e-3, 3.4e-3, 11e-3, 19e-3, 48e-3, 85e-3),
}

Job = tuple[Linkage, tuple[str, ...] | None, tuple[int, ...] | None]


def _job(name: str) -> Job:
    """A linkage, its motion, and the equations to solve."""
    if name == "serial":
        return linkage("six_r"), LINE, None
    if name == "five_bar":
        return linkage("five_bar"), None, None
    return load("bennett"), None, (0, 1, 2) if name == "bennett_rotations" else None


class ThesisTable:
    """Ratio of our time to the printed one, over the orders."""

    params = tuple((name,) for name in PRINTED)
    claims = (("track_share", 0.1),)

    def setup(self, name: str) -> None:
        self.job = _job(name)

    def time_order_seven(self, name: str) -> None:
        """The public call."""
        _expand(self.job, 7)

    def track_share(self, name: str) -> float:
        """Ours over the printed time."""
        ours = [np.median(times(partial(_expand, self.job, k))) for k in range(2, 8)]
        return float(np.exp(np.log(np.array(ours) / PRINTED[name][1:]).mean()))

    def track_error(self, name: str) -> float:
        """Error of order 7."""
        return _error(_expand(self.job, 7))


class ThesisTableByOrder:
    """Ours beside the printed times."""

    params = tuple((name, order) for name in PRINTED for order in range(1, 8))
    repetitions = 3

    def setup(self, name: str, order: int) -> None:
        self.job = _job(name)
        self.found = _expand(self.job, order)
        chain, equations = self.found.chain, self.job[2]
        chosen = None if equations is None else tuple(map(int, equations))
        self.layout = packed_layout(chain, order, chosen)

    def time_kernel(self, name: str, order: int) -> None:
        """From joint screws."""
        polynomials(self.found.chain.screws, self.layout)

    def row(self, name: str, order: int) -> dict[str, str]:
        """Seconds as printed; of the public call, and of its kernel; the error."""
        return {
            "printed": f"{PRINTED[name][order - 1]:.1e} s",
            "public call": seconds(times(partial(_expand, self.job, order))).strip(),
            "kernel": seconds(times(partial(self.time_kernel, name, order))).strip(),
            "error": f"{_error(self.found):.0e}",
        }


def _expand(job: Job, order: int) -> TaylorMotion:
    made, motion, equations = job
    return taylor_motion(made, order, motion, equations=equations)


def _error(found: TaylorMotion) -> float:
    """Error of all joints along a direction."""
    chain, ray = found.chain, np.linspace(1.0, 0.6, found.scales.size)
    terms = monomial_powers(found.exponents, ray * found.scales)[:, None] * found.coefficients
    degree = found.exponents.sum(axis=1)
    series = [terms[degree == k].sum(axis=0)[chain.joints] for k in range(1, found.order + 1)]
    return off(np.array(series) / chain.units, positions(chain, ray, found.order))
