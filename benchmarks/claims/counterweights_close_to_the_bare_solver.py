"""Claim: checked counterweights of 13 bodies or more take 1.5 times as long as the bare solver.

The bare solver gets the cone program over pseudo-inertias with assembled matrices; its result
is neither split into lumps nor checked. For force balance `counterweights` solves a smaller
program, over masses and first moments alone, which has the same optimum: this is part of what
is compared. Matter may be added to every link, in its default region. The error is the
residual of the conditions with counterweights, or the orthogonality of the certificate.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import clarabel
from scipy.sparse import csc_matrix

from balance import counterweights, design_space
from balance.masses.counterweights.added_matter import moment_cone
from balance.masses.counterweights.added_program import build_added_program, conic_arguments
from balance.masses.counterweights.link_regions import regions_of
from balance.space.spaces.design_space import DesignSpace
from benchmarks.claims.verdict_close_to_the_bare_solver import _arm

KINDS = {
    "psd_triangle": clarabel.PSDTriangleConeT,
    "nonnegative": clarabel.NonnegativeConeT,
    "zero": clarabel.ZeroConeT,
}


def _space(model: str, balance: str) -> DesignSpace:
    """Compute the design space of a model, or of a serial arm."""
    spatial = balance == "dynamic"
    if not model.isdigit():
        return design_space(model, balance=balance, spatial=spatial)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(_arm(int(model)), encoding="utf-8")
        return design_space(str(path), balance=balance, spatial=spatial)


class CounterweightsCloseToTheBareSolver:
    """Linkages of 13 and 30 bodies."""

    params = (
        ("stewart_6ups", "force"),
        ("stewart_6ups", "dynamic"),
        ("30", "force"),
        ("30", "dynamic"),
    )
    claims = (("time_counterweights", "time_bare", 1.5), ("track_error", 1e-10))

    def setup(self, model: str, balance: str) -> None:
        """Prepare the design space, and its program for the solver."""
        self.space = _space(model, balance)
        regions = regions_of(self.space, self.space.bodies, {})
        program = build_added_program(self.space, regions, "mass")
        cones = [moment_cone(region) for region in regions.values()]
        q, rows, offset, parts = conic_arguments(program, cones)
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        kinds = [KINDS[part.kind](part.size) for part in parts]
        self.bare = (
            csc_matrix((q.size, q.size)),
            q,
            csc_matrix(-rows),
            offset,
            kinds,
            settings,
        )

    def time_counterweights(self, model: str, balance: str) -> None:
        """The public call, without the search for changes that help."""
        counterweights(self.space, self.space.bodies, relax=False)

    def time_bare(self, model: str, balance: str) -> None:
        """The solver alone."""
        clarabel.DefaultSolver(*self.bare).solve()

    def track_error(self, model: str, balance: str) -> float:
        """Residual of the counterweights, or of the certificate."""
        found = counterweights(self.space, self.space.bodies, relax=False)
        if found.residual is not None:
            return found.residual
        return found.check.orthogonality if found.check else float("inf")


class SmallCounterweightsTakeMilliseconds(CounterweightsCloseToTheBareSolver):
    """Linkages of 3 and 7 bodies whose program takes the solver 1 to 10 ms.

    Regions, conditions, lumps and checks take 1 to 4 ms: the claim of the larger ones does not
    hold for all of these.
    """

    params = (
        ("bennett", "force"),
        ("bennett", "dynamic"),
        ("three_rsr", "force"),
        ("three_rsr", "dynamic"),
        ("eight_bar", "force"),
    )
    claims = (("time_counterweights", "time_bare", 4.0), ("track_error", 1e-10))
