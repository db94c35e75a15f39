"""Claim: a geometry of a sweep costs at most a fifth of the commands on its file.

The commands read the file with the numbers of the geometry, and verify a turn of its crank.
Every call has geometries of its own. The error is the largest difference of a peak of force or
moment from that of the commands, by Pinocchio, in parts of it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import balance
import kinematics
from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.study_data import StudyData
from benchmarks.inputs.sweeps import CASES, SPEED, TURN
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from tests.support.sweep_topologies import gallery_text, write_numbers

# Geometries of a call, and of all calls.
ROWS, GRID = 8, 8000


class SweepsAreQuick:
    """Shaking along a turn of the crank."""

    params = (("four-bar, turn",), ("slider-crank, turn",), ("RUSR, turn",))
    claims = (("time_sweep", "time_commands", 0.2), ("track_error", 1e-3))
    repetitions = 5

    def setup(self, name: str) -> None:
        """Make the job of a sweep, of which each call computes another chunk."""
        case = CASES[name]
        low, high = case.span
        tables = {
            "parameters": {case.path: f"{low}:{high}:{GRID}"},
            "compute": {"quantities": ["shaking"], **TURN},
            "run": {"chunk_rows": ROWS},
        }
        study = StudyData.from_tables(tables, load(case.model), "sweep")
        self.job, self.path = SweepJob.of_study(study), case.path
        self.text, self.inputs = gallery_text(case.model), load(case.model).inputs
        self.values = np.linspace(low, high, GRID)
        order = np.random.default_rng(1).permutation(GRID // ROWS)
        self.chunks: Iterator[int] = iter(order.tolist())

    def time_sweep(self, name: str) -> None:
        """Rows of the sweep."""
        self.columns = self.job.compute(next(self.chunks))

    def time_commands(self, name: str) -> None:
        """The same number of files."""
        start = ROWS * next(self.chunks)
        for value in self.values[start : start + ROWS].tolist():
            self._verify(value)

    def track_error(self, name: str) -> float:
        """Of force and moment."""
        self.time_sweep(name)
        errors = []
        for row, value in enumerate(np.asarray(self.columns[self.path]).tolist()):
            peaks = self._verify(value)
            errors += [
                abs(self.columns[f"peak_{part}"][row] / getattr(peaks, part) - 1.0)
                for part in ("force", "moment")
            ]
        return max(errors)

    def _verify(self, value: float) -> balance.Verification:
        """Write the file with a number, read it at the inputs of the model, and verify it."""
        document = Document("written", write_numbers(self.text, {self.path: value}).encode())
        linkage = kinematics.load(document, at=dict.fromkeys(self.inputs, 0.0))
        return balance.verify(linkage, speed=SPEED, about=(0.0, 0.0, 0.0))
