"""The catalogue of remedies: names, words of the field, and sources."""

from __future__ import annotations

from typing import NamedTuple


class Remedy(NamedTuple):
    """A kind of remedy.

    Attributes:
        name: key of the remedy, also on the command line.
        title: what it is, in words of the field.
        abbreviation: in reviews of the field; empty if there is none.
        source: author, year and place.
    """

    name: str
    title: str
    abbreviation: str
    source: str


_REVIEW = "V. van der Wijk, J. L. Herder, B. Demeulenaere, J. Mech. Robotics 1(4), 2009"
_BECHT = "G. Becht, MSc thesis, TU Delft, 2020, chapter 2"

CATALOGUE: dict[str, Remedy] = {
    remedy.name: remedy
    for remedy in (
        Remedy("own_masses", "counter-masses on the links", "CM", _REVIEW),
        Remedy("separate_rotors", "separate counter-rotations", "SCR", _REVIEW),
        Remedy("counter_rotary_masses", "counter-rotary counter-masses", "CRCM", _REVIEW),
        Remedy("planetary_transmission", "counter-rotations on the base, driven by "
               "wheels along the links", "SCR", _BECHT),
        Remedy("parallelogram_transmission", "counter-rotations on the base, driven by "
               "parallelograms (idler loops)", "SCR", _BECHT),
        Remedy("duplicates", "mirrored copies driven in step", "DM", _REVIEW),
        Remedy("added_dyad", "an added dyad (Assur group)", "ALM",
               "S. Briot, V. Arakelian, Mechanism and Machine Theory 57, 2012"),
        Remedy("passive_wheel", "one wheel driven with a varying ratio", "", _BECHT),
        Remedy("active_wheel", "one wheel with a drive of its own", "ADBU", _REVIEW),
        Remedy("input_relation", "a relation between inputs", "", _BECHT),
        Remedy("slider_path", "a slider along a reactionless path", "", _BECHT),
        Remedy("partial", "least shaking for a budget of matter", "",
               "S. Boyd, L. Vandenberghe, Convex Optimization, 2004"),
    )
}  # fmt: skip
"""Remedies by name, in the order in which they are applied."""
