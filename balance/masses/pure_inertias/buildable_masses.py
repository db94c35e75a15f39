"""Masses that can be built, from chosen pure inertias of a planar linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from balance.masses.designs.design_check import check_design
from balance.masses.designs.feasibility import Feasibility, Verdict, feasible
from balance.masses.pure_inertias.pure_inertia import inertia_conditions
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.inertial_parameters.multipole import rod
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.subspace import subspace
from balance.support.tolerances import PURE_INERTIA_CONDITION
from kinematics.errors import BodyError, UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out
from kinematics.wording import repr_lines

# Most doublings of the masses that can be moved freely.
MAX_DOUBLINGS = 60


@dataclass(frozen=True, eq=False)
class BuildableMasses:
    """Masses with chosen pure inertias, or why there are none.

    Attributes:
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        z: parameters (bodies, 10) of bodies that can be built, about the inertial origin, SI
            units; None unless feasible.
        words: the verdict in one line.
        answer: the result of `balance.masses.feasible` on all masses with these pure inertias
            or multiples of them, with its certificate.
    """

    verdict: Verdict
    z: Array | None
    words: str
    answer: Feasibility = field(repr=False)

    def __repr__(self) -> str:
        """One line: the verdict."""
        return repr_lines(f"BuildableMasses: {self.words}")


def buildable_masses(
    space: DesignSpace | LinkageLike, inertias: Mapping[str, float] | Sequence[float]
) -> BuildableMasses:
    """Find masses that can be built and have the momentum of chosen pure inertias.

    Point masses at revolute joints, positive on one link and negative on the other, make
    bodies with mass of the pure inertias: ``z = (0, 0, g) + Σ a_j T_j`` with the inertia
    transfers T of all joints.

    Args:
        space: a design space of a planar linkage for dynamic balance, or the linkage, its path
            or its name.
        inertias: pure inertia of each body, kg m², in the order of the bodies or by name; a
            body without a name has none. They may be negative.

    Returns:
        Masses with the largest margin, or the certificate that there are none.

    Raises:
        BodyError: a name is unknown.
        UsageError: the pure inertias are not balanced, or the space is another.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 6.2 and 6.3.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> balance.masses.buildable_masses(space, {"crank": 0.0}).verdict
        'infeasible'
    """
    space = as_space(space)
    g = _checked_inertias(space, inertias)
    _, conditions = inertia_conditions(space)
    misfit = conditions @ g
    if np.abs(misfit).max(initial=0.0) > PURE_INERTIA_CONDITION * np.abs(g).max(initial=1e-300):
        raise UsageError(
            "these inertias are not balanced: see the conditions of balance.masses.pure_inertia"
        )
    serial, z = space.scaled_basis[:, : space.serial_nullity], _in_space(space, g)
    pure = to_chain(z, space.chain.frame, True, False).reshape(-1, 1)
    answer = feasible(subspace(space, serial, pure))
    if answer.z is None:
        return BuildableMasses(answer.verdict, None, answer.words, answer)
    parameters = to_chain(answer.z, space.chain.frame, True, False).reshape(-1)
    beyond, part = project_out(pure[:, 0], serial), project_out(parameters, serial)
    if np.linalg.norm(beyond) <= PURE_INERTIA_CONDITION * np.linalg.norm(pure):
        return BuildableMasses("feasible", answer.z, answer.words, answer)
    share = float(beyond @ part / (beyond @ beyond))
    if share > PURE_INERTIA_CONDITION * float(np.linalg.norm(part) / np.linalg.norm(beyond)):
        return BuildableMasses("feasible", freeze(answer.z / share), answer.words, answer)
    return _add_free_masses(space, z, feasible(subspace(space, serial, pure[:, :0])), answer)


def _checked_inertias(
    space: DesignSpace, inertias: Mapping[str, float] | Sequence[float]
) -> Array:
    """Return the pure inertias as an array (bodies,).

    Raises:
        BodyError: a name is unknown.
        UsageError: they are as many or of a size that cannot be.
    """
    if isinstance(inertias, Mapping):
        for name in inertias:
            if name not in space.bodies:
                raise BodyError(space.source, name, "carries no parameters", space.bodies)
        inertias = [inertias.get(name, 0.0) for name in space.bodies]
    g = np.array(inertias, dtype=np.float64)
    if g.shape != (len(space.bodies),) or not np.isfinite(g).all():
        raise UsageError(f"give {len(space.bodies)} finite pure inertias, one for each body")
    return g


def _in_space(space: DesignSpace, g: Array) -> Array:
    """Make parameters (bodies, 10) of pure inertias: equal rods along the axes of the plane."""
    x, y, _ = space.axes
    return np.outer(g, 0.5 * (rod(x) + rod(y)))


def _add_free_masses(
    space: DesignSpace, z: Array, free: Feasibility, answer: Feasibility
) -> BuildableMasses:
    """Add masses without pure inertias, if they can be built, until the bodies can be.

    Args:
        z: parameters (bodies, 10) of the pure inertias.
        free: the verdict on masses without pure inertias.
        answer: the verdict on those with multiples of them, of which one that is not positive
            was found.
    """
    if free.z is None:
        # A positive multiple, too, would leave a mixture of both, without pure inertias.
        text = f"{free.verdict}: only a negative multiple of these pure inertias can be built"
        return BuildableMasses(free.verdict, None, text, answer)
    size = float(np.abs(z).max() / np.abs(free.z).max())
    for k in range(MAX_DOUBLINGS):
        design = z + 2.0**k * size * free.z
        if check_design(space, design).accepted:
            return BuildableMasses("feasible", freeze(design), free.words, free)
    text = "undecided: the masses would be too large for double precision"
    return BuildableMasses("undecided", None, text, answer)
