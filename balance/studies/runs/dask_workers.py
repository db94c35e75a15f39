"""Workers of a Dask cluster that compute chunks.

The job is itself a task, so that the scheduler makes it again if the worker that holds it ends.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from itertools import islice
from pickle import dumps, loads
from typing import TYPE_CHECKING, Any

from balance.studies.runs.chunk_job import ChunkJob, ChunkTask
from balance.studies.runs.chunk_worker import ChunkOutcome, compute_chunk
from balance.support.processes import one_thread_each
from kinematics.errors import PackageError, WorkerError

if TYPE_CHECKING:
    from distributed import Client


# The address that stands for a cluster on this machine.
LOCAL = "local"
# Chunks on the cluster at once, per thread of its workers, and at least.
AHEAD, LEAST = 3, 8
# Times that a task may fail with its worker, and seconds to connect.
RETRIES = 5
PATIENCE = 30


def dask_outcomes(
    job: ChunkJob, tasks: Iterable[ChunkTask], address: str, workers: int
) -> Iterator[ChunkOutcome]:
    """Compute chunks on a cluster and yield them as they are done, in any order.

    Args:
        job: the job; it is sent to each worker once.
        tasks: the chunks.
        address: of the scheduler, such as ``tcp://host:8786``, or ``"local"`` for a cluster
            on this machine that ends with the run.
        workers: number of workers of a local cluster.

    Raises:
        PackageError: Dask is missing.
        WorkerError: the cluster cannot be reached, is lost, or its workers end again and again.
    """
    try:
        import distributed
    except ImportError:
        command = "pip install 'screwbalance[cluster]'"
        raise PackageError("--dask", "Dask distributed", command) from None
    _silence_logs()
    with ExitStack() as ends:
        client = _connect(distributed, address, workers, ends)
        try:
            yield from _windowed(client, distributed, job, tasks)
        except (distributed.KilledWorker, distributed.CancelledError, OSError) as error:
            raise WorkerError(
                f"the cluster {address} is lost ({type(error).__name__})",
                "start it again and resume the run",
            ) from None


def _silence_logs() -> None:
    """Let the library print nothing: some of its loggers have levels of their own."""
    for name in ("distributed", *logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _connect(distributed: Any, address: str, workers: int, ends: ExitStack) -> Client:
    """Connect to a cluster, or start one on this machine."""
    if address == LOCAL:
        with one_thread_each():
            # Without a dashboard it still listens: at a free port, for several runs at once.
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": ":0"},
                silence_logs=logging.CRITICAL,
            )
        ends.enter_context(cluster)
        address = cluster.scheduler_address
    try:
        client: Client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise WorkerError(
            f"no cluster at {address} ({reason})", "give the address that its scheduler prints"
        ) from None
    ends.enter_context(client)
    return client


def _windowed(
    client: Client, distributed: Any, job: ChunkJob, tasks: Iterable[ChunkTask]
) -> Iterator[ChunkOutcome]:
    """Keep a bounded number of chunks on the cluster, and yield what comes back."""
    rest = iter(tasks)
    made = client.submit(loads, dumps(job), pure=False, retries=RETRIES)
    threads = sum(client.nthreads().values())
    futures = [
        _submit(client, made, task) for task in islice(rest, max(LEAST, AHEAD * threads))
    ]
    done = distributed.as_completed(futures, loop=client.loop)
    del futures
    for future in done:
        outcome: ChunkOutcome = future.result()
        future.release()
        remainder = outcome.chunk, outcome.next_row
        task = remainder if outcome.next_row else next(rest, None)
        if task is not None:
            done.add(_submit(client, made, task))
        yield outcome


def _submit(client: Client, made: Any, task: ChunkTask) -> Any:
    """Put one chunk on the cluster."""
    return client.submit(compute_chunk, made, *task, pure=False, retries=RETRIES)
