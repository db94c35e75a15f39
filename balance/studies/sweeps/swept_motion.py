"""The motion of a quantity of a sweep: one turn of a crank, or from pose to pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.trajectory import Trajectory
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage

Options = Mapping[str, Any]

MOTION_OPTIONS = ("crank", "duration", "poses", "samples", "speed")
"""Names of the options that say what the motion is."""
# Samples of a motion between poses, and seconds of each of its lines, by default.
SAMPLES, DURATION = 200, 1.0
REMEDY = (
    'below a line such as [compute.shaking] write speed = "300rpm", or poses = [[0.0], [0.5]] '
    "in displacements of the inputs, and leave out the other"
)


def motion_of_options(
    linkage: Linkage, options: Options, turn_samples: int, *, explain: bool = True
) -> Trajectory:
    """Compute the motion of the options of a quantity.

    Args:
        options: with ``speed``, or with ``poses``.
        turn_samples: steps of a turn, by default.
        explain: as for `balance.motion.verification.crank_revolution.revolve_crank`.

    Raises:
        UsageError: both are given, or neither.
        LinkageError: the linkage cannot follow the motion.
    """
    if ("speed" in options) == ("poses" in options):
        raise UsageError(f"give either speed, of a crank in rad/s, or poses; {REMEDY}")
    if "speed" in options:
        steps = options.get("samples", turn_samples)
        speed, crank = options["speed"], options.get("crank")
        return revolve_crank(linkage, speed, crank, steps=steps, explain=explain)[0]
    return rest_to_rest(
        linkage,
        options["poses"],
        options.get("duration", DURATION),
        options.get("samples", SAMPLES),
    )
