"""The momentum matrix over a grid of poses: where a robot is quiet, and in which direction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import MOMENTUM_NULL
from balance.motion.pose.momentum_kernels import fill_cells, pose_workspace
from balance.motion.pose.momentum_of_masses import MassedChain
from balance.motion.pose.null_space import (
    Components,
    check_components,
    momentum_rows,
)
from kinematics.closure.joint_positions import check_inputs, solve_joint_positions
from kinematics.errors import PoseError, UnreachedError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.wording import repr_lines

# Cells of the grid tried as the first one, nearest to the reference pose first.
FIRST_CELLS = 50
# Cells that are filled between two calls of `progress`.
CELLS_PER_CALL = 4000


@dataclass(frozen=True, eq=False)
class MomentumMap:
    """The momentum matrix over a grid of input positions.

    Cells that cannot be reached from the reference pose through the grid hold NaN.

    Attributes:
        linkage: the linkage.
        axes: positions along each axis of the grid, by name of the input, rad or m.
        components: what counts: ``"both"``, ``"moment"`` or ``"force"``.
        positions: of all joints (…, n), rad and m; … is the shape of the grid.
        matrix: momentum per unit rate (…, 6, mobility), ``[ξ; p]`` about the inertial origin,
            SI units.
        singular_values: (…, mobility), falling; unit as in `ReactionNullSpace`.
        directions: input rates as columns (…, mobility, mobility), in the order of the singular
            values, rad/s and m/s; the last has the least momentum.
        scale: size of the momenta of the bodies (…,), same unit as the singular values.
    """

    linkage: Linkage
    axes: Mapping[str, Array]
    components: Components
    positions: Array
    matrix: Array
    singular_values: Array
    directions: Array
    scale: Array

    @property
    def smallest(self) -> Array:
        """Smallest singular value (…,): momentum of the quietest rate of size 1."""
        return self.singular_values[..., -1]

    @property
    def quietest(self) -> Array:
        """Input rates of size 1 with the least momentum (…, mobility), rad/s and m/s."""
        return self.directions[..., -1]

    @property
    def shaking(self) -> tuple[Array, Array]:
        """Sizes of moment and force impulse per unit rate of each input, (…, mobility) each."""
        moment, force = (self.matrix[..., rows, :] for rows in (slice(0, 3), slice(3, 6)))
        return np.linalg.norm(moment, axis=-2), np.linalg.norm(force, axis=-2)

    @cached_property
    def dimension(self) -> IntArray:
        """Number of independent rates without momentum (…,); -1 where nothing is reached."""
        null = self.singular_values <= MOMENTUM_NULL * self.scale[..., None]
        return np.where(self.reached, null.sum(axis=-1), -1)

    @property
    def reached(self) -> Flags:
        """Whether each cell is reached (…,)."""
        return np.isfinite(self.scale)

    def __repr__(self) -> str:
        """Two lines: the grid, and the least and largest smallest singular value."""
        shape = " × ".join(f"{values.size} {name}" for name, values in self.axes.items())
        sizes = self.smallest[self.reached] / self.scale[self.reached]
        return repr_lines(
            f"MomentumMap of {self.linkage.name}: {shape}, {sizes.size} poses reached",
            f"smallest singular value {sizes.min():.2g} to {sizes.max():.2g} of the momenta of "
            "the bodies",
        )


def momentum_map(
    linkage: LinkageLike,
    grid: Mapping[str, ArrayLike],
    components: Components = "both",
    *,
    z: ArrayLike | None = None,
    about: ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> MomentumMap:
    """Compute the momentum matrix, and its singular values, over a grid of poses.

    Poses are found from the reference pose outwards, from cell to neighbouring cell, so that
    they stay on its branch; cells behind a singularity are reached around it, or not at all.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        grid: positions of inputs by name, each a rising or falling sequence, rad or m from the
            reference pose; inputs that are not named stay at 0.
        components: ``"both"``; or ``"moment"`` or ``"force"`` alone.
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.
        about: point of the moment for ``"moment"`` (3,), metres; by default the inertial
            origin.
        progress: called with the number of poses done and the number of all.

    Returns:
        Matrices, singular values and directions, cell by cell.

    Raises:
        PoseError: a name is not that of an input, a sequence does not rise or fall, or no cell
            can be reached.
        UsageError: there are no such components.
        LinkageError: the number of parameters is wrong.

    Source:
        D. N. Nenchev, Mechanical Sciences 4, 2013; J. J. de Jong, PhD thesis, University of
        Twente, Fig. 3.6.

    Example:
        >>> import balance
        >>> balance.pose.momentum_map("robot.urdf", {"u1": [-0.1, 0.0, 0.1]}).smallest.shape
        (3,)
    """
    check_components(components)
    linkage = as_linkage(linkage)
    model = MassedChain.of(linkage, z)
    axes = _axes(linkage, grid)
    shape = tuple(values.size for values in axes.values())
    q, M, magnitudes = _fill(model, axes, progress)
    point = None if about is None else np.asarray(about, dtype=np.float64).reshape(3)
    rows = momentum_rows(M, model.chain, components, point)
    sizes = momentum_rows(magnitudes, model.chain, components, point, sums=True)
    values, directions = _decompose(rows)
    units = model.chain.units[linkage.positions_of(linkage.inputs)]
    return MomentumMap(
        linkage,
        axes,
        components,
        *(
            freeze(cells.reshape(*shape, *cells.shape[1:]))
            for cells in (
                q * model.chain.units,
                model.to_si(M),
                values,
                units[:, None] * directions,
                np.linalg.norm(sizes, axis=(1, 2)),
            )
        ),
    )


def _axes(linkage: Linkage, grid: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Check the axes of the grid; in the order given."""
    axes = {name: freeze(np.atleast_1d(values)) for name, values in grid.items()}
    for name, values in axes.items():
        check_inputs(linkage, [name])
        steps = np.diff(values)
        one_way = values.ndim == 1 and values.size and (np.all(steps > 0) or np.all(steps < 0))
        if not one_way or not np.isfinite(values).all():
            raise PoseError(
                f"{linkage.source}: positions of {name} must be finite and rise or fall"
            )
    if not axes:
        raise PoseError(f"{linkage.source}: give positions of inputs {linkage.inputs}")
    return axes


