"""Simulate a planar linkage of which named links bend, as a user asks for it.

Bodies at rest under an input at speed take a blow, whose forces grow with the number of modes.
Without one, the links bend as the inertia forces of the rigid motion ask, and no more. With
elastic coordinates q that stand still, rigid accelerations a_r and multipliers λ solve

    M_r a_r + Gᵀ λ + [0; K q] = Q - h        G_r a_r = γ

The bending changes along the motion, which gives its rates: differences of q at two instants.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.flexible.build_beam import BeamOptions
from balance.motion.flexible.drives import DriveProfile, parse_drive
from balance.motion.flexible.flex_data import beam_deflection, moment_about, motion_data
from balance.motion.flexible.flex_links import FlexLink, parse_flex_link
from balance.motion.flexible.from_linkage import FlexibleLinkage, flexible_linkage
from balance.motion.flexible.mechanism import PlanarMechanism, solve_bordered
from balance.motion.flexible.simulate import FlexibleMotion, simulate
from balance.support.options import point_of
from balance.support.result_files import WithPage, WithPicture
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import Array, Flags
from kinematics.wording import html_facts, number_text, repr_lines, size_text

FEWEST_MODES = 6
DEFAULT_DRIVE = "spin:1,1"
LARGE_BENDING = 0.03
"""Bending over the length of a beam above which its peaks are off by a percent and more."""
# Most iterations of closing and bending; each is smaller by the square of the ratio of the
# frequency of the motion to that of the beam.
MOST_STEPS = 60
# Change of the coordinates over the size of the mechanism at which they have settled.
SETTLED = 1e-12
# Motion between the instants of a difference, in radians and sizes of the mechanism.
DIFFERENCE = 1e-3


@dataclass(frozen=True, eq=False)
class FlexibleSimulation(WithPage, WithPicture):
    """Result of `simulate_flexible`: the shaking of a linkage of which links bend.

    Attributes:
        flexible: the linkage in the plane, with its beams.
        motion: coordinates, shaking and energy over time.
        notices: remarks, those of the linkage included.
    """

    page_maker = "flexible:flexible_page"
    picture_maker = "flexible_pictures:shaking_picture"

    flexible: FlexibleLinkage
    motion: FlexibleMotion
    notices: tuple[Notice, ...]

    def __repr__(self) -> str:
        """Name the linkage, the peaks of its shaking, and what bends."""
        bends = ", ".join(
            f"{name} by {beam_deflection(self.motion, self.flexible, name).max():.3g} m"
            for name in self.flexible.beams
        )
        return repr_lines(
            f"FlexibleSimulation of {self.flexible.linkage.name} over {self.time[-1]:g} s",
            f"shaking force {self.peak_force:.4g} N, moment {self.peak_moment:.4g} N m at most",
            f"bends: {bends or 'nothing'}",
            f"drift of energy {size_text(self.motion.energy_drift)}",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"{self.flexible.linkage.name}: links that bend",
            ("duration", f"{self.time[-1]:g} s"),
            ("shaking force", f"{self.peak_force:.4g} N at most"),
            ("shaking moment", f"{self.peak_moment:.4g} N m at most"),
            ("energy", f"drift {size_text(self.motion.energy_drift)}"),
        )

    @property
    def time(self) -> Array:
        """Instants, in seconds; shape (t,)."""
        return self.motion.times

    @property
    def force(self) -> Array:
        """Shaking force on the mount, in the plane, in N; shape (t, 2)."""
        return self.motion.force

    @property
    def moment(self) -> Array:
        """Shaking moment about the point, in N m; shape (t,)."""
        return moment_about(self.motion, self.flexible.point)

    @property
    def peak_force(self) -> float:
        """Largest magnitude of the shaking force, in N."""
        return self.motion.peak_force

    @property
    def peak_moment(self) -> float:
        """Largest magnitude of the shaking moment about the point, in N m."""
        return float(np.abs(self.moment).max())

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data; see ``schemas/flex.schema.json``."""
        return motion_data(self.flexible, self.motion)


def _needed_modes(flex: Sequence[FlexLink]) -> int:
    """Compute how many modes of each beam give the shaking to some percent.

    On n supports at their best points, the first mode that shakes the mount is about the
    (2n - 1)st: fewer modes would show no shaking at all.
    """
    most = max((link.supports for link in flex), default=0)
    return max(FEWEST_MODES, 2 * most + 2 if most > 2 else 0)


