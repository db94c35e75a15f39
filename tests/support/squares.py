"""A job in chunks for tests of the file and of its runners: squares of numbers."""

from __future__ import annotations

import hashlib
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from balance.studies.runs.chunk_job import Column, chunk_size
from kinematics.errors import LinkageError
from tests.support.waiting import HANGS

COLUMNS = (
    Column("number", "integer"),
    Column("Number", "real", "m"),
    Column("words", "text"),
    Column('odd "name"', "real"),
)


@dataclass(frozen=True)
class Squares:
    """Squares of the numbers of the rows, with gaps, in two columns of almost one name."""

    rows: int = 1000
    chunk_rows: int = 64
    seed: str = ""
    pause: float = 0.0
    # A chunk that ends its worker: always if there is no file, else until the file exists.
    deadly: int = -1
    grave: str = ""
    # A chunk that is refused, and one that fails.
    refused: int = -1
    broken: int = -1
    # A file to which each chunk appends a character before it waits for ever.
    stuck: str = ""
    # Processes that are killed as they read the job: one for each character of this file.
    killed: str = ""
    columns: tuple[Column, ...] = COLUMNS
    kind: str = "squares"

    @property
    def digest(self) -> str:
        """Of what decides the results."""
        return hashlib.sha256(f"{self.rows} {self.chunk_rows} {self.seed}".encode()).hexdigest()

    @property
    def description(self) -> str:
        return f'{{"seed": "{self.seed}"}}'

    def __setstate__(self, state):
        """Read the job in a worker, unless that is to be killed now."""
        self.__dict__.update(state)
        path = Path(self.killed or os.devnull)
        left = path.read_text()
        if left:
            path.write_text(left[1:])
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))

    def compute(self, chunk: int):
        time.sleep(self.pause)
        if self.stuck:
            with open(self.stuck, "a") as file:
                file.write("x")
            time.sleep(HANGS)
        if chunk == self.deadly and not os.path.exists(self.grave):
            if self.grave:
                open(self.grave, "x").close()
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        if chunk == self.refused:
            raise LinkageError(f"chunk {chunk} is not wanted")
        if chunk == self.broken:
            raise ZeroDivisionError("by zero")
        size = chunk_size(chunk, self.rows, self.chunk_rows)
        numbers = np.arange(size) + chunk * self.chunk_rows
        real = np.sqrt(numbers) / 3.0
        real[numbers % 7 == 3] = np.nan
        return {
            "number": np.where(numbers % 5 == 0, -1, numbers**2),
            "Number": real,
            "words": ["" if n % 11 == 0 else f"ä,{n}" for n in numbers],
            'odd "name"': np.full(size, np.inf),
        }
