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

import lazy_loader

from kinematics.numerics.compiled.background import register_warm_up
from kinematics.version import __version__ as __version__

# The names are in the file __init__.pyi; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _warm_up() -> Iterator[None]:
    """Run all kernels of this package, step by step."""
    from kinematics.loading.warmup import warm_up_kinematics

    yield from warm_up_kinematics()


register_warm_up("kinematics", _warm_up)
