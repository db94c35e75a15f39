"""What a linkage does to its base: shaking, reactions, paths, links that bend.

Names for users, beside those of `balance` itself:

- ``shaking``: shaking force and moment along a motion
- ``holding_torques``: what inputs hold at rest against gravity
- ``shaking_tolerance``: worst case and spread of shaking of a linkage made within tolerances
- ``ShakingTolerance``: result of ``shaking_tolerance``
- ``verify_against``: verify a linkage and another one along the same motions
- ``VerificationComparison``: result of ``verify_against``
- ``Trajectory``: a motion sampled in time
- ``one_turn``: the motion of one turn of a crank at constant speed
- ``from_csv``: the motion of a table of the inputs over time
- ``from_tool_csv``: the motion that moves a link along a table of its path
- ``rest_to_rest``: the motion that rests at given poses
- ``FloatingBase``: a base with mass, inertia and springs
- ``simulate_floating_base``: simulate the motion of the base that a linkage causes
- ``FloatingBaseMotion``: result of ``simulate_floating_base``
- ``ReactionlessPath``: one path, and the momentum along it
- ``timed_path``: a motion along a path, from rest to rest
- ``inertia_chart``: reactionless paths for several moments of inertia of a link
- ``InertiaChart``: result of ``inertia_chart``
- ``moments_through_poses``: moments of inertia with which a path passes through poses
- ``PathMoments``: result of ``moments_through_poses``
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
