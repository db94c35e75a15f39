"""Other libraries on the Taylor jobs, a module for each; those not installed are left out.

Each has functions named after jobs: given the order, they return a function that does the
job once and one that turns its result into coefficients (joints, monomials), as in `jobs`.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

__all__ = ["library"]


def library(name: str) -> ModuleType:
    """A library, or NotImplementedError if it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        text = f"{name} is not installed: python -m pip install '.[bench]'"
        raise NotImplementedError(text) from None
