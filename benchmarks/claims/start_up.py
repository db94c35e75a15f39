"""Claim: commands take little more time than the import of their libraries, even the first one.

Processor time is that of a whole process with the command, and of an empty process that imports
the same libraries. Cold: nothing is compiled; a lock keeps away the process that compiles in
the background, since the command does not wait for it. Warm: all kernels are in the disk cache.
The error is that of the answer: number of missing models; nullity, against exact arithmetic;
shaking loads, against Pinocchio; residual momentum of a design, and loop residual of a
predicted and corrected pose, both against poses in mpmath.
"""

from __future__ import annotations

import json
import os
import time
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from filelock import FileLock

import balance
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.harness.processes import ROOT, balance_command, python
from benchmarks.references import reference
from kinematics.closure.joint_positions import si_chain
from kinematics.loading.model_gallery import load
from kinematics.numerics.compiled.background import VARIABLE
from kinematics.numerics.compiled.cache_contents import ALL, ready_kernels

# 2000 four-bars, with the rank of each.
STUDY = """
[model]
file = "four_bar_general"
[parameters]
"coupler.length" = "0.4:0.6:50"
"crank.length" = "0.2:0.3:40"
[compute]
quantities = ["rank", "distance"]
"""
LONG = {
    "remedies": ("remedies", "four_bar_general"),
    "verify": ("verify", "delta"),
    "sweep": ("sweep", "run", "study.toml", "--out", "study.db", "--workers", "1"),
}
# Runs a command, and prints the loaded libraries.
LIST = """
import io, json, sys
from contextlib import redirect_stdout
from importlib.metadata import packages_distributions
from kinematics.numerics.compiled.background import begin_command
begin_command()
from balance.app.cli.main import main
with redirect_stdout(io.StringIO()):
    main(sys.argv[1:])
ours = {"balance", "kinematics", "urdf_models"}
roots = {name for name in sys.modules if "." not in name} & set(packages_distributions())
print(json.dumps(sorted(name for name in roots - ours if not name.startswith("_"))))
"""
COMMANDS = {
    "--help": ["--help"],
    "report --help": ["report", "--help"],
    "--version": ["--version"],
    "models": ["models"],
    "report": ["report", "four_bar_general"],
    "verify": ["verify", "four_bar_antiparallelogram_balanced", "--trajectories", "2"],
    "design": ["design", "four_bar_antiparallelogram"],
    "motion": ["motion", "four_bar_general", "--to", "u1=0.3"],
}


@cache
def compile_kernels() -> None:
    """Compile all kernels, unless they are in the disk cache."""
    if ALL not in ready_kernels(Path(balance.__file__).parent):
        python("-c", "import balance, kinematics; kinematics.compile()")


class _Commands:
    """Whole processes of a command, in temporary folders."""

    runs = 5

    def setup(self, *words: str) -> None:
        """Compile all kernels, and list the libraries of the command."""
        compile_kernels()
        command = COMMANDS.get(words[0], ["report", *words])
        loaded = self._run("-c", LIST, *command).splitlines()[-1]
        self.imports = "import " + ", ".join(["sys", *json.loads(loaded)])

    def _run(self, *words: str, **variables: str) -> str:
        with TemporaryDirectory() as folder:
            return python(*words, cwd=folder, **variables)

    def _seconds(self, *words: str, cold: bool = False) -> np.ndarray:
        """Measure the processor time of processes; cold: each with an empty cache."""
        found = []
        for _ in range(self.runs):
            with (
                TemporaryDirectory(ignore_cleanup_errors=True) as folder,
                FileLock(Path(folder) / "kernels.lock"),
            ):
                cache = {"NUMBA_CACHE_DIR": folder} if cold else {}
                before = os.times()
                self._run(*words, **cache)
                after = os.times()
            user = after.children_user - before.children_user
            found.append(user + after.children_system - before.children_system)
        return np.array(found)

    def track_imports(self, *words: str) -> np.ndarray:
        """Import of the same libraries in an empty process."""
        return self._seconds("-c", self.imports)


class Warm(_Commands):
    """Commands, kernels from the disk cache."""

    params = tuple((name,) for name in COMMANDS)
    claims = (("track_command", "track_imports", 4), ("track_error", 1e-9))

    def track_command(self, command: str) -> np.ndarray:
        """The command with its answer."""
        return self._seconds("-m", "balance", *COMMANDS[command])

    def track_error(self, command: str) -> float:
        """Error of the answer."""
        if command == "models":
            found = self._run("-m", "balance", "models").splitlines()
            return abs(len(found) - len(list(ROOT.glob("urdf_models/*.urdf"))))
        if command not in ERRORS:
            return 0.0
        words = COMMANDS[command]
        answer = json.loads(self._run("-m", "balance", *words, "--json"))
        return float(ERRORS[command](words[1], answer))


