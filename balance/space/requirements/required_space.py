"""Distributions that satisfy several requirements: a design space that is an intersection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Conditions
from balance.space.requirements.region_conditions import CommonData, RegionConditions
from balance.space.spaces.certainty import Certainty
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.space_data import RequirementRank
from balance.space.transfers.serial_part import serial_transfers
from kinematics.model.linkage import Notice, names_of
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, first_names, html_facts, repr_lines


@dataclass(frozen=True, eq=False)
class RequiredSpace(CertifiedSpace):
    """Mass distributions that satisfy all of several requirements.

    The serial part is what inertia transfers span that satisfy each of them; ``balance`` is
    ``"force"`` where masses and first moments alone count. ``orders`` is empty: each
    requirement has orders and poses of its own.

    Attributes:
        common: what all requirements share.
        regions: the conditions of each, in canonical order.
    """

    common: CommonData = field(kw_only=True, repr=False)
    regions: tuple[RegionConditions, ...] = field(kw_only=True, repr=False)

    def __repr__(self) -> str:
        """Up to six lines: the space, the requirements, the certainty."""
        return repr_lines(
            f"RequiredSpace of {self.linkage.name}",
            self.parts,
            "; ".join(self.texts),
            f"bodies {first_names(self.bodies)}",
            self.assurance,
            f"as given: {self.as_given.verdict}",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"RequiredSpace of {self.linkage.name}",
            ("parameters", self.parts),
            ("requirements", "; ".join(self.texts)),
            ("bodies", first_names(self.bodies)),
            ("certainty", self.assurance),
            ("as given", self.as_given.verdict),
        )

    @cached_property
    def requirements(self) -> tuple[RequirementRank, ...]:
        """Rank of each requirement alone, and what it adds to the others."""
        known = self.decision.conditions.known
        ranks = []
        for k, region in enumerate(self.regions):
            others = self.regions[:k] + self.regions[k + 1 :]
            without = _stack_conditions(self.common, others, known).rank
            ranks.append(
                RequirementRank(region.requirement.text, len(region.rows), self.rank - without)
            )
        return tuple(ranks)

    @property
    def texts(self) -> tuple[str, ...]:
        """The requirements as text."""
        return tuple(region.requirement.text for region in self.regions)

    @property
    def aim(self) -> str:
        """What is asked for, in words."""
        return count_noun(len(self.regions), "requirement")

    @property
    def parts(self) -> str:
        """Rank, nullity and the two parts of the space, in words."""
        algebra = "planar" if self.planar else "spatial"
        return (
            f"rank {self.rank} of {count_noun(len(self.basis), algebra + ' parameter')}, "
            f"{self.aim}, nullity {self.nullity} = {self.parts_text}"
        )

    @property
    def parts_text(self) -> str:
        """The two parts of the space, in words."""
        more = self.nullity - self.serial_nullity
        return f"{count_noun(self.serial_nullity, 'transfer')} + {more} more"

    def check_proved(self) -> None:
        """Nothing to check: the level is never ``"proved"``."""

    def to_dict(self) -> dict[str, object]:
        """Convert the report to plain data, with its requirements; see `DesignSpace`."""
        return super().to_dict() | {"gravity": [float(x) for x in self.common.gravity]}


def _stack_conditions(
    common: CommonData, regions: Sequence[RegionConditions], known: Array
) -> Conditions:
    """Stack the conditions of regions, each as large as the others, beside known solutions.

    Args:
        common: what the requirements share.
        regions: the conditions of each.
        known: rows of parameters that satisfy all of them.
    """
    blocks = [np.empty((0, common.parameters))]
    blocks += [
        region.rows / np.linalg.norm(region.rows, 2) for region in regions if len(region.rows)
    ]
    conditions = Conditions.given(known, relative_tolerance(common.chain))
    return conditions.append(np.concatenate(blocks))


def _common_transfers(common: CommonData, regions: Sequence[RegionConditions]) -> Array:
    """Compute rows that span the inertia transfers that satisfy each of several regions.

    Args:
        common: what the requirements share.
        regions: the conditions of each.
    """
    first, *others = (region.serial for region in regions)
    if all(rows.shape == first.shape and np.array_equal(rows, first) for rows in others):
        return first
    tolerance = relative_tolerance(common.chain)
    none = Conditions.given(np.empty((0, common.parameters)), tolerance)
    outside = [none.append(region.serial).decide().basis.T for region in regions]
    return none.append(np.concatenate(outside)).decide().basis.T


def space_of(
    common: CommonData,
    regions: Sequence[RegionConditions],
    notices: Sequence[Notice] = (),
    rank: int | None = None,
) -> DesignSpace:
    """Intersect the spaces of several requirements, by one rank decision.

    Args:
        common: what the requirements share.
        regions: the conditions of each, in canonical order.
        notices: remarks.
        rank: the rank by exact arithmetic: pivots beyond it are round-off.
    """
    linkage, chain = common.linkage, common.chain
    known = _common_transfers(common, regions)
    conditions = _stack_conditions(common, regions, known).first(rank)
    moving = set(chain.joints.tolist())
    return DesignSpace(
        source=linkage.source,
        linkage=linkage,
        motion=None,
        balance="force" if common.masses else "dynamic",
        planar=common.planar,
        bodies=names_of(linkage.bodies),
        inputs=linkage.inputs,
        idle=tuple(x.name for j, x in enumerate(linkage.joints) if j not in moving),
        orders=(),
        poses=sum(region.poses for region in regions),
        settled=all(region.settled for region in regions),
        serial_nullity=len(conditions.known),
        axes=chain.frame.R,
        frames=linkage.frames,
        length=chain.frame.length,
        notices=(*linkage.notices, *notices),
        highest_order=None,
        decision=conditions.decide(),
        chain=chain,
        chain_transfers=serial_transfers(chain, common.masses, relative_tolerance(chain)),
    )


def with_requirements(
    space: DesignSpace,
    certainty: Certainty,
    common: CommonData,
    regions: Sequence[RegionConditions],
) -> RequiredSpace:
    """Attach the requirements and a certainty to their intersection."""
    values = {item.name: getattr(space, item.name) for item in fields(DesignSpace) if item.init}
    return RequiredSpace(**values, certainty=certainty, common=common, regions=tuple(regions))
