"""What a sweep computes of each geometry: names, options and columns of quantities.

``rank`` is computed for a whole chunk at once. All others ask a function of this package about
one geometry after the other, and only about those that ``where`` selects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.option_forms import expected_form
from balance.studies.sweeps.row_quantities import QUANTITIES
from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError, LinkageError
from kinematics.model.linkage import Linkage

RANK_DROP = "rank drop"
"""The value of ``where``: only geometries whose rank is below that of generic ones."""
Options = Mapping[str, Any]


RANK = (
    Column("rank", "integer"), Column("nullity", "integer"), Column("serial", "integer"),
    Column("parallel", "integer"), Column("kmax", "integer"), Column("kept_pivot", "real"),
    Column("unsure", "text"),
)  # fmt: skip
NAMES = ("rank", *QUANTITIES)


def read_quantities(table: Options, source: str) -> dict[str, Options]:
    """Check names and options of what is to be computed.

    Args:
        table: ``quantities``, a list of names, and a table of options for each name.
        source: name of the study in messages.

    Returns:
        Options of each quantity, by name.

    Raises:
        FileError: a quantity or an option is unknown.
    """
    names = table.get("quantities", ["rank"])
    if not isinstance(names, list | tuple) or not all(isinstance(x, str) for x in names):
        raise _fault(source, "quantities", "is no list of names", 'write ["rank", "design"]')
    if not names:
        raise _fault(source, "quantities", "nothing to compute", f"name some of {_list(NAMES)}")
    for name in names:
        if name not in NAMES:
            remedy = f"choose from {', '.join(NAMES)}"
            raise _fault(source, name, "no such quantity", remedy)
    for name in table:
        if name not in names and name != "quantities":
            problem = "options of a quantity that is not computed"
            if name not in NAMES:
                problem = "no such entry"
            raise _fault(source, name, problem, f"the quantities are {', '.join(names)}")
    return {name: _read_options(name, table.get(name, {}), source) for name in names}


def check_quantities(quantities: Mapping[str, Options], linkage: Linkage, source: str) -> None:
    """Check the options of quantities against a model.

    Args:
        quantities: those of `read_quantities`.
        source: name of the study in messages.

    Raises:
        FileError: an option does not fit it.
    """
    for name, options in quantities.items():
        check = QUANTITIES[name].check if name in QUANTITIES else None
        try:
            if check is not None:
                check(linkage, options)
        except LinkageError as error:
            text = str(error).removeprefix(f"{linkage.source}: ")
            problem, _, remedy = text.partition("; ")
            raise _fault(source, name, problem, remedy or "correct the option") from None
        except (TypeError, ValueError, KeyError) as error:
            problem = clean(str(error).partition("\n")[0], 200)
            raise _fault(source, name, problem, "correct the option") from None


def are_slow(quantities: Mapping[str, Options]) -> bool:
    """Whether a quantity of every geometry is computed by itself."""
    return any(x != "rank" and "where" not in options for x, options in quantities.items())


def quantity_columns(quantities: Mapping[str, Options], linkage: Linkage) -> tuple[Column, ...]:
    """List the columns of quantities, in order.

    Args:
        quantities: those of `read_quantities`.
    """
    columns: tuple[Column, ...] = ()
    for name, options in quantities.items():
        columns += RANK if name == "rank" else QUANTITIES[name].columns(linkage, options)
    return columns


def _read_options(name: str, options: object, source: str) -> Options:
    """Check the names of the options of a quantity."""
    if not isinstance(options, Mapping):
        raise _fault(source, name, "is no table of options", f"write [compute.{name}]")
    option_names = ("where", *QUANTITIES[name].options) if name in QUANTITIES else ()
    for key in options:
        if key not in option_names:
            remedy = (
                f"choose from {closest_names(key, option_names)}"
                if option_names
                else "leave it out"
            )
            raise _fault(source, f"{name}.{key}", "no such option", remedy)
    for key, value in options.items():
        if key != "where" and (form := expected_form(key, value)):
            problem = f"'{clean(str(value))}' has no meaning"
            raise _fault(source, f"{name}.{key}", problem, f"write {form}")
    if options.get("where", RANK_DROP) != RANK_DROP:
        problem = f"is '{clean(str(options['where']))}'"
        raise _fault(source, f"{name}.where", problem, f'write "{RANK_DROP}", or leave it out')
    return dict(options)


def _list(names: Sequence[str]) -> str:
    return ", ".join(names)


def _fault(source: str, name: str, problem: str, remedy: str) -> FileError:
    return FileError(source, f"[compute] {clean(name)}", problem, remedy)
