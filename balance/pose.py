"""Balance in one pose, and velocities without reaction.

- ``balance_pose``: bodies on input joints solved so that a linkage is balanced in a pose
- ``balancing_family``: all bodies that have a given momentum for a given twist
- ``planar_balancing_body``: the body of a planar linkage with a given momentum
- ``BalancingFamily``: result of ``balancing_family``
- ``PoseBalance``: result of ``balance_pose``
- ``momentum_matrix``: total momentum per unit rate of each input, for given masses
- ``momentum_map``: the momentum matrix over a grid of poses
- ``reaction_null_space``: input rates that leave the base at rest in a pose
- ``MomentumMap``: result of ``momentum_map``
- ``ReactionNullSpace``: result of ``reaction_null_space``
- ``momentum_margins``: how far principal moments are from those of a body that cannot be
- ``critical_moment``: the moment at which a balancing body becomes flat
- ``inertia_from_moments``: the inertia of a body from its principal moments and axes
"""

from __future__ import annotations

from balance.motion.pose.body_family import (
    BalancingFamily,
    balancing_family,
    planar_balancing_body,
)
from balance.motion.pose.momentum_of_masses import momentum_matrix
from balance.motion.pose.null_space import ReactionNullSpace, reaction_null_space
from balance.motion.pose.principal_moments import (
    critical_moment,
    inertia_from_moments,
    momentum_margins,
)
from balance.motion.pose.proximal_bodies import PoseBalance, balance_pose
from balance.motion.pose.workspace_map import MomentumMap, momentum_map

__all__ = [
    "BalancingFamily",
    "MomentumMap",
    "PoseBalance",
    "ReactionNullSpace",
    "balance_pose",
    "balancing_family",
    "critical_moment",
    "inertia_from_moments",
    "momentum_map",
    "momentum_margins",
    "momentum_matrix",
    "planar_balancing_body",
    "reaction_null_space",
]
