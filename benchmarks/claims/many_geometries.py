"""Claim: a four-bar design space takes at most 4 times as long as the bare kernels in C.

Two cores compute 1.7 times as many as one, of the number of geometries that a sweep has. The
kernels in C are closure and momentum to order 3, which the general four-bar needs, without
transfers, ranks or checks. Ranks are compared with exact arithmetic, and bases with momentum at
finite poses. Six-bars, which need up to three times as high orders, take at most 100 µs each on
one core.
"""

from __future__ import annotations

import os
from time import process_time

import numpy as np

from balance.momentum import momentum_regressor
from balance.space import design_space_many
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.inputs.geometry import resized, variants
from benchmarks.references import compiled
from kinematics.loading.model_gallery import load

COUNT = 200_000
SIX_BARS = 20_000


class ManyGeometries:
    """Geometries of one topology: all different, or all of one special kind."""

    params = (("four_bar_general", "any"), ("four_bar_kite", "kites"))
    repetitions = 7
    claims = (
        ("time_one_core", "time_kernels_in_c", 4.0),
        ("time_two_cores", "time_one_core", 1.0 / 1.7),
        ("track_wrong_ranks", 0.0),
        ("track_momentum", 1e-13),
    )

    def setup(self, model: str, kind: str) -> None:
        """Prepare joint screws in SI units, and in units of the chains for C."""
        if (os.cpu_count() or 1) < 2:
            raise NotImplementedError("there is one core only")
        self.linkage = load(model)
        copies = (
            variants(model, 200, seed=6, size=0.05) if kind == "any" else resized(model, 200)
        )
        self.copies = copies[:40]
        chains = [copy.chain for copy in copies]
        self.chain = chains[0]
        given = np.array([[joint.screw for joint in copy.joints] for copy in copies])
        self.geometries = np.tile(given, (COUNT // 200, 1, 1))
        self.screws = np.tile([chain.screws for chain in chains], (COUNT // 200, 1, 1))
        self.X = np.zeros((4, 1, 1, 3, 12))
        self.time_kernels_in_c(model, kind)

    def time_one_core(self, model: str, kind: str) -> None:
        """The public call on one thread."""
        design_space_many(self.linkage, self.geometries, workers=1)

    def time_two_cores(self, model: str, kind: str) -> None:
        """The public call on two."""
        design_space_many(self.linkage, self.geometries, workers=2)

    def time_kernels_in_c(self, model: str, kind: str) -> None:
        """Closure and momentum alone, of the same number of geometries."""
        compiled.both_kernels(self.chain, self.screws, 3, self.X)

    def track_wrong_ranks(self, model: str, kind: str) -> float:
        """Count ranks that differ from that of the model in exact arithmetic."""
        found = design_space_many(self.linkage, self.geometries[: len(self.copies)])
        return float(np.sum(found.rank != exact_ranks(self.linkage).rank))

    def track_momentum(self, model: str, kind: str) -> float:
        """Largest momentum of a basis at a finite pose, relative to that of single bodies."""
        number, copy = len(self.copies) // 2, self.copies[len(self.copies) // 2]
        found = design_space_many(self.linkage, self.geometries[: number + 1], bases=True)
        rows = momentum_regressor(copy, {copy.inputs[0]: 0.2})[0]
        basis = found.basis(number)
        size = np.abs(rows) @ np.abs(basis)
        return float((np.abs(rows @ basis) / size).max())


class SixBars:
    """Six-bars with their joints at random places; the linkages of one input and two loops."""

    params = (("six_bar_watt",), ("six_bar_stephenson",))
    claims = (("track_seconds", 1e-4),)

    def setup(self, model: str) -> None:
        """Prepare joint screws in SI units."""
        self.linkage = load(model)
        copies = variants(model, 200, seed=6, size=0.05)
        given = np.array([[joint.screw for joint in copy.joints] for copy in copies])
        self.geometries = np.tile(given, (SIX_BARS // 200, 1, 1))
        design_space_many(self.linkage, self.geometries[:200], workers=1)

    def track_seconds(self, model: str) -> float:
        """Processor time of one geometry, in seconds."""
        start = process_time()
        design_space_many(self.linkage, self.geometries, workers=1)
        return (process_time() - start) / SIX_BARS
