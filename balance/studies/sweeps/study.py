"""A study of many geometries: read from a file, checked against its model, made a job."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.study_data import StudyData
from balance.studies.sweeps.sweep_table import SweepTable, compute_table
from kinematics.error_text import clean
from kinematics.errors import FileError, UsageError
from kinematics.wording import count_noun, first_names, repr_lines

LARGE = 100_000_000
"""Most geometries of a study that nobody has to confirm."""
# Geometries that cannot be numbered by whole numbers of 64 bits.
TOO_MANY = 2**62


@dataclass(frozen=True, repr=False)
class Study(StudyData):
    """A study; `from_tables` and `read_study` make one, see there for its attributes."""

    def __repr__(self) -> str:
        """Two or three lines: how many geometries, what varies, what is computed."""
        head = f"Study {self.source}: {count_noun(self.rows, 'geometry')}"
        varied = f"parameters {first_names(list(self.parameters))}"
        return repr_lines(head, varied, f"quantities {first_names(list(self.quantities))}")

    def job(self, *, yes: bool = False) -> SweepJob:
        """Make the job that computes the study, chunk by chunk.

        Args:
            yes: allow more than 100 million geometries.

        Raises:
            UsageError: there are more.
            FileError: the study does not fit its model.
        """
        about = f"{self.source}: {min(self.rows, 10**300):.3g} geometries"
        if self.rows > LARGE and not yes:
            remedy = "vary less, take samples instead of a grid, or add --yes"
            raise UsageError(f"{about} are more than {LARGE:.0e}; {remedy}")
        if self.rows >= TOO_MANY:
            raise UsageError(f"{about} cannot be numbered; vary less")
        return SweepJob.of_study(self)

    def run(self, *, workers: int = 1, yes: bool = False) -> SweepTable:
        """Compute the study, and keep all of it in memory.

        Args:
            workers: processes to use.
            yes: allow more than 100 million geometries.

        Returns:
            One row for each geometry.

        Raises:
            LinkageError: as for `job`.
        """
        return compute_table(self.job(yes=yes), workers, self.source)


def read_study(path: str | PathLike[str]) -> Study:
    """Read a study from a TOML file.

    Args:
        path: the file; paths in it are relative to its folder.

    Returns:
        The study.

    Raises:
        FileError: it cannot be read, or a table is wrong.
        LinkageError: its model cannot be read.

    Example:
        >>> import balance
        >>> with open("study.toml", "w") as file:
        ...     print("model.file = 'robot.urdf'", file=file)
        ...     print("parameters.q2.origin.x = '0.1:0.4:31'", file=file)
        >>> balance.studies.read_study("study.toml").rows
        31
    """
    file = Path(path)
    source = clean(str(path), 1000)
    try:
        tables = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FileError(source, "", reason, "give the path of a study") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        problem = f"no TOML: {clean(str(error), 200)}"
        raise FileError(source, "", problem, "correct the file") from None
    return Study.from_tables(tables, None, source, file.parent)
