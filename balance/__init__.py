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
    from balance.certificate import CertificateCheck, check_certificate
    from balance.design import Design
    from balance.designspace import design_space
    from balance.exact.proof import Proof
    from balance.exact.ranks import Exact, exact_ranks
    from balance.feasible import DesignCheck, Feasibility, check_design
    from balance.inertia import mass_properties, parameters, pseudo_inertia, violations
    from balance.loads import shaking
    from balance.meaning.explain import Explanation
    from balance.meaning.freedoms import Freedom
    from balance.meaning.multipole import Primitive
    from balance.mixed import MomentumTaylor, momentum_taylor
    from balance.momentum import momentum_regressor
    from balance.partition import Transfer
    from balance.screw_lines import (
        Meeting,
        ScrewLine,
        common_normal,
        meeting,
        momentum_lines,
        momentum_wrenches,
        screw_figure,
    )
    from balance.space import DesignSpace
    from balance.trajectory import Trajectory
    from balance.verdict import Verification

__all__ = [
    "BodyInertia",
    "Certainty",
    "CertificateCheck",
    "Design",
    "DesignCheck",
    "DesignSpace",
    "Exact",
    "Explanation",
    "Feasibility",
    "Freedom",
    "Meeting",
    "MomentumTaylor",
    "Primitive",
    "Proof",
    "ScrewLine",
    "SpaceRecord",
    "Trajectory",
    "Transfer",
    "Verification",
    "check_certificate",
    "check_design",
    "common_normal",
    "design_space",
    "exact_ranks",
    "load_space",
    "mass_properties",
    "meeting",
    "momentum_lines",
    "momentum_regressor",
    "momentum_taylor",
    "momentum_wrenches",
    "parameters",
    "pseudo_inertia",
    "screw_figure",
    "shaking",
    "violations",
]

_HOMES = {
    "BodyInertia": "bodies",
    "Certainty": "certainty",
    "CertificateCheck": "certificate",
    "Design": "design",
    "DesignCheck": "feasible",
    "DesignSpace": "space",
    "Exact": "exact.ranks",
    "Explanation": "meaning.explain",
    "Feasibility": "feasible",
    "Freedom": "meaning.freedoms",
    "Meeting": "screw_lines",
    "MomentumTaylor": "mixed",
    "Primitive": "meaning.multipole",
    "Proof": "exact.proof",
    "ScrewLine": "screw_lines",
    "SpaceRecord": "archive",
    "Trajectory": "trajectory",
    "Transfer": "partition",
    "Verification": "verdict",
    "common_normal": "screw_lines",
    "check_certificate": "certificate",
    "check_design": "feasible",
    "design_space": "designspace",
    "exact_ranks": "exact.ranks",
    "load_space": "archive",
    "mass_properties": "inertia",
    "meeting": "screw_lines",
    "momentum_lines": "screw_lines",
    "momentum_regressor": "momentum",
    "momentum_taylor": "mixed",
    "momentum_wrenches": "screw_lines",
    "parameters": "inertia",
    "pseudo_inertia": "inertia",
    "screw_figure": "screw_lines",
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
