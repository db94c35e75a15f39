"""Options of ``balance sweep run`` that say what varies of a model, and what is computed.

They are the tables of a study: ``--vary`` has the parameters, ``--compute`` and the options of
quantities what is computed, ``--set`` any other entry, and the options of a model say how its
file is read.
"""

from __future__ import annotations

import argparse
import os
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from balance.app.cli.arguments import Parser
from balance.app.cli.matter_options import add_region_option, check_regions
from balance.app.cli.model_options import check_units, parse_names
from balance.app.cli.motion_source import read_speed
from balance.app.cli.number_arguments import positive_quantity
from kinematics.error_text import clean
from kinematics.errors import FileError, LinkageError

if TYPE_CHECKING:
    from balance.studies.sweeps.job import SweepJob

Tables = dict[str, dict[str, Any]]

# Ending of the file of a study.
STUDY_FILE = ".toml"
# Options of a model that are keys of the table of a study, and their values without them.
MODEL_KEYS: dict[str, Any] = {
    "loops": None,
    "inputs": None,
    "fix_base": False,
    "bodies": "given",
    "massless": [],
    "angles": "nominal",
    "at": None,
    "mode": None,
    "ground": None,
}
# Other options that a study has entries for.
STUDY_OPTIONS = (
    *("vary", "compute", "counterweights", "reduce", "budget", "region", "speed", "entries"),
)
# Options that are tables of a study.
TABLE_OPTIONS = {"parameters": "--vary", "compute": "--compute"}
# Quantities that need more than their name, and the option with it.
NEEDED = {
    "counterweights": "--counterweights crank,rocker",
    "reduce": "--reduce crank,rocker --budget 0.5kg",
    "shaking": "--speed 300rpm",
}
# Lengths of a model that a message lists.
MOST_LENGTHS = 6


def add_study_options(parser: Parser) -> None:
    """Add the options that are tables of a study."""
    study = parser.group("study")
    study.add_argument(
        "--vary",
        action="append",
        type=_varied,
        default=[],
        metavar="PATH=RANGE",
        help="coupler.length=800mm:1200mm:10 (10 values), =90%%:110%%:10 (of that of "
        "the model), =0.8,0.9 (metres); repeatable; without it, lengths are listed",
    )
    study.add_argument(
        "--counterweights",
        type=parse_names,
        metavar="L1,L2",
        help="the least counterweights on these links, steel",
    )
    study.add_argument(
        "--reduce",
        type=parse_names,
        metavar="L1,L2",
        help="or what shakes least for --budget KG on these links",
    )
    budget = study.add_argument(
        "--budget",
        type=_text_that(positive_quantity("mass")),
        metavar="KG",
        help="with --reduce: most mass to add",
    )
    budget.told_beside = True  # type: ignore[attr-defined]
    add_region_option(study)
    study.add_argument(
        "--speed",
        type=_crank_speed,
        metavar="[J=]300rpm",
        help="shaking over a turn, before and after that matter",
    )
    study.add_argument(
        "--compute",
        action="extend",
        type=parse_names,
        default=[],
        metavar="NAME,…",
        help="rank (default), design, distance … (docs/sweeps.md)",
    )
    study.add_argument(
        "--set",
        dest="entries",
        action="append",
        type=_entry,
        default=[],
        metavar="KEY=VALUE",
        help="entry of a study, such as constraints.grashof=crank",
    )


def is_study(arguments: argparse.Namespace) -> bool:
    """Whether the model of the options is the file of a study."""
    return str(arguments.model).lower().endswith(STUDY_FILE)


