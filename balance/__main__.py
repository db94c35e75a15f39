"""The command line, as ``balance`` or ``python -m balance``: one process, one command."""

from __future__ import annotations

import gc

from balance.app.cli.main import main
from kinematics.numerics.compiled.background import begin_command


def command() -> int:
    """Run the command of this process, which need not compile kernels for it.

    Returns:
        The exit code.
    """
    begin_command()
    code = main()
    # The process ends: Python need not look for garbage among all that it has imported.
    gc.freeze()
    return code


if __name__ == "__main__":
    raise SystemExit(command())
