"""Other libraries on the Taylor jobs, one module each; libraries not installed are left out.

Each module has functions named after jobs. For an order, they return a function that does the
job once, and one that converts its result to coefficients (joints, monomials), as in `jobs`.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType


def library(name: str) -> ModuleType:
    """Import a library; NotImplementedError if it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        text = f"{name} is not installed: python -m pip install '.[bench]'"
        raise NotImplementedError(text) from None
