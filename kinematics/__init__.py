"""Kinematics of linkages: screws, loops, and motions as power series.

Knows motion and nothing of mass. Twists are ``[ω; v]`` with v the velocity of the body
point at the origin; all quantities are in the inertial frame, in SI units.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from kinematics.compilation import compile, register

if TYPE_CHECKING:
    from kinematics.linkage import Body, Joint, Linkage, Loop, Notice
    from kinematics.models import gallery, load
    from kinematics.motion import Motion
    from kinematics.taylor import TaylorMotion, taylor_motion
    from kinematics.tools import tool

__all__ = [
    "Body",
    "Joint",
    "Linkage",
    "Loop",
    "Motion",
    "Notice",
    "TaylorMotion",
    "compile",
    "gallery",
    "load",
    "taylor_motion",
    "tool",
]

_HOMES = {
    **dict.fromkeys(["Body", "Joint", "Linkage", "Loop", "Notice"], "linkage"),
    **dict.fromkeys(["gallery", "load"], "models"),
    **dict.fromkeys(["TaylorMotion", "taylor_motion"], "taylor"),
    "Motion": "motion",
    "tool": "tools",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used: reading a bad file needs no kernels."""
    from importlib import import_module

    if name in _HOMES:
        value = getattr(import_module(f"kinematics.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'kinematics' has no attribute '{name}'")


def _stages() -> Iterator[None]:
    """Run all kernels of this package, stage by stage."""
    from kinematics.warmup import stages

    yield from stages()


register("kinematics.warmup", _stages)
