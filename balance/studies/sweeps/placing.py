"""Place the joints of a model for many values of its parameters at once, loops still open.

At the reference pose of the model, with all joint positions as they are there, a number of the
file that changes displaces its frame, and everything beyond it, by

    G = E_p T_p (O' A O⁻¹) T_p⁻¹

with the displacement E_p of the link p in whose frame it is, the pose T_p of that link, the
origin O before and O' after, and the rotation A of the axis. A joint's screws become
``Ad(G) s``; the two sides of a loop are displaced by ``G_P`` and ``G_S``, which leaves it open
by the gap ``G_S G_P⁻¹``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from balance.studies.sweeps.parameter_paths import NumberPlace, Sites
from kinematics.files.urdf.robot_tree import rotation_of_angles
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array


class OpenGeometries(NamedTuple):
    """Geometries whose loops are not yet closed, at the reference pose of the model.

    Attributes:
        screws: of the joints (rows, n, 6), inertial frame, SI units.
        points: of the joints (rows, n, 3), metres.
        gaps: of the welds (rows, loops, 4, 4); see `kinematics.model.linkage.Loop`.
        links: displacement of each link of the file by name (rows or 1, 4, 4).
    """

    screws: Array
    points: Array
    gaps: Array
    links: Mapping[str, Array]


class Placer:
    """A model, and the numbers of it that vary.

    Attributes:
        places: what each path names.
        nominal: value of each path in the model.
    """

    def __init__(
        self, linkage: Linkage, sites: Sites, paths: Mapping[str, NumberPlace]
    ) -> None:
        """Prepare the frames of the model.

        Args:
            linkage: the model at its reference pose.
            paths: the paths that vary, and what each names.
        """
        self.places = dict(paths)
        self.nominal = {path: sites.value(place) for path, place in paths.items()}
        self._sites, self._linkage = sites, linkage
        self._poses = {name: place.pose for name, place in linkage.places.items()}
        self._frames = [self._poses[site.link] @ site.pose for site in sites.sites]
        self._index = {joint.name: j for j, joint in enumerate(linkage.joints)}
        self._order = sorted(paths, key=lambda path: paths[path].kind == "length")

    def place(self, rows: int, values: Mapping[str, Array]) -> OpenGeometries:
        """Place joints and loops.

        Args:
            values: of each path (rows,), metres and radians.
        """
        origins, axes = self._moved_sites(values)
        links = {self._sites.root: np.eye(4)[None]}
        joints = self._linkage.joints
        screws, points = np.empty((rows, len(joints), 6)), np.empty((rows, len(joints), 3))
        pairs: dict[str, dict[str, Array]] = {}
        for k, site in enumerate(self._sites.sites):
            before = links[site.link]
            beyond = before @ self._shift(k, origins[k]) if k in origins else before
            turned = beyond
            if k in axes:
                local = self._frames[k] @ axes[k] @ np.linalg.inv(self._frames[k])
                turned = beyond @ local
            if site.side:
                pairs.setdefault(site.owner, {})[site.side] = turned
                if site.side == "successor":
                    continue
            else:
                links[site.child] = self._carry(k, beyond, axes.get(k))
            for name in coordinate_names(site.owner, site.kind):
                if name in self._index:
                    j = self._index[name]
                    screws[:, j] = _moved_screw(turned, joints[j].screw)
                    points[:, j] = turned[:, :3, :3] @ joints[j].point + turned[:, :3, 3]
        return OpenGeometries(screws, points, self._gaps(pairs, rows), links)

    def origins_of(self, values: Mapping[str, Array], row: int) -> dict[int, Array]:
        """Compute the origins (6,) of the sites that vary, in one row.

        Args:
            values: of all columns of parameters (rows,).
        """
        these = {path: values[path][row : row + 1] for path in self.places}
        return {k: origin[0] for k, origin in self._moved_sites(these)[0].items()}

    def _moved_sites(
        self, values: Mapping[str, Array]
    ) -> tuple[dict[int, Array], dict[int, Array]]:
        """Compute the origins (rows, 6) and rotations of axes (rows, 4, 4) that vary."""
        origins: dict[int, Array] = {}
        axes: dict[int, Array] = {}
        for path in self._order:
            place, value = self.places[path], values[path]
            site = self._sites.sites[place.site]
            if place.kind == "axis":
                n = axes.setdefault(place.site, np.tile(site.axis, (len(value), 1)))
                n[:, place.component] = value
                continue
            if place.site not in origins:
                origins[place.site] = np.tile(site.origin, (len(value), 1))
            origin = origins[place.site]
            if place.kind == "origin":
                origin[:, place.component] = value
                continue
            start = np.zeros(3)
            if place.other >= 0:
                start = origins.get(place.other, self._sites.sites[place.other].origin)[..., :3]
            span = origin[:, :3] - start
            length = np.sqrt(np.sum(span * span, axis=1))
            origin[:, :3] = start + span * (value / length)[:, None]
        turns = {k: _turn(self._sites.sites[k].axis, n) for k, n in axes.items()}
        # The axis of a loop is in both of its frames.
        later = {k + 1: turn for k, turn in turns.items() if self._sites.sites[k].side}
        return origins, turns | later

    def _shift(self, k: int, origin: Array) -> Array:
        """Compute the displacement ``T_p O' O⁻¹ T_p⁻¹`` of a site (rows, 4, 4)."""
        pose, old = self._poses[self._sites.sites[k].link], self._sites.sites[k].origin
        D = np.tile(np.eye(4), (len(origin), 1, 1))
        if np.array_equal(origin[:, 3:], np.broadcast_to(old[3:], origin[:, 3:].shape)):
            D[:, :3, 3] = (origin[:, :3] - old[:3]) @ pose[:3, :3].T
            return D
        D[:, :3, :3] = np.moveaxis(rotation_of_angles(origin[:, 3:].T), -1, 0)
        D[:, :3, 3] = origin[:, :3]
        return np.asarray(pose @ D @ np.linalg.inv(self._frames[k]))

    def _carry(self, k: int, beyond: Array, axis: Array | None) -> Array:
        """Compute the displacement of the link that a joint carries.

        Away from the pose of the file, the joint has turned by M about its axis: about another
        one, the link is elsewhere.
        """
        if axis is None:
            return beyond
        frame, child = self._frames[k], self._poses[self._sites.sites[k].child]
        M = np.linalg.inv(frame) @ child
        back = np.swapaxes(axis, -1, -2)
        return np.asarray(beyond @ frame @ axis @ M @ back @ np.linalg.inv(child))

    def _gaps(self, pairs: Mapping[str, Mapping[str, Array]], rows: int) -> Array:
        """Compute the gaps of all loops (rows, loops, 4, 4)."""
        gaps = np.empty((rows, len(self._linkage.loops), 4, 4))
        for number, loop in enumerate(self._linkage.loops):
            here, there = pairs[loop.name]["predecessor"], pairs[loop.name]["successor"]
            first = next(x for x in self._sites.sites if x.owner == loop.name and x.side)
            if self._linkage.places[first.link].link < 0 and loop.successor < 0:
                ends = self._linkage.joints[loop.end]
                if not ends.in_loop:  # a weld to the ground: its end is the successor
                    here, there = there, here
            gaps[:, number] = there @ np.linalg.inv(here)
        return gaps


def _moved_screw(H: Array, screw: Array) -> Array:
    """Compute ``Ad(H) s`` of one screw (6,) for displacements (rows, 4, 4)."""
    R = H[:, :3, :3]
    turned = R @ screw[:3]
    moved = R @ screw[3:] + (skew(H[:, :3, 3]) @ turned[..., None])[..., 0]
    return np.concatenate([turned, moved], axis=-1)


def _turn(axis: Array, given: Array) -> Array:
    """Compute the least rotations (rows, 4, 4) that turn a unit vector along others (rows, 3).

    ``1 + v̂ + v̂² / (1 + c)`` with ``v = a × b`` and ``c = a · b``; NaN for a zero vector.
    """
    with np.errstate(all="ignore"):
        b = given / np.sqrt(np.sum(given**2, axis=1, keepdims=True))
        v, c = skew(np.cross(axis, b)), b @ axis
        turn = np.tile(np.eye(4), (len(given), 1, 1))
        turn[:, :3, :3] += v + v @ v / (1.0 + c)[:, None, None]
    return turn
