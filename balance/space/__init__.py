"""Which masses balance a linkage: conditions, design spaces, proofs, explanations.

Names for users, beside those of `balance` itself:

- ``design_space_many``: spaces of one topology in many geometries, on all cores
- ``ManySpaces``: results of ``design_space_many``, geometry by geometry
- ``distance_to_rank_drop``: smallest change of geometry that lowers the rank
- ``save_space``: write a space to a file
- ``load_space``: read a space that was saved
- ``SpaceRecord``: a space as data, without the linkage it came from
- ``Freedom``: one way to change the masses that leaves the linkage balanced
- ``Transfer``: inertial parameters that bodies can exchange across one joint
- ``decoupling``: balanced distributions that keep the inertia on the base constant
- ``Decoupling``: the space of these distributions, and whether the masses of the file are in it
- ``locked_inertia``: inertia of the linkage on its base at a pose, joints locked
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
