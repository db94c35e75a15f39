"""Inertia that inputs feel, of all clearly regular geometries of a sweep at once.

A geometry whose loop equations are clearly independent, and whose joints all clearly move, has
the mobility and the inputs of its model: it need not be assembled. With the joint rates
``q̇ = C u̇`` that close the loops, the inertia of an input is ``Σ_b t_wᵀ M_b t_w``. All others
are left to `balance.studies.sweeps.row_quantities.inertia`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from balance.masses.partial_balance.motion_loads import inertia_weights
from balance.studies.sweeps.closing import ClosedGeometries, Closer
from kinematics.model.arrays import Frame
from kinematics.model.chain import clusters, loop_signs, paths
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.tolerances import (
    CLEAR_MOTION_RELATIVE,
    COMPONENT_SIZE_RELATIVE,
    LOOP_RANK_OF_FILE,
    NEAR_SINGULAR_CONDITIONING,
)


def input_inertias(
    model: Linkage,
    closer: Closer,
    closed: ClosedGeometries,
    rows: IntArray,
    masses: Sequence[Mapping[str, Array]],
) -> tuple[Array, Flags]:
    """Compute the inertia that each input feels, at the poses that close the loops.

    Args:
        model: the linkage of the study.
        closed: its geometries.
        rows: numbers of those to compute (count,).
        masses: inertial parameters of the links of the file in each; see
            `balance.studies.sweeps.geometry.link_inertias`.

    Returns:
        Inertias (count, inputs), kg m² or kg; and which geometries are clearly regular
        (count,): the numbers of the others mean nothing.
    """
    chain, n = closer.chain, len(model.joints)
    whole = not model.idle and clusters(chain) == [list(range(n))]
    if not whole or not rows.size:
        return np.zeros((rows.size, len(model.inputs))), np.zeros(rows.size, dtype=np.bool_)
    screws = closer.screws_to_chain(closed.screws[rows])
    free, regular = _free_rates(closer, screws, 3 if model.planar else 6)
    regular &= _are_large(closed, rows)
    at_inputs = free[:, model.positions_of(model.inputs)]
    regular &= np.linalg.svd(at_inputs, compute_uv=False)[:, -1] > CLEAR_MOTION_RELATIVE
    at_inputs[~regular] = np.eye(len(model.inputs))
    rates = free @ np.linalg.inv(at_inputs)
    # Twists of the links of bodies by each input (count, bodies, inputs, 6).
    before = paths(chain.parent)[chain.links]
    by_input = rates.mT[:, None] * before[None, :, None]
    weights = inertia_weights(by_input @ screws[:, None])
    z = _body_parameters(model, chain.frame, closed, rows, masses)
    inertias = np.sum(np.sum(weights * z[:, :, None], axis=-1), axis=1)
    units = chain.units[model.positions_of(model.inputs)]
    return inertias * (chain.frame.length / units) ** 2, regular


def _free_rates(closer: Closer, screws: Array, dim: int) -> tuple[Array, Flags]:
    """Compute joint rates that close the loops (count, n, freedom), and which are clear.

    Args:
        screws: joint screws in the coordinates of the model's chain (count, n, 6).
        dim: equations of a loop, 3 in the plane.
    """
    chain, count = closer.chain, len(screws)
    rank = dim * len(chain.ends) + len(chain.mimics)
    if rank + chain.width != chain.parent.size:
        shape = count, chain.parent.size, chain.width
        return np.zeros(shape), np.zeros(count, dtype=np.bool_)
    signs = loop_signs(chain.parent, chain.ends)
    loops = (signs[None, :, None] * screws.mT[:, None]).reshape(count, -1, chain.parent.size)
    relations = np.broadcast_to(chain.mimics, (count, *chain.mimics.shape))
    _, values, Vt = np.linalg.svd(np.concatenate([loops, relations], axis=1))
    free = np.ascontiguousarray(Vt[:, rank:].mT)
    clear = values[:, rank - 1] > NEAR_SINGULAR_CONDITIONING * values[:, 0]
    clear &= values[:, rank:].max(axis=1, initial=0.0) <= LOOP_RANK_OF_FILE * values[:, 0]
    rates = np.linalg.norm(free, axis=2)
    return free, clear & (rates.min(axis=1) > CLEAR_MOTION_RELATIVE * rates.max(axis=1))


def _are_large(closed: ClosedGeometries, rows: IntArray) -> Flags:
    """Whether each geometry is clearly large enough, beside its distance from the origin."""
    points = closed.placed.points[rows]
    size = np.linalg.norm(points - points.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    far = np.abs(points).max(axis=(1, 2))
    return np.asarray(size > 10.0 * COMPONENT_SIZE_RELATIVE * far)


def _body_parameters(
    model: Linkage,
    frame: Frame,
    closed: ClosedGeometries,
    rows: IntArray,
    masses: Sequence[Mapping[str, Array]],
) -> Array:
    """Compute the parameters of the bodies (count, bodies, 10) in a frame.

    By one product of small matrices a row: the last bits of a row do not depend on how many
    there are.
    """
    to_frame = np.diag([*[1.0 / frame.length] * 3, 1.0])
    to_frame[:3, 3] = -frame.origin / frame.length
    z = np.zeros((rows.size, len(model.bodies), 10))
    place = {body.link: b for b, body in enumerate(model.bodies)}
    for name in masses[0]:
        link = model.places[name].link
        if link in place:
            beyond = closed.placed.links[name]
            beyond = beyond[rows] if len(beyond) > 1 else beyond
            inertias = np.array([of_row[name] for of_row in masses])
            moved = to_frame @ closed.H[rows, link] @ beyond
            z[:, place[link]] += displace_parameters(inertias[:, None], moved[:, None])[:, 0]
    return z
