"""Claim: modes and supports take a fifth of a second, a flexible four-bar ten seconds.

The four-bar of J. P. Meijaard and V. van der Wijk (2022), its coupler of 16 elements hinged at
its ends, over 10 units of time; beside it exudyn, whose peak force agrees to 1 %.
"""

from __future__ import annotations

import numpy as np

from balance.motion.flexible.beam import Beam
from balance.motion.flexible.build_beam import BeamOptions
from balance.motion.flexible.drives import spin_up
from balance.motion.flexible.flex_links import parse_flex_link
from balance.motion.flexible.free_beam_modes import free_modes
from balance.motion.flexible.from_linkage import flexible_linkage
from balance.motion.flexible.simulate import simulate
from balance.motion.flexible.support_points import support_points
from balance.motion.flexible.supported_beam_modes import Support, supported_modes
from benchmarks.peers import library
from benchmarks.peers.exudyn_four_bar import peak_force
from kinematics import ScrewJoint, from_screws

DURATION, ELEMENTS = 10.0, 16
PROFILE = spin_up(1.0, 2.0)


class ModesAndSupportsAreQuick:
    """Twelve free modes, a beam on two pins, four supports; the error is that of λ1 = π."""

    params = ((96,),)
    claims = (("time_modes", 0.2), ("track_error", 1e-6))

    def setup(self, elements: int) -> None:
        """Load the libraries."""
        self.time_modes(elements)

    def time_modes(self, elements: int) -> None:
        """All of them."""
        free_modes(12)
        support_points(4)
        self.found = _pinned(elements)

    def track_error(self, elements: int) -> float:
        """Of the first frequency of a pinned beam."""
        return abs(_pinned(elements) / np.pi**2 - 1.0)


class FlexibleFourBarIsQuick:
    """A simulation with default tolerances; with ``runs`` it is a short one."""

    params = ((6,),)
    claims = (("time_simulate", 10.0),)
    runs = 0
    repetitions = 1

    def setup(self, modes: int) -> None:
        """Build the linkage; a short simulation loads the libraries."""
        self.found = _four_bar(modes)
        self.duration = 0.2 if self.runs else DURATION
        simulate(self.found.mechanism, 0.01, 2)

    def time_simulate(self, modes: int) -> None:
        """The four-bar."""
        self.peak = simulate(self.found.mechanism, self.duration, 501).peak_force


class FlexibleFourBarBesideExudyn(FlexibleFourBarIsQuick):
    """The same by exudyn, with 1000 steps per unit of time."""

    claims = (("track_difference", 0.01),)

    def setup(self, modes: int) -> None:
        """Build the linkage, and load exudyn."""
        library("exudyn")
        super().setup(modes)

    def time_exudyn(self, modes: int) -> None:
        """The four-bar."""
        self.other = peak_force(PROFILE, self.duration, ELEMENTS, int(1000 * self.duration))

    def track_difference(self, modes: int) -> float:
        """Of the peak shaking force from that of exudyn."""
        self.time_simulate(modes)
        self.time_exudyn(modes)
        return abs(self.peak / self.other - 1.0)


def _pinned(elements: int) -> float:
    """Compute the first frequency of a pinned beam."""
    supports = [Support((0.0,)), Support((1.0,))]
    return float(supported_modes(Beam(1.0, 1.0, 1.0), supports, 4, elements).frequencies[0])


def _four_bar(modes: int):
    """Build the four-bar; wheels add to the moments of inertia of crank and rocker.

    They turn against them, so that the moment on the mount is another one, the force the same.
    """
    points = {"u1": (0.0, 0.0, 0.0), "q2": (0.0, 0.5, 0.0), "q4": (1.5, -0.5, 0.0)}
    bodies = {
        "crank": (5.0, (0.0, -0.05, 0.0), 0.1375),
        "coupler": (1.0, (0.5, 0.5, 0.0), 1.0 / 12.0),
        "rocker": (5.0, (1.55, -0.6, 0.0), 0.6875),
    }
    parents = {"u1": ("base", "crank"), "q2": ("crank", "coupler"), "q4": ("base", "rocker")}
    linkage = from_screws(
        [ScrewJoint(name, *parents[name], point=point) for name, point in points.items()],
        [ScrewJoint("q3", "coupler", "rocker", point=(1.0, 0.5, 0.0))],
        {
            name: (mass, centre, moment * np.eye(3))
            for name, (mass, centre, moment) in bodies.items()
        },
        inputs=["u1"],
    )
    return flexible_linkage(
        linkage,
        [parse_flex_link("coupler=EI:1,rhoA:1")],
        {"u1": (PROFILE, False)},
        BeamOptions(elements=ELEMENTS, modes=modes),
    )
