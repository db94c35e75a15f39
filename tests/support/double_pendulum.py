"""A request for remedies of a double pendulum: two slender rods of 1 kg and 1 m."""

import numpy as np

from balance.masses.remedies.request import RemedyRequest
from kinematics import ScrewJoint, from_screws

# Most distance of counterweights from the hinges, metres.
REACH = 0.5


def pendulum(gear, radius):
    """A request for the double pendulum."""
    rod = np.diag([0.0, 1.0 / 12.0, 1.0 / 12.0])
    linkage = from_screws(
        [
            ScrewJoint("q1", "base", "upper"),
            ScrewJoint("q2", "upper", "lower", point=(1, 0, 0)),
        ],
        bodies={"upper": (1.0, (0.5, 0, 0), rod), "lower": (1.0, (1.5, 0, 0), rod)},
        inputs=["q1", "q2"],
    )
    ball = f"ball(0,0,0,{REACH})"
    regions = {"upper": ball, "lower": ball}
    return RemedyRequest(linkage, regions=regions, gear=gear, radius=radius)
