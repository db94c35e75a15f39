"""Claim: the expansions of Table 4.1 of de Jong's thesis take at most a tenth of its time.

Mean seconds of the Taylor expansion of a serial robot along a line, a five-bar and a Bennett
linkage, orders 1 to 7, as printed (J. J. de Jong, PhD thesis, University of Twente, 2019; on a
PC of 2014, in Matlab), and ours on this machine: of the public call, from an assembled linkage
to all coefficients, and of its kernel alone, from joint screws. The lengths of the first two
are not printed; ours are those of the other Taylor jobs. The claim is about the public call,
the geometric mean of orders 2 to 7.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.peers.measured import median
from benchmarks.peers.ours import LINE, linkage
from kinematics import load, taylor_motion
from kinematics.expansion import polynomials
from kinematics.layout import layout
from kinematics.linkage import Linkage, frozen
from kinematics.polynomials import monomials

# Seconds, by order; the Bennett linkage with the closure of rotations only, and with all.
PRINTED = {
    "serial": (0.56e-3, 6.9e-3, 11e-3, 28e-3, 85e-3, 0.35, 2.6),
    "five_bar": (49e-6, 1.5e-3, 3.1e-3, 11e-3, 47e-3, 0.47, 5.4),
    "bennett_rotations": (2.1e-3, 3.6e-3, 4.7e-3, 11e-3, 27e-3, 38e-3, 81e-3),
    "bennett": (2.1e-3, 3.4e-3, 3.4e-3, 11e-3, 19e-3, 48e-3, 85e-3),
}


def _job(name: str) -> tuple[Linkage, tuple[str, ...] | None, tuple[int, ...] | None]:
    """A linkage, its motion, and the equations that are solved."""
    if name == "serial":
        return linkage("six_r"), LINE, None
    if name == "five_bar":
        return linkage("five_bar"), None, None
    return load("bennett"), None, (0, 1, 2) if name == "bennett_rotations" else None


class ThesisTable:
    """Ours and the printed times, by order."""

    params = tuple((name,) for name in PRINTED)
    claims = (("track_share", 0.1),)

    def setup(self, name: str) -> None:
        made, motion, equations = _job(name)
        self.seconds, self.kernel = [], []
        for k in range(1, 8):
            found = taylor_motion(made, k, motion, equations=equations)
            chosen = None if equations is None else frozen(equations, np.int64)
            whole = layout(found.chain, monomials(found.chain.width, k), chosen)
            self.kernel.append(median(partial(polynomials, found.chain.screws, whole)))
            call = partial(taylor_motion, made, k, motion, equations=equations)
            self.seconds.append(median(call))

    def track_share(self, name: str) -> float:
        """Ours over the printed time."""
        ratios = np.array(self.seconds[1:]) / PRINTED[name][1:]
        return float(np.exp(np.log(ratios).mean()))

    def row(self, name: str) -> dict[str, str]:
        """Seconds: printed, of the public call, of its kernel."""
        return {
            f"order {k}": f"{printed:.1e} / {call:.1e} / {kernel:.1e}"
            for k, (printed, call, kernel) in enumerate(
                zip(PRINTED[name], self.seconds, self.kernel, strict=True), 1
            )
        }
