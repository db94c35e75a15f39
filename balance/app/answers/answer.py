"""The answer of a command: what it prints, and the files that it can write.

An answer says what there is, not how it looks: the modules of `balance.app.answers.text` build
its body of facts and tables, and its renderers know no command:
`balance.app.answers.text.render` for text and terminals, `balance.support.json_text` for data,
`balance.app.answers.html.render` for pages.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from kinematics.model.linkage import Notice


MISSING = "–"

Pairs: TypeAlias = Sequence[tuple[str, str]]
"""Labels and values."""
Files: TypeAlias = Mapping[str, Callable[[], str | bytes | Mapping[str, bytes]]]
"""Functions that make files, by the option that names the file; many files are a folder."""


class Facts(NamedTuple):
    """Lines of a label and its value, or its values for several linkages.

    Attributes:
        rows: a label and one or more values each.
        least: least width of the labels, one blank apart from the values; 0: the width of the
            longest, and two blanks.
        wrapped: whether several values are columns of equal width, with cells of several lines.
    """

    rows: Sequence[tuple[str, ...]]
    least: int = 0
    wrapped: bool = False


class AnswerTable(NamedTuple):
    """A table.

    Attributes:
        rows: the head, and the rows.
        align: ``<`` or ``>`` for the columns from the first one on; the last counts for all
            that follow.
        least: least width of a column.
        gap: blanks between columns.
    """

    rows: Sequence[Sequence[str]]
    align: str = "<"
    least: int = 0
    gap: int = 2


class AnswerSection(NamedTuple):
    """Facts under a title."""

    title: str
    pairs: Pairs


AnswerPart: TypeAlias = Facts | AnswerTable | AnswerSection | str
"""A part of what is printed; a text is a line, an empty one a blank line."""
AnswerBody: TypeAlias = Sequence[AnswerPart]
"""What is printed, from top to bottom."""


class Answer(NamedTuple):
    """The answer of a command; functions compute what a renderer or a file needs, when it does.

    Attributes:
        code: the exit code.
        data: computes the object that ``--json`` prints.
        body: computes what is printed otherwise.
        notices: remarks, printed on standard error before the answer.
        remark: one more line there; empty if there is none.
        files: returns the functions that make files, by option; called if one names a file.
        styled: whether a terminal shows the body with its styles.
    """

    code: int
    data: Callable[[], object]
    body: Callable[[], AnswerBody]
    notices: Sequence[Notice] = ()
    remark: str = ""
    files: Callable[[], Files] = dict
    styled: bool = False


def joined_facts(facts: Sequence[Pairs]) -> list[tuple[str, ...]]:
    """Join lists of facts to rows of a label and a text for each list.

    A label that the lists before do not have stands after the label that precedes it in its
    own list. Texts of a label that a list has several times share a cell; a label that a list
    does not have has a dash.

    Args:
        facts: pairs of label and value for each linkage.
    """
    labels: list[str] = []
    for pairs in facts:
        after = -1
        for label, _ in pairs:
            if label not in labels:
                labels.insert(after + 1, label)
            after = labels.index(label)
    return [
        (
            label,
            *("; ".join(v for name, v in pairs if name == label) or MISSING for pairs in facts),
        )
        for label in labels
    ]


def side_by_side(facts: Sequence[Pairs]) -> AnswerBody:
    """Build what is printed on several linkages: a row for each fact, a column for each one."""
    return [Facts(joined_facts(facts), wrapped=True)]
