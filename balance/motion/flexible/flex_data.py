"""Results on flexible links as plain data for JSON; see ``schemas/flex.schema.json``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.motion.flexible.free_beam_modes import FLEX_SCHEMA, FreeMode
from balance.motion.flexible.from_linkage import FlexibleLinkage
from balance.motion.flexible.similarity import Arm, Similarity
from balance.motion.flexible.simulate import FlexibleMotion
from balance.motion.flexible.translators import TranslatorMotion
from balance.support.csv_text import csv_table
from kinematics.numerics.array_types import Array


def modes_data(modes: Sequence[FreeMode]) -> dict[str, object]:
    """Describe the modes of a free beam."""
    rows = [mode.to_dict() for mode in modes]
    return {"schema": FLEX_SCHEMA, "result": "free_modes", "modes": rows}


def _arm_data(arm: Arm) -> dict[str, float | None]:
    """Describe an arm; what is infinite is None."""
    beam = arm.beam
    return {
        "length": beam.length,
        "EI": beam.bending,
        "rhoA": beam.line_mass,
        "EA": beam.axial,
        "GA": beam.shear,
        "rhoI": beam.rotary,
        "tip_mass": arm.tip_mass,
        "tip_radius": arm.tip_radius,
        "tip_inertia": arm.tip_inertia,
        "hub_radius": arm.hub_radius,
    }


def similarity_data(
    first: Arm,
    second: Arm,
    similarity: Similarity,
    motion: FlexibleMotion | None = None,
    translator: TranslatorMotion | None = None,
) -> dict[str, object]:
    """Describe two arms, their conditions, and what was simulated with them.

    Args:
        first: the arm to balance.
        motion: a simulation of both on one hub, if there is one.
        translator: that of translators on two of each, if there is one.
    """
    conditions = [
        {
            "name": rule.name,
            "words": rule.words,
            "left": rule.first,
            "right": rule.second,
            "difference": rule.difference,
            "holds": rule.holds,
        }
        for rule in similarity.conditions
    ]
    return {
        "schema": FLEX_SCHEMA,
        "result": "similar",
        "scale": similarity.scale,
        "arms": [_arm_data(first), _arm_data(second)],
        "similar": similarity.similar,
        "conditions": conditions,
        "frequencies": list(similarity.frequencies),
        "first_moment": similarity.first_moment,
        "motion": None if motion is None else _motion(motion, np.zeros(2)),
        "translator": None if translator is None else _translator(translator),
    }


def _translator(motion: TranslatorMotion) -> dict[str, object]:
    """Describe a translator with its counter-translator, and alone."""
    rig = motion.translator
    return {
        "pitch": rig.pitch,
        "hub_mass": rig.hub_mass,
        "moment": rig.moment,
        "rise": rig.rise,
        "both_hubs": rig.both,
        "blocks": [block._asdict() for block in motion.blocks],
        "displacement": list(motion.displacement),
        "reduction": motion.reduction,
        "pair": _motion(motion.pair, np.zeros(2)),
        "alone": _motion(motion.alone, np.zeros(2)),
    }


def motion_data(linkage: FlexibleLinkage, motion: FlexibleMotion) -> dict[str, object]:
    """Describe the simulation of a linkage."""
    beams = [
        {
            "link": name,
            "length": model.part.length,
            "mass": model.mesh.beam.mass,
            "elements": len(model.mesh.nodes) - 1,
            "coordinates": model.part.size,
            "peak_deflection": float(beam_deflection(motion, linkage, name).max()),
        }
        for name, model in linkage.beams.items()
    ]
    return {
        "schema": FLEX_SCHEMA,
        "result": "motion",
        "linkage": linkage.linkage.name,
        "beams": beams,
        "centre": linkage.centre.tolist(),
        "about": linkage.point.tolist(),
        **_motion(motion, linkage.point),
    }


def beam_deflection(motion: FlexibleMotion, linkage: FlexibleLinkage, name: str) -> Array:
    """Compute the largest deflection of a beam at each instant (t,), in metres.

    It is from the line through its joints, or from the tangent where it is driven or held by
    one joint alone; see `FlexibleLinkage.tangents`.
    """
    model = linkage.beams[name]
    k = [part.name for part in motion.mechanism.parts].index(name)
    q = motion.positions[:, motion.mechanism.slices[k]][:, 3:]
    across = np.array([marker.across for marker in model.part.outline])
    if (root := linkage.tangents.get(name)) is not None:
        arms = np.array([marker.at[0] for marker in model.part.outline]) - root.at[0]
        across = across - root.across - arms[:, None] * root.turn
    return np.asarray(np.abs(q @ across.T).max(axis=1))


def motion_table(linkage: FlexibleLinkage, motion: FlexibleMotion) -> bytes:
    """Write a simulation as comma-separated values, one line per instant, SI units.

    Columns are ``time``, the shaking force on the mount in the plane, the moment about the
    point of the linkage, the energy, and ``bending LINK``, the largest deflection of each beam.
    """
    names = [f"bending {name}" for name in linkage.beams]
    bends = [beam_deflection(motion, linkage, name) for name in linkage.beams]
    moment = moment_about(motion, linkage.point)
    return csv_table(
        ["time", "force_x", "force_y", "moment", "energy", *names],
        [motion.times, motion.force, moment, motion.energy, *bends],
    )


def moment_about(motion: FlexibleMotion, point: Array) -> Array:
    """Compute the shaking moment about a point of the plane (t,), in N m.

    Args:
        point: position in the plane (2,).
    """
    force = motion.force
    return np.asarray(motion.moment - (point[0] * force[:, 1] - point[1] * force[:, 0]))


def _motion(motion: FlexibleMotion, centre: Array) -> dict[str, object]:
    """Describe a simulation; moments are about a point."""
    moment = moment_about(motion, centre)
    return {
        "duration": float(motion.times[-1]),
        "peak_force": motion.peak_force,
        "peak_moment": float(np.abs(moment).max()),
        "energy_drift": motion.energy_drift,
        "method": motion.method,
        "steps": motion.steps,
        "evaluations": motion.evaluations,
        "times": motion.times.tolist(),
        "force": motion.force.tolist(),
        "moment": moment.tolist(),
    }
