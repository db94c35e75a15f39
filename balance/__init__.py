"""Dynamic balance of linkages: which mass distributions do not shake the base.

Parameters of a body are ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the
inertial origin; momentum is ``[moment; force]``; SI units.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from kinematics.compilation import register

if TYPE_CHECKING:
    from balance.archive import SpaceRecord, load_space
    from balance.bodies import BodyInertia
    from balance.designs.certificate import CertificateCheck, check_certificate
    from balance.designs.feasibility import DesignCheck, Feasibility, check_design, feasible
    from balance.designs.optimum import Design, design
    from balance.exact.proof import Proof
    from balance.exact.ranks import Exact, exact_ranks
    from balance.inertia import mass_properties, parameters, pseudo_inertia, violations
    from balance.meaning.explain import Explanation
    from balance.meaning.freedoms import Freedom
    from balance.meaning.multipole import Primitive
    from balance.momentum import momentum_regressor
    from balance.motions.momentum import MomentumTaylor, momentum_taylor
    from balance.screw_lines import (
        Meeting,
        ScrewLine,
        common_normal,
        meeting,
        momentum_lines,
        momentum_wrenches,
        screw_figure,
    )
    from balance.spaces.certainty import Certainty
    from balance.spaces.certification import certify
    from balance.spaces.designspace import design_space
    from balance.spaces.geometries import ManySpaces, design_space_many
    from balance.spaces.space import DesignSpace
    from balance.transfers.partition import Transfer
    from balance.verification.loads import shaking
    from balance.verification.trajectory import Trajectory
    from balance.verification.twin import verify
    from balance.verification.verdict import Verification

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
    "ManySpaces",
    "Meeting",
    "MomentumTaylor",
    "Primitive",
    "Proof",
    "ScrewLine",
    "SpaceRecord",
    "Trajectory",
    "Transfer",
    "Verification",
    "certify",
    "check_certificate",
    "check_design",
    "common_normal",
    "design",
    "design_space",
    "design_space_many",
    "exact_ranks",
    "feasible",
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
    "verify",
    "violations",
]

_HOMES = {
    "BodyInertia": "bodies",
    "Certainty": "spaces.certainty",
    "CertificateCheck": "designs.certificate",
    "Design": "designs.optimum",
    "DesignCheck": "designs.feasibility",
    "DesignSpace": "spaces.space",
    "Exact": "exact.ranks",
    "Explanation": "meaning.explain",
    "Feasibility": "designs.feasibility",
    "Freedom": "meaning.freedoms",
    "ManySpaces": "spaces.geometries",
    "Meeting": "screw_lines",
    "MomentumTaylor": "motions.momentum",
    "Primitive": "meaning.multipole",
    "Proof": "exact.proof",
    "ScrewLine": "screw_lines",
    "SpaceRecord": "archive",
    "Trajectory": "verification.trajectory",
    "Transfer": "transfers.partition",
    "Verification": "verification.verdict",
    "certify": "spaces.certification",
    "common_normal": "screw_lines",
    "check_certificate": "designs.certificate",
    "check_design": "designs.feasibility",
    "design": "designs.optimum",
    "design_space": "spaces.designspace",
    "design_space_many": "spaces.geometries",
    "exact_ranks": "exact.ranks",
    "feasible": "designs.feasibility",
    "load_space": "archive",
    "mass_properties": "inertia",
    "meeting": "screw_lines",
    "momentum_lines": "screw_lines",
    "momentum_regressor": "momentum",
    "momentum_taylor": "motions.momentum",
    "momentum_wrenches": "screw_lines",
    "parameters": "inertia",
    "pseudo_inertia": "inertia",
    "screw_figure": "screw_lines",
    "shaking": "verification.loads",
    "verify": "verification.twin",
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


def _stages() -> Iterator[None]:
    """Run all kernels of this package and of `kinematics`, stage by stage."""
    from balance.warmup import stages

    yield from stages()


register("balance.warmup", _stages)
