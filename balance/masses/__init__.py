"""Which masses can be built: designs, counterweights, remedies.

Names for users, beside those of `balance` itself:

- ``Region``: a convex region of a link frame in which matter may be added
- ``parts_of``: counterweights of limited density as closed solids
- ``part_files``: files of these parts: meshes, outlines of plates and a table
- ``ElasticFrame``: a frame on springs and dampers that carries a linkage
- ``least_violation``: matter within a budget that leaves least of several requirements unmet
- ``LeastViolation``: what is left of each, and which costs most
- ``carrying``: a linkage with a payload that is not in its file
- ``read_payload``: a payload from its text
- ``Payload``: a load, or a range of loads, at a point of a link
- ``movable_weights``: weights that balance every load of a range by moving with it
- ``MovableWeights``: result of ``movable_weights``
- ``MovableWeight``: a weight that moves, and from where to where
- ``feasible``: whether a space holds a distribution that can be built
- ``Feasibility``: the verdict on a space
- ``buildable_masses``: masses that can be built, from chosen pure inertias
- ``BuildableMasses``: these masses, or why there are none
- ``pure_inertia``: move all point masses of a planar linkage, until it has inertias alone
- ``PureInertia``: pure inertias, masses moved, relations of angular velocities
- ``fewest_rotors``: the smallest sets of counter-rotations with which masses balance
- ``FewestRotors``: result of ``fewest_rotors``
- ``RotorSet``: one of the smallest sets
- ``exciting_motion``: a motion that excites the parameters on which balance depends
- ``ExcitingMotion``: result of ``exciting_motion``
- ``AppliedRemedy``: one remedy, its verdict and its cost
- ``ModeAnswer``: a mode of motion, and which masses balance the linkage on it
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
