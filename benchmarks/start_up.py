"""Claim: a command takes little longer than the import of the libraries that it needs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
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
}


class StartUp:
    """Whole processes, kernels from the disk cache."""

    params = tuple((name,) for name in COMMANDS)
    repetitions = 5
    claims = (("time_command", "time_imports", 2.5),)

    def setup(self, command: str) -> None:
        """Find out what the command loads."""
        found = self._run("-c", LIST, *COMMANDS[command])
        self.imports = "import " + ", ".join(["sys", *json.loads(found.splitlines()[-1])])

    def _run(self, *words: str) -> str:
        with TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, *words], cwd=folder, capture_output=True, text=True,
                check=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
            )  # fmt: skip
        return done.stdout

    def time_command(self, command: str) -> None:
        """The command, its answer included."""
        self._run("-m", "balance", *COMMANDS[command])

    def time_imports(self, command: str) -> None:
        """An empty process that loads the same libraries."""
        self._run("-c", self.imports)
