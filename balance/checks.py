"""Checks of answers by another route: certificates, designs, exact arithmetic.

- ``check_certificate``: check a certificate without the solver
- ``check_design``: check a design without the solver
- ``CertificateCheck``: what the check of a certificate found
- ``DesignCheck``: what the check of a design found
- ``exact_ranks``: ranks of the conditions by order, as whole numbers without a tolerance
- ``ExactRanks``: ranks by exact arithmetic
- ``Proof``: lower bounds on rank and nullity that add up to the number of parameters
- ``Certainty``: certainty of the integers, by exact arithmetic and fresh poses
"""

from __future__ import annotations

from balance.masses.designs.certificate import CertificateCheck, check_certificate
from balance.masses.designs.design_check import DesignCheck, check_design
from balance.space.certification.exact_ranks import exact_ranks
from balance.space.exact.modular_ranks import ExactRanks
from balance.space.exact.proof import Proof
from balance.space.spaces.certainty import Certainty

__all__ = [
    "Certainty",
    "CertificateCheck",
    "DesignCheck",
    "ExactRanks",
    "Proof",
    "check_certificate",
    "check_design",
    "exact_ranks",
]
