"""Balance of a linkage in its reference pose: bodies on input joints solved from the others.

A rate of one input moves the body that its joint carries, and all that lies further out, but no
body nearer to the base. From the outermost input inwards, each of these *proximal* bodies is
therefore solved alone, in closed form, from the momentum of the others. In a linkage with loops
the inputs begin its legs. (J. J. de Jong, PhD thesis, University of Twente, section 3.2.)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.pose.body_family import BalancingFamily, balancing_family
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.space.inertial_parameters.body_inertia import BodyInertia, bodies_of_parameters
from balance.space.inertial_parameters.conversions import mass_properties
from balance.space.momentum.regressor import RegressorSeries
from kinematics.closure.joint_positions import si_chain
from kinematics.closure.series import expand
from kinematics.errors import BodyError, CoordinateError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import path
from kinematics.model.linkage import Linkage, names_of
from kinematics.numerics.array_types import Array
from kinematics.wording import repr_lines


@dataclass(frozen=True, eq=False)
class PoseBalance:
    """Bodies on the input joints of a linkage that balance it in its reference pose.

    Attributes:
        linkage: the linkage.
        families: all bodies that balance, by the name of the body, outermost first; the
            families of bodies further in belong to the choices made before.
        z: parameters of all bodies (bodies, 10) about the inertial origin, SI units; None if
            there is no such body, or its mass is given too small.
        residual: size of the momentum left over that of the bodies, for unit rates.
        words: the result in one line.
    """

    linkage: Linkage
    families: Mapping[str, BalancingFamily]
    z: Array | None
    residual: float
    words: str

    @property
    def bodies(self) -> tuple[BodyInertia, ...]:
        """Inertial parameters of all bodies in several frames; empty without a solution."""
        if self.z is None:
            return ()
        linkage, frame = self.linkage, self.linkage.spatial_chain.frame
        return bodies_of_parameters(
            names_of(linkage.bodies),
            self.z,
            linkage.frames,
            frame.R,
            frame.length,
            linkage.source,
        )

    def __repr__(self) -> str:
        """A line with the result, and one for each body that was solved."""
        return repr_lines(
            f"PoseBalance of {self.linkage.name}: {self.words}",
            *(
                f"{name}: {repr(family).splitlines()[-1].strip()}"
                for name, family in self.families.items()
            ),
        )


def balance_pose(
    linkage: LinkageLike,
    masses: Mapping[str, float] | None = None,
    z: ArrayLike | None = None,
) -> PoseBalance:
    """Solve the bodies on the input joints so that a linkage is balanced in its reference pose.

    No rates of the inputs then have momentum there, and no accelerations shake the base. Where
    the mass is free it is that of the file, or a given one; the centre of mass and the tensor
    follow, see `BalancingFamily.body`. All other bodies stay as they are.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts; its argument ``at``
            chooses the pose.
        masses: masses of bodies on input joints, kg, by name.
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.

    Returns:
        The parameters, and the family of each solved body.

    Raises:
        CoordinateError: an input joint carries no body of its own, or a joint that is no input
            lies between it and the base.
        BodyError: a mass is given to a body that is not on an input joint.
        LinkageError: the number of parameters is wrong.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eq. 3.17.

    Example:
        >>> import balance
        >>> balance.pose.balance_pose("robot.urdf").words
        'crank cannot balance: the moment of inertia about the axis would not be above 0'
    """
    linkage = as_linkage(linkage)
    chain = si_chain(linkage, spatial=True)
    proximal = _proximal_bodies(linkage, chain)
    names = names_of(linkage.bodies)
    wanted = dict(masses or {})
    _check_masses(linkage, wanted, [names[b] for _, b in proximal])
    parameters = mass_parameters(linkage, z)
    series = expand(chain, np.zeros((1, chain.width)), 0)
    rates = series.T[0, 0]
    X = RegressorSeries(chain, series).rows(0).reshape(chain.width, 6, -1, 10)
    families: dict[str, BalancingFamily] = {}
    for w, b in proximal:
        others = np.delete(np.arange(len(names)), b)
        momentum = -np.einsum("rbp,bp->r", X[w][:, others], parameters[others])
        family = balancing_family(rates[chain.links[b], w], momentum)
        families[names[b]] = family
        chosen, reason = _choose(family, parameters[b], wanted.get(names[b]))
        if chosen is None:
            words = f"{names[b]} cannot balance: {reason}"
            return PoseBalance(linkage, families, None, np.inf, words)
        parameters[b] = chosen
    words = f"balanced in the reference pose by {', '.join(families)}"
    residual = _residual(X, parameters, linkage.spatial_chain.frame.length)
    return PoseBalance(linkage, families, freeze(parameters), residual, words)


def _choose(
    family: BalancingFamily, file: Array, mass: float | None
) -> tuple[Array | None, str]:
    """Choose a body of a family, or say why there is none.

    Args:
        file: parameters of the body before (10,).
        mass: the mass wanted, kg, by default that of the file.
    """
    if family.reason:
        return None, family.reason
    if family.mass is not None:
        turns = family.twist_pitch != "infinite"
        return family.body(inertia=None if turns else mass_properties(file).inertia), ""
    mass = float(file[0]) if mass is None else mass
    if not mass > family.least_mass:
        return None, f"its mass must be above {family.least_mass:.6g} kg"
    return family.body(mass), ""


def _residual(X: Array, z: Array, length: float) -> float:
    """Compute the momentum for unit rates over that of the bodies, moments over the length."""
    momenta = np.einsum("wrbp,bp->wrb", X, z)
    momenta[:, :3] /= length
    size = float(np.abs(momenta).sum(axis=2).max())
    return float(np.abs(momenta.sum(axis=2)).max()) / (size or 1.0)


def _proximal_bodies(linkage: Linkage, chain: Chain) -> list[tuple[int, int]]:
    """List input columns and the bodies that their joints carry, outermost first."""
    joints = linkage.positions_of(linkage.inputs).tolist()
    carried = []
    for w, joint in enumerate(joints):
        behind = path(chain.parent, joint)
        passive = [linkage.joints[j].name for j in behind if j not in joints]
        bodies = np.flatnonzero(chain.links == joint)
        problem = ""
        if passive:
            problem = f"joint {passive[0]} lies between it and the base and is no input"
        elif bodies.size != 1:
            problem = f"{bodies.size} bodies with inertial parameters are on its link"
        if problem:
            valid = [base_joint.name for base_joint in linkage.joints if base_joint.parent < 0]
            raise CoordinateError(linkage.source, [linkage.inputs[w]], problem, valid)
        carried.append((len(behind), w, int(bodies[0])))
    return [(w, b) for _, w, b in sorted(carried, reverse=True)]


def _check_masses(linkage: Linkage, masses: Mapping[str, float], valid: list[str]) -> None:
    """Raise BodyError for masses of bodies that are not solved."""
    for name, mass in masses.items():
        if name not in valid:
            problem = "only the mass of a body on an input joint can be given"
            raise BodyError(linkage.source, name, problem, valid)
        if not (np.isfinite(mass) and mass > 0.0):
            raise BodyError(linkage.source, name, f"a mass of {mass:g} kg is not above 0")
