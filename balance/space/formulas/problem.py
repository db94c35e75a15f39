"""What formulas ask of a linkage, in the plane or in space: its dimensions, and samples."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from itertools import islice

import numpy as np

from balance.space.conditions.order_kernels import generic_directions
from balance.space.formulas.assembly_order import assembly_order
from balance.space.formulas.geometry_samples import ConditionSamples, GeometrySamples
from balance.space.formulas.modular_conditions import ConditionSource
from balance.space.formulas.planar_parts import PlanarParts, planar_parts
from balance.space.formulas.relations import (
    DimensionRelation,
    FreeDimensions,
    parse_relations,
    relations_in,
)
from balance.space.formulas.spatial_dimensions import (
    BennettLoop,
    SpatialDimensions,
    bennett_loop,
    parse_spatial_relations,
    spatial_relations,
)
from balance.space.formulas.spatial_parts import SpatialParts, spatial_parts
from balance.space.formulas.spatial_samples import SpatialSamples
from balance.space.spaces.design_space import DesignSpace
from kinematics.closure.continuation import continue_in_directions
from kinematics.closure.newton import expand_at
from kinematics.errors import ExactError
from kinematics.model.chain import rigid_parts

# Poses of the file at which links are compared, and rates that are alike for unit rates.
TURN_POSES, TURNS_ALIKE = 8, 1e-9

Parts = PlanarParts | SpatialParts
Dimensions = FreeDimensions | SpatialDimensions


class Problem(ABC):
    """The formulas of one linkage.

    Attributes:
        parts: rigid parts, joints and dimensions.
        target: rank of the conditions of the linkage.
        force: whether forces alone are balanced.
    """

    parts: Parts

    def __init__(self, space: DesignSpace, force: bool) -> None:
        """Keep what the conditions are of."""
        self.target, self.force = space.rank, force

    @abstractmethod
    def parse(self, texts: Sequence[str]) -> list[DimensionRelation]:
        """Parse the relations of ``--where``."""

    @abstractmethod
    def relations(self) -> list[DimensionRelation]:
        """Find relations that the dimensions of the file have."""

    @abstractmethod
    def free(self, relations: Sequence[DimensionRelation]) -> Dimensions:
        """Find the dimensions that relations leave free."""

    @abstractmethod
    def samples(
        self, relations: Sequence[DimensionRelation], deadline: float | None
    ) -> ConditionSamples:
        """Prepare geometries under relations.

        Raises:
            UnclosedError: their conditions have another rank than those of the linkage.
        """

    def choose_motion(self) -> bool:
        """Count only motions in which links turn alike as in the file; tell whether it can."""
        return False

    def given_relations(self) -> list[DimensionRelation]:
        """Find relations without which the linkage does not move."""
        return []


class PlanarProblem(Problem):
    """The formulas of a planar linkage."""

    def __init__(self, space: DesignSpace, force: bool) -> None:
        """Name the dimensions, and find an order of assembly.

        Raises:
            ExactError: the linkage has joints, or an order, that formulas do not know.
        """
        super().__init__(space, force)
        self.parts: PlanarParts = planar_parts(space)
        order = assembly_order(self.parts)
        if order is None:
            raise ExactError(
                f"{space.source}: its links cannot be placed two at a time: formulas need dyads"
            )
        self.source = ConditionSource(self.parts, *order, force)
        self._chain = space.chain

    def choose_motion(self) -> bool:
        """Find by finite poses of the file which directions turn alike.

        A parallelogram and an antiparallelogram have the same dimensions: in one of them the
        coupler turns as the ground does.
        """
        chain, of_part = self._chain, self.source.index.of_part
        part_of = rigid_parts(len(chain.parent), chain.ends).tolist()
        ray = generic_directions(0, 1, chain.width)
        poses = islice(continue_in_directions(chain, ray), TURN_POSES)
        rates = np.array([expand_at(*each).T[0, 0][..., 0] for each in poses])
        if not len(rates):
            return False
        kinds = [np.zeros_like(rates[:, 0])] * (self.source.index.turning + 1)
        for link, part in enumerate(part_of[: len(chain.parent)]):
            kinds[of_part[part]] = rates[:, link]
        self.source.alike = [
            next(k for k, kind in enumerate(kinds) if np.abs(kind - each).max() < TURNS_ALIKE)
            for each in kinds
        ]
        return True

    def parse(self, texts: Sequence[str]) -> list[DimensionRelation]:
        """Parse the relations of ``--where``."""
        return parse_relations(self.parts, texts)

    def relations(self) -> list[DimensionRelation]:
        """Find equal distances, and equal points in frames of links."""
        return relations_in(self.parts)

    def free(self, relations: Sequence[DimensionRelation]) -> FreeDimensions:
        """Find the dimensions that relations leave free."""
        return FreeDimensions(self.parts, relations, cartesian=not self.force)

    def samples(
        self, relations: Sequence[DimensionRelation], deadline: float | None
    ) -> GeometrySamples:
        """Prepare geometries whose loops close."""
        return GeometrySamples(self.source, self.free(relations), self.target, deadline)


class SpatialProblem(Problem):
    """The formulas of a spatial linkage: an open chain, or a single loop."""

    def __init__(self, space: DesignSpace, force: bool) -> None:
        """Name the dimensions.

        Raises:
            ExactError: the linkage is neither, or has joints that formulas do not know.
        """
        super().__init__(space, force)
        self.parts: SpatialParts = spatial_parts(space)

    @cached_property
    def _bennett(self) -> tuple[BennettLoop, list[DimensionRelation]] | None:
        return bennett_loop(self.parts)

    def given_relations(self) -> list[DimensionRelation]:
        """Find the equalities of a Bennett linkage."""
        return [] if self._bennett is None else self._bennett[1]

    def parse(self, texts: Sequence[str]) -> list[DimensionRelation]:
        """Parse the relations of ``--where``."""
        return parse_spatial_relations(self.parts, texts)

    def relations(self) -> list[DimensionRelation]:
        """Find equal lengths, offsets and angles."""
        return spatial_relations(self.parts)

    def free(self, relations: Sequence[DimensionRelation]) -> SpatialDimensions:
        """Find the dimensions that relations leave free."""
        loop = None if self._bennett is None else self._bennett[0]
        return SpatialDimensions(self.parts, relations, loop)

    def samples(
        self, relations: Sequence[DimensionRelation], deadline: float | None
    ) -> SpatialSamples:
        """Prepare geometries whose loops the ground closes."""
        free = self.free(relations)
        return SpatialSamples(self.parts, free, self.force, self.target, deadline)


def problem_of(space: DesignSpace, force: bool) -> Problem:
    """Make the problem of a design space.

    Raises:
        ExactError: formulas do not cover the linkage.
    """
    return (PlanarProblem if space.chain.planar else SpatialProblem)(space, force)
