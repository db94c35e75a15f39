"""Transmissions: counter-rotors on the ground against the rotations of links.

The rotation of a link of a planar linkage is brought to the ground along the links that carry
it, by wheels or by parallelograms, and a rotor on the ground turns against it.

Their own masses count. Bars, levers and wheels have the mass per length of the linkage: the
mass of its bodies over the sum of their lengths, where the length of a body is the largest
distance from the joint that carries it to another of its joints, or to its centre of mass.
Bars and levers are slender rods. A wheel is a disc with the mass of a rod as long as its
diameter. Wheels have the radius that levers have as their length, a quarter of the shortest
link along which they are carried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.regions import Region, ball_region
from balance.masses.designs.mass_regions import joint_points
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.counter_rotations.counter_rotors import link_rotor_conditions
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    FewestRotors,
    RotorSet,
    fewest_of,
)
from balance.masses.remedies.counter_rotations.rotor_elements import RotorWriter
from balance.masses.remedies.counter_rotations.separate_rotors import (
    answer_without_rotors,
    rotor_details,
    unusable,
)
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant, append_elements
from kinematics.model.chain import path
from kinematics.model.document.element import Element
from kinematics.model.document.make_elements import inertial, joint, link, loop, origin
from kinematics.model.document.write_numbers import number_words
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest, round_decimals
from kinematics.numerics.tolerances import TIE_RELATIVE
from kinematics.wording import count_noun, number_text

# Length of a lever, or radius of a wheel, over that of the shortest link that carries it.
LEVER = 0.25
# Directions of levers that are tried; that furthest from all links counts.
DIRECTIONS = 24
EYE = np.eye(4)


class _CarriedParts(NamedTuple):
    """The parts of a kind of transmission that links carry, in words.

    Attributes:
        drive: what drives rotors.
        parts: what has a size.
        bound: what that size is: a bound, or not optimised.
    """

    drive: str
    parts: str
    bound: str


WHEELS = _CarriedParts("wheels", "wheels", "a radius, and a bound: smaller ones weigh less")
LEVERS = _CarriedParts(
    "parallelograms", "levers", "a quarter of the shortest link: set, not sought"
)


def apply_planetary_transmission(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by rotors on the ground, driven by wheels along its links.

    A wheel coaxial with each joint on the way from a link to the ground turns with that link,
    by belts or gears along the links between; the rotor turns -N times for one turn of the
    link, N being ``request.gear``. Wheels have masses of their own.

    Yields:
        A result for the smallest set of links with the least momenta and, if no link of it
        needs a transmission, one for the best set of which one does.
    """
    yield from _apply(request, "planetary_transmission", _TransmissionWriter.wheels, WHEELS)