def _fill(
    model: MassedChain, axes: Mapping[str, Array], progress: Callable[[int, int], None] | None
) -> tuple[Array, Array, Array]:
    """Find the poses of all cells, and the momenta there; NaN where there is none."""
    linkage, chain = model.linkage, model.chain
    shape = np.array([values.size for values in axes.values()])
    strides = np.append(np.cumprod(shape[:0:-1])[::-1], 1)
    cells = int(shape.prod())
    points = np.zeros((cells, chain.width))
    scale = chain.units[linkage.positions_of(linkage.inputs)]
    for name, values in zip(axes, np.meshgrid(*axes.values(), indexing="ij"), strict=True):
        w = linkage.inputs.index(name)
        points[:, w] = values.ravel() / scale[w]
    q = np.full((cells, chain.parent.size), np.nan)
    seen, queue, ends = (np.zeros(size, np.int64) for size in (cells, cells, 2))
    first, q_first = _first_cell(model, points)
    q[first], seen[first], queue[0], ends[1] = q_first, 1, first, 1
    M, magnitudes = np.full((2, cells, 6, chain.width), np.nan)
    n = chain.parent.size
    workspace = pose_workspace(chain), np.empty((2, n)), np.empty(chain.width)
    while ends[0] < ends[1]:
        fill_cells(
            chain.walked,
            chain.links,
            model.z,
            (points, shape, strides),
            (q, seen, queue, ends),
            (M, magnitudes),
            CELLS_PER_CALL,
            workspace,
        )
        if progress is not None:
            progress(int(ends[0]), cells)
    return q, M, magnitudes


def _first_cell(model: MassedChain, points: Array) -> tuple[int, Array]:
    """Find the cell nearest to the reference pose that is reached from it along a line."""
    linkage = model.linkage
    for cell in np.argsort(np.einsum("cw,cw->c", points, points), kind="stable")[:FIRST_CELLS]:
        goal = zip(linkage.inputs, points[cell], strict=True)
        try:
            return int(cell), solve_joint_positions(
                model.chain, points[cell], linkage.source, goal
            )
        except UnreachedError:
            continue
    raise PoseError(
        f"{linkage.source}: no pose of the grid is reached from the reference pose; give "
        "positions nearer to it"
    )


def _decompose(rows: Array) -> tuple[Array, Array]:
    """Compute singular values (cells, width), padded by 0, and directions as columns."""
    cells, count, width = rows.shape
    values, directions = np.full((cells, width), np.nan), np.full((cells, width, width), np.nan)
    reached = np.isfinite(rows).all(axis=(1, 2))
    # All directions are needed, also where there are fewer components than inputs.
    _, sizes, V = np.linalg.svd(rows[reached], full_matrices=count < width)
    padded = np.zeros((len(sizes), width))
    padded[:, : sizes.shape[1]] = sizes
    values[reached], directions[reached] = padded, np.swapaxes(V, 1, 2)
    return values, directions
