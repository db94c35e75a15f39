"""The best balanced and physically realisable mass distribution for an objective."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from os import PathLike
from typing import get_args

import numpy as np

from balance.masses.designs.certificate import CertificateCheck
from balance.masses.designs.constraints import Constraints, build_program, constraints_of
from balance.masses.designs.density import AIR, STEEL, Solid, solid_data, solid_of, solid_texts
from balance.masses.designs.design_check import DesignCheck, check_design, leaves_plane
from balance.masses.designs.feasibility import Verdict, assemble_design, decide_feasibility
from balance.masses.designs.light_bodies import bounds_of_more_mass, light_text, more_mass_words
from balance.masses.designs.mass_regions import BALL_RADIUS, Ball
from balance.masses.designs.objectives import Objective, minimise_objective
from balance.masses.designs.pseudo_inertia_cone import (
    bodies_with,
    from_si,
    given_parameters,
    matrices_of,
)
from balance.masses.designs.verdicts import FORCES_ALONE, describe_furthest, describe_limits
from balance.masses.designs.write_urdf import replace_inertials
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.inertial_parameters.conversions import MassProperties
from balance.space.requirements.contradiction import contradiction, contradiction_words
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.requirements.required_space import RequiredSpace, space_of
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.mass_table import MassTable, mass_table
from balance.support.materials import Density, density_in_si
from balance.support.options import Balance
from balance.support.result_files import WithPage, WithPicture, write_file
from balance.support.tolerances import DENSITIES_EQUAL
from balance.support.units import length_in_si
from kinematics.errors import BodyError, UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import first_names, html_facts, number_text, repr_lines

DESIGN_SCHEMA = "balance.design/2"
# Thickness of flat bodies whose density is limited, in lengths of the space, unless given.
THICKNESS = 0.05
ONE_POSE = "; at the reference pose alone"  # end of the verdict


@dataclass(frozen=True, eq=False)
class Design(WithPage, WithPicture):
    """Result of `design`: a mass distribution, or a certificate that there is none.

    Attributes:
        space: the design space; spatial if kept bodies are not symmetric about the plane.
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        minimise: the objective.
        value: value of the objective in SI units (see `design`); None without an objective or
            a design.
        keep: names of the bodies that stay as in the file.
        bounds: least and largest mass of a body, kg.
        within: radius of the ball about the joints of each link that must contain its mass, in
            lengths of the link; kept links have none. None if masses may be anywhere.
        z: parameters (bodies, 10) about the inertial origin, SI units; None if there is
            no design.
        certificate: one symmetric matrix per body; see `check_certificate`.
        multipliers: one number per body, the second part of the certificate.
        margin: smallest eigenvalue of the pseudo-inertias over the sum of their traces, in
            units of the chain.
        residuals: result of the check of the design or of the certificate.
        words: the verdict in one line.
        anywhere: the answer without balls, if there is no design with balls and the answer
            without them differs; None otherwise.
        floor: least mass of a body that is not kept, kg, and its least second moment about its
            centre of mass, kg m², that an objective other than the change was minimised with;
            see `balance.masses.designs.objectives`. None otherwise.
        density: density that each body nowhere exceeds, kg/m³, by name; empty without limits.
        thickness: that of the bodies whose density is limited, m; None in space.
    """

    page_maker = "design:design_page"
    picture_maker = "design:design_picture"

    space: DesignSpace
    verdict: Verdict
    minimise: Objective | None
    value: float | None
    keep: tuple[str, ...]
    bounds: Mapping[str, tuple[float, float]]
    within: float | None
    z: Array | None
    certificate: tuple[Array, ...] | None
    multipliers: Array | None
    margin: float
    residuals: DesignCheck | CertificateCheck | None
    words: str
    anywhere: Design | None = None
    floor: tuple[float, float] | None = None
    density: Mapping[str, float] = field(default_factory=dict)
    thickness: float | None = None

    @property
    def constraints(self) -> Constraints:
        """Constraints of the design, as `check_design` and `check_certificate` take them."""
        return constraints_of(
            self.space, self.keep, self.bounds, self.within, self.density, self.thickness
        )

    @property
    def balls(self) -> dict[str, Ball]:
        """Ball that must contain the mass of each body, metres, inertial frame; see `Ball`.

        The disc of a planar linkage is at the height of the middle of the mechanism.
        """
        frame, names = self.space.chain.frame, self.space.bodies
        return {
            names[b]: Ball(
                frame.length * ball.centre @ frame.R[: ball.centre.size] + frame.origin,
                frame.length * ball.radius,
            )
            for b, ball in self.constraints.balls.items()
        }

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the mass of each body."""
        bodies = [f"{body.name} {number_text(body.mass)} kg" for body in self.bodies]
        bodies = [*more_mass_words(self.more_mass), *bodies]
        return repr_lines(f"Design for {self.space.linkage.name}", self.words, *bodies)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        bodies = ((body.name, f"{number_text(body.mass)} kg") for body in self.bodies)
        title = f"Design for {self.space.linkage.name}"
        return html_facts(title, ("verdict", self.words), *bodies)

    @property
    def bodies(self) -> tuple[BodyInertia, ...]:
        """Inertial parameters of the bodies in several frames; empty without a design."""
        return () if self.z is None else bodies_with(self.space, self.z)

    @property
    def solids(self) -> tuple[Solid | None, ...]:
        """Homogeneous solid that has the inertia of each body; empty without a design.

        Lengths are in metres, in the frame of the link. Flat bodies whose density is limited
        are plates, others ellipsoids. None without mass, and for a kept body that cannot be.
        """
        normal = self.space.axes[2]
        solids: list[Solid | None] = []
        for body, frame in zip(self.bodies, self.space.frames, strict=False):
            if body.link_com is None or body.link_inertia is None:
                solids.append(None)
                continue
            flat = self.thickness is not None and body.name in self.density
            properties = MassProperties(body.mass, body.link_com, body.link_inertia)
            solids.append(solid_of(properties, frame[:3, :3].T @ normal if flat else None))
        return tuple(solids)

    @property
    def densest(self) -> tuple[str, float] | None:
        """The body that needs the largest density, kg/m³, of those that are not kept."""
        needed = {
            body.name: solid.density
            for body, solid in zip(self.bodies, self.solids, strict=True)
            if solid is not None and body.name not in self.keep
        }
        if not needed:
            return None
        first = first_largest(list(needed.values()), relative=DENSITIES_EQUAL)
        return list(needed.items())[first]

    @property
    def lighter_than_air(self) -> tuple[str, ...]:
        """Names of the bodies, but for those kept, whose solids are lighter than air."""
        solids = zip(self.space.bodies, self.solids, strict=False)
        light = {name for name, solid in solids if solid is not None and solid.density < AIR}
        return tuple(name for name in self.space.bodies if name in light - {*self.keep})

    @cached_property
    def more_mass(self) -> Mapping[str, tuple[float, float]]:
        """Bounds that give bodies lighter than air more mass; empty if none have a design."""
        light = {x.name: x.mass for x in self.bodies if x.name in self.lighter_than_air}
        rest = self.within, False, self.density or None, self.thickness
        return bounds_of_more_mass(
            light, self.bounds, lambda x: maximise_margin(self.space, self.keep, x, *rest).z
        )

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the linkage with these masses, and no other change.

        Args:
            path: file to write it to; None for none.

        Raises:
            UsageError: there is no design.
            FileError: the linkage has no file, or the new one cannot be written.
        """
        if self.z is None:
            words = self.words.replace(FORCES_ALONE, f'{FORCES_ALONE} (balance="force")')
            raise UsageError(f"{self.space.linkage.name}: no masses to write: {words}")
        elements = {
            body.name: body.urdf
            for body in self.bodies
            if body.name not in self.keep and body.urdf
        }
        return write_file(path, replace_inertials(self.space.linkage, elements))

    def to_table(self) -> MassTable:
        """Return mass, centre, inertia and solid of each body; see `MassRow`."""
        rows = ((b.name, b.mass, b.link_com, b.link_inertia) for b in self.bodies)
        solids = solid_texts(self.space.bodies, self.solids) if self.density else {}
        note = light_text(self.lighter_than_air)
        return mass_table(rows, self.space.length, self.words, solids, note)

    def to_dict(self) -> dict[str, object]:
        """Return the design as plain data for JSON; see ``schemas/design.schema.json``."""
        return {
            "schema": DESIGN_SCHEMA,
            "model": self.space.linkage.name,
            "at": self.space.linkage.at,
            "algebra": "planar" if self.space.planar else "spatial",
            "balance": self.space.balance,
            "requirements": [item._asdict() for item in self.space.requirements],
            "verdict": self.verdict,
            "minimise": self.minimise,
            "value": self.value,
            "keep": list(self.keep),
            "bounds": {
                name: [low, high if high < inf else None]
                for name, (low, high) in self.bounds.items()
            },
            "within": self.within,
            "balls": {
                name: {"centre": ball.centre.tolist(), "radius": ball.radius}
                for name, ball in self.balls.items()
            },
            "margin": self.margin,
            "residuals": self.residuals._asdict() if self.residuals else None,
            "words": self.words,
            "certificate": [Z.tolist() for Z in self.certificate] if self.certificate else None,
            "multipliers": None if self.multipliers is None else self.multipliers.tolist(),
            "density": dict(self.density),
            "thickness": self.thickness,
            "bodies": [
                {**_as_data(body), "solid": solid and solid_data(solid)}
                for body, solid in zip(self.bodies, self.solids, strict=True)
            ],
            "anywhere": self.anywhere.to_dict() if self.anywhere else None,
            "floor": None if self.floor is None else list(self.floor),
            "readings": [reading.to_dict() for reading in self.space.readings],
        }


def _as_data(body: BodyInertia) -> dict[str, object]:
    """Return a body as plain data for JSON."""
    assert body.com is not None and body.link_com is not None and body.link_inertia is not None
    return {
        "name": body.name,
        "mass": body.mass,
        "com": body.com.tolist(),
        "link_com": body.link_com.tolist(),
        "link_inertia": body.link_inertia.tolist(),
        "moments": np.linalg.eigvalsh(body.link_inertia).tolist(),
        "z": body.z.tolist(),
    }


def design(
    space: DesignSpace | LinkageLike,
    minimise: Objective | None = None,
    *,
    keep: Sequence[str] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    within: float | None = BALL_RADIUS,
    one_pose: bool = False,
    density: Density = STEEL,
    thickness: float | str | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance | None = None,
) -> Design:
    """Compute the best balanced mass distribution, or a certificate that there is none.

    The design minimises the objective over all y with ``P_b(y) ≻ 0`` for every body b, where
    P_b is the pseudo-inertia of the body. In a plane all bodies are symmetric about it, so
    that all six components of the momentum vanish; if kept bodies are not, the conditions on
    all ten parameters are used. The mass of each body that is not kept is within a ball about
    the joints of its link; see `balance.masses.designs.mass_regions.ball_of`. If this leaves no
    design, the answer without balls is computed too.

    A limit of density makes bodies be those that a material allows: a homogeneous ellipsoid of
    at most this density has the inertia of the body, or, in a plane, an elliptic plate of the
    thickness; see `balance.masses.designs.density`. Other solids of the same inertia are less
    compact. Without an objective the design is that of the least change, if all bodies of the
    file have mass and extent; else, and without limits of density, that of the largest margin,
    with the mass of the file. Links may become ``lighter_than_air``: ``bounds`` hold them.

    Args:
        space: a design space, or a linkage, its path or its name.
        minimise: ``"mass"``: total mass, kg; ``"inertia"``: the largest principal moment of
            inertia of any body that is not kept, about the origin of its link frame, kg m²;
            ``"rotor"``: trace of the generalised inertia matrix of the motion at the reference
            pose, kg m², with sliding coordinates in lengths of ``space.length`` metres;
            ``"change"``: distance from the masses in the file, without a unit, the same in
            every link frame and unit; convex, so its minimum is a global one (see
            `balance.masses.designs.nearest`). Of the designs within 1e-5 of a least mass,
            inertia or rotor, the nearest to the file is the answer. Bounds of each: see
            `balance.masses.designs.objectives`.
        keep: names of bodies that stay as in the file.
        bounds: least and largest mass of bodies, kg, by name.
        within: radius of the balls, in lengths of the links; None for masses anywhere.
        one_pose: whether balance at the reference pose alone is enough: no momentum for any
            rates there. The space is then one of order 0, ``max_order=0``.
        density: density that no body exceeds, or that of some bodies by name, kg/m³ or a
            material; bodies that are kept have no limit. Steel by default; None for no limits.
        thickness: that of the bodies of a planar linkage whose density is limited, m, or a
            text such as ``"20mm"``; by default a twentieth of ``space.length``.
        motion: restriction of the inputs of a linkage; a space has its own.
        balance: ``"dynamic"``, as by default of a linkage, or ``"force"``.

    Returns:
        The design, or the certificate, and the result of its check.

    Raises:
        BodyError: a body is unknown, its bounds contradict each other, it is kept and
            limited, or the change is measured from one that is singular.
        LinkageError: all bodies are kept; or there is a thickness without a density, or in
            space.
        ValueError: there is no such objective, or the radius, a density or the thickness is
            not above 0.

    Source: T. Lee, P. M. Wensing, F. C. Park, IEEE Transactions on Robotics 36(1), 2020.

    Example:
        >>> import balance
        >>> bounds = {"crank": (0.5, 2.0)}
        >>> balance.design("robot.urdf", "mass", bounds=bounds, balance="force").bodies[0]
        BodyInertia of crank: 0.5 kg at ...
    """
    if minimise is not None and minimise not in get_args(Objective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(Objective))}")
    space = as_space(space, motion, balance)
    if one_pose and len(space.orders) > 1:
        raise ValueError("balance at one pose needs a space of order 0: give it max_order=0")
    limits = density_in_si(density), length_in_si(thickness)
    answer = maximise_margin(space, keep, bounds, within, one_pose, *limits)
    constraints = answer.constraints
    if minimise is None and density is not None and answer.z is not None:
        answer = _least_change(answer, constraints)
    elif minimise and answer.z is not None:
        answer = _minimise(replace(answer, minimise=minimise), constraints)
    else:
        answer = replace(answer, minimise=minimise)
    if within is not None and answer.z is None:
        answer = _with_answer_anywhere(answer, constraints, one_pose)
    if light := answer.lighter_than_air:
        answer = replace(
            answer, words=f"{answer.words}; lighter than air: {first_names(light)}"
        )
    if isinstance(answer.space, RequiredSpace) and answer.verdict == "infeasible":
        return replace(answer, words=f"{answer.words}; {_contradiction(answer, answer.space)}")
    return replace(answer, words=f"{answer.words}{ONE_POSE}") if one_pose else answer


def maximise_margin(
    space: DesignSpace,
    keep: Sequence[str] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    within: float | None = BALL_RADIUS,
    one_pose: bool = False,
    density: float | Mapping[str, float] | None = STEEL,
    thickness: float | None = None,
) -> Design:
    """Compute the design of the largest margin; see `design`.

    The space is a spatial one if kept bodies are not symmetric about the plane of the linkage.
    """
    limits = dict(bounds or {})
    constraints = constraints_of(space, keep, limits, within)
    if space.planar and space.balance == "dynamic" and leaves_plane(space, constraints):
        space = recompute_spatial(space, 0 if one_pose else None)
    if density is not None and thickness is None and space.planar:
        thickness = THICKNESS * space.length
    constraints = constraints_of(space, keep, limits, within, density, thickness)
    answer = decide_feasibility(space, constraints, all_balanced=one_pose)
    return Design(
        space,
        answer.verdict,
        None,
        None,
        tuple(keep),
        limits,
        within,
        answer.z,
        answer.certificate,
        answer.multipliers,
        answer.margin,
        answer.residuals,
        answer.words,
        density={
            space.bodies[b]: material.density for b, material in constraints.densities.items()
        },
        thickness=thickness,
    )


def _with_answer_anywhere(answer: Design, constraints: Constraints, one_pose: bool) -> Design:
    """Add the answer without balls to one without a design within them."""
    without_balls = design(
        answer.space,
        answer.minimise,
        keep=answer.keep,
        bounds=answer.bounds,
        within=None,
        one_pose=one_pose,
        density=answer.density or None,
        thickness=answer.thickness,
    )
    without_balls = replace(without_balls, words=without_balls.words.removesuffix(ONE_POSE))
    if without_balls.verdict == "infeasible":
        return replace(without_balls, within=answer.within)
    if answer.verdict == without_balls.verdict:
        return answer
    text = f"{without_balls.verdict} anywhere (--anywhere, in Python within=None)"
    if without_balls.z is not None:
        P = matrices_of(answer.space, without_balls.z)
        text = f"{text}: {describe_furthest(answer.space, P, constraints)}"
    words = answer.words.replace("undecided:", f"undecided{describe_limits(constraints)}:", 1)
    return replace(answer, words=f"{words}; {text}", anywhere=without_balls)


def _contradiction(answer: Design, space: RequiredSpace) -> str:
    """Name the requirements that leave no design: one alone, or the first two of them."""

    def excluded(chosen: Sequence[int]) -> bool:
        some = space_of(space.common, [space.regions[k] for k in chosen])
        constraints = constraints_of(
            some,
            answer.keep,
            answer.bounds,
            answer.within,
            answer.density or None,
            answer.thickness,
        )
        return decide_feasibility(some, constraints).verdict == "infeasible"

    return contradiction_words(contradiction(space.texts, excluded), "design")


def _minimise(answer: Design, constraints: Constraints) -> Design:
    """Replace a design by the one that minimises the objective."""
    assert answer.z is not None and answer.minimise is not None
    space, wanted = answer.space, answer.minimise
    program = build_program(space, constraints)
    for best in minimise_objective(space, program, wanted, answer.z, answer.margin):
        P = matrices_of(space, given_parameters(space))
        P[list(program.free)] = best.P
        z = assemble_design(
            space, constraints, P, _normal_moments(space) if wanted == "change" else None
        )
        check = check_design(space, z, constraints)
        if check.accepted:
            margin = program.cone.least(best.P).min() / np.trace(P, axis1=1, axis2=2).sum()
            return replace(
                answer,
                z=z,
                value=best.value,
                margin=float(margin),
                residuals=check,
                floor=best.floor,
                words=f"feasible: the design of the least {wanted}",
            )
    text = (
        f"undecided: there are designs, but the one of the least {wanted} was not found; ask "
        "for no objective to see one"
    )
    return replace(answer, verdict="undecided", z=None, margin=0.0, residuals=None, words=text)


def _least_change(answer: Design, constraints: Constraints) -> Design:
    """Replace a design by that of the least change, if it can be measured and is found."""
    try:
        nearest = _minimise(replace(answer, minimise="change"), constraints)
    except BodyError:
        return answer
    return nearest if nearest.z is not None else answer


def _normal_moments(space: DesignSpace) -> Array:
    """Compute central second moments of the file's bodies along the chain's third axis."""
    P = from_si(given_parameters(space), space.chain.frame)
    m = np.where(P[:, 3, 3], P[:, 3, 3], 1.0)
    return np.asarray(P[:, 2, 2] - P[:, 2, 3] ** 2 / m)