def check_study_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options of a study do not fit each other."""
    if not isinstance(arguments.model, str):
        arguments.refuse("a sweep keeps the path of its model: give a file, and not a stream")
    if is_study(arguments):
        given = [name for name in STUDY_OPTIONS if getattr(arguments, name)]
        given += [name for name, none in MODEL_KEYS.items() if getattr(arguments, name) != none]
        if arguments.balance != "dynamic":
            given.append("balance")
        given += ["spatial"] * arguments.spatial
        given += ["write_study"] * (arguments.write_study is not None)
        if given:
            named = {"angles": "as-written", "entries": "set"}.get(given[0], given[0])
            option = f"--{named.replace('_', '-')}"
            arguments.refuse(f"{option} goes with a model: {arguments.model} has its own entry")
        return
    if not arguments.vary:
        arguments.refuse(f"nothing varies: give --vary, such as {_vary_text(arguments)}")
    if (arguments.reduce is None) != (arguments.budget is None):
        arguments.refuse("--reduce L1,L2 and --budget KG need each other")
    _check_matter_regions(arguments)
    paths = [path for path, _ in arguments.vary]
    if twice := [path for path in paths if paths.count(path) > 1]:
        arguments.refuse(f"--vary {twice[0]} is given twice: give all its values in one")
    for name, option in NEEDED.items():
        has_option = getattr(arguments, _source(name)) is not None or any(
            f"{key}.".startswith(f"compute.{name}.") for key, _ in arguments.entries
        )
        if name in arguments.compute and not has_option:
            arguments.refuse(f"--compute {name}: it needs {option}")


def _check_matter_regions(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if a region is for a link that gets no matter."""
    from balance.masses.counterweights.link_regions import ALL

    check_regions(arguments)
    links = [*(arguments.counterweights or ()), *(arguments.reduce or ())]
    for name, _ in arguments.region:
        if name != ALL and name not in links and ALL not in links:
            arguments.refuse(
                f"--region {clean(name)}: nothing is added to this link: name it in "
                "--counterweights or --reduce"
            )


def _regions_on(links: list[str], arguments: argparse.Namespace) -> dict[str, dict[str, str]]:
    """Entry of the regions of the options for these links; empty if they have none."""
    from balance.masses.counterweights.link_regions import ALL

    regions = {k: v for k, v in arguments.region if k in links or ALL in (k, *links)}
    return {"regions": regions} if regions else {}


def _source(quantity: str) -> str:
    """Name the option of a quantity that needs one."""
    return {"shaking": "speed"}.get(quantity, quantity)


def job_of_options(arguments: argparse.Namespace) -> SweepJob:
    """Make the job of the study that is read, or of that of the options.

    Raises:
        LinkageError: the study or its model cannot be used; faults name the options.
    """
    from balance.studies.sweeps.study import Study, read_study

    if is_study(arguments):
        return read_study(arguments.model).job(yes=arguments.yes)
    try:
        study = Study.from_tables(_tables(arguments), None, clean(arguments.model, 1000))
        if arguments.at:
            check_units(study.model.load(), arguments.at)
        return study.job(yes=arguments.yes)
    except FileError as error:
        raise _with_options(error, arguments) from None


def study_of_options(arguments: argparse.Namespace) -> str:
    """Write the study of the options as TOML, with paths relative to ``--write-study``."""
    from balance.studies.sweeps.study_text import study_text

    tables = _tables(arguments)
    folder = Path(arguments.write_study).absolute().parent
    for key in ("file", "loops"):
        path = tables["model"].get(key)
        if path is not None and os.path.isfile(path):
            tables["model"][key] = Path(os.path.relpath(path, folder)).as_posix()
    return study_text(tables)


def _tables(arguments: argparse.Namespace) -> Tables:
    """Make the tables of the study of the options."""
    model: dict[str, Any] = {"file": arguments.model}
    for name, default in MODEL_KEYS.items():
        value = getattr(arguments, name)
        if value != default:
            model[name] = dict(value) if name == "at" else value
    compute: dict[str, Any] = {"quantities": _quantities(arguments) or ["rank"]}
    if arguments.balance != "dynamic":
        compute["balance"] = arguments.balance
    if arguments.spatial:
        compute["spatial"] = True
    if arguments.counterweights is not None:
        links = arguments.counterweights
        compute["counterweights"] = {"links": links} | _regions_on(links, arguments)
    if arguments.reduce is not None:
        links, budget = arguments.reduce, {"budget": arguments.budget}
        compute["reduce"] = {"links": links} | budget | _regions_on(links, arguments)
    if arguments.speed is not None:
        crank, speed = arguments.speed
        compute["shaking"] = {"speed": speed} | ({"crank": crank} if crank else {})
    tables: Tables = {"model": model, "parameters": dict(arguments.vary), "compute": compute}
    for key, value in arguments.entries:
        if problem := _enter(tables, key, value):
            arguments.refuse(f"--set {clean(key)}: {clean(problem)}")
    return tables


def _quantities(arguments: argparse.Namespace) -> list[str]:
    """List the quantities of the options, each once."""
    adding = [
        name for name in ("counterweights", "reduce") if getattr(arguments, name) is not None
    ]
    names = [*adding, *arguments.compute]
    if arguments.speed is not None:
        names += ["shaking", *(f"shaking after {name}" for name in adding)]
    return list(dict.fromkeys(names))


