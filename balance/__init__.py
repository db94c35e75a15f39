"""Dynamic balance of linkages: which mass distributions do not shake the base.

Parameters of a body are ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the
inertial origin; momentum is ``[moment; force]``; SI units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from balance.archive import SpaceRecord, load_space
    from balance.bodies import BodyInertia
    from balance.certainty import Certainty
    from balance.designspace import design_space
    from balance.exact.proof import Proof
    from balance.exact.ranks import Exact, exact_ranks
    from balance.inertia import mass_properties, parameters, pseudo_inertia, violations
    from balance.loads import shaking
    from balance.meaning.explain import Explanation
    from balance.meaning.freedoms import Freedom
    from balance.meaning.multipole import Primitive
    from balance.momentum import momentum_regressor
    from balance.partition import Transfer
    from balance.space import DesignSpace
    from balance.trajectory import Trajectory
    from balance.verdict import Verification

__all__ = [
    "BodyInertia",
    "Certainty",
    "DesignSpace",
    "Exact",
    "Explanation",
    "Freedom",
    "Primitive",
    "Proof",
    "SpaceRecord",
    "Trajectory",
    "Transfer",
    "Verification",
    "design_space",
    "exact_ranks",
    "load_space",
    "mass_properties",
    "momentum_regressor",
    "parameters",
    "pseudo_inertia",
    "shaking",
    "violations",
]

_HOMES = {
    "BodyInertia": "bodies",
    "Certainty": "certainty",
    "DesignSpace": "space",
    "Exact": "exact.ranks",
    "Explanation": "meaning.explain",
    "Freedom": "meaning.freedoms",
    "Primitive": "meaning.multipole",
    "Proof": "exact.proof",
    "SpaceRecord": "archive",
    "Trajectory": "trajectory",
    "Transfer": "partition",
    "Verification": "verdict",
    "design_space": "designspace",
    "exact_ranks": "exact.ranks",
    "load_space": "archive",
    "mass_properties": "inertia",
    "momentum_regressor": "momentum",
    "parameters": "inertia",
    "pseudo_inertia": "inertia",
    "shaking": "loads",
    "violations": "inertia",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used: the command line needs few of them."""
    from importlib import import_module

    if name in _HOMES:
        value = getattr(import_module(f"balance.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'balance' has no attribute '{name}'")
