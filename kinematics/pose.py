"""Finite poses: joint positions that close the loops, reached from the reference pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics import closure
from kinematics.assembly import radius
from kinematics.chain import arrange, flatten, lock, move
from kinematics.errors import PoseError
from kinematics.linkage import Chain, Frame, Linkage, frozen, names

__all__ = ["joint_positions", "si_chain"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Loops that are open by more, in radians and characteristic lengths, are not closed.
OPEN = 1e-8
STEPS = 500


def joint_positions(linkage: Linkage, q: ArrayLike | Mapping[str, float]) -> Array:
    """Positions of all joints, in the order of ``linkage.joints``; SI units, (n,).

    Args:
        linkage: an assembled linkage.
        q: displacements from the reference pose: of all joints (n,), which must close the
            loops; or of the inputs alone (mobility,), or by name, inputs that are not
            named staying at 0: the other joints then follow along the straight line of
            input displacements, without a change of branch.

    Raises:
        PoseError: the joints do not close the loops, or the loops cannot be closed.
    """
    all_names = names(linkage.joints)
    if isinstance(q, Mapping):
        unknown = [name for name in q if name not in linkage.inputs]
        if unknown:
            raise PoseError(
                f"{linkage.source}: joint {unknown[0]} is not an input; "
                f"the inputs are {', '.join(linkage.inputs)}"
            )
        q = [q.get(name, 0.0) for name in linkage.inputs]
    values = np.asarray(q, dtype=np.float64)
    if values.shape == (len(all_names),):
        return _checked(linkage, values)
    if values.shape != (linkage.mobility,):
        raise PoseError(
            f"{linkage.source}: got {values.size} joint positions; "
            f"give {len(all_names)} (all joints) or {linkage.mobility} (the inputs)"
        )
    return _followed(linkage, values)


def si_chain(linkage: Linkage, spatial: bool) -> Chain:
    """All joints as a chain in SI units about the inertial origin, planar unless ``spatial``.

    The axes of a planar chain are those of the plane.
    """
    chain = move(arrange(linkage, Frame()), _independent(linkage), np.eye(linkage.mobility))
    if spatial or not linkage.planar:
        return chain
    moving = lock(chain, np.isin(names(linkage.joints), linkage.idle))
    return flatten(moving, linkage.chain.frame.R[2])


def _independent(linkage: Linkage) -> IntArray:
    """Indices of the inputs."""
    at = {name: j for j, name in enumerate(names(linkage.joints))}
    return np.array([at[name] for name in linkage.inputs], dtype=np.int64)


def _checked(linkage: Linkage, q: Array) -> Array:
    """The given positions, if they close the loops."""
    chain = arrange(linkage)
    error = closure.forward(chain, q / chain.units).error
    if not error <= OPEN:
        raise PoseError(
            f"{linkage.source}: these joint positions leave the loops open by {error:.2g} "
            "(radians and characteristic lengths); give the inputs alone to have them closed"
        )
    return q


def _followed(linkage: Linkage, u: Array) -> Array:
    """Positions reached along the straight line from the reference pose to ``u``.

    At each step the linkage is expanded anew; the sum of the series, within half the
    estimated radius of convergence, is the first guess of Newton's method.
    """
    reference = move(arrange(linkage), _independent(linkage), np.eye(linkage.mobility))
    ray = u / reference.units[_independent(linkage)]
    q, here, done = np.zeros(len(linkage.joints)), reference, 0.0
    for _ in range(STEPS):
        if done >= 1.0:
            return q * reference.units
        rates = closure.expand(here, ray[None], 6).C[0] @ ray
        step = min(1.0 - done, 0.5 * radius(rates))
        powers = step ** np.arange(1, 8) / np.arange(1, 8)
        guess = q + powers @ rates
        pose = closure.close(reference, guess)
        if pose.error > 1e-10 or np.abs(pose.q - guess).max() > 0.1 * np.abs(guess - q).max():
            break
        q, done = pose.q, done + step
        here = replace(reference, screws=frozen(pose.screws))
    raise PoseError(
        f"{linkage.source}: the loops cannot be closed beyond {done:.0%} of the way to the inputs "
        f"{', '.join(f'{n}={v:.4g}' for n, v in zip(linkage.inputs, u, strict=True))}"
    )
