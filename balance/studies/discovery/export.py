"""A member of a family as a linkage with balanced masses, confirmed by independent routes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from balance.masses.designs.best_design import Design, design
from balance.masses.designs.feasibility import feasible
from balance.masses.designs.write_urdf import replace_inertials
from balance.motion.verification.result import Verification
from balance.motion.verification.to_pinocchio import verify
from balance.space.certification.certify_space import certify
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.studies.discovery.confirm import random_members
from balance.studies.discovery.families import Family, relations_of
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.rational import rational_members
from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.to_linkage import to_linkage
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.numerics.linalg.ties import rank_least_first

# Members found by walks and random ones that are tried for masses, and rational ones next to
# those that can be built.
OWN, DRAWN, ROUNDED = 10, 150, 40
TRAJECTORIES = 5


@dataclass(frozen=True, eq=False)
class ExportedMember:
    """A member with masses.

    Attributes:
        urdf: its file.
        rational: whether its coordinates are rational, so that exact arithmetic applies.
        space: its design space, certified if it is rational.
        design: masses that balance it, or the reason why there are none.
        verification: of the file as written; None if it carries no masses.
    """

    urdf: bytes
    rational: bool
    space: DesignSpace
    design: Design
    verification: Verification | None


def export_member(job: DiscoveryJob, family: Family, seed: int = 1) -> ExportedMember:
    """Find a member that can be built, rational if possible, and give it balanced masses.

    Args:
        family: a family that it found.
        seed: of the random members.

    Raises:
        LinkageError: no member can be read as a linkage.
    """
    drawn = random_members(job.structure, family, DRAWN, np.random.default_rng([seed, 2]))
    ranks = rank_least_first([-member.margin for member in family.members], 1.0)
    geometries = [family.members[k].geometry for k in ranks[:OWN]]
    members = LaneGeometry(*(np.concatenate(a) for a in zip(*geometries, drawn, strict=True)))
    best = None
    for geometry, rational in _candidates(job, family, members):
        linkage, verdict = _judge(job, family, geometry)
        if linkage is None:
            continue
        if verdict == "feasible":
            best = linkage, rational
            break
        best = best or (linkage, rational)
    if best is None:
        raise LinkageError("no member of this family could be read as a linkage")
    return _with_masses(*best)


def _judge(
    job: DiscoveryJob, family: Family, geometry: LaneGeometry
) -> tuple[Linkage | None, str]:
    """Read a geometry as a linkage, and decide whether it can be built."""
    try:
        linkage = _reload(to_linkage(job.topology, job.structure, geometry))
        space = design_space(linkage)
        if space.nullity != family.nullity:
            return None, ""
        return linkage, str(feasible(space).verdict)
    except LinkageError:
        return None, ""


def _candidates(
    job: DiscoveryJob, family: Family, members: LaneGeometry
) -> Iterator[tuple[LaneGeometry, bool]]:
    """Yield rational members next to those that can be built, these, and any others."""
    good: list[LaneGeometry] = []
    other: list[LaneGeometry] = []
    for lane in range(len(members.points)):
        geometry = members.take(slice(lane, lane + 1))
        linkage, verdict = _judge(job, family, geometry)
        if linkage is not None:
            (good if verdict == "feasible" else other).append(geometry)
        if len(good) == 6:
            break
    chosen = good or other[:4]
    for geometry in chosen:
        held, independent = relations_of(job.topology, job.structure, geometry)[0]
        relations = [*independent, *(r for r in held if r not in independent)]
        rationals = rational_members(job.structure, family, geometry, [relations])
        for _, member in zip(range(ROUNDED), rationals, strict=False):
            points = member.geometry.points / member.scale
            yield member.geometry._replace(points=points), True
    yield from ((geometry, False) for geometry in chosen)


def _reload(linkage: Linkage) -> Linkage:
    """Write a linkage and read it again, so that its file can be edited."""
    return _read(linkage.to_urdf().encode())


def _read(urdf: bytes) -> Linkage:
    return load(Document("the member", urdf))


def _with_masses(linkage: Linkage, rational: bool) -> ExportedMember:
    """Design masses for a member, write them, and verify what was written."""
    space = design_space(linkage)
    if rational:
        space = certify(space)
    mass_design = design(space)
    if mass_design.z is None:
        return ExportedMember(linkage.to_urdf().encode(), rational, space, mass_design, None)
    inertials = {body.name: body.urdf for body in mass_design.bodies if body.urdf}
    urdf = replace_inertials(linkage, inertials)
    checked = verify(_read(urdf), trajectories=TRAJECTORIES)
    return ExportedMember(urdf, rational, space, mass_design, checked)