def _enter(tables: Tables, key: str, value: Any) -> str:
    """Put the value of ``--set`` into the tables; an option of a quantity into its table.

    Returns:
        Why it cannot be put there; empty if it is.
    """
    from balance.studies.sweeps.quantities import NAMES

    name, _, entry = key.partition(".")
    table = tables.setdefault(name, {})
    quantity, dot, option = entry.rpartition(".")
    if name == "compute" and dot:
        table, entry = table.setdefault(quantity, {}), option
        if not isinstance(table, dict):
            what = "a list" if isinstance(table, list) else "a single value"
            return f"compute.{quantity} is {what}, and has no entries"
    elif name == "compute" and entry in NAMES and not isinstance(value, dict):
        return f"it is a table of options: set one of them, --set {key}.OPTION=VALUE"
    table[entry] = value
    return ""


def _with_options(error: FileError, arguments: argparse.Namespace) -> FileError:
    """Name the options in place of the tables in the fault of a study."""
    head, _, entry = error.element.partition("]")
    table, entry = head.removeprefix("["), entry.strip()
    key = f"{table}.{entry}"
    given = {
        f"compute.{name}": f"--{_source(name)}"
        for name in NEEDED
        if getattr(arguments, _source(name)) is not None
    }
    keys = [each for each, _ in arguments.entries]
    beside = entry not in _quantities(arguments)
    beneath = beside and any(each.startswith(f"{key}.") for each in keys)
    if key in keys or beneath or (table == "compute" and "." in entry):
        element = f"--set {key}"
    elif key in given:
        element = given[key]
    elif table in TABLE_OPTIONS:
        element = f"{TABLE_OPTIONS[table]} {entry}".rstrip()
    else:
        return error
    return FileError(error.file, element, error.problem, error.remedy)


def _vary_text(arguments: argparse.Namespace) -> str:
    """Write an example of ``--vary``, with the lengths of the model if it can be read."""
    example = "coupler.length=800mm:1200mm:10"
    from balance.studies.sweeps.parameter_paths import PathError, read_sites
    from kinematics.loading.model_gallery import load

    try:
        sites = read_sites(load(arguments.model, arguments.loops))
    except (LinkageError, OSError, ValueError):
        return example
    lengths = {}
    for link in sites.links:
        if link == sites.root:
            continue
        try:
            lengths[f"{link}.length"] = sites.value(sites.find(f"{link}.length"))
        except PathError:
            continue
    if not lengths:
        return "q2.origin.x=0.1:0.2:10"
    path = list(lengths)[min(1, len(lengths) - 1)]
    told = [f"{name} {value:.4g} m" for name, value in list(lengths.items())[:MOST_LENGTHS]]
    return f"{path}=90%:110%:10; now {', '.join(told)}; other paths: docs/sweeps.md"


def _text_that(can_be_read: Callable[[str], object]) -> Callable[[str], str]:
    """Build an argparse type that keeps the words which another one can read."""

    def keep(text: str) -> str:
        can_be_read(text)
        return text

    return keep


def _crank_speed(text: str) -> tuple[str, str]:
    """Parse ``[J=]300rpm`` into the crank, empty without one, and the words of its speed."""
    read_speed(text)
    crank, _, speed = text.rpartition("=")
    return crank.strip(), speed.strip()


def _varied(text: str) -> tuple[str, Any]:
    """Parse ``PATH=RANGE``: a grid, values apart by commas, or a range as in a study.

    Raises:
        ArgumentTypeError: it has no path, or no range.
    """
    path, _, words = text.partition("=")
    if not path.strip() or not words.strip():
        raise argparse.ArgumentTypeError(
            f"'{text}' is not PATH=RANGE, such as coupler.length=800mm:1200mm:10"
        )
    value = _toml_value(words.strip())
    if isinstance(value, str) and "," in value:
        return path.strip(), [word.strip() for word in value.split(",")]
    return path.strip(), value


def _entry(text: str) -> tuple[str, Any]:
    """Parse ``TABLE.KEY=VALUE``.

    Raises:
        ArgumentTypeError: it has no key of a table, or no value.
    """
    key, _, words = text.partition("=")
    table, dot, name = key.strip().partition(".")
    if not (table and dot and name and words.strip()):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not TABLE.KEY=VALUE, such as constraints.grashof=crank"
        )
    return key.strip(), _toml_value(words.strip())


def _toml_value(words: str) -> Any:
    """Read a value as TOML writes it; other words are a text."""
    try:
        value = tomllib.loads(f"value = {words}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        return words
    return value if isinstance(value, bool | int | float | str | list | dict) else words
