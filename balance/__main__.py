"""The command line, as ``python -m balance``."""

from __future__ import annotations

from balance.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