def simulate_flexible(
    linkage: LinkageLike,
    flex: Sequence[FlexLink | str],
    drives: Mapping[str, DriveProfile | str] | None = None,
    duration: float = 5.0,
    *,
    samples: int = 501,
    elements: int | None = None,
    modes: int | None = None,
    damping: float = 0.0,
    geometric: bool = True,
    from_rest: bool = False,
    about: ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FlexibleSimulation:
    """Simulate a planar linkage of which named links bend, and its shaking.

    The links become straight beams through their revolute joints, in floating frames;
    everything else stays as the file says. The linkage starts in its reference pose: at rest,
    or, if an input has a speed there, with the velocities of rigid links and the bending that
    their inertia forces ask.

    Args:
        linkage: an assembled linkage, or an argument of `kinematics.load`.
        flex: links that bend, as data or as words: ``"coupler=EI:2.1,rhoA:0.12"`` in SI units,
            or ``"coupler=rect(0.01,0.002),steel"``.
        drives: inputs by the name of their joint, as profile and whether that is a moment, or
            as words: ``"spin:SPEED,RISE"``, ``"speed:SPEED"``, ``"moment:VALUE,RISE"``. By
            default the first input spins up to 1 rad/s in 1 s. Other inputs stay.
        duration: seconds.
        samples: number of instants of the result.
        elements: of each beam; by default 16, or twice the modes if that is more.
        modes: of each beam that are kept; by default as many as `_needed_modes` says.
        damping: β of the damping β K, in seconds.
        geometric: whether a bent beam keeps its length (centrifugal and axial stiffening).
        from_rest: whether all bodies are at rest at the start even if an input has a speed
            there, which hits them: the forces of this blow grow with the number of modes.
        about: point in the inertial frame for moments, metres; the centre of mass at the start
            by default.
        progress: is called with the instants done and of all.

    Raises:
        UsageError: words have another form.
        LinkageError: the linkage is not planar, a link cannot be a beam, or the integration
            fails.

    Source: J. P. Meijaard, V. van der Wijk, Mechanism and Machine Theory 172, 104784, 2022.

    Example:
        >>> import balance
        >>> bends, drive = ["coupler=EI:2,rhoA:0.5"], {"u1": "spin:3,0.1"}
        >>> simulation = balance.flexible.simulate_flexible("robot.urdf", bends, drive, 0.2)
        >>> simulation.force.shape, simulation.motion.energy_drift < 1e-6
        ((501, 2), True)
    """
    linkage = as_linkage(linkage)
    links = [parse_flex_link(link) if isinstance(link, str) else link for link in flex]
    given = drives or dict.fromkeys(linkage.inputs[:1], DEFAULT_DRIVE)
    inputs = {
        name: parse_drive(drive) if isinstance(drive, str) else drive
        for name, drive in given.items()
    }
    enough = _needed_modes(links)
    kept = enough if modes is None else modes
    size = max(16, 2 * kept) if elements is None else elements
    options = BeamOptions(size, kept, geometric=geometric, damping=damping)
    flexible = flexible_linkage(linkage, links, inputs, options)
    if about is not None:
        flexible = replace(flexible, about=(flexible.axes @ point_of(about))[:2])
    start = velocities = None
    if _moves_at_start(flexible.mechanism) and not from_rest:
        flexible.mechanism.check()
        start, velocities = _steady_start(flexible.mechanism)
    motion = simulate(
        flexible.mechanism,
        duration,
        samples,
        start=start,
        velocities=velocities,
        progress=progress,
    )
    notices = (*linkage.notices, *_notices(kept, enough), *_bending_notices(flexible, motion))
    return FlexibleSimulation(flexible, motion, notices)


def _notices(kept: int, enough: int) -> tuple[Notice, ...]:
    """Warn of modes that are too few for the supports."""
    if enough == FEWEST_MODES or kept >= enough - 2:
        return ()
    message = (
        f"{kept} modes of a beam are too few for its supports, which silence the lowest modes: "
        f"the shaking comes out too small; keep {enough}, the default"
    )
    return (Notice("few_modes", message),)


def _bending_notices(flexible: FlexibleLinkage, motion: FlexibleMotion) -> tuple[Notice, ...]:
    """Warn of links that bend further than the model of small bending follows."""
    notices = []
    for name, model in flexible.beams.items():
        share = float(beam_deflection(motion, flexible, name).max()) / model.part.length
        if share > LARGE_BENDING:
            notices.append(
                Notice(
                    "large_bending",
                    f"link '{name}' bends by {number_text(100.0 * share, '.2g')} % of its "
                    "length, and the beam is one of small bending: peaks are off by about "
                    "1.5 % at 5 % of the length, by 25 % at 17 %; stiffen it or drive slower",
                )
            )
    return tuple(notices)


def _moves_at_start(mechanism: PlanarMechanism) -> bool:
    """Tell whether an input has a speed at the start."""
    return any(drive.profile(0.0)[1] != 0.0 for drive in mechanism.drives if not drive.moment)


def _steady_start(mechanism: PlanarMechanism) -> tuple[Array, Array]:
    """Compute coordinates and rates (n,) of a mechanism that has moved steadily before.

    Args:
        mechanism: the mechanism; its start is taken without bending.

    Raises:
        LinkageError: the links bend too far, or the mechanism does not close.
    """
    p, v = _settle(mechanism, 0.0, mechanism.start)
    bends = _elastic(mechanism)
    turning = [at.start + 2 for at in mechanism.slices]
    fastest = np.abs(v[turning]).max(initial=0.0)
    shifts = np.abs(np.delete(v, turning)).max(initial=0.0) / mechanism.size
    h = DIFFERENCE / max(fastest, shifts, 1e-300)
    ahead, behind = (_settle(mechanism, t, p + t * v)[0] for t in (h, -h))
    rates = np.zeros(len(p))
    rates[bends] = (ahead - behind)[bends] / (2.0 * h)
    return p, _rigid_rates(mechanism, 0.0, p, rates)


def _elastic(mechanism: PlanarMechanism) -> Flags:
    """Mark the elastic coordinates (n,)."""
    mask = np.zeros(len(mechanism.start), dtype=np.bool_)
    for at in mechanism.slices:
        mask[at.start + 3 : at.stop] = True
    return mask


def _settle(mechanism: PlanarMechanism, t: float, p: Array) -> tuple[Array, Array]:
    """Bend the links as the rigid motion at a time asks; rates are those of the rigid motion.

    Raises:
        LinkageError: the bending does not settle.
    """
    for _ in range(MOST_STEPS):
        p = _close(mechanism, t, p)
        v = _rigid_rates(mechanism, t, p, np.zeros(len(p)))
        bent = _bend(mechanism, t, p, v)
        change = np.abs(bent - p).max(initial=0.0)
        p = bent
        if change <= SETTLED * max(mechanism.size, 1e-6):
            return _close(mechanism, t, p), v
        if not change < 1e3 * mechanism.size:
            break
    raise LinkageError(
        "the links bend too far at this speed for a start without a blow: lower the speed, or "
        "spin the input up from rest (spin:SPEED,RISE)"
    )


def _close(mechanism: PlanarMechanism, t: float, p: Array) -> Array:
    """Move the rigid coordinates onto the constraints; the bending stays."""
    rigid, v = ~_elastic(mechanism), np.zeros(len(p))
    for _ in range(MOST_STEPS):
        constraints = mechanism.constraints(t, p, v)
        if np.abs(constraints.g).max(initial=0.0) < SETTLED * max(mechanism.size, 1e-6):
            break
        p = p.copy()
        p[rigid] -= _least(mechanism, p, constraints.rows, constraints.g)
    return p


def _rigid_rates(mechanism: PlanarMechanism, t: float, p: Array, v: Array) -> Array:
    """Complete the rates of the elastic coordinates by rigid ones that keep the constraints."""
    constraints, rigid = mechanism.constraints(t, p, v), ~_elastic(mechanism)
    v = v.copy()
    v[rigid] -= _least(mechanism, p, constraints.rows, constraints.rows @ v + constraints.rates)
    return v


def _least(mechanism: PlanarMechanism, p: Array, rows: Array, residual: Array) -> Array:
    """Solve G_r Δ = residual for the rigid change Δ of least mass-weighted size."""
    rigid = ~_elastic(mechanism)
    mass = mechanism.inertia(p, np.zeros(len(p)))[0][np.ix_(rigid, rigid)]
    right = np.concatenate([np.zeros(len(mass)), residual])
    return solve_bordered(mass, rows[:, rigid], right)[: len(mass)]


def _bend(mechanism: PlanarMechanism, t: float, p: Array, v: Array) -> Array:
    """Compute the coordinates with the bending that the rigid accelerations at a state ask."""
    bends = _elastic(mechanism)
    mass, bias = mechanism.inertia(p, v)
    closure = mechanism.constraints(t, p, v)
    stiffness = np.zeros_like(mass)
    for part, at in zip(mechanism.parts, mechanism.slices, strict=True):
        elastic = slice(at.start + 3, at.stop)
        stiffness[elastic, elastic] = part.stiffness
    # Unknown are rigid accelerations and elastic coordinates, in the places of each other.
    columns = np.where(bends, stiffness, mass)
    right = np.concatenate([stiffness @ p - bias, closure.gamma])
    for drive in mechanism.drives:
        if drive.moment:
            right[: len(p)] += drive.profile(t)[0] * closure.positions[drive.joint].row
    full = np.block(
        [
            [columns, closure.rows.T],
            [
                np.where(bends, 0.0, closure.rows),
                np.zeros((len(closure.rows), len(closure.rows))),
            ],
        ]
    )
    try:
        solution = np.linalg.solve(full, right)
    except np.linalg.LinAlgError:
        raise LinkageError(
            "the flexible mechanism starts in a singular pose, where its constraints depend on "
            "one another; start it elsewhere (--at)"
        ) from None
    return np.where(bends, solution[: len(p)], p)
