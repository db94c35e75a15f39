"""Options that several functions share."""

from __future__ import annotations

from typing import Literal, TypeAlias

__all__ = ["Balance"]

Balance: TypeAlias = Literal["dynamic", "force"]
"""``"dynamic"`` for all six components of the momentum, ``"force"`` for the linear ones."""
