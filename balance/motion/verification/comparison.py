"""A linkage beside another one, or beside itself with other masses, along the same motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from balance.motion.verification.verification import UNITS, Verification
from balance.motion.verification.verify_motions import verify, verify_second
from balance.support.change_text import change_text
from balance.support.linkage_names import linkage_names
from balance.support.result_files import WithPage, WithPicture
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.model.motion import while_text
from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, repr_lines


@dataclass(frozen=True, eq=False)
class VerificationComparison(WithPage, WithPicture):
    """Result of `verify_against`: two verifications along the same motions.

    Attributes:
        after: the verification of the linkage.
        before: that of what it is compared with.
    """

    page_maker = "verification_page:comparison_page"
    picture_maker = "verification:comparison_picture"

    after: Verification
    before: Verification

    @property
    def sentence(self) -> str:
        """How the peaks differ, and what is left: ``Shaking force 22 → 1.7 N (92 % less)``."""
        here, there = self.after.model, self.before.model
        if here == there:
            here, there = linkage_names([self.after.linkage, self.before.linkage])
        force, moment = (
            peak_change((self.before, self.after), part, worded=True)
            for part in ("force", "moment")
        )
        outcome = f": {self.after.outcome}".removesuffix(": ")
        change = f"from {there} to {here}{while_text(self.after.motion)}"
        return f"Shaking force {force}, moment {moment}, {change}{outcome}."

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON, as ``balance verify --against`` prints it."""
        against = {"against": self.before.to_dict(), "sentence": self.sentence}
        return self.after.to_dict() | against

    def __repr__(self) -> str:
        """Four lines: both linkages, how the peaks differ, both verdicts."""
        return repr_lines(
            f"VerificationComparison of {self.after.model}, against {self.before.model}",
            self.sentence,
            f"before: {self.before.verdict}",
            f"after: {self.after.verdict}",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"Comparison of {self.after.model} with {self.before.model}",
            ("change", self.sentence),
            ("before", self.before.verdict),
            ("after", self.after.verdict),
        )


def verify_against(
    linkage: Verification | LinkageLike, before: Verification | LinkageLike, **options: Any
) -> VerificationComparison:
    """Verify a linkage and another one along the same motions, as ``verify --against`` does.

    Moments are about one point, the middle of the linkage before if ``about`` is not given, and
    a crank turns at the same speed. The linkage before gets random motions of its own if its
    inputs have other names, or if it cannot follow.

    Args:
        linkage: the linkage, its path or its name; or a verification of it, whose motions
            and point count.
        before: what it is compared with, likewise.
        options: keyword arguments of `balance.verify`, for a linkage.

    Returns:
        Both verifications, with a page and a picture.

    Raises:
        LinkageError: see `balance.verify`.
        UsageError: there are options beside a verification.

    Example:
        >>> import balance
        >>> pair = balance.motion.verify_against("robot.urdf", "robot.urdf", speed="60rpm")
        >>> pair.after.force == pair.before.force
        True
    """
    if isinstance(linkage, Verification):
        if options:
            raise UsageError("a verification has its motions: leave out the options")
        after = linkage
    else:
        if not isinstance(before, Verification):
            before = as_linkage(before)
        point = before.point if isinstance(before, Verification) else middle_of(before)
        after = verify(linkage, **{"about": point, **options})
    if isinstance(before, Verification):
        return VerificationComparison(after, before)
    return VerificationComparison(after, _verify_likewise(after, as_linkage(before)))


def middle_of(linkage: Linkage) -> Array:
    """Return the middle of a linkage (3,) in the inertial frame, metres."""
    return linkage.spatial_chain.frame.origin


def _verify_likewise(first: Verification, linkage: Linkage) -> Verification:
    """Verify a second linkage with the options of the first verification."""
    options: dict[str, Any] = {"seed": first.seed, "trajectories": len(first.runs)}
    if first.seed is None:
        options = {}
    if first.crank is not None and len(linkage.inputs) > 1:
        options["crank"] = first.crank.joint
    options |= {"motion": first.motion, "balance": first.balance}
    return verify_second(first, linkage, tolerance=first.tolerance, **options)


def round_off_of(pair: Sequence[Verification], part: str) -> float:
    """Return the shaking ``"force"`` or ``"moment"`` that round-off decides, N or N m.

    A load within the tolerance, which the decimals of a table do not tell from zero, is
    round-off too.

    Args:
        pair: verifications that are compared: the larger size counts.
        part: the load.
    """
    return max(_round_off(check, part) for check in pair)


def _round_off(check: Verification, part: str) -> float:
    """Return what round-off decides of a load of one verification; see `round_off_of`."""
    size, scale = _peak(check, part), check.part_scale(part)
    least, _ = check.peak_range(part)
    unknown = least == 0.0 and size <= check.tolerance * scale
    return max(check.round_off * scale, size if unknown else 0.0)


def _peak(check: Verification, part: str) -> float:
    """Return the peak of a shaking load, N or N m."""
    return check.force if part == "force" else check.moment


def peak_change(pair: Sequence[Verification], part: str, *, worded: bool = False) -> str:
    """Write the peaks of a shaking ``"force"`` or ``"moment"``, and by how much they differ.

    Args:
        pair: the verification before, and after.
        part: the load.
        worded: as in `balance.support.change_text.change_text`.
    """
    before, after = (_peak(check, part) for check in pair)
    least = round_off_of(pair, part)
    return change_text(before, after, f"{UNITS[part]} peak", least, worded=worded)
