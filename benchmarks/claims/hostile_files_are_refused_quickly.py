"""Claim: files that are made to keep a reader busy are refused within three seconds.

They are larger, deeper or longer than the limits, hold entities that would expand to 10⁹
characters, or YAML of brackets and repeated names. A file with a bad number is refused in less
than half a second, and a robot of a thousand joints is read in two. Processor time is that of
the whole command. The error is the number of bad files that are read, and of missing links.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from benchmarks.harness.processes import ROOT
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.loading.model_gallery import gallery

INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
HEAD = '<robot name="r"><link name="l0"/>'
BAD_NUMBER = gallery()["four_bar_general"].read_text("utf-8").replace('xyz="', 'xyz="nan ', 1)
ENTITIES = "".join(f"<!ENTITY a{i} '{f'&a{i - 1};' * 10}'>" for i in range(1, 10))
ROBOTS = {
    "a bad number": BAD_NUMBER,
    "entities": f"<!DOCTYPE robot [<!ENTITY a0 'x'>{ENTITIES}]><robot name='&a9;'/>",
    "a million levels": "<robot name='r'>" + "<a>" * 1_000_000,
    "a million elements": HEAD + "<a/>" * 1_000_000 + "</robot>",
    "a million attributes": "<robot " + " ".join(f'a{i}=""' for i in range(1_000_000)) + "/>",
    "a word of 15 MB": "<" + "x" * 15_000_000,
}
# YAML files beside a robot.
LOOPS = {
    "brackets": "closed_loop: " + "[" * 100_000,
    "anchors": "a: &a [x]\n" + "".join(f"k{i}: [*a, *a]\n" for i in range(5000)),
    "loops": "closed_loop: [" + "[tip_a, tip_b]," * 8000 + "]",
    "motors": "name_mot: [" + "j1," * 40_000 + "]",
    "lists": "- " * 50_000,
    "empty lines": "closed_loop: '\n" + "\n" * 100_000,
}


def chain(joints: int, mimics: bool = False) -> str:
    """Write a robot that is an open chain."""
    parts = []
    for k in range(1, joints + 1):
        mimic = f'<mimic joint="j{k - 1}"/>' if mimics and k > 1 else ""
        parts.append(
            f'<link name="l{k}">{INERTIAL}</link><joint name="j{k}" type="revolute">'
            f'<parent link="l{k - 1}"/><child link="l{k}"/>{mimic}</joint>'
        )
    return HEAD + "".join(parts) + "</robot>"


class _Refused:
    """A command that refuses a file."""

    runs = 5

    def setup(self, case: str) -> None:
        """Choose the files."""
        self.files = {"robot.urdf": ROBOTS[case]}

    @contextmanager
    def _folder(self) -> Iterator[Path]:
        """Write the files to a folder."""
        with TemporaryDirectory() as name:
            folder = Path(name)
            for file, text in self.files.items():
                (folder / file).write_text(text, encoding="utf-8")
            yield folder

    def track_refusal(self, case: str) -> np.ndarray:
        """Processor time of the command."""
        seconds = []
        with self._folder() as folder:
            for _ in range(self.runs):
                before = os.times()
                _report(folder)
                after = os.times()
                user = after.children_user - before.children_user
                seconds.append(user + after.children_system - before.children_system)
        return np.array(seconds)

    def track_files_read(self, case: str) -> int:
        """Bad files that are read."""
        with self._folder() as folder:
            return int(_report(folder) != 3)


def _report(folder: Path) -> int:
    """Report on the robot in a folder, and return the exit code."""
    loops = ["--loops", "robot.yaml"] if (folder / "robot.yaml").exists() else []
    return subprocess.run(
        [sys.executable, "-m", "balance", "report", "robot.urdf", *loops],
        cwd=folder,
        capture_output=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    ).returncode


class HostileRobots(_Refused):
    """Robots."""

    params = tuple((case,) for case in ROBOTS if case != "a bad number")
    claims = (("track_refusal", 3.0), ("track_files_read", 0.0))


class BadNumber(_Refused):
    """A robot with a number that is none: neither NumPy nor Numba is loaded."""

    params = (("a bad number",),)
    claims = (("track_refusal", 0.45), ("track_files_read", 0.0))


class HostileLoops(_Refused):
    """YAML files beside a robot."""

    params = tuple((case,) for case in LOOPS)
    claims = (("track_refusal", 3.0), ("track_files_read", 0.0))

    def setup(self, case: str) -> None:
        """Choose an open chain and the file beside it, which is to close it."""
        self.files = {"robot.urdf": chain(2), "robot.yaml": LOOPS[case]}


class LongRobots:
    """A chain of joints; in the other case each one mimics the one before it."""

    params = ((1000, "free"), (1000, "mimics"))
    claims = (("track_seconds", 2.0), ("track_missing", 0.0))
    runs = 5

    def setup(self, joints: int, kind: str) -> None:
        """Write the robot."""
        self.text = chain(joints, kind == "mimics")

    def _read(self) -> tuple[float, int]:
        """Read the robot: processor time in seconds, and the number of its bodies."""
        with TemporaryDirectory() as name:
            path = Path(name) / "robot.urdf"
            path.write_text(self.text, encoding="utf-8")
            start = process_time()
            draft = read_unassembled(path)
            return process_time() - start, len(draft.bodies)

    def track_seconds(self, joints: int, kind: str) -> np.ndarray:
        """Processor time of reading."""
        return np.array([self._read()[0] for _ in range(self.runs)])

    def track_missing(self, joints: int, kind: str) -> int:
        """Links that are not read."""
        return joints - self._read()[1]
