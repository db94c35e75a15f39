"""The result of an identification: combinations, masses, and what they mean for balance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import NamedTuple

import numpy as np

from balance.masses.designs.pseudo_inertia_cone import bodies_with
from balance.masses.designs.write_urdf import replace_inertials
from balance.masses.identification.combinations import Combination
from balance.masses.identification.measurements import Measurements
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.spaces.design_space import DesignSpace
from balance.support.result_files import WithPage, WithPicture, write_file
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, html_facts, number_text, repr_lines

SCHEMA = "balance.identify/1"


class Identified(NamedTuple):
    """A combination of parameters, in the file and as it was measured; SI units.

    Attributes:
        combination: which one.
        file: its value with the masses of the file.
        value: its measured value; None if the loads do not determine it.
        error: the standard error of that; None likewise.
        likeliest: its value with the likeliest masses.
    """

    combination: Combination
    file: float
    value: float | None
    error: float | None
    likeliest: float

    @property
    def off(self) -> float | None:
        """Difference of the file from what was measured, in standard errors."""
        if self.value is None or not self.error:
            return None
        return (self.file - self.value) / self.error

    def __repr__(self) -> str:
        """One line: the combination, its value and its standard error."""
        if self.value is None or self.error is None:
            return f"Identified: {self.combination.words} is not determined"
        value, error = number_text(self.value), number_text(self.error, ".2g")
        return f"Identified: {self.combination.words} = {value} ± {error}"


class IdentifiedMass(NamedTuple):
    """The likeliest mass of a link.

    Attributes:
        link: its name.
        file: mass in the file, kg.
        mass: the likeliest mass, kg.
        error: its standard error, kg, of loads and file together.
        com: centre of mass in the link frame (3,), metres.
    """

    link: str
    file: float
    mass: float
    error: float
    com: Array

    def __repr__(self) -> str:
        """One line: the mass and its standard error."""
        mass, error = number_text(self.mass), number_text(self.error, ".2g")
        return f"IdentifiedMass of {self.link}: {mass} ± {error} kg"


class ShakingOf(NamedTuple):
    """Shaking along the measured motions, root mean square, without gravity.

    Attributes:
        force: N.
        moment: about the point of the moments, N m.
        force_error: standard error of the force, N; 0 for the masses of the file.
        moment_error: that of the moment, N m.
        force_share: the force over the sum of the forces of the single bodies.
        moment_share: the moment over the sum of the moments of the single bodies.
    """

    force: float
    moment: float
    force_error: float
    moment_error: float
    force_share: float
    moment_share: float


class ChannelFit(NamedTuple):
    """How well identified masses explain a measured load.

    Attributes:
        name: of the channel.
        size: root mean square of the load, N or N m.
        file: root mean square of what the masses of the file leave of it.
        residual: the same of the identified combinations.
        noise: standard deviation of its noise, as the residuals show it.
        correlation: of neighbouring residuals.
    """

    name: str
    size: float
    file: float
    residual: float
    noise: float
    correlation: float


class Recording(NamedTuple):
    """A measured motion, the loads that were measured with it, and what explains these.

    Attributes:
        trajectory: the motion at the times of the loads.
        measurements: the loads.
        predicted: loads of the masses of the file, and of the identified combinations
            (2, N, channels).
        channels: how well each load is explained.
    """

    trajectory: Trajectory
    measurements: Measurements
    predicted: Array
    channels: tuple[ChannelFit, ...]

    @property
    def duration(self) -> float:
        """Time from the first sample of the loads to the last, seconds."""
        return float(np.ptp(self.measurements.time))

    @property
    def words(self) -> str:
        """What was measured: ``fx, fy, mz: 80 samples, 2 s``."""
        samples = count_noun(len(self.measurements.time), "sample")
        names = ", ".join(self.measurements.channels)
        return f"{names}: {samples}, {number_text(self.duration)} s"

    def __repr__(self) -> str:
        """One line: the channels, the number of samples and the duration."""
        return f"Recording of {self.words}"


@dataclass(frozen=True, eq=False)
class Identification(WithPage, WithPicture):
    """Result of `identify`.

    Attributes:
        space: the design space of the linkage, whose complement are the combinations on which
            balance depends.
        combinations: these combinations, those that the loads determine first.
        excited: number of all combinations that the loads determine, also of those that only
            weigh.
        condition: ratio of the largest and the smallest standard error of unit combinations
            among those on which balance depends; masses in kg, lengths in `space.length`.
        recordings: the measured motions and loads, and how well each load is explained.
        z: likeliest parameters (bodies, 10) about the inertial origin, SI units.
        masses: the likeliest mass of each link.
        before: shaking with the masses of the file, over the samples of all recordings.
        after: shaking as it was identified: by the loads alone, if they determine it, else with
            the likeliest masses.
        load_errors: bounds on the error of force, N, and moment, N m, root mean square, since
            the table of the motion is rounded; 0 for exact motions.
        prior: standard deviation of the masses of the file, relative to them.
        gravity: acceleration of gravity (3,), m/s².
        point: point of the moments (3,), metres.
        sensors: parameters of sensors and drives by name: offsets, friction, rotors; None for
            one that cannot be told from the masses.
        sensor_errors: their standard errors; None likewise.
        cutoff: frequency below which motion and loads were filtered, Hz; None for no filter.
        notices: remarks.
    """

    page_maker = "identification:identification_page"
    picture_maker = "identification:identification_picture"

    space: DesignSpace
    combinations: tuple[Identified, ...]
    excited: int
    condition: float
    recordings: tuple[Recording, ...]
    z: Array
    masses: tuple[IdentifiedMass, ...]
    before: ShakingOf
    after: ShakingOf
    load_errors: tuple[float, float]
    prior: float
    gravity: Array
    point: Array
    sensors: Mapping[str, float | None]
    sensor_errors: Mapping[str, float | None]
    cutoff: float | None
    notices: tuple[Notice, ...] = ()

    @property
    def determined(self) -> int:
        """Number of the combinations on which balance depends that the loads determine."""
        return sum(item.combination.determined for item in self.combinations)

    @property
    def complete(self) -> bool:
        """Whether the loads determine all combinations on which balance depends."""
        return self.determined == len(self.combinations)

    @property
    def verdict(self) -> str:
        """``"identified"``, or ``"partly identified"``."""
        return "identified" if self.complete else "partly identified"

    @property
    def furthest(self) -> float:
        """Largest difference of the file from what was measured, in standard errors."""
        return max(
            (abs(item.off) for item in self.combinations if item.off is not None), default=0.0
        )

    @property
    def words(self) -> str:
        """The verdict in words."""
        total = len(self.combinations)
        if self.complete:
            which = f"{count_noun(total, 'combination')} on which balance depends"
            return f"identified: all {which}"
        return (
            f"partly identified: {self.determined} of {total} combinations on which balance "
            "depends; the motion does not excite the others, or no sensor feels them"
        )

    @property
    def sentence(self) -> str:
        """The answer in one sentence: what is known, and what it means for the shaking."""
        force, moment = (
            f"{number_text(getattr(self.after, name))} ± "
            f"{number_text(getattr(self.after, f'{name}_error'), '.2g')} {unit}"
            for name, unit in (("force", "N"), ("moment", "N m"))
        )
        return (
            f"{self.words[0].upper()}{self.words[1:]}. Shaking force {force} rms, moment "
            f"{moment} rms; by the file {number_text(self.before.force)} N, "
            f"{number_text(self.before.moment)} N m."
        )

    @property
    def bodies(self) -> tuple[BodyInertia, ...]:
        """Likeliest inertial parameters of the bodies."""
        return bodies_with(self.space, self.z)

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the first combinations."""
        lines = (repr(item).removeprefix("Identified: ") for item in self.combinations)
        return repr_lines(f"Identification of {self.space.linkage.name}", self.words, *lines)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        rows = (
            (item.combination.words, repr(item).rpartition(" = ")[2])
            for item in self.combinations
        )
        title = f"Identification of {self.space.linkage.name}"
        return html_facts(title, ("verdict", self.words), *rows)

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the linkage with the likeliest masses, and no other change.

        Args:
            path: file to write it to; None for none.

        Raises:
            FileError: the linkage has no file, or the new one cannot be written.
        """
        elements = {body.name: body.urdf for body in self.bodies if body.urdf}
        return write_file(path, replace_inertials(self.space.linkage, elements))

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/identify.schema.json``."""
        space = self.space
        return {
            "schema": SCHEMA,
            "model": space.linkage.name,
            "at": space.linkage.at,
            "balance": space.balance,
            "verdict": self.verdict,
            "words": self.words,
            "sentence": self.sentence,
            "samples": sum(len(part.measurements.time) for part in self.recordings),
            "duration": sum(part.duration for part in self.recordings),
            "gravity": self.gravity.tolist(),
            "about": self.point.tolist(),
            "prior": self.prior,
            "relevant": len(self.combinations),
            "determined": self.determined,
            "excited": self.excited,
            "condition": self.condition,
            "combinations": [_combination_data(item) for item in self.combinations],
            "recordings": [_recording_data(part) for part in self.recordings],
            "cutoff": self.cutoff,
            "sensors": dict(self.sensors),
            "sensor_errors": dict(self.sensor_errors),
            "masses": [mass._asdict() for mass in self.masses],
            "z": self.z.tolist(),
            "shaking": {"file": self.before._asdict(), "identified": self.after._asdict()},
            "load_errors": {"force": self.load_errors[0], "moment": self.load_errors[1]},
            "warnings": [notice.to_dict() for notice in self.notices],
        }


def _recording_data(recording: Recording) -> dict[str, object]:
    """Return a recording as plain data for JSON."""
    return {
        "samples": len(recording.measurements.time),
        "duration": recording.duration,
        "channels": [channel._asdict() for channel in recording.channels],
    }


def _combination_data(item: Identified) -> dict[str, object]:
    """Return a combination as plain data for JSON."""
    return {
        "words": item.combination.words,
        "terms": [
            {"parameter": label, "link": link, "factor": factor}
            for label, link, factor in item.combination.terms
        ],
        "unit": item.combination.unit,
        "determined": item.combination.determined,
        "file": item.file,
        "value": item.value,
        "error": item.error,
        "likeliest": item.likeliest,
        "off": item.off,
    }
