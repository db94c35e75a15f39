"""The design space and the verdict on every mode of motion that starts from a pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from balance.masses.designs.best_design import maximise_margin
from balance.masses.designs.feasibility import Verdict
from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.spaces.compute_space import design_space
from balance.support.options import Balance
from kinematics.errors import LinkageError, MeetingModesError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.model.mode_of_motion import ModeOfMotion
from kinematics.wording import MAX_NAMES, count_noun, repr_lines, round_to_ten_digits

MODES_SCHEMA = "balance.modes/1"
# What the verdict says on masses that bodies can have.
VERDICT_TEXTS = {"feasible": "yes", "infeasible": "no", "undecided": "undecided"}


@dataclass(frozen=True, eq=False)
class ModeAnswer:
    """A mode of motion, and which masses balance the linkage on it.

    Attributes:
        mode: the mode, with the linkage at a pose on it.
        space: its design space, certified; None if there is none.
        verdict: whether masses that balance can be built: ``"feasible"``, ``"infeasible"`` or
            ``"undecided"``; None without a space.
        complete: whether no condition comes at a higher order, up to the order asked for.
        problem: the reason for which there is no space; else empty.
    """

    mode: ModeOfMotion
    space: CertifiedSpace | None
    verdict: Verdict | None
    complete: bool = False
    problem: str = ""

    def __repr__(self) -> str:
        """Give one line: mobility, nullity and verdict."""
        text = f"nullity {self.space.nullity}, {self.verdict}" if self.space else self.problem
        mode = self.mode
        return repr_lines(f"ModeAnswer: mode {mode.number}: mobility {mode.mobility}, {text}")

    @property
    def sure(self) -> bool:
        """Whether the answer is complete and nothing is in doubt."""
        doubtful = self.space is None or bool(self.space.doubts)
        return self.complete and not doubtful and self.verdict in ("feasible", "infeasible")

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/modes.schema.json``."""
        space, mode = self.space, self.mode
        answer: dict[str, object] = {
            "number": mode.number,
            "mobility": mode.mobility,
            "here": mode.here,
            "positions": {name: round_to_ten_digits(q) for name, q in mode.positions.items()},
            "verdict": self.verdict,
            "problem": self.problem or None,
        }
        if space is None:
            return answer | dict.fromkeys(
                (
                    "inputs",
                    "idle",
                    "orders",
                    "kmax",
                    "rank",
                    "nullity",
                    "serial",
                    "parallel",
                    "certainty",
                    "reason",
                )
            )
        return answer | {
            "inputs": list(space.inputs),
            "idle": list(space.idle),
            "orders": [order._asdict() for order in space.orders],
            "kmax": space.kmax,
            "rank": space.rank,
            "nullity": space.nullity,
            "serial": space.serial.shape[1],
            "parallel": space.parallel.shape[1],
            "certainty": space.level,
            "reason": space.assurance.removeprefix(f"{space.level}: "),
        }


@dataclass(frozen=True, eq=False)
class ModeAnswers:
    """Result of `motion_modes`.

    Attributes:
        name: of the linkage.
        balance: ``"dynamic"`` or ``"force"``.
        modes: an answer for each mode, in the order of their numbers.
        doubt: why there may be more modes; empty if nothing speaks for it.
    """

    name: str
    balance: Balance
    modes: tuple[ModeAnswer, ...]
    doubt: str = ""

    @property
    def sure(self) -> bool:
        """Whether all modes are listed, every answer is complete, and nothing is in doubt."""
        return not self.doubt and all(answer.sure for answer in self.modes)

    @property
    def sentence(self) -> str:
        """Whether the linkage can balance on its modes, in one sentence."""
        texts = [VERDICT_TEXTS.get(answer.verdict or "", "unknown") for answer in self.modes]
        if len({*texts}) == 1:
            return f"Can it balance? {texts[0].capitalize()}, on every mode of motion."
        numbers: dict[str, list[int]] = {}
        for answer, text in zip(self.modes, texts, strict=True):
            numbers.setdefault(text, []).append(answer.mode.number)
        listed = "; ".join(f"{text} on {_name_modes(numbers[text])}" for text in numbers)
        return f"Can it balance? {listed[0].upper()}{listed[1:]}."

    def __repr__(self) -> str:
        """Give a line for the linkage and one for each mode."""
        lines = [repr(answer).removeprefix("ModeAnswer: ") for answer in self.modes]
        head = f"ModeAnswers: {count_noun(len(self.modes), 'mode')} of {self.name}"
        return repr_lines(head, *lines)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/modes.schema.json``."""
        return {
            "schema": MODES_SCHEMA,
            "sentence": self.sentence,
            "model": self.name,
            "balance": self.balance,
            "doubt": self.doubt or None,
            "modes": [answer.to_dict() for answer in self.modes],
        }


def _name_modes(numbers: Sequence[int]) -> str:
    if len(numbers) > MAX_NAMES:
        return count_noun(len(numbers), "mode")
    return f"mode{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))}"


def motion_modes(
    model: LinkageLike,
    motion: Sequence[str] | None = None,
    balance: Balance = "dynamic",
    *,
    spatial: bool = False,
) -> ModeAnswers:
    """Compute design space and verdict on every mode of motion that meets at a pose.

    Args:
        model: a path, name or model that `kinematics.load` reads, or a linkage: its one mode.
        motion: as for `balance.design_space`.
        balance: likewise.
        spatial: likewise.

    Returns:
        The modes: those that pass the pose of the file before those to which another mode
        leads, by mobility, then by the rates of the joints. A single one if the pose is
        regular.

    Raises:
        LinkageError: the linkage cannot be used.

    Source:
        A. Müller, P. C. López-Custodio, J. S. Dai, Identification of non-transversal motion
        bifurcations of linkages, J. Mech. Robotics 13, 2021.

    Example:
        >>> import balance
        >>> [answer.space.nullity for answer in balance.motion_modes("robot.urdf").modes]
        [4]
    """
    doubt = ""
    try:
        linkage = as_linkage(model)
    except MeetingModesError as error:
        modes, doubt = error.modes, error.doubt
    else:
        modes = (ModeOfMotion(1, linkage.mobility, True, {}, linkage),)
    options = {"motion": motion, "balance": balance, "spatial": spatial}
    return answer_modes(modes, options, doubt)


def answer_modes(
    modes: Sequence[ModeOfMotion], options: Mapping[str, Any], doubt: str = ""
) -> ModeAnswers:
    """Compute design space and verdict on given modes.

    Args:
        modes: of `kinematics.errors.MeetingModesError`.
        options: arguments of `balance.design_space`.
        doubt: of the same error.
    """
    answers = tuple(_answer_on_mode(mode, options) for mode in modes)
    linkages = (mode.linkage for mode in modes)
    name = next((x.name for x in linkages if isinstance(x, Linkage)), "")
    return ModeAnswers(name, options.get("balance", "dynamic"), answers, doubt)


def _answer_on_mode(mode: ModeOfMotion, options: Mapping[str, Any]) -> ModeAnswer:
    """Compute design space and verdict on one mode."""
    if isinstance(mode.linkage, LinkageError):
        return ModeAnswer(mode, None, None, problem=str(mode.linkage))
    try:
        space = certify(design_space(mode.linkage, **options))
        complete = space.settled or options.get("max_order") is not None
        return ModeAnswer(mode, space, maximise_margin(space).verdict, complete)
    except LinkageError as error:
        return ModeAnswer(mode, None, None, problem=str(error))
