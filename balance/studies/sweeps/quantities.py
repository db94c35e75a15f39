"""What a sweep computes of each geometry: names, options and columns of quantities.

``rank`` is computed for a whole chunk at once. All others ask a function of this package about
one geometry after the other, and only about those that ``where`` selects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.ranges import is_finite_number
from balance.studies.sweeps.row_quantities import (
    NO_DENSITY,
    QUANTITIES,
    REDUCE,
    WITH_MASSES,
    added_before,
)
from balance.studies.sweeps.study_units import in_si
from balance.studies.sweeps.swept_motion import MOTION_OPTIONS
from balance.support.materials import density_in_si
from kinematics.error_text import clean, closest_names, did_you_mean
from kinematics.errors import FileError, LinkageError, UsageError
from kinematics.model.linkage import Linkage

Options = Mapping[str, Any]

RANK_DROP = "rank drop"
"""The value of ``where``: only geometries whose rank is below that of generic ones."""
RANK = (
    Column("rank", "integer"),
    Column("nullity", "integer"),
    Column("serial", "integer"),
    Column("parallel", "integer"),
    Column("kmax", "integer"),
    Column("kept_pivot", "real"),
    Column("unsure", "text"),
)
NAMES = ("rank", *QUANTITIES)
# Quantities of which the numbers in options may have units.
OPTION_UNITS = {
    "bounds": ("mass",),
    "budget": ("mass",),
    "duration": ("time",),
    "gravity": ("acceleration",),
    "max_bearing": ("force",),
    "max_torque": ("torque", "force"),
    "poses": ("angle", "length"),
    "speed": ("angular velocity",),
    "thickness": ("length",),
    "weight_moment": ("length",),
    "within": ("length",),
}
# Most samples of a motion.
MOST_SAMPLES = 1_000_000


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
        raise _fault(
            source, "quantities", "nothing to compute", f"name some of {', '.join(NAMES)}"
        )
    for name in names:
        if name not in NAMES:
            remedy = f"choose from {', '.join(NAMES)}"
            problem = f"no such quantity{did_you_mean(name, NAMES)}"
            raise _fault(source, name, problem, remedy)
    for name in table:
        if name not in names and name != "quantities":
            problem = "options of a quantity that is not computed"
            if name not in NAMES:
                problem = "no such entry"
            problem += did_you_mean(name, names)
            remedy = f"the quantities are {', '.join(names)}"
            for after in names:
                if after.startswith(f"{name} after "):
                    remedy = f'add "{name}" to quantities, or write [compute."{after}"]'
            raise _fault(source, name, problem, remedy)
    for name in names:
        quantity = added_before(name)
        if quantity and quantity not in names:
            remedy = f'add "{quantity}" to quantities, and its links'
            raise _fault(source, name, f"{quantity} is not computed", remedy)
    return {name: _read_options(name, _given(name, table), source) for name in names}


def share_motion(table: Options) -> Options:
    """Give ``reduce`` the motion of ``shaking``, unless it has one of its own.

    Args:
        table: as for `read_quantities`.
    """
    reduction, shaking = table.get(REDUCE), table.get("shaking")
    if not isinstance(reduction, Mapping) or not isinstance(shaking, Mapping):
        return table
    if "speed" in reduction or "poses" in reduction:
        return table
    motion = {name: shaking[name] for name in MOTION_OPTIONS if name in shaking}
    return {**table, REDUCE: {**motion, **reduction}}


def _given(name: str, table: Options) -> Any:
    """The options of a quantity.

    After matter is added they are those before by default, and then the motion of what adds it.
    """
    given, quantity = table.get(name, {}), added_before(name)
    if given != {} or not quantity:
        return given
    before = table.get(name.removesuffix(f" after {quantity}"), {})
    if (
        before != {}
        or not name.startswith("shaking")
        or not isinstance(table.get(quantity), dict)
    ):
        return before
    return {key: value for key, value in table[quantity].items() if key in MOTION_OPTIONS}


def full_options(quantities: Mapping[str, Options], name: str) -> Options:
    """Return the options of a quantity, with those of what adds matter if it comes after that.

    Args:
        quantities: those of `read_quantities`.
    """
    quantity = added_before(name)
    return (
        {**quantities[name], quantity: quantities[quantity]} if quantity else quantities[name]
    )


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


def masses_of_column(quantities: Mapping[str, Options], linkage: Linkage, column: str) -> str:
    """Name the quantity with whose masses a column was computed; empty for those given.

    Args:
        quantities: those of `read_quantities`.
    """
    for name, options in quantities.items():
        columns = quantity_columns({name: options}, linkage)
        if column in [each.name for each in columns]:
            return name if name in WITH_MASSES else added_before(name)
    return ""


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
    try:
        options = {key: _in_si(key, value) for key, value in options.items()}
    except UsageError as error:
        raise _fault(source, name, str(error), "correct the unit") from None
    for key, value in options.items():
        if key != "where" and (form := _expected_form(key, value)):
            problem = f"'{clean(str(value))}' has no meaning"
            raise _fault(source, f"{name}.{key}", problem, f"write {form}")
    if options.get("where", RANK_DROP) != RANK_DROP:
        problem = f"is '{clean(str(options['where']))}'"
        raise _fault(source, f"{name}.where", problem, f'write "{RANK_DROP}", or leave it out')
    return dict(options)


def _in_si(option: str, value: Any) -> Any:
    """Convert texts of numbers with units, and names of materials, to numbers.

    Raises:
        UsageError: a unit is not one of the quantity, or a material is not known.
    """
    if option == "density":
        return value if value == NO_DENSITY else density_in_si(value)
    return in_si(value, *OPTION_UNITS[option]) if option in OPTION_UNITS else value


def _fault(source: str, name: str, problem: str, remedy: str) -> FileError:
    return FileError(source, f"[compute] {clean(name)}", problem, remedy)


def _expected_form(option: str, value: object) -> str:
    """Say how the value of an option is written if this one is wrong; else an empty text.

    Args:
        option: name of an option of a quantity.
        value: its value, as a study has it.
    """
    is_right, form = FORMS[option]
    return "" if is_right(value) else form


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_list(value: object, is_right: Callable[[Any], bool]) -> bool:
    """Whether a value is a list whose items are right."""
    return isinstance(value, list | tuple) and all(map(is_right, value))


def _is_table(value: object, is_right: Callable[[Any], bool]) -> bool:
    """Whether a value is a table whose values are right."""
    return isinstance(value, Mapping) and all(map(is_right, value.values()))


def _is_pair(value: object) -> bool:
    """Whether a value is a list of two numbers, which may be infinite."""
    return (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(is_finite_number(x) or x in (math.inf, -math.inf) for x in value)
    )


def _is_count(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int):
        return False
    return 0 < value <= MOST_SAMPLES


def _is_density(value: object) -> bool:
    """Whether a value is a number, a table of numbers, or none."""
    return value == NO_DENSITY or is_finite_number(value) or _is_table(value, is_finite_number)


def _is_caps(value: object) -> bool:
    return _is_table(value, is_finite_number)


def _is_row(value: object) -> bool:
    return _is_list(value, is_finite_number)


FORMS: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "bounds": (lambda value: _is_table(value, _is_pair), "{rocker = [0.1, 3.0]}, in kg"),
    "budget": (is_finite_number, '"0.5kg", or a number in kg'),
    "count": (_is_count, "a whole number"),
    "crank": (_is_text, '"u1"'),
    "density": (_is_density, '"steel", "7.85g/cm3", {crank = 2700}, or "none"'),
    "thickness": (is_finite_number, '"10mm", or metres'),
    "duration": (is_finite_number, '"500ms", or seconds'),
    "gravity": (_is_row, "[0.0, -9.81, 0.0]"),
    "keep": (lambda value: _is_list(value, _is_text), '["coupler"]'),
    "links": (lambda value: _is_list(value, _is_text), '["crank", "rocker"]'),
    "max_bearing": (_is_caps, '{q2 = "200N"}'),
    "max_torque": (_is_caps, '{u1 = "5Nm"}'),
    "minimise": (_is_text, '"mass"'),
    "poses": (lambda value: _is_list(value, _is_row), "[[0.0], [0.5]]"),
    "regions": (lambda value: _is_table(value, _is_text), '{crank = "ball(0,0,0,0.1)"}'),
    "require": (_is_text, '"force; dynamic at u1=0.3"'),
    "samples": (_is_count, f"a whole number up to {MOST_SAMPLES}"),
    "speed": (is_finite_number, '"300rpm", or a number in rad/s'),
    "weight_moment": (is_finite_number, '"200mm", or metres'),
    "within": (is_finite_number, '"30mm", or metres'),
}
