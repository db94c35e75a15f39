"""Quantities of one geometry, each by the function of this package that computes it.

For each quantity there is a function that names its columns, one that computes their values,
and, if it has options that a model may not fit, one that checks them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.link_regions import regions_of
from balance.masses.counterweights.volume.plates import density_limits
from balance.masses.designs.best_design import Design, design, maximise_margin
from balance.masses.designs.constraints import constraints_of
from balance.masses.designs.density import STEEL
from balance.masses.designs.mass_regions import BALL_RADIUS
from balance.masses.partial_balance.motion_loads import input_inertia
from balance.masses.partial_balance.partial_balance import PartialBalance
from balance.motion.verification.input_paths import SteadyPath
from balance.motion.verification.shaking_wrench import body_wrenches_along
from balance.motion.verification.trajectory import Trajectory, drive
from balance.space.certification.certify_space import certify
from balance.space.requirements.require import require
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.closing import ClosedGeometries, Closer
from balance.studies.sweeps.geometry import SweptGeometry
from balance.studies.sweeps.swept_inertia import input_inertias
from balance.studies.sweeps.swept_motion import MOTION_OPTIONS, motion_of_options
from balance.studies.sweeps.swept_reduction import (
    REDUCE_OPTIONS,
    check_reduce,
    reduce_columns,
    reduce_values,
)
from balance.studies.sweeps.weight_columns import ADDED, weight_columns, weight_values
from balance.support.options import GRAVITY
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.tolerances import SIZE_DETERMINED

Options = Mapping[str, Any]


class Quantity(NamedTuple):
    """A quantity of one geometry.

    Attributes:
        columns: names its columns, for a model and options.
        compute: computes their values.
        options: names of its options, beside ``where``.
        check: raises LinkageError for options that do not fit a model.
        together: computes the values of many geometries of a model at once, (count, columns),
            and of which they hold; the others are computed one by one.
    """

    columns: Callable[[Linkage, Options], tuple[Column, ...]]
    compute: Callable[[SweptGeometry, Options], Sequence[Any]]
    options: tuple[str, ...] = ()
    check: Callable[[Linkage, Options], object] | None = None
    together: (
        Callable[
            [Linkage, Closer, ClosedGeometries, IntArray, Sequence[Mapping[str, Array]]],
            tuple[Array, Flags],
        ]
        | None
    ) = None


DESIGN = "design"
COUNTERWEIGHTS, REDUCE, MASSES = "counterweights", "reduce", "masses"
"""Entries that are added to options: those of what adds matter, and parameters of bodies."""
NO_DENSITY = "none"
"""Density of matter that is of any density: of point masses."""
# Orders whose ranks are listed by default, and at most.
ORDERS, MOST_ORDERS = 5, 50
# Samples of one turn of a crank, by default: two degrees apart.
TURN_SAMPLES = 180
# Samples between the neighbours of the largest one.
CLOSER_SAMPLES = 9


def _certainty_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name the level of certainty."""
    return (Column("certainty", "text"),)


def certainty(geometry: SweptGeometry, options: Options) -> tuple[str]:
    """Compute the level of certainty of the integers, by exact arithmetic where that applies.

    The geometry is written as a file at the pose that closes its loops.
    """
    text, given = geometry.linkage.to_urdf(), geometry.linkage
    bare = any(not body.inertia.any() for body in given.bodies)
    again = load(
        Document(given.source, text.encode()),
        inputs=given.inputs,
        bodies="all" if bare else "given",
    )
    space = geometry.space
    exact_space = design_space(
        again, None, space.balance, spatial=again.planar and not space.planar
    )
    return (certify(exact_space).level,)


def _singular_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name the singular values beside the gap."""
    return Column("kept", "real"), Column("dropped", "real")


def singular_values(geometry: SweptGeometry, options: Options) -> tuple[float, float]:
    """Compute the smallest singular value kept and the largest dropped, over the largest."""
    return geometry.space.kept, geometry.space.dropped


def _distance_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name the distance to a rank drop."""
    return (Column("distance", "real"),)


def distance(geometry: SweptGeometry, options: Options) -> tuple[float]:
    """Compute the distance to a rank drop, in characteristic lengths and radians."""
    return (distance_to_rank_drop(geometry.space),)


