"""Kinematics of linkages: screws, loops, and motions as power series.

Twists are ``[ω; v]`` with v the velocity of the body point at the origin; all quantities are
in the inertial frame, in SI units.

- ``load``: read a linkage, close its loops and choose its coordinates
- ``compile``: compile all kernels of the packages that are imported, ahead of their use
- ``from_screws``: build a linkage from the screws of its joints
- ``ScrewJoint``: a joint of such a linkage, in its tree or of a loop
- ``from_dh``: build a serial linkage from Denavit-Hartenberg parameters
- ``from_pinocchio``: build a linkage from a Pinocchio model
- ``gallery``: list the paths of the linkages of the package, by name
- ``tool``: make the coordinates of a tool the inputs of a linkage
- ``taylor_motion``: compute the Taylor expansion of the closed motion
- ``taylor_motion_many``: compute the expansions about many poses at once
- ``Linkage``: a linkage at its reference pose, with loops closed and coordinates chosen
- ``Joint``: one degree of freedom between two links
- ``Body``: a rigid body with inertial parameters
- ``Loop``: a weld that closes a loop
- ``Motion``: linear relations between the inputs
- ``TaylorMotion``: the closed motion as a polynomial
- ``ManyTaylorMotions``: the closed motion as a polynomial about each of many poses
- ``Notice``: a remark for the user
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from kinematics.numerics.compiled.background import compile, register_warm_up

if TYPE_CHECKING:
    from kinematics.closure.assembly.tool_frame import tool
    from kinematics.closure.taylor.many_poses import ManyTaylorMotions, taylor_motion_many
    from kinematics.closure.taylor.taylor_motion import TaylorMotion, taylor_motion
    from kinematics.loading.building.dh_rows import from_dh
    from kinematics.loading.building.from_pinocchio import from_pinocchio
    from kinematics.loading.building.screw_joints import ScrewJoint, from_screws
    from kinematics.loading.model_gallery import gallery, load
    from kinematics.model.linkage import Body, Joint, Linkage, Loop, Notice
    from kinematics.model.motion import Motion

__all__ = [
    "Body",
    "Joint",
    "Linkage",
    "Loop",
    "ManyTaylorMotions",
    "Motion",
    "Notice",
    "ScrewJoint",
    "TaylorMotion",
    "compile",
    "from_dh",
    "from_pinocchio",
    "from_screws",
    "gallery",
    "load",
    "taylor_motion",
    "taylor_motion_many",
    "tool",
]

_HOMES = {
    **dict.fromkeys(["Body", "Joint", "Linkage", "Loop", "Notice"], "model.linkage"),
    **dict.fromkeys(["ScrewJoint", "from_screws"], "loading.building.screw_joints"),
    **dict.fromkeys(["gallery", "load"], "loading.model_gallery"),
    **dict.fromkeys(["TaylorMotion", "taylor_motion"], "closure.taylor.taylor_motion"),
    **dict.fromkeys(["ManyTaylorMotions", "taylor_motion_many"], "closure.taylor.many_poses"),
    "Motion": "model.motion",
    "__version__": "version",
    "from_dh": "loading.building.dh_rows",
    "from_pinocchio": "loading.building.from_pinocchio",
    "tool": "closure.assembly.tool_frame",
}


def __getattr__(name: str) -> object:
    """Import a public name at its first use: reading an invalid file needs no kernels."""
    from importlib import import_module

    if name in _HOMES:
        value = getattr(import_module(f"kinematics.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'kinematics' has no attribute '{name}'")


def __dir__() -> list[str]:
    """List the public names, for help and for completion, imported or not."""
    return sorted({*globals(), *_HOMES})


def _warm_up() -> Iterator[None]:
    """Run all kernels of this package, step by step."""
    from kinematics.loading.warmup import warm_up_kinematics

    yield from warm_up_kinematics()


register_warm_up("kinematics", _warm_up)
