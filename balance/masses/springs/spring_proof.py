"""Proofs in rational numbers that springs balance, or that none do, and their certainty."""

from __future__ import annotations

from collections.abc import Sequence

from balance.masses.springs.attached_springs import AttachedSpring
from balance.masses.springs.energy_identity import (
    EnergyProof,
    FreeEnd,
    direction,
    place,
    prove_constant,
    prove_none,
)
from balance.masses.springs.rational_vectors import Vector3
from balance.masses.springs.spring import Spring
from balance.masses.springs.spring_problem import SpringProblem
from balance.space.spaces.certainty import Certainty
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Part of a range by which what an exact identity may shift lies inside of it.
SPRING_INSIDE = 1e-9


def proved_certainty(
    problem: SpringProblem,
    springs: Sequence[Spring],
    gravity: Array,
    balanced: bool,
    in_span: bool,
    certainty: Certainty,
) -> tuple[EnergyProof | None, Certainty]:
    """Seek a proof in rational numbers of balance, or that no stiffnesses balance."""
    linkage, g = problem.linkage, gravity.tolist()
    if balanced and not certainty.doubts:
        free = [_free_end(*pair) for pair in zip(problem.springs, springs, strict=True)]
        proof = prove_constant(linkage, springs, free, g, problem.turns)
        if isinstance(proof, str):
            return None, certainty._replace(reason=f"{certainty.reason}; {proof}")
        reason = "the energies add up to a constant, identically in rational numbers"
        return proof, certainty._replace(level="proved", reason=reason)
    if not balanced and not in_span and not any(any(x.lengths) for x in problem.springs):
        ends = [_open_ends(linkage, spring) for spring in problem.springs]
        if prove_none(linkage, ends, g):
            reason = "no stiffnesses make the energies constant, in rational numbers"
            return None, certainty._replace(level="proved", reason=reason)
    return None, certainty


def _free_end(attached: AttachedSpring, spring: Spring) -> FreeEnd:
    """List what of a spring is within its limits: the end with more of such coordinates."""
    inside = [
        tuple(
            axis
            for axis, ((low, high), x) in enumerate(
                zip(end.box or (), there.point, strict=True)
            )
            if min(x - low, high - x) > SPRING_INSIDE * (high - low)
        )
        for end, there in zip(attached.asked.ends, spring.ends, strict=True)
    ]
    end = 0 if len(inside[0]) >= len(inside[1]) else 1
    k, (low, high) = spring.stiffness, attached.asked.stiffness
    return FreeEnd(end, inside[end], min(k - low, high - k) > SPRING_INSIDE * k)


def _open_ends(
    linkage: Linkage, spring: AttachedSpring
) -> tuple[tuple[int, Vector3, tuple[Vector3, ...]], ...]:
    """Write where a spring may be attached in rational numbers."""
    ends = []
    for end in spring.asked.ends:
        box = end.box or ()
        link, point = place(linkage, end.link, [low for low, _ in box])
        axes = [axis for axis, (low, high) in enumerate(box) if low < high]
        ends.append((link, point, tuple(direction(linkage, end.link, axis) for axis in axes)))
    return tuple(ends)
