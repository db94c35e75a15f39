"""Commands in a process of its own, with the rounding as it is or perturbed.

``python -m tests.support.gallery_run`` runs every command of the gallery and prints what each
printed, one in a line, as JSON. With ``--seed N`` the rounding is perturbed; the seed chooses
how kernels run, unless ``--variant NAME`` does. ``--only WORDS`` takes the commands with these
words. ``--compare 20`` runs the commands as they are and with the seeds 0 to 19, and prints
each command whose text or exit code changed; the exit code is then 1.
"""

from __future__ import annotations

import argparse
import difflib
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tests.support.rounding import VARIANTS, perturb_rounding

ROOT = Path(__file__).parents[2]
# What a command prints of time, and of kernels that it had to compile.
OF_TIME = re.compile(
    r" in [\d.]+ s, \d+ geometries a second|^compiling kernels .*\n"
    r"|^kernels are compiled in the background .*\n|^time +[\d.]+ s$",
    re.M,
)


class Printed(NamedTuple):
    """What a command printed, and its exit code."""

    code: int
    out: str
    err: str


def run_commands(
    commands: Sequence[str], seed: int | None = None, variant: str = ""
) -> dict[str, Printed]:
    """Run commands in one new process, in an empty folder.

    Args:
        commands: each as in a shell, without the name of the program.
        seed: of the perturbed rounding; None leaves the rounding as it is.
        variant: how kernels run, one of `tests.support.rounding.VARIANTS`.

    Returns:
        What each command printed.
    """
    options = [] if seed is None else ["--seed", str(seed)]
    options += ["--variant", variant] if variant else []
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [
                sys.executable,
                "-m",
                "tests.support.gallery_run",
                "--folder",
                folder,
                "--commands",
                "-",
                *options,
            ],
            cwd=ROOT,
            input="\n".join(commands),
            text=True,
            stdout=subprocess.PIPE,
            check=True,
        )
    records = map(json.loads, done.stdout.splitlines())
    return {command: Printed(*printed) for command, printed in records}


def changed_commands(
    usual: dict[str, Printed], other: dict[str, Printed]
) -> dict[str, tuple[Printed, Printed]]:
    """Find the commands of two runs whose text, without that of time, or exit code differs."""
    return {
        command: (usual[command], other[command])
        for command in usual
        if _without_time(usual[command]) != _without_time(other[command])
    }


def _without_time(printed: Printed) -> Printed:
    """Leave out what a command prints of time."""
    return Printed(printed.code, OF_TIME.sub("", printed.out), OF_TIME.sub("", printed.err))


def _compare(commands: Sequence[str], seeds: Sequence[int], variant: str) -> int:
    """Print the commands that seeds change; return how many pairs of them there are."""
    usual, total = run_commands(commands), 0
    for seed in seeds:
        changed = changed_commands(usual, run_commands(commands, seed, variant))
        total += len(changed)
        if changed:
            print(changed_lines(changed), flush=True)
        print(f"seed {seed}: {len(changed)} of {len(commands)} changed", flush=True)
    return total


def changed_lines(changed: dict[str, tuple[Printed, Printed]]) -> str:
    """Show the lines that changed, below each command."""
    texts = []
    for command, (before, after) in changed.items():
        lines = difflib.unified_diff(_lines(before), _lines(after), n=0, lineterm="")
        texts.append("\n  ".join([command, *list(lines)[2:]]))
    return "\n".join(texts)


def _lines(printed: Printed) -> list[str]:
    """The lines of what a command printed, and its exit code."""
    plain = _without_time(printed)
    return [f"exit {plain.code}", *plain.out.splitlines(), *plain.err.splitlines()]


def main() -> None:
    """Run the commands, and print what each printed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--variant", choices=VARIANTS, default="")
    parser.add_argument("--only", default="")
    parser.add_argument("--commands", type=argparse.FileType(), metavar="FILE")
    parser.add_argument("--folder", default=".")
    parser.add_argument("--compare", type=int, metavar="SEEDS")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if options.seed is not None:
        perturb_rounding(options.seed, options.variant)
    from tests.support.gallery_commands import all_commands, prepare_folder, words_of

    commands = options.commands.read().splitlines() if options.commands else all_commands()
    if options.compare is not None:
        commands = [command for command in commands if options.only in command]
        seeds = range(options.first, options.first + options.compare)
        raise SystemExit(_compare(commands, seeds, options.variant) > 0)
    _stay_in_this_process()
    prepare_folder(Path(options.folder))
    os.chdir(options.folder)
    from tests.support.command_runs import asked

    for command in commands:
        if options.only in command:
            print(json.dumps([command, asked(words_of(command))]), flush=True)


def _stay_in_this_process() -> None:
    """Let studies use no processes of their own, whose rounding would not be perturbed."""
    from balance.studies.runs import chunk_runs

    plain = chunk_runs.run_chunks

    def run_chunks(job: object, file: object, *, workers: int, **options: object) -> object:
        return plain(job, file, workers=0, **options)

    chunk_runs.run_chunks = run_chunks


if __name__ == "__main__":
    main()
