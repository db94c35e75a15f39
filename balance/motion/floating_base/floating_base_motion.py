"""Result of a simulation on a base that floats: motion, conserved quantities, verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from balance.motion.floating_base.base import FloatingBase
from balance.motion.floating_base.samples import Samples
from balance.motion.motion_tolerances import (
    BASE_DRIFT_RELATIVE,
    INTEGRAL_DETERMINED,
    STARTS_AT_REST,
)
from balance.motion.verification.input_paths import InputPath
from balance.support.result_files import WithPage, WithPicture
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, html_facts, repr_lines, size_text

FLOATING_BASE_SCHEMA = "balance.floating_base/1"
# Rotation of a base in space beyond which the moment of a rotational spring is not unique.
HALF_TURN = 3.1


@dataclass(frozen=True, eq=False)
class FloatingBaseMotion(WithPage, WithPicture):
    """Result of `simulate_floating_base`: the motion of a base and of the linkage on it.

    Attributes:
        linkage: the linkage.
        base: its base.
        length: characteristic length, metres.
        tolerance: largest residual of a base at rest.
        time: seconds, at every step of the integration (N,).
        samples: the motion at these times, in SI units.
        held: twist of the base (N, 6), in its own coordinates and units of the chain, if all
            inputs stayed where they are at the start.
        frequencies: natural frequencies of the base on its springs, inputs held, hertz.
        torques: torques on free inputs by name, N m or N; None if the inputs are prescribed.
        initial: velocities at the start by name, rad/s and m/s.
        notices: notices of the linkage.
        path: prescribed motion of the inputs; None if they are free.
    """

    page_maker = "floating_base:floating_base_page"
    picture_maker = "floating_base:floating_base_picture"

    linkage: Linkage
    base: FloatingBase
    length: float
    tolerance: float
    time: Array
    samples: Samples
    held: Array
    frequencies: tuple[float, ...]
    torques: Mapping[str, float] | None
    initial: Mapping[str, float]
    notices: tuple[Notice, ...]
    path: InputPath | None

    def __repr__(self) -> str:
        """Four lines: duration, motion of the base, conserved quantities, verdict."""
        return repr_lines(
            f"FloatingBaseMotion of {self.model}: {count_noun(self.time.size, 'sample')} "
            f"over {self.duration:.4g} s",
            f"the base turns {self.rotation_text} and moves {self.displacement_text}",
            f"drift of energy {drift_text(self.energy_drift)}, of momentum "
            f"{drift_text(self.momentum_drift)}",
            f"{self.verdict} (residual {drift_text(self.residual)}, "
            f"tolerance {self.tolerance:.1e})",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"{self.model} on a base that floats",
            ("duration", f"{self.duration:.4g} s"),
            ("base", f"turns {self.rotation_text}, moves {self.displacement_text}"),
            (
                "drift",
                f"energy {drift_text(self.energy_drift)}, momentum "
                f"{drift_text(self.momentum_drift)}",
            ),
            ("verdict", f"{self.verdict} (residual {drift_text(self.residual)})"),
        )

    @property
    def model(self) -> str:
        """Name of the linkage."""
        return self.linkage.name

    @property
    def planar(self) -> bool:
        """Whether the base moves in a plane."""
        return self.samples.momentum.shape[1] == 3

    @property
    def duration(self) -> float:
        """Time from the start to the end, seconds."""
        return float(self.time[-1] - self.time[0])

    @property
    def rotation(self) -> float:
        """Largest rotation of the base from the start, radians."""
        return _largest_norm(self.samples.rotation)

    @property
    def displacement(self) -> float:
        """Largest displacement of its centre of mass from the start, metres."""
        return _largest_norm(self.samples.displacement)

    @property
    def rotation_text(self) -> str:
        """The rotation with its unit; as a bound where the integration decides it."""
        return f"{size_text(self.rotation, '.3g', floor=INTEGRAL_DETERMINED)} rad"

    @property
    def displacement_text(self) -> str:
        """The displacement with its unit; as a bound where the integration decides it."""
        text = size_text(self.displacement, ".3g", self.length, INTEGRAL_DETERMINED)
        return f"{text} m"

    @property
    def energy_drift(self) -> float:
        """Largest change of kinetic energy plus energy in springs minus work of the drives.

        It is relative to the peak of these energies.
        """
        of = self.samples
        total = of.kinetic + of.spring - of.work
        parts = of.kinetic + of.spring + np.abs(of.work)
        return _ratio(np.abs(total - total[0]).max(), parts.max())

    @property
    def momentum_drift(self) -> float:
        """Largest change of the momentum minus the impulse of the springs.

        It is relative to the peak sum of the momenta of base and bodies.
        """
        total = self.samples.momentum - self.samples.impulse
        return _ratio(_largest_norm(total - total[0]), self.samples.momentum_size.max())

    @property
    def agreed(self) -> bool:
        """Whether energy and momentum are conserved to 1e-9."""
        return max(self.energy_drift, self.momentum_drift) <= BASE_DRIFT_RELATIVE

    @property
    def residual(self) -> float:
        """Largest twist of the base that the motion of the inputs causes.

        Twists are in radians and characteristic lengths, relative to the largest twist of a
        body on the base. A base that moves at the start would move on without the inputs: the
        difference from that motion counts.
        """
        return _ratio(_largest_norm(self.samples.twist - self.held), self.samples.speed.max())

    @property
    def turning_residual(self) -> float:
        """Largest angular velocity of the base that the inputs cause, relative likewise."""
        turning = (self.samples.twist - self.held)[:, :3]
        return _ratio(_largest_norm(turning), self.samples.speed.max())

    @property
    def keeps_attitude(self) -> bool:
        """Whether the inputs do not turn the base, within the tolerance."""
        return self.turning_residual <= self.tolerance

    @property
    def undisturbed(self) -> bool:
        """Whether the residual is within the tolerance."""
        return self.residual <= self.tolerance

    @property
    def verdict(self) -> str:
        """What the base does, or ``"no verdict"`` if energy or momentum is not conserved."""
        if not self.agreed:
            return "no verdict"
        if any(name in self.initial for name in ("wx", "wy", "wz", "vx", "vy", "vz")):
            words = f"the inputs {'do not ' if self.undisturbed else ''}disturb the base"
        else:
            words = "the base stays at rest" if self.undisturbed else "the base moves"
        if not self.undisturbed and self.keeps_attitude:
            words += ", but do not turn it" if "inputs" in words else ", but does not turn"
        return words

    @property
    def brief(self) -> str:
        """Summary in one line."""
        return f"{self.verdict}, residual {drift_text(self.residual)}"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on inputs that rest, on large rotations, and on conserved quantities."""
        remarks = []
        if not self.samples.speed.any():
            remarks.append("no input moves")
        rates = np.abs(self.samples.ud)
        starts_at_rest = rates[0].max() <= STARTS_AT_REST * rates.max()
        if self.path is not None and not starts_at_rest and not self.initial:
            remarks.append(
                "the inputs move at the start, while the base rests: base and linkage have the "
                "momentum of that motion throughout, and the base follows it"
            )
        if self.base.turning_stiffness and not self.planar and self.rotation > HALF_TURN:
            remarks.append(
                "the base turns by more than half a turn, where its spring is undefined"
            )
        if not self.agreed:
            remarks.append(
                f"energy drifts by {drift_text(self.energy_drift)} and momentum by "
                f"{drift_text(self.momentum_drift)}: no verdict"
            )
        return tuple(remarks)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/floating_base.schema.json``."""
        of, base = self.samples, self.base
        return {
            "schema": FLOATING_BASE_SCHEMA,
            "model": self.model,
            "file": self.linkage.source,
            "at": self.linkage.at,
            "algebra": "planar" if self.planar else "spatial",
            "base": {
                "mass": base.mass,
                "inertia": base.moments,
                "products": base.products,
                "com": base.com,
                "turning_stiffness": base.turning_stiffness,
                "stiffness": base.stiffness,
            },
            "inputs": list(self.linkage.inputs),
            "torques": None if self.torques is None else {**self.torques},
            "initial": {**self.initial},
            "duration": self.duration,
            "samples": self.time.size,
            "length": self.length,
            "undisturbed": self.undisturbed if self.agreed else None,
            "tolerance": self.tolerance,
            "residual": self.residual,
            "turning_residual": self.turning_residual,
            "peak": {
                "rotation": self.rotation,
                "displacement": self.displacement,
                "turning": _largest_norm(of.turning),
                "velocity": _largest_norm(of.velocity),
            },
            "end": {
                "inputs": dict(zip(self.linkage.inputs, of.u[-1].tolist(), strict=True)),
                "rotation": of.rotation[-1],
                "displacement": of.displacement[-1],
                "turning": of.turning[-1],
                "velocity": of.velocity[-1],
            },
            "frequencies": list(self.frequencies),
            "drift": {"energy": self.energy_drift, "momentum": self.momentum_drift},
            "verdict": self.verdict,
            "remarks": list(self.remarks),
            "warnings": [notice.to_dict() for notice in self.notices],
        }


def drift_text(size: float) -> str:
    """Write a relative size along a motion; as a bound where the integration decides it."""
    return size_text(size, floor=INTEGRAL_DETERMINED)


def _largest_norm(vectors: Array) -> float:
    """Compute the largest norm of vectors (N, k)."""
    return float(np.linalg.norm(vectors, axis=1).max())


def _ratio(part: float, whole: float) -> float:
    """Divide, where nothing over nothing is 0."""
    return float(part / whole) if whole > 0.0 else float(part)