def _order_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name the ranks up to each order."""
    count = options.get("count", ORDERS)
    return tuple(Column(f"rank_{k}", "integer") for k in range(count))


def orders(geometry: SweptGeometry, options: Options) -> tuple[int, ...]:
    """Compute the rank up to each order; it stays once it is that of the space."""
    space, count = geometry.space, options.get("count", ORDERS)
    ranks = [order.rank for order in space.orders][:count]
    last_rank = space.rank if ranks and ranks[-1] == space.rank else -1
    return (*ranks, *[last_rank] * (count - len(ranks)))


def _check_orders(linkage: Linkage, options: Options) -> None:
    """Refuse a count of orders that is none."""
    count = options.get("count", ORDERS)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_ORDERS:
        raise UsageError(f"count {count}; give a whole number from 1 to {MOST_ORDERS}")


def _inertia_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name the inertia that each input feels."""
    return tuple(
        Column(f"inertia_{name}", "real", "kg" if name in linkage.sliding else "kg m²")
        for name in linkage.inputs
    )


def inertia(geometry: SweptGeometry, options: Options) -> tuple[float, ...]:
    """Compute the inertia that each input feels at the reference pose."""
    return tuple(input_inertia(geometry.linkage, options.get(MASSES)).values())


def _after(quantity: Quantity, adding: str) -> Quantity:
    """Make the same quantity of the masses with the matter that another quantity adds.

    Where that finds none, there is no value.

    Args:
        adding: the other quantity, of `AFTER`.
    """

    def columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
        return tuple(
            replace(column, name=f"{column.name}_{AFTER[adding].ending}")
            for column in quantity.columns(linkage, options)
        )

    def compute(geometry: SweptGeometry, options: Options) -> Sequence[Any]:
        z = masses_after(geometry, adding, options[adding])[0]
        if z is None:
            return [np.nan] * len(quantity.columns(geometry.linkage, options))
        return quantity.compute(geometry, {**options, MASSES: z})

    return quantity._replace(columns=columns, compute=compute, together=None)


def _design_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name verdict, margin and objective of a design."""
    columns = Column("design", "text"), Column("margin", "real")
    if "minimise" not in options:
        return columns
    unit = {"mass": "kg", "change": ""}.get(options["minimise"], "kg m²")
    return *columns, Column(f"least_{options['minimise']}", "real", unit)


def best_design(geometry: SweptGeometry, options: Options) -> tuple[Any, ...]:
    """Compute the verdict on designs, the margin, and the objective if there is one."""
    answer = _design_of(geometry, options)
    if answer.z is None:
        geometry.lacks[DESIGN] = answer.words
    value = np.nan if answer.value is None else answer.value
    return (answer.verdict, answer.margin, value)[: 3 if "minimise" in options else 2]


def _design_of(geometry: SweptGeometry, options: Options) -> Design:
    """Compute the design with the least objective, or the largest margin without one."""
    solve = design if "minimise" in options else maximise_margin
    return solve(geometry.space, **_design_options(options))


def _check_design_options(linkage: Linkage, options: Options) -> None:
    """Refuse bodies that the model does not have, and objectives that there are not."""
    wanted = _design_options(options)
    space = design_space(linkage, None)
    within = wanted.get("within", BALL_RADIUS)
    # The thickness that is the default differs from geometry to geometry.
    thickness = wanted.get("thickness", 1.0 if space.planar else None)
    constraints_of(
        space,
        wanted.get("keep", ()),
        wanted.get("bounds", {}),
        within,
        wanted.get("density", STEEL),
        thickness,
    )
    if options.get("minimise", "mass") not in ("mass", "inertia", "rotor", "change"):
        raise UsageError(f"minimise '{options['minimise']}'; take mass, inertia, rotor, change")


def _design_options(options: Options) -> dict[str, Any]:
    """Convert options to arguments of `balance.design`."""
    arguments = _arguments(options)
    if "bounds" in arguments:
        arguments["bounds"] = {
            name: (float(low), float(high)) for name, (low, high) in arguments["bounds"].items()
        }
    return arguments | ({"keep": tuple(arguments["keep"])} if "keep" in arguments else {})


def _counterweight_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name verdict, added mass and objective of counterweights, and the weights of links."""
    columns = [Column("counterweights", "text"), Column("added_mass", "real", "kg")]
    if options.get("minimise", "mass") != "mass":
        columns.append(Column(f"added_{options['minimise']}", "real", "kg m²"))
    return *columns, *weight_columns(linkage, options["links"], ADDED)


