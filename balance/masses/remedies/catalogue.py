"""The catalogue of remedies: names, words of the field, and sources."""

from __future__ import annotations

from typing import NamedTuple

from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError


class Remedy(NamedTuple):
    """A kind of remedy.

    Attributes:
        name: key of the remedy, also on the command line.
        short: what is built, in a few words without a comma: `remedy_named` reads it too.
        title: what it is, in words of the field.
        abbreviation: in reviews of the field; empty if there is none.
        source: author, year and place.
        module: that of its function ``apply_…``, which the comparison imports by its name, so
            that who names one remedy waits for no other.
    """

    name: str
    short: str
    title: str
    abbreviation: str
    source: str
    module: str


_REVIEW = "V. van der Wijk, J. L. Herder, B. Demeulenaere, J. Mech. Robotics 1(4), 2009"
_BECHT = "G. Becht, MSc thesis, TU Delft, 2020, chapter 2"
_BODY = (
    "Complete Shaking Force and Shaking Moment Balancing of Mechanisms Using a Moving Rigid "
    "Body, Technische Mechanik (journals.ub.ovgu.de/index.php/techmech/article/view/771)"
)

CATALOGUE: dict[str, Remedy] = {
    remedy.name: remedy
    for remedy in (
        Remedy(
            "own_masses",
            "counterweights on the links",
            "counter-masses on the links",
            "CM",
            _REVIEW,
            "matter_on_links",
        ),
        Remedy(
            "separate_rotors",
            "rotors against joints",
            "separate counter-rotations",
            "SCR",
            _REVIEW,
            "counter_rotations.separate_rotors",
        ),
        Remedy(
            "counter_rotary_masses",
            "turning counterweights",
            "counter-rotary counter-masses",
            "CRCM",
            _REVIEW,
            "counter_rotations.counter_rotary_masses",
        ),
        Remedy(
            "planetary_transmission",
            "rotors on the base by wheels",
            "counter-rotations on the base, driven by wheels along the links",
            "SCR",
            _BECHT,
            "counter_rotations.transmissions",
        ),
        Remedy(
            "parallelogram_transmission",
            "rotors on the base by bars",
            "counter-rotations on the base, driven by parallelograms (idler loops)",
            "SCR",
            _BECHT,
            "counter_rotations.transmissions",
        ),
        Remedy(
            "duplicates",
            "mirrored copies",
            "mirrored copies driven in step",
            "DM",
            _REVIEW,
            "copies.duplicates",
        ),
        Remedy(
            "added_dyad",
            "an added dyad",
            "an added dyad (Assur group)",
            "ALM",
            _REVIEW,
            "dyads.added_dyad",
        ),
        Remedy(
            "passive_wheel",
            "a wheel of varying ratio",
            "one wheel driven with a varying ratio",
            "",
            _BECHT,
            "balancers.balancing_wheels",
        ),
        Remedy(
            "active_wheel",
            "a wheel with a motor",
            "one wheel with a drive of its own",
            "ADBU",
            _REVIEW,
            "balancers.balancing_wheels",
        ),
        Remedy(
            "moving_mass",
            "a moving body with motors",
            "one body on slides with drives of its own",
            "ADBU",
            _BODY,
            "balancers.moving_body",
        ),
        Remedy(
            "cam_mass",
            "a moving body with cams",
            "one body moved by cams",
            "",
            _BODY,
            "balancers.moving_body",
        ),
        Remedy(
            "free_joint",
            "a free hinge of the frame",
            "a free joint at the common centre of mass",
            "",
            _BECHT,
            "balancers.free_joint",
        ),
        Remedy(
            "input_relation",
            "a relation of inputs",
            "a relation between inputs",
            "",
            _BECHT,
            "constraints.input_relations",
        ),
        Remedy(
            "slider_path",
            "a path of the slider",
            "a slider along a reactionless path",
            "",
            _BECHT,
            "constraints.slider_path",
        ),
        Remedy(
            "constant_speed_dyad",
            "a dyad at constant speed",
            "an added dyad (Assur group), for a crank at constant speed",
            "ALM",
            "S. Briot, V. Arakelian, Mechanism and Machine Theory 57, 2012",
            "dyads.constant_speed_dyad",
        ),
        Remedy(
            "balance_shafts",
            "balance shafts",
            "balance shafts against harmonics at constant speed",
            "",
            "F. W. Lanchester, 1911; E. N. Stevensen, J. Engineering for Industry 95(2), 1973",
            "shafts.balance_shafts",
        ),
        Remedy(
            "force_masses",
            "counterweights for the force",
            "counter-masses against the force alone",
            "CM",
            _REVIEW,
            "matter_on_links",
        ),
        Remedy(
            "pantograph",
            "a pantograph",
            "a pantograph with a counter-mass against the force",
            "",
            "V. H. Arakelian, M. R. Smith, J. Mechanical Design 127(2), 2005",
            "dyads.pantograph",
        ),
        Remedy(
            "partial",
            "counterweights for less shaking",
            "least shaking for a budget of matter",
            "",
            "S. Boyd, L. Vandenberghe, Convex Optimization, 2004",
            "matter_on_links",
        ),
        Remedy(
            "harmonic_springs",
            "springs at constant speed",
            "springs against the input torque at constant speed",
            "",
            "B. Demeulenaere, J. De Schutter, J. Mechanical Design 127(5), 2005",
            "shafts.harmonic_springs",
        ),
    )
}
"""Remedies by name, in the order in which they are applied."""


def remedy_named(text: str) -> str:
    """Find the name of a remedy, given by it or by what is built, as tables have it.

    Args:
        text: such as ``input_relation`` or ``"a relation of inputs"``, in upper or lower case,
            words apart by blanks or underscores.

    Raises:
        UsageError: there is none; the nearest one is suggested.

    Example:
        >>> from balance.masses.remedies.catalogue import remedy_named
        >>> remedy_named("Mirrored copies")
        'duplicates'
    """
    known = {_folded(each): remedy.name for remedy in CATALOGUE.values() for each in remedy[:2]}
    if _folded(text) not in known:
        meant = did_you_mean(text.strip(), (each for r in CATALOGUE.values() for each in r[:2]))
        names = ", ".join(CATALOGUE)
        raise UsageError(f"no remedy '{text.strip()}'{meant}: choose from {names}")
    return known[_folded(text)]


def _folded(text: str) -> str:
    """Write words in lower case, one blank apart."""
    return " ".join(text.lower().replace("_", " ").split())
