"""What a worker does with a chunk, in a process beside the writer or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import NamedTuple

from balance.studies.runs.chunk_job import ChunkColumns, ChunkJob, PartedJob
from balance.studies.runs.program_version import program_version
from kinematics.errors import LinkageError, UsageError, WorkerError

# Variables that set the threads of libraries: matrices are small.
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")

_ONE_AT_A_TIME = Lock()


class ChunkOutcome(NamedTuple):
    """What became of a chunk; exceptions are texts, since not all of them can be pickled.

    Attributes:
        chunk: its number.
        program: the program that computed it.
        columns: its columns, or those of some of its rows; None if it failed.
        refused: the type of refusal: ``"usage"``, ``"linkage"``, or an empty text.
        error: why it failed.
        trace: where it failed, if it should not.
        first: the first row of the chunk in the columns, from 0.
        next_row: the first row that is left to compute; 0 if none is.
    """

    chunk: int
    program: str
    columns: ChunkColumns | None
    refused: str = ""
    error: str = ""
    trace: str = ""
    first: int = 0
    next_row: int = 0


def compute_chunk(job: ChunkJob, chunk: int, first: int = 0) -> ChunkOutcome:
    """Compute a chunk, or rows of it for a few seconds, and keep what goes wrong.

    A worker with several threads computes one chunk at a time: jobs may keep working memory.

    Args:
        chunk: number of the chunk.
        first: the first of its rows to compute, from 0.
    """
    try:
        with _ONE_AT_A_TIME:
            if not isinstance(job, PartedJob):
                return ChunkOutcome(chunk, program_version(), job.compute(chunk))
            columns, next_row = job.compute_part(chunk, first)
            return ChunkOutcome(
                chunk, program_version(), columns, first=first, next_row=next_row
            )
    except LinkageError as error:
        kind = "usage" if isinstance(error, UsageError) else "linkage"
        return ChunkOutcome(chunk, program_version(), None, kind, str(error))
    except Exception as error:
        import traceback

        text = f"{type(error).__name__}: {error}"
        return ChunkOutcome(chunk, program_version(), None, "", text, traceback.format_exc())


def values_of(outcome: ChunkOutcome) -> ChunkColumns:
    """Return the columns of a chunk, or raise what it failed with.

    Raises:
        LinkageError: the chunk was refused.
        WorkerError: the worker runs another version of the program.
        RuntimeError: the chunk failed by a defect.
    """
    if outcome.program != program_version():
        raise WorkerError(
            f"a worker runs version {outcome.program}, and this is {program_version()}",
            "install the same version on all machines",
        )
    if outcome.columns is not None:
        return outcome.columns
    if outcome.refused:
        raise (UsageError if outcome.refused == "usage" else LinkageError)(outcome.error)
    failure = RuntimeError(f"chunk {outcome.chunk}: {outcome.error}")
    failure.add_note(outcome.trace)
    raise failure


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes that start within the block use one thread each for their matrices."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
