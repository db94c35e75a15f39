"""A Dask cluster in one process that can be killed: ``python -m tests.support.dask_cluster``.

It prints the address of its scheduler, and ends with its standard input.
"""

from __future__ import annotations

import logging
import sys

import distributed

if __name__ == "__main__":
    with distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": ":0"},
        silence_logs=logging.CRITICAL,
    ) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
