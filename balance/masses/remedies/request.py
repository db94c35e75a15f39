"""A request for remedies: the linkage, and what may be used."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from balance.masses.counterweights.link_regions import ALL, regions_of
from balance.masses.counterweights.regions import Region
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.partial_balance.motion_loads import input_inertia
from balance.masses.partial_balance.shaking_problem import RANDOM_MOTIONS, SAMPLES
from balance.motion.verification.trajectory import Trajectory, random_motions
from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import Balance
from kinematics.errors import LinkageError, UsageError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.edit_xml import read_source
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.motion import motion_of

# Radius of rotors by default, in characteristic lengths of the linkage, or lengths of its tip.
ROTOR_RADIUS = 0.25
# Random motions along which a file is verified, and the poses of each: a momentum that is not
# zero is an analytic function of the pose, which generic poses do not miss.
MOTIONS, POSES = 5, 40
# What is known of the linkage, whatever the options.
KEPT = (
    "space",
    "spatial_space",
    "own_file",
    "base",
    "massless",
    "input_inertia",
    "motions",
    "motions_of_loads",
)


@dataclass(frozen=True, eq=False)
class RemedyRequest:
    """What remedies are applied to, and with what.

    Attributes:
        linkage: the linkage.
        motion: relations between its inputs.
        balance: ``"dynamic"`` or ``"force"``.
        named_links: links of the linkage to which matter may be added; all bodies by default.
        regions: where, by name of the link, see `balance.counterweights`.
        gear: turns of a rotor for one turn of its joint, N > 0.
        radius: radius of rotors, metres; None for a quarter of the characteristic length, or
            of the length of a link at the end of a chain if that is longer.
        budget: most mass that partial balance may add, kg; None for the mass of the linkage.
        spatial: whether bodies have ten parameters even in a plane.
        angles: how angles that look rounded are read; see `kinematics.load`.
        progress: called with the number of steps done and of all steps of a search.
        only: remedies that the user names: long searches are made for these alone.
        trade_off: points of added mass against input inertia for each remedy that balances by
            the least matter; 0 for none.
        density: density that added matter nowhere exceeds, kg/m³; None for point masses.
        thickness: that of plates of added matter on a planar linkage, m; None for other matter.
        prove: whether the gap of the least matter is proved, and that there is none; see
            `balance.counterweights`.
    """

    linkage: Linkage
    motion: tuple[str, ...] = ()
    balance: Balance = "dynamic"
    named_links: tuple[str, ...] = ()
    regions: Mapping[str, Region | str] = field(default_factory=dict)
    gear: float = 1.0
    radius: float | None = None
    budget: float | None = None
    spatial: bool = False
    angles: str = "nominal"
    progress: Callable[[int, int], None] | None = None
    only: tuple[str, ...] = ()
    trade_off: int = 0
    density: float | None = None
    thickness: float | None = None
    prove: bool = True

    def check(self) -> None:
        """Refuse a request that no remedy can serve.

        Raises:
            UsageError: a number is out of range, no link carries parameters, or a region is
                for another link.
            BodyError: a link to add matter to is unknown.
        """
        for name, value in (("gear", self.gear), ("rotor radius", self.rotor_radius)):
            if not 0.0 < value < float("inf"):
                raise UsageError(f"{name} {value:g}: give a positive number")
        if self.trade_off < 0 or self.trade_off == 1:
            raise UsageError(f"a trade-off of {self.trade_off} points: give 2 or more")
        if self.density is not None and not 0.0 < self.density < float("inf"):
            raise UsageError(f"density {self.density:g}: give a positive number")
        if self.budget is not None and not 0.0 <= self.budget < float("inf"):
            raise UsageError(f"budget {self.budget:g}: a mass is not negative")
        if not self.given_mass > 0.0:
            raise LinkageError(
                f"{self.linkage.source}: no moving link has a mass; remedies are compared by "
                "what they add: give the links that move an <inertial>"
            )
        regions_of(self.space, self.links, self.regions)

    def changed(self, **changes: Any) -> RemedyRequest:
        """Return the request with other options; what is known of its linkage stays."""
        request = replace(self, **changes)
        for name in KEPT:
            if name in self.__dict__:
                request.__dict__[name] = self.__dict__[name]
        return request

    @property
    def links(self) -> tuple[str, ...]:
        """Links of the linkage to which matter may be added."""
        everything = ALL not in self.linkage.places and self.named_links == (ALL,)
        return self.space.bodies if everything else self.named_links or self.space.bodies

    @cached_property
    def space(self) -> CertifiedSpace:
        """The design space of the linkage as it is."""
        return certify(
            design_space(self.linkage, self.motion or None, self.balance, spatial=self.spatial)
        )

    @cached_property
    def spatial_space(self) -> DesignSpace:
        """The same with all components of the momentum, on ten parameters of each body."""
        return recompute_spatial(self.space)

    @property
    def rotor_radius(self) -> float:
        """Radius of rotors, metres."""
        if self.radius is not None:
            return self.radius
        return ROTOR_RADIUS * max(self.space.length, self._tip_length)

    @property
    def _tip_length(self) -> float:
        """Length of the longest link that carries no joint: its centre of mass is half-way.

        The characteristic length is one of the joints, and does not know of such links.
        """
        joints = self.linkage.joints
        inner = {joint.parent for joint in joints} | {loop.end for loop in self.linkage.loops}
        inner |= {loop.successor for loop in self.linkage.loops}
        tips = [
            body
            for body in self.linkage.bodies
            if body.link not in inner and body.inertia[0] > 0.0
        ]
        arms = [
            np.cross(joints[body.link].screw[:3], joints[body.link].point - centre)
            for body in tips
            for centre in (body.inertia[1:4] / body.inertia[0],)
        ]
        return 2.0 * max((float(np.linalg.norm(arm)) for arm in arms), default=0.0)

    @property
    def given_mass(self) -> float:
        """Mass of the moving bodies in the file, kg."""
        return float(given_parameters(self.space)[:, 0].sum())

    @cached_property
    def base(self) -> Document:
        """URDF text of the linkage: its own file, if that says all of it at its pose.

        Loops of a YAML file, another reference pose, other formats and repaired loops are not
        in the file; the linkage is then written anew.
        """
        if self.own_file is not None:
            return self.own_file
        return Document(self.linkage.source, self.linkage.to_urdf().encode())

    @cached_property
    def own_file(self) -> Document | None:
        """The file of the linkage, if nothing else makes up the linkage; see `base`."""
        linkage = self.linkage
        if linkage.tree is None or linkage.displaced is not None:
            return None
        try:
            data, _ = read_source(linkage, "link", "")
            document = Document(linkage.source, data)
            read = read_unassembled(document, None, ReadOptions(angles=self.angles))
        except LinkageError:
            return None
        # Links that the user declares massless have masses in the file.
        heavy = {body.name for body in linkage.bodies if body.inertia.any()}
        same = heavy == {body.name for body in read.bodies if body.inertia.any()}
        return document if same and read.tree == linkage.tree else None

    @property
    def space_of_base(self) -> DesignSpace:
        """The design space of the linkage in `base`, to which matter can be written.

        Raises:
            LinkageError: it does not assemble.
        """
        if self.own_file is not None:
            return self.space
        motion = self.motion or None
        return design_space(self.load_base(), motion, self.balance, spatial=self.spatial)

    def load_base(self) -> Linkage:
        """Load the linkage in `base`; all of its links that may carry matter are bodies.

        Raises:
            LinkageError: it does not assemble.
        """
        return load(
            self.base,
            None,
            self.linkage.inputs,
            bodies="all",
            massless=self.massless,
            angles=self.angles,
        )

    @cached_property
    def massless(self) -> tuple[str, ...]:
        """Links that move and carry no parameters, each rigid body once.

        Those between the joints that a spherical, planar or floating joint is written as are
        not in the linkage, but in `base`.
        """
        carry = {GROUND, *(body.link for body in self.linkage.bodies)}
        top: dict[int, str] = {}
        for name, place in self.linkage.places.items():
            top.setdefault(place.link, name)
        between = (
            link.name
            for link in build_tree(self.base.data).children
            if link.tag == "link" and link.name not in self.linkage.places
        )
        return (*(name for link, name in top.items() if link not in carry), *between)

    @property
    def freedoms(self) -> int:
        """Degrees of freedom of the linkage under its relations."""
        return freedoms_of(self.linkage, self.motion)

    @cached_property
    def motions(self) -> tuple[Trajectory, ...]:
        """Random motions of 1 s of the linkage under its relations.

        Raises:
            PoseError: there are none near the reference pose.
        """
        return self._random_motions(MOTIONS, POSES)

    @cached_property
    def motions_of_loads(self) -> tuple[Trajectory, ...]:
        """Those along which `balance.partial` and `balance.verify` compute loads.

        Raises:
            PoseError: there are none near the reference pose.
        """
        return self._random_motions(RANDOM_MOTIONS, SAMPLES)

    def _random_motions(self, count: int, samples: int) -> tuple[Trajectory, ...]:
        """Make random motions under the relations of the request."""
        limits = motion_of(self.linkage, self.motion or None)
        return tuple(random_motions(self.linkage, count, samples, motion=limits))

    @cached_property
    def input_inertia(self) -> dict[str, float]:
        """Inertia that each input feels in the file, by name; see `input_inertia`."""
        return input_inertia(self.linkage)


def freedoms_of(linkage: Linkage, motion: Sequence[str]) -> int:
    """Count the degrees of freedom of a linkage under relations of its inputs.

    Raises:
        MotionError: a relation is wrong.
    """
    restricted = motion_of(linkage, motion or None)
    return linkage.mobility if restricted is None else int(restricted.basis.shape[1])
