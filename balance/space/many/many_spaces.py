"""Results of `balance.space.many.many_geometries`, geometry by geometry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from balance.space.inertial_parameters.conversions import from_chain
from kinematics.model.arrays import Frame
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import count_noun, first_names, repr_lines


@dataclass(frozen=True, eq=False)
class ManySpaces:
    """Results of `design_space_many`, geometry by geometry.

    Attributes:
        rank: number of conditions (count,); -1 where the linkage cannot be assembled.
        nullity: dimension of the space (count,); -1 there.
        serial_nullity: of the part that joints explain (count,); -1 there.
        kmax: highest order that adds a condition (count,); -1 where no order reaches the
            rank, and there.
        kept: smallest pivot of the conditions, relative to the largest (count,).
        refused: why a linkage cannot be assembled, by number of the geometry.
        unsure: why integers of a geometry may be wrong, by its number: a decision is near
            round-off. `balance.certify` decides exactly, for a linkage from a file.
        bases: orthonormal bases in the units of the frames, as rows; those of a geometry are
            the first ``nullity`` (count, parameters, parameters), or (0, …).
        origins: middle of the mechanism (count, 3), metres.
        lengths: characteristic length (count,), metres.
        R: axes of the frames, the last of which is the normal of a planar linkage (3, 3).
        planar: whether bodies have four parameters, those of a plane.
        force: whether only linear momentum counts.
    """

    rank: IntArray
    nullity: IntArray
    serial_nullity: IntArray
    kmax: IntArray
    kept: Array
    refused: Mapping[int, str]
    unsure: Mapping[int, str]
    bases: Array = field(repr=False)
    origins: Array = field(repr=False)
    lengths: Array = field(repr=False)
    R: Array = field(repr=False)
    planar: bool
    force: bool

    def __repr__(self) -> str:
        """Two lines: how many geometries, refused and unsure ones, ranks."""
        algebra = "planar" if self.planar else "spatial"
        balance = "force" if self.force else "dynamic"
        ranks = sorted(set(self.rank[self.rank >= 0].tolist()))
        return repr_lines(
            f"ManySpaces: {count_noun(self.rank.size, 'geometry')}, {algebra}, "
            f"{balance} balance; "
            f"{len(self.refused)} refused, {len(self.unsure)} unsure",
            f"ranks {first_names([str(rank) for rank in ranks])}",
        )

    def basis(self, number: int) -> Array:
        """Compute the basis (parameters, nullity) of a geometry as `SpaceRecord.basis`."""
        frame = Frame(self.R, self.origins[number], float(self.lengths[number]))
        G = from_chain(frame, self.planar, self.force)
        rows = self.bases[number, : max(0, int(self.nullity[number]))]
        return (rows.reshape(-1, len(G)) @ G.T).reshape(rows.shape).T
