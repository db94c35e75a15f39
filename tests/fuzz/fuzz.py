"""Mutants of good files: every one is refused in one line, or read as a second reader does.

``python -m tests.fuzz.fuzz --cases 100000 --seed 0`` runs as many cases as it is told; a seed
stands for the cases that follow it, so that ``--seed 4711 --cases 1`` is one case again.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from balance import design_space
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import FileError, LinkageError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.read_options import ReadOptions
from tests.fuzz.mutants import Mutant, mutant
from tests.independent.second_reading import read
from tests.independent.second_words import Strange
from tests.support.comparison import SMALL, closed, compare, compare_closed
from tests.support.time_limit import time_limit

# Seconds after which a case hangs.
LIMIT = 300.0
# One in so many: assembled though a loop is open; and on to the design space.
OPEN, FURTHER = 40, 40
# Loops of more joints that stay open take too long to be given up.
LARGE = 16
# Angles as meant and as written differ by less, and lengths by so much of the extent.
ROUNDED = 1e-3
# Loops that are open by no more may close once angles are what they are meant to be.
NEARLY = 1e-3
# Axes are moved by less where loops close to rounding.
MENDED = 1e-2


@dataclass
class Tally:
    """What became of the cases."""

    counts: Counter = field(default_factory=Counter)
    found: list[str] = field(default_factory=list)
    slowest: tuple[float, int] = (0.0, -1)


def run(seeds: range, folder: Path, limit: float = LIMIT) -> Iterator[Tally]:
    """Run the cases of some seeds; yields the same tally after each."""
    tally = Tally()
    for seed in seeds:
        begin = time.perf_counter()
        case = mutant(seed)
        try:
            with time_limit(limit):
                tally.counts[_outcome(case, folder)] += 1
        except Exception as error:
            where = traceback.format_exception(error)[-2].strip().splitlines()
            text = f"{case.model} {case.changes}: {error!r} in {' '.join(where)}"
            tally.found.append(f"seed {seed}: {text}")
            tally.counts["found"] += 1
        tally.slowest = max(tally.slowest, (time.perf_counter() - begin, seed))
        yield tally


def written(case: Mutant, folder: Path) -> Path:
    """The file of a case, and the one beside it."""
    path, beside = folder / "robot.urdf", folder / "robot.yaml"
    path.write_bytes(case.urdf)
    beside.unlink(missing_ok=True)
    if case.yaml is not None:
        beside.write_bytes(case.yaml)
    return path


def _outcome(case: Mutant, folder: Path) -> str:
    """How a case ends; anything but that is an error.

    Raises:
        AssertionError: the product and the second reading differ, or a refusal says too
            little.
    """
    path = written(case, folder)
    reading = ("as_written", "nominal")[case.seed % 2]
    try:
        draft = read_unassembled(path, options=ReadOptions(angles=reading))
    except LinkageError as error:
        _check_line(error, folder)
        return "refused by the reader"
    try:
        said = read(case.urdf, case.yaml)
    except Strange as strange:
        raise AssertionError(f"accepted, but the second reading is: {strange}") from None
    told = any(notice.code == "rounded_angles" for notice in draft.notices)
    rounded = told and reading == "nominal"
    nearly = all(weld.distance + weld.angle <= NEARLY for weld in said.welds.values())
    compare(draft, said, ROUNDED if rounded else SMALL)
    far = case.seed % OPEN or len(draft.joints) > LARGE
    if far and not (closed(said) or (rounded and nearly)):
        return "read, open"
    try:
        linkage = assemble(draft, exactly=reading == "as_written")
        compare_closed(linkage, draft, MENDED if said.welds else SMALL)
        if case.seed % FURTHER == 1:
            space = design_space(linkage)
            assert 0 <= space.rank <= space.rank + space.nullity
            return "design space"
    except LinkageError as error:
        _check_line(error, folder)
        return "refused after reading"
    return "linkage"


def _check_line(error: LinkageError, folder: Path) -> None:
    """One clean line that says where, what, and what to do."""
    text = str(error)
    assert text.splitlines() == [text] and text.isprintable() and len(text) < 5000, text
    assert text.startswith(str(folder)) and ";" in text, text
    if isinstance(error, FileError):
        assert error.problem and error.remedy


def main() -> int:
    """Run cases from the command line, with a line of progress."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds for a case")
    options = parser.parse_args()
    begin, tally, told = time.perf_counter(), Tally(), 0
    seeds = range(options.seed, options.seed + options.cases)
    with tempfile.TemporaryDirectory() as folder:
        for n, tally in enumerate(run(seeds, Path(folder), options.limit), 1):
            for line in tally.found[told:]:
                print(line, flush=True)
            told = len(tally.found)
            if n % (50 if sys.stderr.isatty() else 5000) == 0:
                end = "\r" if sys.stderr.isatty() else "\n"
                print(f"{n} of {len(seeds)}, {told} found", end=end, file=sys.stderr)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{len(seeds)} cases in {time.perf_counter() - begin:.0f} s, {peak:.0f} MB at most")
    for name, count in sorted(tally.counts.items()):
        print(f"{count:8} {name}")
    print(f"slowest: seed {tally.slowest[1]}, {tally.slowest[0]:.1f} s")
    return 1 if tally.found else 0


if __name__ == "__main__":
    sys.exit(main())
