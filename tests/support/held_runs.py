"""Runs that stop writing at a number of rows, so that what happens to them happens halfway.

``python -m tests.support.held_runs ROWS sweep run …`` is ``balance sweep run …`` that waits as
soon as its file covers ROWS rows, until its standard input ends: at the latest with the process
that started it.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

from balance.__main__ import command
from balance.studies.runs.results_file import ResultsFile


def hold_at(rows: int) -> None:
    """Let files of this process wait for the end of the standard input from a row on."""
    write = ResultsFile.write_chunk

    def write_and_wait(file: ResultsFile, chunk: int, values: Mapping, *part: int) -> bool:
        is_new = write(file, chunk, values, *part)
        if file.computed()[0] >= rows:
            sys.stdin.read()
        return is_new

    ResultsFile.write_chunk = write_and_wait


if __name__ == "__main__":
    hold_at(int(sys.argv[1]))
    del sys.argv[1]
    sys.exit(command())
