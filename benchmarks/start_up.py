"""Claim: a command takes little longer than the import of the libraries that it needs.

The error is that of the answer: models that are not listed; the nullity, against exact
arithmetic; loads, of our series against Pinocchio; momentum that is left by a design, and how
far a predicted and corrected pose leaves the loop open, both against poses in mpmath.
"""

from __future__ import annotations

import json
from tempfile import TemporaryDirectory

import numpy as np

from balance.exact.ranks import exact_ranks
from benchmarks import reference
from benchmarks.processes import ROOT, python
from kinematics.models import load
from kinematics.pose import si_chain

# Run a command, and list the libraries that are loaded then.
LIST = """
import io, json, sys
from contextlib import redirect_stdout
from importlib.metadata import packages_distributions
from balance.cli import main
with redirect_stdout(io.StringIO()):
    main(sys.argv[1:])
ours = {"balance", "kinematics", "urdf_models"}
roots = {name for name in sys.modules if "." not in name} & set(packages_distributions())
print(json.dumps(sorted(name for name in roots - ours if not name.startswith("_"))))
"""
COMMANDS = {
    "models": ["models"],
    "report": ["report", "four_bar_general"],
    "verify": ["verify", "four_bar_antiparallelogram_balanced", "--trajectories", "2"],
    "design": ["design", "four_bar_antiparallelogram"],
    "motion": ["motion", "four_bar_general", "--to", "u1=0.3"],
}


class StartUp:
    """Whole processes, kernels from the disk cache."""

    params = tuple((name,) for name in COMMANDS)
    repetitions = 5
    claims = (("time_command", "time_imports", 2.5), ("track_error", 1e-9))

    def setup(self, command: str) -> None:
        """Find out what the command loads."""
        found = self._run("-c", LIST, *COMMANDS[command])
        self.imports = "import " + ", ".join(["sys", *json.loads(found.splitlines()[-1])])

    def _run(self, *words: str) -> str:
        with TemporaryDirectory() as folder:
            return python(*words, cwd=folder)

    def track_error(self, command: str) -> float:
        """Of the answer."""
        if command == "models":
            found = self._run("-m", "balance", "models").splitlines()
            return abs(len(found) - len(list(ROOT.glob("urdf_models/*.urdf"))))
        words = COMMANDS[command]
        answer = json.loads(self._run("-m", "balance", *words, "--json"))
        return float(ERRORS[command](words[1], answer))

    def time_command(self, command: str) -> None:
        """The command, its answer included."""
        self._run("-m", "balance", *COMMANDS[command])

    def time_imports(self, command: str) -> None:
        """An empty process that loads the same libraries."""
        self._run("-c", self.imports)


def _report(model: str, answer: dict) -> float:
    return abs(answer["nullity"] - exact_ranks(load(model)).nullity)


def _verify(model: str, answer: dict) -> float:
    return answer["agreement"]


def _design(model: str, answer: dict) -> float:
    """Relative to the momentum of the bodies by themselves."""
    z = np.concatenate([body["z"] for body in answer["bodies"]])
    X = reference.momentum(si_chain(load(model), True), np.ones(1), 3)
    return max((np.abs(x @ z) / (np.abs(x) @ np.abs(z)).max()).max() for x in X)


def _motion(model: str, answer: dict) -> float:
    linkage = load(model)
    chain, names = si_chain(linkage, True), [joint.name for joint in linkage.joints]
    told = [joint["name"] for joint in answer["joints"]]
    pose = dict(zip(told, answer["poses"][0]["corrected"], strict=True))
    return reference.gap(chain, np.array([pose[names[j]] for j in chain.joints]))


ERRORS = {"report": _report, "verify": _verify, "design": _design, "motion": _motion}
