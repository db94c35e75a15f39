"""How sure a design space is: proved, verified or estimated, and the numbers behind it."""

from __future__ import annotations

from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.answer import Answer
from balance.conditions.rank import Decision
from balance.exact.proof import Proof, independent
from balance.exact.ranks import Exact, exact_ranks
from balance.exact.serial import exact_transfers
from balance.momentum import rows_at
from kinematics.errors import LinkageError
from kinematics.linkage import Chain, Linkage
from kinematics.walk import walk

__all__ = ["LEVELS", "Certainty", "certify"]

Array = NDArray[np.float64]

LEVELS = ("estimated", "verified", "proved")
# Momentum of a distribution of size 1 that counts as none, relative to the conditions.
BALANCED = 1e-11
# Sizes below which that, and a singular value, are round-off beyond doubt.
ROUND_OFF = 1e-14
# Rays along which poses are tried, steps each way, and the longest of them.
RAYS, STEPS, STEP = 2, 5, 0.137


class Certainty(NamedTuple):
    """What is known of a design space beyond floating-point arithmetic.

    Attributes:
        level: ``"proved"``: exact lower bounds of rank and nullity add up to the number of
            parameters; ``"verified"``: there is a parallel part, and all momenta vanish at
            finite poses that were not used, to 1e-11 of the size of the conditions; exact
            arithmetic, where it can be done, finds the same rank; ``"estimated"``: neither.
        reason: why, in one line.
        rank: lower bound of the rank by exact arithmetic, if the loops close at all orders;
            None if it cannot be done.
        nullity: lower bound of the nullity by exact arithmetic, if idle joints stay at
            rest; or None.
        residual: largest momentum left at the poses tried, relative to the conditions.
        poses: how many were tried.
        proof: of the rank and nullity, if they are proved.
    """

    level: str
    reason: str
    rank: int | None
    nullity: int | None
    residual: float
    poses: int
    proof: Proof | None = None

    def to_dict(self) -> dict[str, object]:
        """The entry ``evidence`` of the report: all but the level and the proof."""
        rest = ("level", "proof")
        return {name: value for name, value in self._asdict().items() if name not in rest}


def certify(space: Answer, linkage: Linkage, chain: Chain, decision: Decision) -> Certainty:
    """The certainty of a design space.

    Args:
        space: the design space.
        linkage: the linkage it is of.
        chain: its joints that move.
        decision: its basis in the units of the chain, and the numbers behind its rank.
    """
    residual, poses = _residual(chain, space.balance == "force", decision.basis)
    parallel = space.nullity - space.serial_nullity
    verified = space.settled and parallel > 0 and poses > 0 and residual <= BALANCED
    # A complete rank needs no more orders than it took; what looks free is put to the test.
    last = space.kmax if parallel == 0 else None
    try:
        exact = exact_ranks(
            linkage, space.motion, space.balance, last, spatial=not space.planar,
            expected=space.rank,
        )  # fmt: skip
    except LinkageError as error:
        # Without exact arithmetic a condition near round-off is not told from none.
        verified &= max(decision.dropped, residual) <= ROUND_OFF
        seen = f"momenta vanish to {residual:.0e}; " if verified else ""
        reason = f"{seen}not by exact arithmetic: {error}"
        return Certainty(LEVELS[verified], reason, None, None, residual, poses)
    moving = set(chain.joints.tolist())
    idle = [j for j in range(len(linkage.joints)) if j not in moving]
    found = independent(exact, exact_transfers(exact.chain, idle))
    bounds = exact.rank, len(found)
    count = sum(notice.code == "not_exact" for notice in exact.notices)
    replaced = f", with {count} numbers of the file replaced (see --exact)" if count else ""
    doubt = _doubt(space, exact, len(found), idle, residual, replaced)
    if not doubt:
        proof = Proof(exact.chain, exact.witness, found)
        reason = "exact lower bounds of rank and nullity add up to the number of parameters"
        return Certainty("proved", reason + replaced, *bounds, residual, poses, proof)
    if exact.rank == space.rank and verified:
        reason = "balanced at finite poses, and of the same rank by exact arithmetic"
        return Certainty("verified", reason + replaced, *bounds, residual, poses)
    return Certainty("estimated", doubt, *bounds, residual, poses)


def _doubt(
    space: Answer, exact: Exact, nullity: int, idle: list[int], residual: float,
    replaced: str,
) -> str:  # fmt: skip
    """Why exact arithmetic does not prove the rank; empty if it does."""
    if not space.settled and not space.poses:
        return f"orders up to {space.orders[-1].order} only: more conditions may follow"
    if exact.rank > space.rank:
        if exact.rank + nullity == exact.parameters and not replaced:
            return (
                f"exact arithmetic proves rank {exact.rank}: what makes the difference is "
                "below round-off"
            )
        return f"exact arithmetic{replaced} finds rank {exact.rank} or more"
    if exact.rank < space.rank:
        return f"exact arithmetic finds rank {exact.rank} only, at the orders it computed"
    if residual > BALANCED:
        return f"momenta of {residual:.1e} of the conditions are left at finite poses"
    if exact.rank + nullity != exact.parameters:
        return "there are solutions that no inertia transfer from body to body explains"
    if not exact.regular:
        return "that its loops close at all orders is not proved"
    held = {
        j for j in idle if j not in exact.chain.dependent and not any(exact.chain.columns[j])
    }
    return "" if held == set(idle) else "that its idle joints stay at rest is not proved"


def _residual(chain: Chain, force: bool, basis: Array) -> tuple[float, int]:
    """Largest momentum left at fresh poses, relative to the conditions; how many poses.

    Both ways along generic rays; steps are shorter than those to the poses that decided.
    """
    rng = np.random.default_rng(106)
    worst, poses = 0.0, 0
    for _ in range(1 if chain.width == 1 else RAYS):
        ray = rng.standard_normal(chain.width)
        for sign in (1.0, -1.0):
            way = walk(chain, sign * ray / np.sqrt(ray @ ray), reach=STEP)
            for pose in islice(way, STEPS):
                X = rows_at(chain, pose, force)
                left = np.sqrt(np.sum((X @ basis) ** 2, axis=0)).max(initial=0.0)
                worst = max(worst, float(left / (np.linalg.norm(X) or 1.0)))
                poses += 1
    return worst, poses
