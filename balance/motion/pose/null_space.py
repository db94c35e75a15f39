"""Velocities without reaction: the null space of the momentum matrix in a pose.

A robot whose input rates lie in the null space of ``M_B`` moves without momentum. In general
the matrix has full column rank, and only rest is without reaction; with fewer rows than
columns, or in a balanced pose, it has not. (D. N. Nenchev, Reaction null space of a multibody
system with applications in robotics, Mechanical Sciences 4, 2013; J. J. de Jong, PhD thesis,
University of Twente, Eq. 3.51.)

Whole momentum is measured in N s: moments about the middle of the mechanism are divided by its
characteristic length; rates of sliding inputs count in such lengths. The null space does not
depend on these two.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import MOMENTUM_NULL
from balance.motion.pose.momentum_of_masses import MassedChain
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain, freeze
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.pivoted_qr import round_off
from kinematics.wording import repr_lines, vector_text

Components = Literal["both", "moment", "force"]


@dataclass(frozen=True, eq=False)
class ReactionNullSpace:
    """Input rates without momentum in a pose.

    Attributes:
        inputs: names of the inputs.
        components: what vanishes: ``"both"``, ``"moment"`` or ``"force"``.
        q: positions of all joints (n,), rad and m.
        matrix: momentum matrix (6, mobility), ``[ξ; p]`` about the inertial origin, SI units.
        singular_values: of the components (mobility,), falling, zero where there are fewer
            components than inputs; N s, for the moment alone N m s, per rad/s or per
            characteristic length per second.
        scale: size of the momenta of the bodies that add up to the matrix, same unit.
        basis: rates as columns (mobility, dimension), rad/s and m/s; orthonormal where sliding
            rates count in characteristic lengths.
        directions: all input rates as columns (mobility, mobility), in the order of the
            singular values; the last are the basis.
    """

    inputs: tuple[str, ...]
    components: Components
    q: Array
    matrix: Array
    singular_values: Array
    scale: float
    basis: Array
    directions: Array

    @property
    def dimension(self) -> int:
        """Number of independent rates without momentum."""
        return self.basis.shape[1]

    def __repr__(self) -> str:
        """Two lines: dimension, and singular values over the momenta of the bodies."""
        what = {"both": "momentum", "moment": "angular momentum", "force": "linear momentum"}
        share = self.singular_values / (self.scale or 1.0)
        return repr_lines(
            f"ReactionNullSpace: {self.dimension} of {len(self.inputs)} rates without "
            f"{what[self.components]}",
            f"singular values {vector_text(share)} of the momenta of the bodies",
        )


def momentum_rows(
    M: Array, chain: Chain, components: Components, about: Array | None, sums: bool = False
) -> Array:
    """Select the components of momentum matrices that count, in a unit of their own.

    Args:
        M: matrices of the chain (..., 6, width); see `MassedChain.momenta`.
        components: ``"both"``, ``"moment"`` or ``"force"``.
        about: point of the moment (3,), metres, inertial frame; for ``"both"`` it is the middle
            of the mechanism.
        sums: whether the entries are sums of sizes, which add up about another point too.

    Returns:
        Shape (..., 6 or 3, width): N s for unit rates, for ``"moment"`` N m s.
    """
    L = chain.frame.length
    if components != "moment":
        return L * (M if components == "both" else M[..., 3:, :])
    arm = ((np.zeros(3) if about is None else about) - chain.frame.origin) / L
    # moment about another point: ξ - arm × p
    shift = np.abs(skew(arm)) if sums else -skew(arm)
    return np.asarray(L**2 * (M[..., :3, :] + shift @ M[..., 3:, :]))


def _null_space_at(
    model: MassedChain,
    q: Array,
    components: Components = "both",
    about: Array | None = None,
    tolerance: float = MOMENTUM_NULL,
) -> ReactionNullSpace:
    """Compute the null space at joint positions that are known to close the loops.

    Args:
        model: the linkage with its masses, prepared.
        q: positions of all joints (n,), in units of the chain.
        components: see `reaction_null_space`.
        about: see `reaction_null_space`.
        tolerance: see `reaction_null_space`.
    """
    chain, linkage = model.chain, model.linkage
    M, magnitudes = (matrices[0] for matrices in model.momenta(q[None]))
    rows = momentum_rows(M, chain, components, about)
    scale = float(
        np.linalg.norm(momentum_rows(magnitudes, chain, components, about, sums=True))
    )
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    values = np.zeros(chain.width)
    values[: sizes.size] = sizes
    least = max(tolerance, round_off(chain.frame.origin, chain.frame.length))
    rank = int(np.count_nonzero(values > least * scale))
    units = chain.units[linkage.positions_of(linkage.inputs)]
    directions = units[:, None] * directions.T
    return ReactionNullSpace(
        linkage.inputs,
        components,
        freeze(q * chain.units),
        freeze(model.to_si(M)),
        freeze(values),
        scale,
        freeze(directions[:, rank:]),
        freeze(directions),
    )


def reaction_null_space(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    components: Components = "both",
    *,
    z: ArrayLike | None = None,
    about: ArrayLike | None = None,
    tolerance: float = MOMENTUM_NULL,
) -> ReactionNullSpace:
    """Compute the input rates that leave the base of a linkage at rest in a pose.

    They are the null space of the momentum matrix, ``M_B(q) u̇ = 0``. A base that floats then
    stays at rest, too.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of the inputs or of all joints; see
            `kinematics.closure.joint_positions.joint_positions`; radians and metres.
        components: ``"both"``; or ``"moment"`` or ``"force"`` alone.
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.
        about: point of the moment for ``"moment"`` (3,), metres, in the inertial frame; by
            default the inertial origin. Where there is linear momentum, the moment depends
            on it.
        tolerance: singular values up to this part of the momenta of the bodies are zero.

    Returns:
        The rates, and the singular values that decide their number.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
        UsageError: there are no such components.
        LinkageError: the number of parameters is wrong.

    Source:
        D. N. Nenchev, Mechanical Sciences 4, 2013; J. J. de Jong, PhD thesis, University of
        Twente, Eq. 3.51.

    Example:
        >>> import balance
        >>> balance.pose.reaction_null_space("robot.urdf", {"u1": 0.1}).dimension
        0
    """
    check_components(components)
    linkage = as_linkage(linkage)
    model = MassedChain.of(linkage, z)
    positions = joint_positions(linkage, q) / model.chain.units
    point = None if about is None else np.asarray(about, dtype=np.float64).reshape(3)
    return _null_space_at(model, positions, components, point, tolerance)


def check_components(components: str) -> None:
    """Raise UsageError for components that do not exist."""
    if components not in get_args(Components):
        choices = ", ".join(get_args(Components))
        raise UsageError(f"there are no components '{components}'; they are {choices}")
