"""Design spaces of many geometries of one topology, for sweeps and searches.

One compiled loop per core places the joints, finds the transfers, expands the motion and
decides the rank, as `balance.design_space` does for one linkage. Planar linkages of one input
lie side by side in the lanes of vectors (`balance.space.many.lane_kernels`), others follow one
after the other. Geometries that no loop settles are passed to that function: those that are
singular or nearly so, or close only within round-off.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from math import comb
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from balance.space.conditions.collect import collect_conditions
from balance.space.conditions.order_kernels import generic_directions
from balance.space.inertial_parameters.conversions import from_chain, to_chain
from balance.space.many.lane_kernels import lane_sweep
from balance.space.many.lane_workspace import lane_sweep_workspace
from balance.space.many.many_geometries_kernels import (
    planar_sweep,
    spatial_sweep,
    sweep_workspace,
)
from balance.space.many.placing_kernels import find_wrong_screw, place_geometry, points_on_axes
from balance.space.momentum.regressor import parameters_per_body, rows_per_column
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace, square_doubt
from balance.space.transfers.lane_transfers import lane_transfers
from balance.space.transfers.rigid_parts import number_rigid_parts
from balance.space.transfers.serial_part import serial_transfers
from balance.support.options import Balance
from balance.support.tolerances import SWEEP_PIVOT_CLEAR
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Frame, freeze, read_only
from kinematics.model.chain import centres_of_mass
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.simd import round_up_to_vectors
from kinematics.numerics.linalg.skyline_qr import COUNT, ROWS
from kinematics.wording import count_noun, first_names, repr_lines

# Integers, smallest pivots and bases of geometries.
Results = tuple[IntArray, Array, Array]

# Number of geometries in a task of one thread: at least, and at most; threads wait for one
# another between short calls of kernels.
CHUNK_SIZE = 512
LARGE_CHUNK_SIZE = 8192
# Large sweeps have a multiple of so many tasks: as many for each of 2, 3, 4, 6, 8 … threads.
TASKS = 24


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


def design_space_many(
    linkage: LinkageLike,
    geometries: ArrayLike,
    balance: Balance = "dynamic",
    *,
    spatial: bool = False,
    bases: bool = False,
    workers: int | None = None,
) -> ManySpaces:
    """Compute the design spaces of one topology in many geometries, on all cores.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts: its joints, loops,
            bodies and inputs are those of all.
        geometries: joint screws (count, joints, 6) at the reference pose, with closed loops:
            ``[n; r × n + λ n]`` or ``[0; n]``, in the inertial frame, SI units.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        spatial: count all ten parameters per body, even if the linkage is planar.
        bases: whether to return bases of the spaces too.
        workers: threads to use; one per core by default.

    Returns:
        Integers and, if requested, bases, geometry by geometry; see `ManySpaces`.

    Raises:
        LinkageError: a screw is not of the kind of its joint.
        ValueError: an option has no such value, or the array no such shape.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 5.

    Example:
        >>> import balance, kinematics
        >>> linkage = kinematics.load("robot.urdf")
        >>> screws = [joint.screw for joint in linkage.joints]
        >>> balance.space.design_space_many(linkage, [screws, screws]).rank
        array([8, 8])
    """
    linkage = as_linkage(linkage)
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    screws = _read_screws(linkage, geometries)
    spatial = spatial or not linkage.planar
    sweep = _Sweep(linkage, screws, balance == "force", spatial, bases)
    starts = range(0, len(screws), sweep.chunk_size)
    if workers == 1:
        list(map(sweep.solve_chunk, starts))
    else:
        with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
            list(pool.map(sweep.solve_chunk, starts))
    refused, unsure = {}, {}
    for number in sorted(sweep.unsettled):
        try:
            doubts = sweep.solve_alone(number)
        except LinkageError as error:
            refused[number] = str(error)
        else:
            if doubts:
                unsure[number] = "; ".join(doubts)
    for number in sorted(sweep.thin):
        if doubts := sweep.thin_doubts(number):
            unsure[number] = "; ".join(doubts)
    return sweep.result(refused, unsure)


def _chunk_size(count: int) -> int:
    """Choose the number of geometries in a task, of full lanes, whatever the threads."""
    tasks = TASKS * max(1, -(-count // (TASKS * LARGE_CHUNK_SIZE)))
    return round_up_to_vectors(max(CHUNK_SIZE, -(-count // tasks)))


def _read_screws(linkage: Linkage, geometries: ArrayLike) -> Array:
    """Convert joint screws to a read-only array (count, joints, 6), metres.

    Raises:
        ValueError: the array has another shape.
    """
    screws = read_only(np.ascontiguousarray(geometries, dtype=np.float64))
    if screws.ndim != 3 or screws.shape[1:] != (len(linkage.joints), 6):
        raise ValueError(f"geometries must have the shape (count, {len(linkage.joints)}, 6)")
    return screws


class _Sweep:
    """A sweep of many geometries, whose results are filled in chunk by chunk."""

    def __init__(
        self, linkage: Linkage, screws: Array, force: bool, spatial: bool, bases: bool
    ) -> None:
        """Allocate the results."""
        self.chunk_size = _chunk_size(len(screws))
        self.linkage, self.screws, self.force, self.spatial = linkage, screws, force, spatial
        self.chain = chain = linkage.spatial_chain if spatial else linkage.chain
        self.rows_per_column = rows_per_column(chain.planar, force)
        self.parameters_per_body = parameters_per_body(chain.planar, force)
        count, unknowns = len(screws), self.parameters_per_body * chain.links.size
        # Numbers of those that no loop settles, and of others with a small pivot.
        self.unsettled: list[int] = []
        self.thin: list[int] = []
        # Filled by the threads, as are the others: pages of memory are first used there.
        self.answers = np.empty((count, 4), np.int64)
        self.kept = np.zeros(count)
        self.bases = np.zeros((count if bases else 0, unknowns, unknowns))
        self.origins, self.lengths = np.zeros((count, 3)), np.empty(count)
        kinds = np.array([joint.kind for joint in linkage.joints])
        self.sliding, self.helical = kinds == "prismatic", kinds == "helical"
        self.near_points = np.array([joint.point for joint in linkage.joints])
        self.centres = centres_of_mass(linkage.bodies)
        transfers = serial_transfers(chain, force)
        self.rigid_transfers = transfers.rows[transfers.owner < 0]
        # Lanes are for planar linkages of one input whose loops can determine the others.
        in_lanes = chain.planar and chain.width == 1
        in_lanes = in_lanes and chain.envelope[COUNT, ROWS] >= chain.dependent.size
        self.listed = lane_transfers(chain, force) if in_lanes else None
        # Rays that a linkage without transfers needs, and eight times as many.
        self.fewest_rays = min(
            comb(chain.width + 1, 2), 1 - (-unknowns // (chain.width * self.rows_per_column))
        )
        self.rays = generic_directions(0, 8 * self.fewest_rays, chain.width)

    def place(self, part: slice) -> tuple[Array, Array, Array]:
        """Write joint screws and mimic relations of a part in the frame of each geometry.

        Returns:
            Both, and the relative size of round-off of each geometry.
        """
        chain, count = self.chain, part.stop - part.start
        screws = np.empty((count, *chain.screws.shape))
        mimics = np.empty((count, *chain.mimics.shape))
        tolerances = np.empty(count)
        relations = chain.mimics / chain.units
        pivots = np.argmax(relations != 0.0, axis=1)
        place_geometry(
            self.screws[part],
            self.near_points,
            self.centres,
            chain.frame.R,
            pivots,
            relations,
            screws,
            mimics,
            self.origins[part],
            self.lengths[part],
            tolerances,
        )
        screws.flags.writeable = mimics.flags.writeable = False
        return screws, mimics, tolerances

    def check_screws(self, part: slice) -> None:
        """Check that joint screws are of the kinds of their joints.

        Raises:
            LinkageError: one is not.
        """
        wrong = int(find_wrong_screw(self.screws[part], self.sliding, self.helical))
        if wrong >= 0:
            number, j = divmod(wrong, len(self.linkage.joints))
            joint = self.linkage.joints[j]
            raise LinkageError(
                f"{self.linkage.source}: joint '{joint.name}': its screw in geometry "
                f"{part.start + number} is not that of a {joint.kind} joint; see Joint.screw"
            )

    def solve_chunk(self, start: int) -> None:
        """Check a chunk, and compute its geometries that `solve_alone` need not compute.

        Raises:
            LinkageError: a screw is not of the kind of its joint.
        """
        part = slice(start, min(start + self.chunk_size, len(self.screws)))
        self.check_screws(part)
        self.answers[part], self.lengths[part] = -1, 1.0
        ranks, kept = self.answers[part, 0], self.kept[part]
        if not self.linkage.idle:
            geometries = *self.place(part), self.lengths[part]
            results = self.answers[part], kept, self.bases[part]
            if self.listed is not None:
                self._solve_in_lanes(self.listed, geometries, results)
            if (ranks < 0).any():
                self._solve_in_turn(geometries, results)
        thin = (kept < SWEEP_PIVOT_CLEAR) & (ranks >= 0)
        self.unsettled.extend((start + np.flatnonzero(ranks < 0)).tolist())
        self.thin.extend((start + np.flatnonzero(thin)).tolist())

    def _solve_in_lanes(
        self, listed: IntArray, geometries: tuple[Array, ...], results: Results
    ) -> None:
        """Compute those geometries of a chunk that agree with others of it in every rank."""
        chain, size = self.chain, self.parameters_per_body
        shape = len(listed) + len(self.rigid_transfers), self.rows_per_column, size
        workspace = chain.borrow(("lanes", *shape), lambda: lane_sweep_workspace(chain, *shape))
        lane_sweep(
            (chain.walked, chain.links, listed, self.rigid_transfers),
            geometries,
            size,
            results,
            np.empty(len(results[0]), np.int64),
            workspace,
        )
        chain.give_back(("lanes", *shape), workspace)

    def _solve_in_turn(self, geometries: tuple[Array, ...], results: Results) -> None:
        """Compute the geometries of a chunk that have no answer yet, one after the other."""
        chain = self.chain
        shape = (
            len(self.rays),
            len(self.rigid_transfers),
            self.rows_per_column,
            self.parameters_per_body,
        )
        sweep = planar_sweep if chain.planar else spatial_sweep
        workspaces = chain.borrow(shape, lambda: sweep_workspace(chain, *shape))
        sweep(
            (
                chain.walked,
                chain.once(number_rigid_parts),
                chain.links,
                self.rigid_transfers,
                self.rays,
            ),
            geometries,
            (self.fewest_rays, self.rows_per_column, self.parameters_per_body),
            results,
            workspaces,
        )
        chain.give_back(shape, workspaces)

    def thin_doubts(self, number: int) -> tuple[str, ...]:
        """Say why the integers of a geometry with a small pivot may be wrong, if they may.

        The singular values are those that `design_space` finds of the same linkage.
        """
        screws, mimics, tolerances = self.place(slice(number, number + 1))
        chain = replace(self.chain, screws=screws[0])
        if mimics.size:
            chain = replace(chain, mimics=mimics[0])
        tolerance = float(tolerances[0])
        transfers = serial_transfers(chain, self.force, tolerance)
        collected = collect_conditions(chain, transfers.rows, self.force, tolerance, None)
        return square_doubt(collected.conditions.decide().kept)

    def solve_alone(self, number: int) -> tuple[str, ...]:
        """Compute one geometry by `design_space`.

        Returns:
            Reasons why its integers may be wrong, a line each.

        Raises:
            LinkageError: it cannot be assembled.
        """
        points, linkage = np.empty_like(self.near_points), self.linkage
        points_on_axes(self.screws[number], self.near_points, points)
        joints = tuple(
            replace(joint, screw=freeze(screw), point=freeze(point))
            for joint, screw, point in zip(
                linkage.joints, self.screws[number], points, strict=True
            )
        )
        moved = assemble(replace(linkage, joints=joints), linkage.inputs)
        if not self.spatial and not moved.planar:
            raise LinkageError(
                f"{linkage.source}: geometry {number} leaves the plane; ask for spatial "
                "parameters"
            )
        balance: Balance = "force" if self.force else "dynamic"
        space = design_space(moved, None, balance, spatial=self.spatial and moved.planar)
        frame = space.chain.frame
        self.origins[number], self.lengths[number] = frame.origin, frame.length
        kmax = -1 if space.kmax is None else space.kmax
        self.answers[number] = space.rank, space.nullity, space.serial_nullity, kmax
        self.kept[number] = space.kept
        if len(self.bases):
            self.bases[number, : space.nullity] = _move_back(space, linkage)
        unsettled = () if space.settled else ("not all conditions were found",)
        return (*unsettled, *space.doubts)

    def result(self, refused: dict[int, str], unsure: dict[int, str]) -> ManySpaces:
        """Collect the results, read-only."""
        rank, nullity, serial, kmax = (read_only(column) for column in self.answers.T)
        return ManySpaces(
            rank,
            nullity,
            serial,
            kmax,
            read_only(self.kept),
            MappingProxyType(refused),
            MappingProxyType(unsure),
            read_only(self.bases),
            read_only(self.origins),
            read_only(self.lengths),
            self.chain.frame.R,
            self.chain.planar,
            self.force,
        )


def _move_back(space: DesignSpace, linkage: Linkage) -> Array:
    """Move the basis of a space back to the pose of a linkage.

    Assembly leaves a singular pose along the motion, so the space is that of another pose.
    Its parameters are displaced back with their bodies.

    Returns:
        Orthonormal rows in the frame of the space.
    """
    away = space.frames @ np.linalg.inv(linkage.frames)
    if np.abs(away - np.eye(4)).max(initial=0.0) == 0.0:
        return space.scaled_basis.T
    force = space.balance == "force"
    # Of the ten parameters only those that count matter: no displacement that keeps the plane
    # maps the others to them.
    lift = np.linalg.pinv(to_chain(np.eye(10), Frame(space.axes), space.planar, force))
    z = space.basis.T.reshape(space.nullity, -1, len(lift)) @ lift
    here = displace_parameters(z, np.linalg.inv(away))
    scaled = to_chain(here.reshape(-1, 10), space.chain.frame, space.planar, force)
    Q, _ = np.linalg.qr(scaled.reshape(space.nullity, -1).T)
    return np.asarray(Q.T)
