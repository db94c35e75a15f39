"""Counterweights that move with a payload: weights of constant mass, for every load of a range.

Where masses and first moments alone count, what must vanish is linear in them and in the load.
Weights whose masses stay, and whose first moments balance the least and the greatest load,
therefore balance every load between, if each moves on the straight line from one place to the
other, by equal steps for equal steps of the load. Both places are in the region, and so is the
line, as regions are convex: one convex program.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import MomentCone, first_moment_cone
from balance.masses.counterweights.added_program import (
    AddedProgram,
    build_added_program,
    conic_arguments,
)
from balance.masses.counterweights.decide_points import balance_residual
from balance.masses.counterweights.link_regions import regions_of
from balance.masses.counterweights.regions import Region
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.payload import Payload, carrying, read_payload
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from balance.support.tolerances import (
    CONDITION_LEFT,
    COUNTERWEIGHT_RESIDUAL,
    LUMP_SHARE_LEAST,
)
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, repr_lines, vector_text


class MovableWeight(NamedTuple):
    """A weight that moves with the load, on a straight line.

    Attributes:
        link: the link that carries it.
        mass: kg.
        start: where it is for the least load (3,), in the frame of the link, metres.
        end: where it is for the greatest load, likewise.
    """

    link: str
    mass: float
    start: Array
    end: Array

    def __repr__(self) -> str:
        """Give one line: mass, link and both places."""
        return f"MovableWeight: {self.words}"

    @property
    def words(self) -> str:
        """Mass, link and both places in words."""
        where = f"{vector_text(self.start)} m to {vector_text(self.end)} m"
        return f"{number_text(self.mass)} kg on {self.link}, from {where}"


class MovableWeights(NamedTuple):
    """Result of `movable_weights`.

    Attributes:
        payload: the payload.
        fixed: whether weights that stay balance every load: the load itself is balanced.
        weights: the weights that move, of the least mass; empty if there are none.
        residual: largest residual for the least and the greatest load, over the bodies' sizes.
        words: the answer in one line.
    """

    payload: Payload
    fixed: bool
    weights: tuple[MovableWeight, ...]
    residual: float
    words: str

    def __repr__(self) -> str:
        """Up to six lines: the answer, and the weights."""
        return repr_lines("MovableWeights", self.words, *(w.words for w in self.weights))

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            **self.payload.to_dict(),
            "fixed_balance": self.fixed,
            "words": self.words,
            "movable": [
                {
                    "link": weight.link,
                    "mass": weight.mass,
                    "start": weight.start.tolist(),
                    "end": weight.end.tolist(),
                }
                for weight in self.weights
            ],
        }


def movable_weights(
    space: DesignSpace | LinkageLike,
    linkage: LinkageLike,
    payload: Payload | str,
    links: Sequence[str],
    regions: Mapping[str, Region | str] | None = None,
) -> MovableWeights:
    """Find weights on links that balance every load of a range by moving with it.

    Args:
        space: a design space in which masses and first moments alone count, or a linkage, its
            path or its name: its force balance.
        linkage: its linkage without the payload, or what `kinematics.load` accepts.
        payload: a range of loads, or its text.
        links: names of links that may carry a weight.
        regions: where a weight may be, by name, as for `balance.counterweights`.

    Raises:
        BodyError: a link is unknown, or part of the ground.
        UsageError: the payload is one load.

    Example:
        >>> from balance.masses import movable_weights
        >>> links = ["crank", "rocker"]
        >>> movable_weights("robot.urdf", "robot.urdf", "coupler=0:0.5", links).fixed
        False
    """
    linkage = as_linkage(linkage)
    payload = read_payload(payload) if isinstance(payload, str) else payload
    if not isinstance(space, DesignSpace):
        space = as_space(space, balance="force")
    if not payload.varies:
        raise UsageError(f"payload '{payload.text}' is one load: give a range low:high")
    ends = [replace(space, linkage=carrying(linkage, payload, m)) for m in payload[-2:]]
    if _stays_balanced(ends):
        words = "the payload is balanced wherever it is: weights that stay balance every load"
        return MovableWeights(payload, True, (), 0.0, words)
    if space.balance != "force":
        words = (
            "weights that move are found where forces or gravity alone are to vanish: second "
            "moments are not linear in a place"
        )
        return MovableWeights(payload, False, (), np.inf, words)
    places = regions_of(ends[0], links, regions or {})
    programs = [build_added_program(end, places, "mass") for end in ends]
    cones = [first_moment_cone(region) for region in places.values()]
    moments = _solve(programs, cones)
    if moments is None:
        words = "no weights that move within their regions balance every load"
        return MovableWeights(payload, False, (), np.inf, words)
    residual = max(
        balance_residual(end, _with(end, program, part))
        for end, program, part in zip(ends, programs, moments, strict=True)
    )
    weights = _weights(space, places, programs, moments)
    total = sum(weight.mass for weight in weights)
    if residual > COUNTERWEIGHT_RESIDUAL:
        return MovableWeights(
            payload, False, (), residual, "undecided: weights that move do not pass their check"
        )
    words = (
        f"{number_text(total)} kg that move with the load balance every load from "
        f"{number_text(payload.low)} to {number_text(payload.high)} kg"
    )
    return MovableWeights(payload, False, weights, residual, words)


def _stays_balanced(ends: Sequence[DesignSpace]) -> bool:
    """Whether the difference of two loads is balanced by itself."""
    low, high = (given_parameters(end) for end in ends)
    return balance_residual(ends[0], high - low) <= COUNTERWEIGHT_RESIDUAL


def _solve(programs: Sequence[AddedProgram], cones: Sequence[MomentCone]) -> list[Array] | None:
    """Find moments (links, 4, 4) for both loads with equal masses, of the least mass.

    None if the solver finds that there are none, or leaves conditions open.
    """
    if any(np.linalg.norm(program.unmatched) > CONDITION_LEFT for program in programs):
        return None
    (q, A, a, first), (_, B, b, second) = (conic_arguments(x, cones) for x in programs)
    height, width = len(A), A.shape[1]
    starts = np.cumsum([0, *(len(cone.matrices) for cone in cones)])
    rows = np.zeros((2 * height + len(cones), 2 * width))
    rows[:height, :width], rows[height : 2 * height, width:] = A, B
    for k, cone in enumerate(cones):
        masses, at = cone.matrices[:, 3, 3], slice(starts[k], starts[k + 1])
        rows[2 * height + k, at] = masses * programs[0].unit
        rows[2 * height + k, width + starts[k] : width + starts[k + 1]] = (
            -masses * programs[1].unit
        )
    offset = np.concatenate([a, b, np.zeros(len(cones))])
    solution = solve_conic(
        np.concatenate([q, np.zeros(width)]),
        rows,
        offset,
        [*first, *second, ConstraintBlock("zero", len(cones))],
    )
    if solution.infeasible:
        return None
    # The equations hold to the solver's accuracy: bring them to round-off.
    rank = [program.target.size for program in programs]
    equal = [*range(rank[0]), *range(height, height + rank[1]), *range(2 * height, len(rows))]
    E, residual = rows[equal], rows[equal] @ solution.x + offset[equal]
    x = solution.x - np.linalg.lstsq(E, residual, rcond=1e-12)[0]
    return [
        np.array(
            [cone.matrices.T @ part[starts[k] : starts[k + 1]] for k, cone in enumerate(cones)]
        )
        for part in (x[:width], x[width:])
    ]


def _with(space: DesignSpace, program: AddedProgram, moments: Array) -> Array:
    """Add moments to the given masses: parameters (bodies, 10)."""
    z = given_parameters(space).copy()
    for (b, region), P in zip(program.regions.items(), moments, strict=True):
        H = space.frames[b] @ region.place
        z[b] += program.unit * from_pseudo_inertia(H @ P @ H.T)
    return z


def _weights(
    space: DesignSpace,
    places: Mapping[int, Region],
    programs: Sequence[AddedProgram],
    moments: Sequence[Array],
) -> tuple[MovableWeight, ...]:
    """Describe the weights of moments for both loads."""
    masses = [
        program.unit * part[:, 3, 3] for program, part in zip(programs, moments, strict=True)
    ]
    total = float(masses[0].sum())
    weights = []
    for k, (b, region) in enumerate(places.items()):
        mass = float(masses[0][k])
        if mass <= LUMP_SHARE_LEAST * total:
            continue
        start, end = (
            region.place[:3, :3] @ (part[k, :3, 3] / part[k, 3, 3]) + region.place[:3, 3]
            for part in moments
        )
        weights.append(MovableWeight(space.bodies[b], mass, start, end))
    return tuple(weights)
