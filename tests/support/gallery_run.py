"""Run the commands of the gallery in one process, and print what each printed, as JSON.

``python -m tests.support.gallery_run [--seed N] [--variant NAME] [--only WORD]``
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tests.support.perturbed_functions import rounding  # noqa: E402
from tests.support.rounding import VARIANTS, install  # noqa: E402


def main() -> None:
    """Run the commands."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int)
    parser.add_argument("--variant", choices=VARIANTS)
    parser.add_argument("--only", default="")
    parser.add_argument("--out")
    options = parser.parse_args()
    if options.variant or options.seed is not None:
        install(options.variant or "as_built")
    from tests.fuzz.sweep_words import STUDY
    from tests.support.command_runs import asked
    from tests.support.gallery_commands import DATA, all_commands

    rounding.seed = options.seed
    _stay_in_this_process()
    commands = [words for words in all_commands() if options.only in " ".join(words)]
    out = open(options.out, "w") if options.out else sys.stdout
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("study.toml").write_text(STUDY, encoding="utf-8")
        for words in commands:
            label = " ".join(words).replace(str(DATA), "tests/data")
            start = time.perf_counter()
            done = asked(words)
            seconds = time.perf_counter() - start
            record = {"command": label, "code": done.code, "out": done.out, "err": done.err,
                      "seconds": seconds}  # fmt: skip
            print(json.dumps(record), file=out, flush=True)


def _stay_in_this_process() -> None:
    """Let studies use no processes of their own, whose rounding would not be perturbed."""
    from balance.result_files import chunk_runs

    plain = chunk_runs.run_chunks

    def run_chunks(job: object, file: object, *, workers: int, **options: object) -> object:
        return plain(job, file, workers=0, **options)

    chunk_runs.run_chunks = run_chunks


if __name__ == "__main__":
    main()