def apply_parallelogram_transmission(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by rotors on the ground, driven by parallelograms.

    An idler coaxial with each joint on the way from a link to the ground keeps parallel to
    that link by a bar along each link between, which closes a loop; the rotor turns -N times
    for one turn of the idler on the ground, N being ``request.gear``. Idlers and bars have
    masses of their own.

    Yields:
        As `apply_planetary_transmission`.
    """
    write = _TransmissionWriter.parallelograms
    yield from _apply(request, "parallelogram_transmission", write, LEVERS)


def _apply(
    request: RemedyRequest,
    remedy: str,
    write: Callable[[_TransmissionWriter, _Transmission, tuple[str, ...]], None],
    by: _CarriedParts,
) -> Iterator[AppliedRemedy]:
    """Judge the linkage with rotors on the ground against one or two sets of links."""
    if why := unusable(request):
        yield refused(remedy, why)
        return
    if not request.space.planar:
        yield refused(remedy, "axes that are not parallel: it transmits rotations in a plane")
        return
    chains = _chains_to_ground(request)
    fewest = _fewest_on_ground(request)
    if fewest.verdict != "feasible" or not fewest.count:
        yield answer_without_rotors(remedy, fewest)
        return
    sets = [fewest.sets[0]]
    if all(len(chains[name]) == 1 for name in sets[0].joints):
        longer = (x for x in fewest.sets if any(len(chains[name]) > 1 for name in x.joints))
        sets += [rotor_set for rotor_set in (next(longer, None),) if rotor_set is not None]
    for rotor_set in sets:
        far = [name for name in rotor_set.joints if len(chains[name]) > 1]
        if far:
            drive = f"driven by {by.drive} from {', '.join(far)}"
            yield _judged(request, remedy, rotor_set, write, drive, by)
        else:
            yield replace(_judged_without_transmission(request, rotor_set), remedy=remedy)


def _judged(
    request: RemedyRequest,
    remedy: str,
    rotor_set: RotorSet,
    write: Callable[[_TransmissionWriter, _Transmission, tuple[str, ...]], None],
    drive: str,
    carried: _CarriedParts | None = None,
) -> AppliedRemedy:
    """Judge the linkage with rotors on the ground against one set of links."""
    chains, fewest = _chains_to_ground(request), _fewest_on_ground(request)
    out, writer = _Transmission(), _TransmissionWriter(request)
    for name in rotor_set.joints:
        write(writer, out, chains[name])
    number = count_noun(len(rotor_set.joints), "rotor")
    words = f"{number} on the ground against {', '.join(rotor_set.joints)}, {drive}"
    if carried is not None:
        sizes = ", ".join(f"{number_text(size, '.3g')} m" for size in out.sizes.values())
        words += f", with {carried.parts} of {sizes} ({carried.bound})"
    details = {**rotor_details(fewest, rotor_set), "carried_sizes": out.sizes}
    return judge_variant(request, _variant(request, remedy, words, out, details))


@lru_cache(maxsize=1)
def _judged_without_transmission(request: RemedyRequest, rotor_set: RotorSet) -> AppliedRemedy:
    """Judge rotors against links on the ground, once for all transmissions."""
    write = _TransmissionWriter.wheels
    return _judged(request, "planetary_transmission", rotor_set, write, "without transmission")


def _chains_to_ground(request: RemedyRequest) -> dict[str, tuple[str, ...]]:
    """List the joints from the ground to each body, by its name."""
    return {body: _chain_to_ground(request, body) for body in request.space.bodies}


@lru_cache(maxsize=1)
def _fewest_on_ground(request: RemedyRequest) -> FewestRotors:
    """Find the fewest rotors on the ground against links, once for all transmissions."""
    links = [body for body, chain in _chains_to_ground(request).items() if chain]
    return fewest_of(link_rotor_conditions(request.space, links), request.progress)


def _variant(
    request: RemedyRequest,
    remedy: str,
    words: str,
    out: _Transmission,
    details: Mapping[str, object],
) -> Variant:
    """Make the variant of a linkage with transmissions and rotors."""
    return Variant(
        remedy,
        words,
        append_elements(request.base, out.elements),
        (*request.links, *out.free),
        regions=out.free,
        massless=tuple(out.massless),
        new_links=tuple(out.links),
        new_joints=tuple(out.joints),
        details={**details, "mass_per_length": mass_per_length(request)},
    )


@dataclass
class _Transmission:
    """What is built in for some rotors on the ground.

    Attributes:
        elements: links, joints and loops.
        free: region of each new link that may get more matter, by its name.
        links: new links, and ``massless`` those of them without mass.
        joints: new joints and loops.
        massless: see ``links``.
        sizes: radius of the wheels or length of the levers that are carried for a link, by its
            name, metres.
    """

    elements: list[Element] = field(default_factory=list)
    free: dict[str, Region] = field(default_factory=dict)
    links: list[str] = field(default_factory=list)
    joints: list[str] = field(default_factory=list)
    massless: list[str] = field(default_factory=list)
    sizes: dict[str, float] = field(default_factory=dict)

    def add_link(self, name: str, mass: Element | None = None) -> None:
        """Add a link.

        Args:
            mass: its ``<inertial>``, if it has mass.
        """
        self.elements.append(link(name, mass))
        self.links.append(name)

    def add_joint(self, element: Element) -> None:
        """Add a joint or a loop."""
        self.elements.append(element)
        self.joints.append(element.name)


def _chain_to_ground(request: RemedyRequest, body: str) -> tuple[str, ...]:
    """List the joints from the ground to a body; none if one of them does not turn.

    Args:
        body: name of the body.
    """
    linkage = request.linkage
    end = next(element.link for element in linkage.bodies if element.name == body)
    joints = [linkage.joints[j] for j in path([x.parent for x in linkage.joints], end)]
    if any(element.kind != "revolute" or element.in_loop for element in joints):
        return ()
    return tuple(element.name for element in reversed(joints))


def mass_per_length(request: RemedyRequest) -> float:
    """Compute the mass of the bodies of a linkage over the sum of their lengths, kg/m."""
    total = 0.0
    for body in request.linkage.bodies:
        points = joint_points(request.space, body)
        if body.inertia[0] > 0.0:
            points = [*points, body.inertia[1:4] / body.inertia[0]]
        total += float(np.linalg.norm(np.array(points) - points[0], axis=1).max())
    return request.given_mass / (total or request.space.length)


class _TransmissionWriter(RotorWriter):
    """Makes transmissions to the ground, and rotors there."""

    def __init__(self, request: RemedyRequest) -> None:
        """Start with the names of the file of a request."""
        super().__init__(request)
        self.gear, self.mass_per_length = request.gear, mass_per_length(request)
        self.axes = request.space.axes

    def wheels(self, out: _Transmission, chain: Sequence[str]) -> None:
        """Add wheels coaxial with the joints of a chain that turn with its last link.

        Belts or gears along the links keep them at one angle: a wheel on joint i turns by
        ``q_i + … + q_k`` on the link before it. The sum is written as one joint upon another,
        with massless links between them, of which each follows one joint of the chain.

        Args:
            out: what is built in.
            chain: the joints from the ground to the link.
        """
        end = self.side(chain[-1], "child")
        radius = self._carried_size(self._spans(chain))
        if len(chain) > 1:
            out.sizes[end] = radius
        for k, name in enumerate(chain[:-1]):
            wheel = self.take_name(f"{end}_wheel")
            self._stack(out, wheel, chain[k:], 1.0, self._disc(name, radius))
        if len(chain) > 1:
            wheel = self.take_name(f"{end}_wheel")
            self._fix(out, end, wheel, self._disc(chain[-1], radius))
        rotor = self.take_name(f"{end}_rotor")
        self._stack(out, rotor, chain, -self.gear, None)
        out.free[rotor] = ball_region(np.zeros(3), self.radius)

    def parallelograms(self, out: _Transmission, chain: Sequence[str]) -> None:
        """Add idlers coaxial with the joints of a chain, and bars that keep them parallel.

        Each parallelogram is a loop of the link between two joints, the levers on both, and a
        bar between their ends; the last lever is part of the last link. The levers are a
        quarter of the shortest link, and point furthest away from all of them at the reference
        pose. Idlers may get counterweights as far away as their levers are long: the link alone
        cannot balance bars that move with it in some terms and not in others.

        Args:
            out: what is built in.
            chain: the joints from the ground to the link.
        """
        end, spans = self.side(chain[-1], "child"), self._spans(chain)
        lever, idlers = self._lever(spans), []
        if spans:
            out.sizes[end] = float(np.linalg.norm(lever))
        for name in chain[:-1]:
            idlers.append(self.take_name(f"{end}_idler"))
            turning = self.take_name(f"{idlers[-1]}_joint")
            out.add_link(idlers[-1], self._rod(self._local(name, lever)))
            out.free[idlers[-1]] = ball_region(np.zeros(3), float(np.linalg.norm(lever)))
            at = self.joints[name].first("origin") or origin(EYE)
            carrier, axes = self.side(name, "parent"), (self.axis(name), "")
            out.add_joint(joint(turning, "continuous", carrier, idlers[-1], at, axes))
        for k, name in enumerate(chain[:-1]):
            far = idlers[k + 1] if k + 2 < len(chain) else end
            tips = [_point(self._local(each, lever)) for each in chain[k : k + 2]]
            self._bar(out, name, chain[k + 1], (idlers[k], far), tips, spans[k])
        if idlers:
            tip = self._local(chain[-1], lever)
            self._fix(out, end, self.take_name(f"{end}_lever"), self._rod(tip))
        source = f"{idlers[0]}_joint" if idlers else chain[0]
        rotor = self.take_name(f"{end}_rotor")
        self._follow(out, chain[0], self.side(chain[0], "parent"), rotor, (source, -self.gear))
        out.free[rotor] = ball_region(np.zeros(3), self.radius)

    def _stack(
        self,
        out: _Transmission,
        name: str,
        chain: Sequence[str],
        ratio: float,
        mass: Element | None,
    ) -> None:
        """Add a link on the axis of the first joint of a chain that turns by all its joints."""
        carrier = self.side(chain[0], "parent")
        for k, source in enumerate(chain):
            last = k == len(chain) - 1
            child = name if last else self.take_name(f"{name}_sum")
            if not last:
                out.massless.append(child)
            sign = float(np.sign(self._axis_vector(source) @ self._axis_vector(chain[0])))
            place = chain[0] if k == 0 else None
            turns = (source, sign * ratio)
            self._follow(
                out, chain[0], carrier, child, turns, mass if last else None, place is not None
            )
            carrier = child

    def _follow(
        self,
        out: _Transmission,
        at: str,
        carrier: str,
        child: str,
        turns: tuple[str, float],
        mass: Element | None = None,
        placed: bool = True,
    ) -> None:
        """Add a link on a continuous joint that follows a joint."""
        here = (self.joints[at].first("origin") if placed else None) or origin(EYE)
        out.add_link(child, mass)
        turning, axes = self.take_name(f"{child}_joint"), (self.axis(at), "")
        mimic = (*turns, 0.0)
        out.add_joint(joint(turning, "continuous", carrier, child, here, axes, mimic=mimic))

    def _fix(self, out: _Transmission, carrier: str, child: str, mass: Element) -> None:
        """Add a link that is fixed at the frame of another."""
        out.add_link(child, mass)
        out.add_joint(
            joint(self.take_name(f"{child}_joint"), "fixed", carrier, child, origin(EYE))
        )

    def _bar(
        self,
        out: _Transmission,
        name: str,
        after: str,
        ends: tuple[str, str],
        tips: Sequence[Element],
        span: Array,
    ) -> None:
        """Add the bar of one parallelogram, from the tip of a lever to that of the next."""
        bar, local = self.take_name(f"{ends[0]}_bar"), self._local(name, span)
        out.add_link(bar, self._rod(local))
        turning, axes = self.take_name(f"{bar}_joint"), (self.axis(name), "")
        out.add_joint(joint(turning, "continuous", ends[0], bar, tips[0], axes))
        far = _point(local)
        next_origin = self.joints[after].first("origin")
        if next_origin and self.side(after, "parent") == self.side(name, "child"):
            # The decimals of the file, so that the parallelogram is one exactly.
            far = Element("origin", {"xyz": next_origin.attributes.get("xyz", "0 0 0")})
        closing = self.take_name(f"{bar}_loop")
        out.add_joint(loop(closing, "revolute", [(bar, far), (ends[1], tips[1])], axes))

    def _spans(self, chain: Sequence[str]) -> list[Array]:
        """Compute the vectors (3,) from each joint of a chain to the next, inertial frame."""
        frames = [self.linkage.places[self.side(name, "child")].pose for name in chain]
        return [b[:3, 3] - a[:3, 3] for a, b in zip(frames[:-1], frames[1:], strict=True)]

    def _lever(self, spans: Iterable[Array]) -> Array:
        """Choose the vector (3,) of the levers in the inertial frame."""
        flat = np.array([self.axes[:2] @ span for span in spans]).reshape(-1, 2)
        lengths = np.linalg.norm(flat, axis=1)
        if not len(flat):
            return np.zeros(3)
        turn = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
        e = np.column_stack([np.cos(turn), np.sin(turn)])
        sines = np.abs(np.outer(e[:, 0], flat[:, 1]) - np.outer(e[:, 1], flat[:, 0])) / lengths
        best = e[first_largest(sines.min(axis=1))]
        length = self._carried_size(spans)
        # Four digits, so that both levers of a parallelogram have the same decimals.
        digits = 3 - int(np.floor(np.log10(length * (1.0 + TIE_RELATIVE))))
        return np.asarray(round_decimals(length * best, digits) @ self.axes[:2])

    def _carried_size(self, spans: Iterable[Array]) -> float:
        """Compute the size of wheels or levers that are carried along some links, metres."""
        shortest = min((np.linalg.norm(self.axes[:2] @ span) for span in spans), default=0.0)
        return LEVER * float(shortest)

    def _local(self, name: str, vector: Array) -> Array:
        """Express an inertial vector (3,) in the frame of the link after a joint."""
        R = self.linkage.places[self.side(name, "child")].pose[:3, :3]
        return np.asarray(R.T @ vector)

    def _axis_vector(self, name: str) -> Array:
        """Return the axis of a joint (3,), inertial frame."""
        joints = self.linkage.joints
        return joints[self.linkage.positions_of([name])[0]].screw[:3]

    def _rod(self, end: Array) -> Element:
        """Make the ``<inertial>`` of a slender rod from the origin of a frame to a point."""
        mass = self.mass_per_length * float(np.linalg.norm(end))
        tensor = mass / 12.0 * (end @ end * np.eye(3) - np.outer(end, end))
        return inertial(mass, tensor, _point(0.5 * end))

    def _disc(self, name: str, radius: float) -> Element:
        """Make the ``<inertial>`` of a wheel on the axis of a joint."""
        mass = self.mass_per_length * 2.0 * radius
        n = self._local(name, self._axis_vector(name))
        tensor = mass * radius**2 / 4.0 * (np.eye(3) + np.outer(n, n))
        return inertial(mass, tensor, origin(EYE))


def _point(at: Array) -> Element:
    """Make the ``<origin>`` of a point (3,)."""
    return Element("origin", {"xyz": number_words(at)})
