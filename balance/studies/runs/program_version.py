"""Which program computes: its version, and the hash of its code."""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path

from kinematics.version import __version__

# Folders of the packages, which are side by side.
ROOT = Path(__file__).parents[3]
PACKAGES = ("kinematics", "balance")


@cache
def program_version() -> str:
    """Name the program that runs here: version, and the first digits of the hash of its code.

    Results of two programs with one name are the same.
    """
    digest = sha256()
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            text = file.read_bytes()
            name = file.relative_to(ROOT).as_posix()
            digest.update(f"{name} {len(text)}\n".encode())
            digest.update(text)
    return f"{__version__} (code {digest.hexdigest()[:12]})"
