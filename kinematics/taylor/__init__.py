"""Taylor motions: the joints of a closed motion as polynomials in its inputs."""

from __future__ import annotations

from kinematics.taylor.motion import TaylorMotion, taylor_motion

__all__ = ["TaylorMotion", "taylor_motion"]