def _least_counterweights(geometry: SweptGeometry, options: Options) -> tuple[Any, ...]:
    """Compute the verdict on counterweights, their mass, and the objective if it is another.

    Then mass and place of the weight of each link.
    """
    answer = geometry.counterweights(_arguments(options))
    if answer.value is None:
        geometry.lacks[COUNTERWEIGHTS] = answer.words
        return (answer.verdict,)
    objective = [] if options.get("minimise", "mass") == "mass" else [answer.value]
    weights = weight_values(geometry.linkage, options["links"], answer.weights)
    return answer.verdict, answer.added_mass, *objective, *weights


def _least_shaking(geometry: SweptGeometry, options: Options) -> tuple[Any, ...]:
    """Compute verdict, added mass and share of the least shaking for a budget."""
    answer = geometry.reduction(_arguments(options))
    if answer.shaking is None:
        geometry.lacks[REDUCE] = answer.words
    return reduce_values(geometry.linkage, options, answer)


def _check_reduce(linkage: Linkage, options: Options) -> None:
    """Refuse a request for the least shaking that does not fit a model."""
    check_reduce(linkage, _arguments(options))


def _arguments(options: Options) -> dict[str, Any]:
    """Convert options to arguments of the function that computes a quantity."""
    return {
        name: None if (name, value) == ("density", NO_DENSITY) else value
        for name, value in options.items()
        if name != "where"
    }


def _check_counterweights(linkage: Linkage, options: Options) -> None:
    """Refuse links and regions that the model does not have."""
    if not isinstance(options.get("links"), list | tuple):
        raise UsageError('no links to add matter to; write links = ["crank", "rocker"]')
    space = design_space(linkage)
    regions = regions_of(space, options["links"], options.get("regions", {}))
    density_limits(
        space, regions, _arguments(options).get("density", STEEL), options.get("thickness")
    )
    if options.get("minimise", "mass") not in ("mass", "inertia", "rotor"):
        raise UsageError(f"minimise '{options['minimise']}'; take mass, inertia or rotor")


def _shaking_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name peak and root mean square of force and moment."""
    return (
        Column("peak_force", "real", "N"),
        Column("rms_force", "real", "N"),
        Column("peak_moment", "real", "N m"),
        Column("rms_moment", "real", "N m"),
    )


def _shaking_of_masses(geometry: SweptGeometry, options: Options) -> tuple[float, ...]:
    """Compute shaking force and moment of the masses of the model along a motion.

    The moment is about the inertial origin. Samples of the motion are equally far apart in
    time; the peak of a turn is that of a parabola through closer samples about the largest.
    """
    linkage, z = geometry.linkage, options.get(MASSES)
    way = geometry.motion(options, TURN_SAMPLES)
    sizes = _sizes_along(linkage, way, z)
    peaks = [_peak(size) for size in sizes]
    if isinstance(way.path, SteadyPath):
        largest = np.argmax(sizes, axis=1).tolist()
        closer = {
            k: _sizes_along(linkage, _sample_closer(linkage, way, k), z) for k in set(largest)
        }
        peaks = [_peak(closer[k][part]) for part, k in enumerate(largest)]
    means = [float(np.sqrt(np.trapezoid(size * size) / (size.size - 1))) for size in sizes]
    return peaks[0], means[0], peaks[1], means[1]


def _sizes_along(linkage: Linkage, way: Trajectory, z: Array | None) -> Array:
    """Compute the sizes of shaking force and moment along a motion (2, N).

    Sizes up to SIZE_DETERMINED of the largest sum of those of the bodies are round-off, and
    are set to 0.
    """
    loads = np.stack(np.split(body_wrenches_along(linkage, way, z), 2, axis=2)[::-1])
    sizes = np.linalg.norm(loads.sum(axis=2), axis=2)
    of_bodies = np.linalg.norm(loads, axis=3).sum(axis=2).max(axis=1, keepdims=True)
    return np.where(sizes > SIZE_DETERMINED * of_bodies, sizes, 0.0)


def _sample_closer(linkage: Linkage, way: Trajectory, k: int) -> Trajectory:
    """Sample a turn of a crank again, closer, about a sample."""
    assert way.path is not None
    first, last = max(k - 1, 0), min(k + 1, way.time.size - 1)
    time = np.linspace(way.time[first], way.time[last], CLOSER_SAMPLES)
    return drive(linkage, time, *way.path.at(time), start=way.q[first])


def _peak(sizes: Array) -> float:
    """Compute the largest value of a smooth function from equally spaced samples."""
    k = int(np.argmax(sizes))
    if not 0 < k < len(sizes) - 1:
        return float(sizes[k])
    before, most, after = np.square(sizes[k - 1 : k + 2])
    bend = before - 2.0 * most + after
    return float(np.sqrt(most - (after - before) ** 2 / (8.0 * bend))) if bend else sizes[k]


def _check_shaking(linkage: Linkage, options: Options) -> None:
    """Refuse a motion that is none of the model."""
    motion_of_options(linkage, options, TURN_SAMPLES)


def _required_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name rank and dimension of the space of requirements, and the verdict on designs."""
    return (
        Column("required_rank", "integer"),
        Column("required_nullity", "integer"),
        Column("required_design", "text"),
    )


