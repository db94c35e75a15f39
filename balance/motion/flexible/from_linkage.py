"""Turn a planar linkage of a file into a mechanism in which named links bend."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from balance.motion.flexible.beam_part import Marker, MovingPart, RigidPart, mean_marker
from balance.motion.flexible.build_beam import BeamModel, BeamOptions, model_beam
from balance.motion.flexible.drives import DriveProfile
from balance.motion.flexible.flex_links import FlexLink
from balance.motion.flexible.mechanism import PlanarMechanism
from balance.motion.flexible.mechanism_types import GearRelation, JointDrive, MechanismJoint, On
from balance.motion.flexible.support_points import support_points
from balance.motion.flexible.supported_beam_modes import Clamp, EndBody, Support
from kinematics.errors import BodyError, LinkageError
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.plane import plane_axes
from kinematics.model.spatial.inertia import inertia_tensor
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import count_noun, number_text

SHORT = 1e-9
"""Least distance of the joints of a beam, over the size of the linkage."""
STRAIGHT = 1e-6
"""Distance of the joints of a beam from a line, over the size of the linkage."""
LOAD_PART = 0.3
"""Part of the mass of all links that stands for what the end of a driven beam carries."""


@dataclass(frozen=True, eq=False)
class FlexibleLinkage:
    """A linkage of which some links bend.

    Attributes:
        linkage: as the file describes it.
        mechanism: parts, joints and inputs in the plane of motion.
        axes: of that plane, as rows x, y, normal in the inertial frame; shape (3, 3).
        beams: models of the links that bend, by name.
        centre: centre of mass of all links at the start, in the plane; shape (2,).
        outlines: for drawing, the points of each rigid part between which it extends: its
            joints, and its centre of mass if all of them are at one place.
        about: point in the plane that moments are about (2,); None: the centre of mass.
        tangents: where beams are driven, or held by one joint alone, by name: their bending is
            measured from the tangent there, that of others from the line through their joints.
    """

    linkage: Linkage
    mechanism: PlanarMechanism
    axes: Array
    beams: Mapping[str, BeamModel]
    centre: Array
    outlines: Mapping[int, tuple[Marker, ...]]
    about: Array | None = None
    tangents: Mapping[str, Marker] = field(default_factory=dict)

    @property
    def point(self) -> Array:
        """Point in the plane that moments are about (2,), metres."""
        return self.centre if self.about is None else self.about


def flexible_linkage(
    linkage: Linkage,
    flex: Sequence[FlexLink],
    drives: Mapping[str, DriveProfile],
    options: BeamOptions | None = None,
) -> FlexibleLinkage:
    """Replace named links of a planar linkage by straight beams through their joints.

    Args:
        linkage: the linkage; its reference pose is the start, without deformation.
        flex: the links that bend; their mass in the file is replaced by that of the beam.
        drives: profile of each driven joint by name, and whether it is a moment; inputs of the
            linkage without a profile stay where they are.
        options: how beams are modelled.

    Raises:
        LinkageError: the linkage is not planar, a name is unknown, or a link cannot be a beam.
    """
    if not linkage.planar:
        raise LinkageError(f"{linkage.name} is not planar: links bend in planar linkages alone")
    build = _Builder(linkage, options or BeamOptions(), drives)
    link_names = [body.name for body in linkage.bodies]
    for link in flex:
        if link.name not in link_names:
            raise BodyError(linkage.name, link.name, "is not a link with mass", link_names)
    return build.build({link.name: link for link in flex})


class _Builder:
    """Gathers groups of welded links, and places their parts and joints."""

    def __init__(
        self,
        linkage: Linkage,
        options: BeamOptions,
        drives: Mapping[str, DriveProfile],
    ) -> None:
        """Find the groups of links that move as one."""
        self.linkage, self.options, self.drives = linkage, options, drives
        turning = [j.screw[:3] for j in linkage.joints if np.any(j.screw[:3])]
        idle = {j for j, joint in enumerate(linkage.joints) if joint.name in linkage.idle}
        normals = [
            n
            for j, n in zip(
                [j for j, joint in enumerate(linkage.joints) if np.any(joint.screw[:3])],
                turning,
                strict=True,
            )
            if j not in idle
        ]
        normal = normals[0] if normals else np.array([0.0, 0.0, 1.0])
        normal = normal * np.sign(normal[first_largest(np.abs(normal))])
        self.axes = plane_axes(normal / np.linalg.norm(normal))
        self.group = list(range(len(linkage.joints)))
        for j in sorted(idle):
            self._merge(j, linkage.joints[j].parent)
        for loop in linkage.loops:
            self._merge(loop.end, loop.successor)
        self.moving = [j for j in range(len(linkage.joints)) if j not in idle]
        self.parts: list[MovingPart] = []
        self.start: list[Array] = []
        self.part_of = {GROUND: -1}
        self.beams: dict[str, BeamModel] = {}
        self.tangents: dict[str, Marker] = {}
        self.ends: dict[tuple[int, int], Marker] = {}

    def _merge(self, a: int, b: int) -> None:
        """Join the groups of two links."""
        first, second = (self._group_of(link) for link in (a, b))
        low, high = min(first, second), max(first, second)
        self.group = [low if g == high else g for g in self.group]

    def _group_of(self, link: int) -> int:
        """Find the group of a link; -1 is the ground."""
        return GROUND if link == GROUND else self.group[link]

    def _plane(self, point: Array) -> Array:
        """Project a point to the plane."""
        return np.asarray((self.axes @ point)[:2])

    def build(self, flex: Mapping[str, FlexLink]) -> FlexibleLinkage:
        """Place all parts and joints."""
        inertia: dict[int, Array] = defaultdict(lambda: np.zeros(10))
        bending = {}
        for body in self.linkage.bodies:
            group = self._group_of(body.link)
            if body.name in flex:
                bending[group] = flex[body.name]
                self._check_alone(body.name, body.link, group)
            else:
                inertia[group] = inertia[group] + body.inertia
        touching: dict[int, list[int]] = defaultdict(list)
        for j in self.moving:
            for link in (self.linkage.joints[j].parent, j):
                touching[self._group_of(link)].append(j)
        self.total = sum(body.inertia[0] for body in self.linkage.bodies)
        outlines = {}
        for group in dict.fromkeys(g for g in self.group if g != GROUND):
            self.part_of[group] = len(self.parts)
            if group in bending:
                self._add_beam(group, bending[group], touching[group])
            else:
                points = [self._plane(self.linkage.joints[j].point) for j in touching[group]]
                k = len(self.parts)
                outlines[k] = self._add_rigid(group, inertia[group], points)
        return self._finish(outlines)

    def _finish(self, outlines: Mapping[int, tuple[Marker, ...]]) -> FlexibleLinkage:
        """Compose the mechanism."""
        place = {j: k for k, j in enumerate(self.moving)}
        joints = tuple(self._joint(j) for j in self.moving)
        relations = tuple(
            GearRelation(place[mimic.joint], place[mimic.source], mimic.ratio)
            for mimic in self.linkage.mimics
            if mimic.joint in place and mimic.source in place
        )
        points = np.array([self._plane(joint.point) for joint in self.linkage.joints])
        size = float(np.ptp(points, axis=0).max()) or 1.0
        mechanism = PlanarMechanism(
            tuple(self.parts),
            joints,
            np.concatenate(self.start),
            relations,
            self._drives(place),
            size,
        )
        mass, _ = mechanism.inertia(mechanism.start, np.zeros(len(mechanism.start)))
        total, moment = 0.0, np.zeros(2)
        for at in mechanism.slices:
            m, (x, y) = mass[at.start, at.start], mechanism.start[at][:2]
            total += m
            moment += (
                m * x + mass[at.start + 1, at.start + 2],
                m * y - mass[at.start, at.start + 2],
            )
        return FlexibleLinkage(
            self.linkage,
            mechanism,
            self.axes,
            self.beams,
            moment / max(total, 1e-300),
            outlines,
            tangents=self.tangents,
        )

    def _drives(self, place: Mapping[int, int]) -> tuple[JointDrive, ...]:
        """Compose the inputs: those of the caller, and inputs of the linkage at rest."""
        index = {joint.name: j for j, joint in enumerate(self.linkage.joints)}
        drives = []
        for name, (profile, moment) in self.drives.items():
            if index.get(name) not in place:
                names = ", ".join(self.linkage.joints[j].name for j in self.moving)
                raise LinkageError(
                    f"'{name}' is not a joint that moves; the joints are {names}"
                )
            drives.append(JointDrive(place[index[name]], profile, moment))
        held = [name for name in self.linkage.inputs if name not in self.drives]
        if any(drive.moment for drive in drives) or len(drives) >= self.linkage.mobility:
            held = held if len(drives) < self.linkage.mobility else []
        for name in held[: self.linkage.mobility - len(drives)]:
            drives.append(JointDrive(place[index[name]], lambda t: (0.0, 0.0, 0.0)))
        return tuple(drives)

    def _check_alone(self, name: str, link: int, group: int) -> None:
        """Refuse a beam to which other links are fixed.

        Raises:
            BodyError: there are some, or the beam is fixed to the ground.
        """
        others = [
            other
            for other, place in self.linkage.places.items()
            if other != name and place.link == link
        ] + [
            body.name
            for body in self.linkage.bodies
            if body.name != name and self._group_of(body.link) == group
        ]
        if group == GROUND or others:
            fixed = ", ".join(others) or "the ground"
            problem = f"cannot bend: {fixed} is fixed to it"
            raise BodyError(self.linkage.name, name, problem)

    def _add_rigid(self, group: int, z: Array, points: Sequence[Array]) -> tuple[Marker, ...]:
        """Add a rigid part; its frame is at its centre of mass, parallel to the plane's."""
        mass, normal = float(z[0]), self.axes[2]
        centre = self._plane(z[1:4] / mass) if mass > 0.0 else np.mean(points, axis=0)
        moment = float(normal @ inertia_tensor(z) @ normal) - mass * float(centre @ centre)
        name = self.linkage.joints[group].name
        names = [b.name for b in self.linkage.bodies if self._group_of(b.link) == group]
        self.parts.append(RigidPart(names[0] if names else name, mass, max(moment, 0.0)))
        self.start.append(np.array([*centre, 0.0]))
        self.ends.update(
            {
                (group, j): Marker(self._plane(self.linkage.joints[j].point) - centre)
                for j in self.moving
            }
        )
        corners = [point - centre for point in points]
        if np.ptp(points, axis=0).max() <= SHORT * float(np.abs(points).max()):
            corners = [corners[0], np.zeros(2)]
        return tuple(map(Marker, corners))

    def _add_beam(self, group: int, flex: FlexLink, joints: Sequence[int]) -> None:
        """Add a beam through the joints of a link, the outer ones its frame.

        Raises:
            BodyError: it has joints that are not revolute, apart and on one line, or one joint
                and no length.
        """
        if not joints or any(self.linkage.joints[j].kind != "revolute" for j in joints):
            problem = "cannot bend: a beam has revolute joints"
            raise BodyError(self.linkage.name, flex.name, problem)
        places, direction = self._line(flex, joints)
        joints = sorted(joints, key=lambda j: places[j])
        first, span = joints[0], places[joints[-1]] - places[joints[0]]
        at = {j: places[j] - places[first] for j in joints}
        points, weights, length = _hinges(flex, span)
        over = points[0][0]
        if flex.thickness > length:
            thick = f"{number_text(flex.thickness)} m thick and {number_text(length)} m long"
            problem = f"cannot bend: it is {thick}; lengths without a unit are metres"
            raise BodyError(self.linkage.name, flex.name, problem)
        beam = flex.beam(length)
        frame: list[Support | Clamp] = [Clamp(over)]
        if len(joints) > 1:
            frame = [Support(tuple(s), tuple(w)) for s, w in zip(points, weights, strict=True)]
        held, load = None, None
        for k, j in enumerate(joints):
            if self.linkage.joints[j].name in self.drives and not flex.supports:
                held = [Clamp(over + at[j])]
                load = EndBody(LOAD_PART * self.total) if k == 0 and len(joints) > 1 else None
        through = [over + at[j] for j in joints[1:-1]]
        model = model_beam(
            flex.name, beam, frame, self.options, None, load, held, through=through
        )
        self.beams[flex.name] = model
        for j in joints:
            self.ends[group, j] = model.marker(over + at[j])
            if self.linkage.joints[j].name in self.drives or len(joints) == 1:
                self.tangents[flex.name] = self.ends[group, j]
        if flex.supports:
            for j, s, w in zip(joints, points, weights, strict=True):
                self.ends[group, j] = mean_marker([model.marker(x) for x in s], w)
        angle = float(np.arctan2(direction[1], direction[0]))
        hinge = self.ends[group, first].at[0]
        start = self._plane(self.linkage.joints[first].point)
        self.parts.append(model.part)
        self.start.append(
            np.array([*(start - hinge * direction), angle, *np.zeros(model.part.size)])
        )

    def _line(self, flex: FlexLink, joints: Sequence[int]) -> tuple[dict[int, float], Array]:
        """Place the joints of a link along a line, and return its direction (2,).

        Raises:
            BodyError: there is no such line.
        """
        points = {j: self._plane(self.linkage.joints[j].point) for j in joints}
        size = max(1e-6, float(np.abs(list(points.values())).max()))
        start = points[joints[0]]
        if len(joints) == 1:
            body = next(
                candidate for candidate in self.linkage.bodies if candidate.name == flex.name
            )
            root = self.linkage.joints[joints[0]].point
            ahead = self._plane(body.inertia[1:4] - body.inertia[0] * root)
            problem = "cannot bend: it has 1 joint, at its centre of mass, and points nowhere"
        else:
            gaps = {j: float(np.linalg.norm(point - start)) for j, point in points.items()}
            ahead = points[max(gaps, key=lambda j: gaps[j])] - start
            problem = "cannot bend: its joints coincide"
        if not np.linalg.norm(ahead) >= SHORT * size:
            raise BodyError(self.linkage.name, flex.name, problem)
        direction = ahead / np.linalg.norm(ahead)
        across = np.array([-direction[1], direction[0]])
        if any(abs(across @ (point - start)) > STRAIGHT * size for point in points.values()):
            problem = "cannot bend: its joints are not on a line, and a beam is straight"
            raise BodyError(self.linkage.name, flex.name, problem)
        if len(joints) != 2 and (flex.supports or (len(joints) == 1 and flex.length is None)):
            need = "length:… in metres" if len(joints) == 1 else "no supports"
            problem = f"has {count_noun(len(joints), 'joint')}: give {need}"
            raise BodyError(self.linkage.name, flex.name, problem)
        places = {j: float(direction @ (point - start)) for j, point in points.items()}
        if len(set(places.values())) < len(places):
            problem = "cannot bend: its joints coincide"
            raise BodyError(self.linkage.name, flex.name, problem)
        return places, np.asarray(direction)

    def _joint(self, j: int) -> MechanismJoint:
        """Place a joint; one about the reverse of the normal has its links exchanged."""
        joint = self.linkage.joints[j]
        groups = self._group_of(joint.parent), self._group_of(j)
        if joint.kind == "prismatic":
            axis = self._plane(joint.screw[3:])
            axis = axis / np.linalg.norm(axis)
            sides = groups
        else:
            axis = np.array([1.0, 0.0])
            sides = groups if joint.screw[:3] @ self.axes[2] > 0.0 else groups[::-1]
        ends = [self._end(group, j) for group in sides]
        turn = [self.start[self.part_of[g]][2] if g != GROUND else 0.0 for g in sides]
        return MechanismJoint(
            joint.name,
            "prismatic" if joint.kind == "prismatic" else "revolute",
            ends[0],
            ends[1],
            (float(axis[0]), float(axis[1])),
            float(turn[1] - turn[0]),
        )

    def _end(self, group: int, j: int) -> On:
        """Find the point of a joint on one of its links."""
        if group == GROUND:
            return On(-1, Marker(self._plane(self.linkage.joints[j].point)))
        return On(self.part_of[group], self.ends[group, j])


def _hinges(flex: FlexLink, span: float) -> tuple[list[list[float]], list[list[float]], float]:
    """Place the points that carry a beam: positions and weights for each joint, and length."""
    if flex.supports:
        best = support_points(flex.supports)
        length, half = 0.5 * span / best.hinge, flex.supports // 2
        s = ((best.points + 0.5) * length).tolist()
        w = best.weights.tolist()
        return [s[:half], s[half:]], [w[:half], w[half:]], length
    length = span if flex.length is None else flex.length
    if span == 0.0:
        return [[0.0]], [[1.0]], length
    if length < span:
        raise LinkageError(
            f"link '{flex.name}': a beam of {length:g} m is shorter than from joint to joint "
            f"({span:g} m)"
        )
    over = 0.5 * (length - span)
    return [[over], [over + span]], [[1.0], [1.0]], length