class WarmReport(Warm):
    """The report on a four-bar."""

    params = (("report",),)
    claims = (("track_command", 0.55),)


class WarmHelp(Warm):
    """Commands without a linkage."""

    params = (("--help",), ("report --help",), ("--version",), ("models",))
    claims = (("track_command", 0.1),)


class _Cold(_Commands):
    """The first report on a machine."""

    def track_first(self, *words: str) -> np.ndarray:
        """The report with its answer, and nothing compiled."""
        return self._seconds("-m", "balance", "report", *words, cold=True)

    def track_difference(self, *words: str) -> float:
        """Return 1 if integers of the answer differ from those of compiled kernels."""
        answers = []
        for way in ("never", "now"):
            text = self._run("-m", "balance", "report", *words, "--json", BALANCE_COMPILE=way)
            answers.append(json.loads(text))
        names = ("orders", "rank", "nullity", "serial", "parallel", "mobility", "certainty")
        first, second = ([answer.get(name) for name in names] for answer in answers)
        return float(_integers(first) != _integers(second))


class ColdFourBar(_Cold):
    """A planar linkage with one loop."""

    params = (("four_bar_general",),)
    claims = (
        ("track_first", 2.5),
        ("track_first", "track_imports", 4),
        ("track_difference", 0),
    )


class ColdThreeRsr(_Cold):
    """The linkage of the README, whole and on its plane of symmetry."""

    slow = True
    params = (("three_rsr",), ("three_rsr", "--motion", "u2=u3"))
    claims = (
        ("track_first", 7),
        ("track_first", "track_imports", 5),
        ("track_difference", 0),
    )


class ColdParallelRobots(_Cold):
    """Six loops or three legs of four bars."""

    slow = True
    runs = 3
    params = (("delta",), ("stewart_6ups",))
    claims = (
        ("track_first", 20),
        ("track_first", "track_imports", 15),
        ("track_difference", 0),
    )


class FirstLongCommand(_Commands):
    """A command of some seconds on an empty cache; seconds on the clock of a quiet machine.

    It begins uncompiled, and takes up kernels as the process beside it compiles them: little
    longer than the better of compiling all kernels that it needs first, and none.
    """

    slow = True
    runs = 3
    params = (("remedies",), ("verify",), ("sweep",))
    claims = (("track_first", "track_better", 1.3),)

    def setup(self, verb: str) -> None:
        """Look up the words of the command; every run has an empty cache."""
        self.words = LONG[verb]

    def _clock(self, way: str) -> np.ndarray:
        """Seconds on the clock until the command answers."""
        seconds = []
        for _ in range(self.runs):
            with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                (Path(folder) / "study.toml").write_text(STUDY)
                variables = {"NUMBA_CACHE_DIR": str(Path(folder) / "cache"), VARIABLE: way}
                start = time.perf_counter()
                balance_command(*self.words, cwd=folder, **variables)
                seconds.append(time.perf_counter() - start)
        return np.array(seconds)

    def track_first(self, verb: str) -> np.ndarray:
        """The command as it is called by a new user."""
        return self._clock("background")

    def track_better(self, verb: str) -> np.ndarray:
        """The faster of kernels compiled before their first call, and never."""
        return min(map(self._clock, ("now", "never")), key=np.median)

    def track_error(self, verb: str) -> float:
        """That of the answers is the claim of `Warm`."""
        return 0.0


def _integers(found: object) -> list[int]:
    """The integers of an answer, in order."""
    if isinstance(found, dict):
        found = list(found.values())
    if isinstance(found, list):
        return [number for item in found for number in _integers(item)]
    return [found] if isinstance(found, int) else []


def _report(model: str, answer: dict) -> float:
    return abs(answer["nullity"] - exact_ranks(load(model)).nullity)


def _verify(model: str, answer: dict) -> float:
    return answer["agreement"]


def _design(model: str, answer: dict) -> float:
    """Residual momentum relative to that of the single bodies."""
    z = np.concatenate([body["z"] for body in answer["bodies"]])
    X = reference.momentum(si_chain(load(model), True), np.ones(1), 3)
    return max((np.abs(x @ z) / (np.abs(x) @ np.abs(z)).max()).max() for x in X)


def _motion(model: str, answer: dict) -> float:
    linkage = load(model)
    chain, names = si_chain(linkage, True), [joint.name for joint in linkage.joints]
    listed = [joint["name"] for joint in answer["joints"]]
    pose = dict(zip(listed, answer["poses"][0]["corrected"], strict=True))
    return reference.gap(chain, np.array([pose[names[j]] for j in chain.joints]))


ERRORS = {"report": _report, "verify": _verify, "design": _design, "motion": _motion}
