"""Requirements of a search: what they mean for all geometries of a topology.

Joints are named by their letters. Those that requirements name are the inputs, as many as
there are freedoms; their displacements are angles from the pose in which the joints are drawn,
so that they mean the same whatever the lengths are. Directions and points are those of the
frame of the ground (see `balance.studies.discovery.lane_regions`), in the plane.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from string import ascii_uppercase

import numpy as np

from balance.space.requirements.curves import places_on_surface, read_surface
from balance.space.requirements.requirement import Requirement, read_requirements
from balance.studies.discovery.lane_regions import force_rows, moment_rows, whole_momentum
from balance.studies.discovery.structure import LaneRegion, MomentumRows, TopologyArrays
from balance.studies.discovery.topologies import Topology
from kinematics.errors import MotionError, UsageError
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array

# Poses of a curved region, largest displacement at them, radians, and places to choose from.
PLACES, NEAR_PLACES, LISTED = 10, 0.4, 64
# Largest displacement of a joint, radians: a turn and a little.
FARTHEST = 6.3
# Directions of the axes in the plane.
AXES = {"x": (1.0, 0.0), "y": (0.0, 1.0)}


def canonical_requirements(texts: str | Sequence[str]) -> str:
    """Write requirements in one order, each once, with ``;`` between.

    Raises:
        UsageError: a text is no requirement.
    """
    listed = read_requirements(texts)
    if len(listed) > 1 and all(item.whole and not any(item.region) for item in listed):
        # Dynamic balance everywhere contains force balance everywhere.
        return "dynamic"
    return "; ".join(item.text for item in listed)


def required_structure(
    topology: Topology, structure: TopologyArrays, require: str, gravity: Sequence[float]
) -> TopologyArrays:
    """Give a topology the conditions of requirements.

    Args:
        require: the requirements, as for `balance.require`, with letters of joints as inputs.
        gravity: direction of gravity in the frame of the ground (3,).

    Raises:
        UsageError: a requirement cannot be read, or means nothing for all geometries.
    """
    listed = read_requirements(require)
    for item in listed:
        _check(topology, item)
    inputs = _inputs(topology, structure, listed)
    joints = tuple(structure.origin.tolist().index(ascii_uppercase.index(x)) for x in inputs)
    framed = any(not item.whole and item.about != "com" for item in listed)
    frame = _frame(topology, structure, listed) if framed else ()
    force = all(item.masses_alone for item in listed)
    structure = replace(structure, inputs=joints, frame=frame, force=force)
    regions = [
        _region(topology, structure, inputs, gravity, item)
        for item in listed
        if item.about != "com"  # where no force is left, this is the moment about any point
    ] + [
        _region(topology, structure, inputs, gravity, item._replace(quantity="dynamic"))
        for item in listed
        if item.about == "com"
    ]
    first = regions[0].relations
    if any(len(each.places) or not np.array_equal(each.relations, first) for each in regions):
        return replace(structure, regions=tuple(regions))
    structure = replace(structure, relations=np.concatenate([structure.relations, first]))
    if all(item.whole for item in listed):
        return structure
    free = np.zeros((0, len(structure.parent)))
    return replace(structure, regions=tuple(each._replace(relations=free) for each in regions))


def _refusal(item: Requirement, problem: str) -> UsageError:
    return UsageError(f"requirement '{item.text}': {problem}")


def _check(topology: Topology, item: Requirement) -> None:
    """Refuse what has no meaning for all geometries of a topology.

    Raises:
        UsageError: see above.
    """
    if item.quantity == "decoupled":
        raise _refusal(item, "no search asks for it: walks follow momenta, not inertias")
    if item.order:
        raise _refusal(
            item, "walks follow momenta, not their derivatives: ask for poses, or for a curve"
        )
    if item.path:
        raise _refusal(item, "a search is kept without its files: write a curve, as B=A**2")
    if any(abs(value) > FARTHEST for _, value in item.pose or ()):
        raise _refusal(item, "a displacement is more than a turn; joints turn in radians")
    if topology.space != "plane" and not item.whole:
        raise _refusal(
            item, "only geometries in a plane share a frame; write 'dynamic' or 'force'"
        )
    if item.axes and not any(axis in item.axes for axis in _axes_that_count(item)):
        raise _refusal(item, "asks for nothing in the plane xy of a search")


def _axes_that_count(item: Requirement) -> str:
    """The axes along which a plane has something."""
    return "z" if item.quantity == "moment" else "xy"


def _inputs(
    topology: Topology, structure: TopologyArrays, listed: Sequence[Requirement]
) -> tuple[str, ...]:
    """List the joints that requirements name, in alphabetical order.

    Raises:
        UsageError: they are not as many as there are freedoms, or do not turn.
    """
    letters = ascii_uppercase[: len(topology.edges)]
    names: set[str] = set()
    for item in listed:
        words = [name for name, _ in item.pose or ()]
        for relation in item.relations:
            words += re.findall(r"[A-Za-z_]\w*(?!\w*\()", relation)
        known = {word for word in words if word in letters}
        for name, _ in item.pose or ():
            if name not in letters:
                some = ", ".join(letters)
                raise _refusal(item, f"'{name}' is no joint of the topology: one of {some}")
        for name in known:
            if topology.edges[letters.index(name)][0] != "R":
                raise _refusal(
                    item,
                    f"joint {name} does not turn: only angles mean the same for all lengths",
                )
        names |= known
    used = any(any(item.region) for item in listed)
    if used and len(names) != structure.width:
        text = "; ".join(item.text for item in listed)
        raise UsageError(
            f"'{text}' names {len(names)} joints, but the joints named are the inputs, and the "
            f"topology has {structure.width}: name as many, such as at A=0"
        )
    return tuple(sorted(names))


def _frame(
    topology: Topology, structure: TopologyArrays, listed: Sequence[Requirement]
) -> tuple[int, int]:
    """Choose the joints that give the frame of the ground.

    Raises:
        UsageError: the ground has no such joints.
    """
    ground = topology.joints_of(0)
    turning = [k for k in ground if topology.edges[k][0] == "R"]
    others = turning[1:] or [k for k in ground if topology.edges[k][0] == "P"]
    if not turning or not others:
        raise UsageError(
            f"{topology.name}: the ground has no two joints that give it a frame: require "
            "'dynamic' or 'force'"
        )
    for item in listed:
        if not turning[1:] and isinstance(item.about, tuple) and any(item.about):
            raise _refusal(
                item, "coordinates count in the distance of two turning joints of the ground"
            )
    first, second = (structure.origin.tolist().index(k) for k in (turning[0], others[0]))
    return first, second


def _region(
    topology: Topology,
    structure: TopologyArrays,
    inputs: tuple[str, ...],
    gravity: Sequence[float],
    item: Requirement,
) -> LaneRegion:
    """Read one requirement.

    Raises:
        UsageError: its relations cannot be read.
    """
    components = _components(structure, gravity, item)
    count = len(inputs)
    relations = np.zeros((0, len(structure.parent)))
    places, tangents = np.zeros((0, count)), np.zeros((0, count, count))
    if item.order is not None:
        pose = dict(item.pose or ())
        places, tangents = np.array([[pose.get(x, 0.0) for x in inputs]]), np.eye(count)[None]
    elif item.relations:
        try:
            rows = [row for _, row in Motion.parse(item.relations, inputs).coefficients()]
            relations = np.zeros((len(rows), len(structure.parent)))
            relations[:, list(structure.inputs)] = np.array(rows, dtype=float)
        except MotionError:
            places, tangents = _places(item, inputs)
    return LaneRegion(components, relations, places, tangents)


def _places(item: Requirement, inputs: tuple[str, ...]) -> tuple[Array, Array]:
    """Choose poses on a curve or surface, near the reference pose, and its tangents there.

    Raises:
        UsageError: the relations are none of a curve.
    """
    listed = list(islice(places_on_surface(read_surface(item, inputs), inputs), LISTED))
    near = [place for place in listed if np.abs(place.u).max() <= NEAR_PLACES] or listed
    if not max(np.abs(place.u).max() for place in near[:PLACES]) <= FARTHEST:
        raise _refusal(item, "its poses are more than a turn from the reference pose")
    return (
        np.array([place.u for place in near[:PLACES]]),
        np.array([place.tangents for place in near[:PLACES]]),
    )


def _components(
    structure: TopologyArrays, gravity: Sequence[float], item: Requirement
) -> MomentumRows:
    """Give the components of the momentum that a requirement is about.

    Raises:
        UsageError: gravity is along the normal of the plane.
    """
    if item.whole:
        return whole_momentum(structure.algebra.dim, item.quantity == "force")
    if item.quantity == "moment":
        about = item.about if isinstance(item.about, tuple) else (0, 0)
        return moment_rows(float(about[0]), float(about[1]))
    if item.quantity == "gravity":
        if not any(gravity[:2]):
            raise _refusal(
                item,
                "gravity is along the normal of the plane: give its direction in the frame of "
                "the ground, such as --gravity 0,-1,0",
            )
        return force_rows(gravity[0], gravity[1])
    rows = [force_rows(*AXES[axis]) for axis in item.axes if axis in AXES]
    return MomentumRows(*(np.concatenate(parts) for parts in zip(*rows, strict=True)))
