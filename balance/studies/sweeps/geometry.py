"""One geometry of a sweep as a linkage, with the spaces that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from balance.masses.counterweights.counterweights import counterweights
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.partial_balance.partial_balance import PartialBalance
from balance.motion.verification.trajectory import Trajectory
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.studies.sweeps.closing import ClosedGeometries
from balance.studies.sweeps.swept_motion import (
    MOTION_OPTIONS,
    Options,
    motion_of_options,
)
from balance.studies.sweeps.swept_reduction import reduction
from balance.support.options import Balance
from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.joint_positions import with_bodies
from kinematics.files.urdf.read import inertial_parameters
from kinematics.files.urdf.robot_tree import describe_robot
from kinematics.model.arrays import freeze
from kinematics.model.chain import fitted_frame
from kinematics.model.linkage import Body, Linkage, LinkPose
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.numerics.array_types import Array


def link_inertias(linkage: Linkage) -> dict[str, Array]:
    """Compute the inertial parameters (10,) of each link of the file that has any.

    Args:
        linkage: a linkage with the elements of its file.

    Returns:
        By name of the link, about the inertial origin at the reference pose, SI units.
    """
    if linkage.tree is None:
        return {}
    return {
        name: inertial_parameters(inertial, linkage.places[name].pose)
        for name, inertial in describe_robot(linkage.tree).links.items()
        if inertial is not None
    }


def bar_inertial(mass_per_length: float, start: Array, end: Array) -> Array:
    """Compute the numbers of a uniform slender bar between two points of a link.

    ``m = ρ l``, the centre of mass in the middle, ``I = m l² / 12`` across.

    Args:
        mass_per_length: ρ, kg/m.
        start: one end (3,), metres.
        end: the other.

    Returns:
        Mass, centre of mass and inertia about it (10,), see `Sites.inertials`.
    """
    span = end - start
    length = float(np.linalg.norm(span))
    mass = mass_per_length * length
    inertia = mass / 12.0 * (length**2 * np.eye(3) - np.outer(span, span))
    middle = 0.5 * (start + end)
    return np.array([mass, *middle, *inertia.diagonal(), *inertia[[0, 0, 1], [1, 2, 2]]])


class SweptGeometry:
    """One row of a sweep.

    Attributes:
        row: its number among the rows that were closed together.
        lacks: why quantities have no masses, in words, by name of the quantity.
    """

    def __init__(
        self,
        model: Linkage,
        masses: Mapping[str, Array],
        closed: ClosedGeometries,
        row: int,
        balance: Balance,
        spatial: bool,
        like: SweptGeometry | None = None,
    ) -> None:
        """Keep what the linkage is made of.

        Args:
            model: the linkage of the study.
            masses: those of `link_inertias`.
            balance: as for `balance.design_space`.
            like: a geometry that differs in its masses alone: it moves as this one does.
        """
        self.row, self._model, self._masses, self._closed = row, model, masses, closed
        self.lacks: dict[str, str] = {}
        self._weights: Counterweights | None = None
        self._reduction: PartialBalance | None = None
        self._like = like
        self._motions: list[tuple[Options, Trajectory]] = [] if like is None else like._motions
        self._options: dict[str, Any] = {"balance": balance, "spatial": spatial}

    @cached_property
    def linkage(self) -> Linkage:
        """The linkage at the pose that closes its loops.

        Raises:
            LinkageError: it cannot be assembled.
        """
        model, closed, i = self._model, self._closed, self.row
        bodies = tuple(map(self._body, model.bodies))
        if self._like is not None:
            shared = with_bodies(self._like.linkage, bodies)
            if fitted_frame(shared).length == shared.spatial_chain.frame.length:
                return shared
        H = closed.H[i]
        joints = tuple(
            replace(
                joint,
                screw=freeze(screw),
                point=freeze(H[joint.parent, :3, :3] @ point + H[joint.parent, :3, 3]),
            )
            for joint, screw, point in zip(
                model.joints, closed.screws[i], closed.placed.points[i], strict=True
            )
        )
        places = {
            name: LinkPose(place.link, freeze(self._moved(name) @ place.pose))
            for name, place in model.places.items()
        }
        q = closed.q[i] + (0.0 if model.displaced is None else model.displaced)
        draft = replace(
            model,
            joints=joints,
            bodies=bodies,
            places=places,
            loops=tuple(replace(loop, gap=freeze(np.eye(4))) for loop in model.loops),
            displaced=freeze(q) if q.any() else None,
            notices=(),
            other_poses=(),
            at=None,
            tree=None,
            document=None,
        )
        return assemble(draft, model.inputs)

    @cached_property
    def space(self) -> DesignSpace:
        """Its design space."""
        return design_space(self.linkage, None, **self._options)

    def counterweights(self, options: Mapping[str, Any]) -> Counterweights:
        """Compute the least counterweights, once.

        Args:
            options: arguments of `balance.counterweights`.

        Raises:
            LinkageError: see there.
        """
        if self._weights is None:
            self._weights = counterweights(self.space, **options, relax=False, prove=False)
        return self._weights

    def motion(self, options: Options, turn_samples: int) -> Trajectory:
        """Compute the motion of the options of a quantity, once for all quantities with it.

        Args:
            options: see `balance.studies.sweeps.swept_motion.motion_of_options`.
            turn_samples: steps of a turn, by default.

        Raises:
            LinkageError: see there.
        """
        asked = {name: options[name] for name in MOTION_OPTIONS if name in options}
        asked["turn_samples"] = turn_samples
        for known, way in self._motions:
            if known == asked:
                return way
        # Reasons of rows have no numbers, and no remedy.
        way = motion_of_options(self.linkage, options, turn_samples, explain=False)
        self._motions.append((asked, way))
        return way

    def reduction(self, options: Mapping[str, Any]) -> PartialBalance:
        """Compute the matter within a budget that lets it shake least, once.

        Args:
            options: see `balance.studies.sweeps.swept_reduction.reduction`.

        Raises:
            LinkageError: see `balance.partial`.
        """
        if self._reduction is None:
            self._reduction = reduction(self.linkage, self._options["balance"], options)
        return self._reduction

    def _moved(self, link: str) -> Array:
        """Compute the displacement (4, 4) of a link of the file from its place in the model."""
        links = self._closed.placed.links[link]
        displacement = links[self.row if len(links) > 1 else 0]
        return np.asarray(
            self._closed.H[self.row, self._model.places[link].link] @ displacement
        )

    def _body(self, body: Body) -> Body:
        """Displace a body: the masses of all links of the file that are part of it."""
        H = self._moved(body.name)
        z = np.zeros(10)
        for name, inertia in self._masses.items():
            if self._model.places[name].link == body.link:
                z += displace_parameters(inertia, self._moved(name))
        frame = freeze(H @ body.frame)
        return replace(body, inertia=freeze(z), frame=frame)
