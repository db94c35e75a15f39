"""Whether a linkage can balance: what its design space decides, in one sentence.

The space decides whether the masses of the file balance the linkage, and whether some link can
have no mass. Whether bodies can have the other masses of the space is decided by
`balance.design`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from balance.space.spaces.given_masses import moves_no_centre
from balance.support.tolerances import MASS_NEVER
from kinematics.files.urdf.validate_inertias import UNPHYSICAL
from kinematics.wording import first_names

if TYPE_CHECKING:
    from balance.space.spaces.design_space import DesignSpace

Verdict = Literal["as_given", "force_alone", "open", "impossible", "undecided"]
DECIDED = "(balance design decides)"
# Codes of the notices on masses that no body has.
NO_BODIES = (UNPHYSICAL, "non_physical")


class CanBalance(NamedTuple):
    """Whether a linkage can balance, as far as its design space decides it.

    Attributes:
        verdict: ``"as_given"``: the masses of the file balance it; ``"force_alone"``: they
            leave no shaking force, but a shaking moment; ``"impossible"``: it balances only
            without mass; ``"open"``: other masses balance it, and `balance.design` decides
            whether bodies can have them; ``"undecided"``.
        sentence: a question, and the answer to it.
        verb: the command of ``balance`` that comes next; empty if there is none.
    """

    verdict: Verdict
    sentence: str
    verb: str


def answer_of(space: DesignSpace) -> CanBalance:
    """Say whether a linkage can balance, as far as its design space decides it."""
    answer = _answer(space)
    if not space.requirements:
        return answer._replace(sentence=f"Can it balance? {answer.sentence}.")
    # Only the design takes requirements.
    verb = answer.verb if answer.verb == "design" else ""
    return CanBalance(answer.verdict, f"Can it balance as required? {answer.sentence}.", verb)


def _answer(space: DesignSpace) -> CanBalance:
    given = space.as_given.balanced
    if space.doubts:
        return CanBalance("undecided", f"Undecided: {space.doubts[0]}", "verify")
    if given and not space.settled:
        last = space.orders[-1].order if space.orders else 0
        text = f"Undecided: these masses meet the conditions up to order {last}, not all"
        return CanBalance("undecided", text, "verify")
    real = not any(notice.code in NO_BODIES for notice in space.warnings)
    if given and real:
        text = f"Yes, with these masses: {balanced_text(space)}"
        return CanBalance("as_given", text, "verify")
    force_alone = (
        given is False and real and space.balance == "dynamic" and not space.requirements
        and moves_no_centre(space)
    )  # fmt: skip
    return _with_other_masses(space, force_alone)


def _with_other_masses(space: DesignSpace, force_alone: bool) -> CanBalance:
    """Say what masses other than those of the file can do."""
    without = _massless_text(space) if space.encloses else ""
    verb = "remedies" if without else "design"
    if force_alone:
        others = f"both {without}" if without else f"perhaps both with others {DECIDED}"
        text = f"Only forces with these masses, which leave a shaking moment; {others}"
        return CanBalance("force_alone", text, verb)
    if without:
        return CanBalance("impossible", f"No, {without}", verb)
    given = space.as_given.balanced
    if given is None:
        return CanBalance("open", f"Perhaps, for its file has no masses {DECIDED}", verb)
    here = "which balance it but which no bodies can have" if given else ""
    text = f"Not with these masses{', ' * bool(here)}{here}; perhaps with others {DECIDED}"
    return CanBalance("open", text, verb)


def _massless_text(space: DesignSpace) -> str:
    """Say which links have no mass in any distribution of the space; empty if each may."""
    count = len(space.bodies)
    masses = space.scaled_basis.reshape(count, -1, space.nullity)[:, 0]
    massless = np.linalg.norm(masses, axis=1) <= MASS_NEVER
    if massless.all():
        return "only without mass"
    if massless.any():
        names = [name for name, never in zip(space.bodies, massless, strict=True) if never]
        return f"only without mass in {first_names(names)}"
    if np.linalg.norm(masses.sum(axis=0)) <= MASS_NEVER:
        return "only with masses that add up to nothing"
    return ""


def balanced_text(space: DesignSpace) -> str:
    """Say what does not shake with masses of a design space."""
    if space.requirements or not space.settled:
        return "what is asked for holds"
    when = f"with {', '.join(space.motion.relations)}" if space.motion else "in any motion"
    if space.balance == "force":
        return f"no shaking force {when} (the moment does not count)"
    return f"no shaking force and no shaking moment {when}"
