"""Results of springs: stiffnesses, points, and the torques that are left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from balance.masses.springs.spring import Spring
from balance.space.spaces.certainty import Certainty
from balance.support.result_files import WithPage, WithPicture
from balance.support.tolerances import SPRING_TORQUE_LEFT
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, html_facts, number_text, repr_lines

if TYPE_CHECKING:
    from balance.masses.payload import Payload
    from balance.masses.springs.energy_identity import EnergyProof
    from balance.masses.springs.spring_loads import SpringLoads

SCHEMA = "balance.springs/1"


@dataclass(frozen=True, eq=False)
class SpringBalance(WithPage, WithPicture):
    """Result of `springs`.

    Attributes:
        linkage: the linkage.
        gravity: acceleration of gravity (3,), m/s².
        springs: the springs, in the order in which they were asked for.
        sets: the smallest sets of springs that balance, as indices from 0; empty if none does.
        every_set: whether all sets of springs up to that size were tried.
        unknowns: number of stiffnesses and coordinates that are free.
        rank: rank of the conditions on them.
        in_span: whether springs of either sign would balance.
        inputs: poses of the workspace at which torques were computed (poses, inputs).
        before: what the inputs hold there without springs (poses, inputs), N m and N.
        after: what they hold with the springs.
        certainty: how sure it is that the torques vanish in all motions.
        excluded: whether springs that balance, or fewer of them, are excluded where none are
            given; False where both ends of a spring are free, and a search found none.
        proof: springs in rational numbers that balance identically; None without such a proof.
        payload: the load that is not in the file; of a range, the springs are for its mean.
        loads: what these springs, and others whose points move, do for a range of loads.
        notices: remarks for the user.
    """

    page_maker = "springs:springs_page"
    picture_maker = "springs:springs_picture"

    linkage: Linkage
    gravity: tuple[float, float, float]
    springs: tuple[Spring, ...]
    sets: tuple[tuple[int, ...], ...]
    every_set: bool
    unknowns: int
    rank: int
    in_span: bool
    inputs: Array
    before: Array
    after: Array
    certainty: Certainty
    excluded: bool = True
    proof: EnergyProof | None = None
    payload: Payload | None = None
    loads: SpringLoads | None = None
    notices: tuple[Notice, ...] = ()

    def __repr__(self) -> str:
        """Up to six lines: the linkage, the verdict, the springs."""
        needed = (repr(spring) for spring in self.springs if spring.stiffness > 0.0)
        return repr_lines(f"SpringBalance of {self.linkage.name}", self.words, *needed)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        rows = ((spring.asked, repr(spring)) for spring in self.springs)
        title = f"SpringBalance of {self.linkage.name}"
        return html_facts(title, ("verdict", self.words), *rows)

    @property
    def balanced(self) -> bool:
        """Whether the inputs hold nothing in any pose."""
        return bool(self.sets)

    @property
    def verdict(self) -> str:
        """``"feasible"`` if springs balance, ``"infeasible"`` if none do.

        ``"undecided"`` if they balance, and it is in doubt whether in every pose; or if none
        were found with both ends of a spring free, and none are excluded. For a range of
        loads, whether springs balance every load whose points may move with it.
        """
        if self.loads is not None:
            return "feasible" if self.loads.springs else "infeasible"
        if not self.balanced:
            return "infeasible" if self.excluded else "undecided"
        return "undecided" if self.certainty.doubts else "feasible"

    @property
    def share_left(self) -> float:
        """Root mean square of the torques over the workspace, over that of gravity alone."""
        if self.balanced:
            return 0.0
        return float(np.linalg.norm(self.after) / np.linalg.norm(self.before))

    @property
    def words(self) -> str:
        """The verdict in words."""
        if self.loads is not None:
            able = "balance" if self.loads.springs else "do not balance"
            return f"{self.verdict}: springs whose points move with the load {able} every load"
        needed = sum(spring.stiffness > 0.0 for spring in self.springs)
        if self.balanced:
            word = "balances" if needed == 1 else "balance"
            where = "every pose"
            if self.certainty.doubts:
                where = f"the poses computed; {'; '.join(self.certainty.doubts)}"
            spring = count_noun(needed, "spring")
            return f"{self.verdict}: {spring} {word} gravity in {where}"
        if self.share_left >= 1.0 - SPRING_TORQUE_LEFT:
            return f"{self.verdict}: {self.reason}; no spring of these helps"
        share = number_text(100.0 * self.share_left, ".3g")
        return (
            f"{self.verdict}: {self.reason}; {count_noun(needed, 'spring')} "
            f"leave{'s' if needed == 1 else ''} {share} % of the torque of gravity (rms)"
        )

    @property
    def reason(self) -> str:
        """Why there is no balance, in words; empty if there is."""
        if self.balanced:
            return ""
        if not self.excluded:
            return "no points of both ends were found that balance, and none are excluded"
        if self.in_span and any(spring.free_length for spring in self.springs):
            return "some stiffness or free length would be out of its range"
        if self.in_span:
            return "some stiffness would be negative, or out of its range"
        return "no stiffnesses, of either sign, make the energy constant"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/springs.schema.json``."""
        peaks = (np.abs(x).max(axis=0).tolist() for x in (self.before, self.after))
        return {
            "schema": SCHEMA,
            "model": self.linkage.name,
            "at": self.linkage.at,
            "gravity": list(self.gravity),
            "verdict": self.verdict,
            "words": self.words,
            "springs": [
                {
                    "asked": spring.asked,
                    "ends": [{"link": e.link, "point": list(e.point)} for e in spring.ends],
                    "stiffness": spring.stiffness,
                    "free_length": spring.free_length,
                    "lengths": list(spring.lengths),
                    "force": spring.force,
                }
                for spring in self.springs
            ],
            "sets": [[k + 1 for k in chosen] for chosen in self.sets],
            "every_set": self.every_set,
            "unknowns": self.unknowns,
            "rank": self.rank,
            "in_span": self.in_span,
            "excluded": self.excluded,
            "share_left": self.share_left,
            "poses": len(self.inputs),
            "peak_torque": {
                name: {"gravity": before, "left": after}
                for name, before, after in zip(self.linkage.inputs, *peaks, strict=True)
            },
            "certainty": {
                "level": self.certainty.level,
                "reason": self.certainty.reason,
                "residual": self.certainty.residual,
                "poses": self.certainty.poses,
            },
            "payload": self._payload_data(),
            "proof": None if self.proof is None else self._proof_data(self.proof),
        }

    def _proof_data(self, proof: EnergyProof) -> dict[str, object]:
        """Write the rational springs of a proof as text of fractions."""
        needed = [k for k, spring in enumerate(self.springs, 1) if spring.stiffness > 0.0]
        return {
            "springs": [
                {"spring": k, "stiffness": str(stiffness), "shifts": [str(x) for x in shifts]}
                for k, stiffness, shifts in zip(
                    needed, proof.stiffnesses, proof.shifts, strict=True
                )
            ],
            "poses": proof.poses,
            "multipliers": proof.multipliers,
        }

    def _payload_data(self) -> dict[str, object] | None:
        """Write the payload, and what springs do for a range of loads."""
        if self.loads is not None:
            return self.loads.to_dict()
        return None if self.payload is None else self.payload.to_dict()
