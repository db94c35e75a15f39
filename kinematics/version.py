"""The version of the installed package, looked up when it is asked for."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

__all__ = ["__version__"]

try:
    __version__ = version("screwbalance")
except PackageNotFoundError:
    __version__ = "unknown"