def requirements(geometry: SweptGeometry, options: Options) -> tuple[Any, ...]:
    """Compute the space of several requirements, and whether it has designs."""
    space = require(
        geometry.linkage, options["require"], gravity=options.get("gravity", GRAVITY)
    )
    return space.rank, space.nullity, maximise_margin(space).verdict


def _check_requirements(linkage: Linkage, options: Options) -> None:
    """Refuse requirements that cannot be read, or that the model cannot meet."""
    if "require" not in options:
        raise UsageError('nothing is required; write require = "force; dynamic at u1=0.3"')
    require(linkage, options["require"], gravity=options.get("gravity", GRAVITY))


QUANTITIES: dict[str, Quantity] = {
    "certainty": Quantity(_certainty_columns, certainty),
    "counterweights": Quantity(
        _counterweight_columns,
        _least_counterweights,
        ("density", "links", "minimise", "regions", "thickness"),
        _check_counterweights,
    ),
    DESIGN: Quantity(
        _design_columns,
        best_design,
        ("bounds", "density", "keep", "minimise", "thickness", "within"),
        _check_design_options,
    ),
    "distance": Quantity(_distance_columns, distance),
    "input_inertia": Quantity(_inertia_columns, inertia, together=input_inertias),
    "orders": Quantity(_order_columns, orders, ("count",), _check_orders),
    REDUCE: Quantity(reduce_columns, _least_shaking, REDUCE_OPTIONS, _check_reduce),
    "requirements": Quantity(
        _required_columns, requirements, ("gravity", "require"), _check_requirements
    ),
    "shaking": Quantity(_shaking_columns, _shaking_of_masses, MOTION_OPTIONS, _check_shaking),
    "singular_values": Quantity(_singular_columns, singular_values),
}


class _Added(NamedTuple):
    """A quantity that adds matter, after which others are computed again.

    Attributes:
        answer: computes the answer for arguments; it has masses ``z``, or none.
        ending: ends the names of columns.
    """

    answer: Callable[[SweptGeometry, Options], Counterweights | PartialBalance]
    ending: str


AFTER = {
    COUNTERWEIGHTS: _Added(SweptGeometry.counterweights, "after"),
    REDUCE: _Added(SweptGeometry.reduction, "reduced"),
}
"""Quantities that add matter, by name."""
WITH_MASSES = (*AFTER, DESIGN)
"""Quantities that give a row other masses; the file of a row has those of the first."""
QUANTITIES |= {
    f"{name} after {quantity}": _after(QUANTITIES[name], quantity)
    for quantity in AFTER
    for name in ("input_inertia", "shaking")
}
"""Quantities that are computed geometry by geometry, by name."""
MASS_QUANTITIES = (
    *("counterweights", "design", "input_inertia", "reduce", "shaking"),
    *(name for name in QUANTITIES if " after " in name),
)
"""Quantities that may depend on the masses of the model."""


def masses_after(
    geometry: SweptGeometry, quantity: str, options: Options
) -> tuple[Array | None, str]:
    """Compute the parameters (bodies, 10) of a design, or with the matter that is added.

    Args:
        quantity: the quantity, of `WITH_MASSES`.
        options: its options.

    Returns:
        The parameters, inertial origin, SI units, or None where it finds none; and its verdict
        in one line.

    Raises:
        LinkageError: see `balance.counterweights`, `balance.partial` and `balance.design`.
    """
    if quantity == DESIGN:
        designed = _design_of(geometry, options)
        return designed.z, designed.words
    answer = AFTER[quantity].answer(geometry, _arguments(options))
    return answer.z, answer.words


def added_before(name: str) -> str:
    """Name the quantity after which one is computed; empty for others."""
    quantity = name.rpartition(" after ")[2]
    return quantity if quantity in AFTER and quantity != name else ""
