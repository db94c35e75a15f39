"""A general four-bar balanced by counterweights, and by rotors that gears turn against it.

Its links are bars of steel (`steel_links`), which stay; the tip of a rocker carries no tool.
Counterweights balance the forces, and rotors that gears turn backwards, at as few joints as
possible, the moments: the remedy ``separate_rotors`` of `balance.compare_remedies`. The file
has the gears as ``<mimic>``.

Source: R. S. Berkof, Mechanism and Machine Theory 8(3), 1973: two rotors are enough if the
coupler is a physical pendulum.
"""

from __future__ import annotations

from balance.masses.designs.density import STEEL
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.counter_rotations.separate_rotors import apply_separate_rotors
from balance.masses.remedies.request import RemedyRequest
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.general_four_bars import GeneralFourBar
from balance.studies.synthesis.steel_links import bar_width, bars_inertial
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document

# Turns of a rotor for one of its joint; radius of rotors, over the longest link.
GEAR, RADIUS = 3.0, 0.5


def balanced_by_rotors(
    four_bar: GeneralFourBar, density: float | None = STEEL, thickness: float | None = None
) -> AppliedRemedy | None:
    """Add counterweights and counter-rotors to a four-bar of steel bars.

    Args:
        density: density of counterweights and rotors at most, kg/m³; None for points.
        thickness: of the plates that they are, metres; None for other matter.

    Returns:
        The remedy, with its file; None if there is none that balances it.
    """
    at = four_bar.pivots()
    G, W, Z, H = (at[name] for name in ("crank_base", "crank_tip", "rocker_tip", "rocker_base"))
    tool = four_bar.first.point - W if four_bar.tool_link == "coupler" else None
    corners = [0j, Z - W] if tool is None else [0j, Z - W, tool, 0j]
    lengths = [abs(W - G), abs(Z - H), *map(abs, corners)]
    width = bar_width(lengths)
    inertials = {
        "crank": bars_inertial([0j, W - G], width),
        "coupler": bars_inertial(corners, width, tool),
        "rocker": bars_inertial([0j, Z - H], width),
    }
    try:
        linkage = load(Document(four_bar.kind, four_bar_urdf(four_bar, inertials)))
        request = RemedyRequest(
            linkage,
            gear=GEAR,
            radius=RADIUS * max(lengths),
            density=density,
            thickness=thickness,
            prove=False,
        )
        request.check()
        remedies = apply_separate_rotors(request)
        return next((each for each in remedies if each.verdict == "feasible"), None)
    except LinkageError:
        return None
