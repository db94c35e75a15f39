"""The command line, as ``balance`` or ``python -m balance``: one process, one command."""

from __future__ import annotations

import sys

from balance.cli import USAGE, main
from kinematics.compilation import begin_command
from kinematics.errors import UsageError

__all__ = ["command"]


def command() -> int:
    """Run the command of this process, which need not compile kernels for it.

    Returns:
        The exit code.
    """
    try:
        begin_command()
    except UsageError as error:
        print(f"balance: {error}", file=sys.stderr)
        return USAGE
    return main()


if __name__ == "__main__":
    raise SystemExit(command())
