"""The tables of a study: a model, what varies in it, what must hold, and what is computed.

They are those of a TOML file, or Python dictionaries of the same form. Whatever is wrong in
them is one line that says what, where and what to do.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np

from balance.studies.sweeps.constraints import read_constraints
from balance.studies.sweeps.parameter_paths import PathError, Sites, read_sites
from balance.studies.sweeps.quantities import are_slow, read_quantities, share_motion
from balance.studies.sweeps.ranges import (
    MOST_POINTS,
    SAMPLED,
    Range,
    RangeError,
    are_texts,
    is_finite_number,
    read_range,
    stored_range,
)
from balance.studies.sweeps.study_units import in_si, quantities_of_path, resolve_percentages
from balance.support.options import Balance
from kinematics.error_text import clean, closest_names, did_you_mean
from kinematics.errors import FileError, UsageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.document.write_numbers import element_text
from kinematics.model.linkage import Linkage, names_of

Tables = Mapping[str, Any]

TABLES = {
    "model": (
        "angles",
        "at",
        "bodies",
        "file",
        "fix_base",
        "ground",
        "inputs",
        "loops",
        "massless",
        "mode",
    ),
    "parameters": (),
    "relations": (),
    "sampling": ("count", "seed"),
    "constraints": (),
    "compute": (),
    "run": ("chunk_rows",),
}
"""Tables of a study, and the keys of those in which only these may stand."""
# Rows of a chunk by default; fewer where a quantity of every row takes milliseconds.
CHUNK_ROWS, SLOW_ROWS = 2048, 64
# Entries of a study as text that are tables.
STORED_TABLES = ("model", "parameters", "relations", "constraints", "quantities")
# Largest coordinate of a pose: radians or metres.
LARGEST = 1e9


@dataclass(frozen=True)
class StudyData:
    """A study whose tables were read; they are not yet checked against its model.

    Attributes:
        source: name of the study in messages.
        model: the model as text.
        parameters: range of each parameter, by path, or by a name that relations use.
        relations: expression of each further path.
        constraints: what must hold, as in the table of the study.
        quantities: what to compute, by name with options.
        balance: ``"dynamic"`` or ``"force"``.
        spatial: count all ten parameters per body, even if the linkage is planar.
        samples: samples of each point of the grid.
        seed: of the samples.
        chunk_rows: most rows that are computed together.
    """

    source: str
    model: _ModelText
    parameters: Mapping[str, Range]
    relations: Mapping[str, str] = field(default_factory=dict)
    constraints: Tables = field(default_factory=dict)
    quantities: Mapping[str, Tables] = field(default_factory=dict)
    balance: Balance = "dynamic"
    spatial: bool = False
    samples: int = 1
    seed: int = 0
    chunk_rows: int = CHUNK_ROWS

    @classmethod
    def from_tables(
        cls,
        tables: Tables,
        model: Linkage | None = None,
        source: str = "study",
        folder: Path | None = None,
    ) -> Self:
        """Make a study of tables such as those of a TOML file.

        Args:
            tables: see ``docs/sweeps.md``.
            model: the linkage, instead of the table ``model``.
            source: name of the study in messages.
            folder: that of the study, in which the files of the model are.

        Raises:
            FileError: a table is wrong; the message says what, where and what to do.
            LinkageError: the model cannot be read.
        """
        for name in tables:
            if name not in TABLES:
                remedy = f"the tables are {', '.join(TABLES)}"
                problem = f"no such table{did_you_mean(str(name), TABLES)}"
                raise FileError(source, f"[{clean(str(name))}]", problem, remedy)
        parts = {name: _table(tables, name, source) for name in TABLES}
        text = _read_model(parts["model"], model, source, folder)
        ranges = dict(_read_ranges(parts["parameters"], text, source))
        samples, seed = _read_sampling(parts["sampling"], ranges, source)
        compute = dict(parts["compute"])
        balance, spatial = _read_balance(compute, source)
        quantities = read_quantities(share_motion(compute), source)
        count = parts["run"].get(
            "chunk_rows", SLOW_ROWS if are_slow(quantities) else CHUNK_ROWS
        )
        return cls(
            source,
            text,
            ranges,
            dict(_read_relations(parts["relations"], source)),
            read_constraints(parts["constraints"], source),
            quantities,
            balance,
            spatial,
            samples,
            seed,
            _whole(count, "[run] chunk_rows", source, 1, 10**6),
        )

    @property
    def rows(self) -> int:
        """Number of geometries."""
        return self.samples * math.prod(each.count for each in self.parameters.values())

    def to_text(self) -> str:
        """Write the study as JSON text, from which `from_text` makes it again."""
        data = dict(vars(self)) | {"model": self.model.to_dict()}
        data["parameters"] = {k: [x.kind, x.numbers] for k, x in self.parameters.items()}
        return json.dumps(data, sort_keys=False)

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Read a study from the text of `to_text`.

        Raises:
            FileError: the text is not one of a study.
        """
        source = "study"
        try:
            data = json.loads(text)
        except (ValueError, RecursionError):
            raise _no_study("is no JSON") from None
        names = {each.name for each in fields(cls)}
        if not isinstance(data, dict) or set(data) != names:
            raise _no_study("has other entries than a study")
        if not all(isinstance(data[name], dict) for name in STORED_TABLES):
            raise _no_study(f"one of {', '.join(STORED_TABLES)} is no table")
        balance, spatial = _read_balance(data, source)
        compute = {**data["quantities"], "quantities": list(data["quantities"])}
        return cls(
            clean(str(data["source"]), 1000),
            _stored_model(data["model"]),
            {name: _stored_range(name, pair) for name, pair in data["parameters"].items()},
            dict(_read_relations(data["relations"], source)),
            read_constraints(data["constraints"], source),
            read_quantities(compute, source),
            balance,
            spatial,
            _whole(data["samples"], "samples", source, 1, 2**62),
            _whole(data["seed"], "seed", source, 0, 2**63),
            _whole(data["chunk_rows"], "chunk_rows", source, 1, 10**6),
        )


def _stored_model(data: Tables) -> _ModelText:
    """Read the model of a study as `ModelText.to_dict` writes it."""
    wrong = set(data) != {"source", "text", "options"}
    if wrong or not isinstance(data["source"], str) or not isinstance(data["text"], str):
        raise _no_study("its model has other entries than texts and options")
    options = data["options"]
    option_names = set(TABLES["model"]) - {"file", "loops", "fix_base"}
    if (
        not isinstance(options, dict)
        or not set(options) <= option_names
        or _check_options(options)
    ):
        raise _no_study("the options of its model have no meaning")
    return _ModelText(data["source"], data["text"], options)


def _stored_range(name: str, pair: object) -> Range:
    """Read the kind and the numbers of a range."""
    try:
        return stored_range(pair)
    except RangeError as error:
        raise _no_study(f"the range of '{clean(name)}': {error}") from None


def _no_study(problem: str) -> FileError:
    """Make the error of a text that is not one of a study."""
    return FileError("study", "", problem, "give the text that to_text() returns")


def _table(tables: Tables, name: str, source: str) -> Tables:
    """Take one table of a study, and refuse keys that it does not have."""
    table = tables.get(name, {})
    if not isinstance(table, Mapping):
        raise FileError(source, f"[{name}]", "is no table", f"write [{name}] on a line alone")
    keys = TABLES[name]
    for key in table if keys else ():
        if key not in keys:
            remedy = f"choose from {closest_names(key, keys)}"
            raise FileError(source, f"[{name}] {clean(key)}", "no such key", remedy)
    return table


def _read_model(
    table: Tables, model: Linkage | None, source: str, folder: Path | None
) -> _ModelText:
    """Read the model of a study."""
    if model is not None:
        return _text_of_linkage(model)[0]
    name = table.get("file")
    if not isinstance(name, str):
        raise FileError(source, "[model]", "names no file", 'write file = "robot.urdf"')
    options = {key: value for key, value in table.items() if key != "file"}
    try:
        options = {
            key: in_si(value, "angle", "length") if key == "at" else value
            for key, value in options.items()
        }
    except UsageError as error:
        remedy = 'write at = {u1 = "30deg"}, or radians and metres'
        raise FileError(source, "[model] at", str(error), remedy) from None
    beside = (folder or Path()) / name
    if isinstance(options.get("loops"), str):
        options["loops"] = str((folder or Path()) / options["loops"])
    if wrong := _check_options(options):
        remedy = "write lists of texts, and a table of numbers for at"
        raise FileError(source, "[model]", wrong, remedy)
    try:
        is_beside = beside.is_file()
    except OSError as error:  # a name that is too long
        remedy = 'write file = "robot.urdf"'
        raise FileError(source, "[model]", f"file: {error.strerror}", remedy) from None
    return _text_of_file(beside if is_beside else name, options)[0]


def _read_ranges(table: Tables, model: _ModelText, source: str) -> Iterator[tuple[str, Range]]:
    """Read the ranges of all parameters; percentages are those of values of the model."""
    if not table:
        remedy = 'write for instance "q2.origin.x" = "0.1:0.4:31"'
        raise FileError(source, "[parameters]", "nothing varies", remedy)
    sites = read_sites(model.load()) if "%" in str(dict(table)) else None
    for path, value in _flat(table, ""):
        try:
            numbers = value
            if sites is not None:
                numbers = resolve_percentages(value, partial(_value_in_model, sites, path))
            yield path, read_range(numbers, *quantities_of_path(path))
        except (PathError, RangeError) as error:
            remedy = 'give "first:last:count", a list, or {uniform = [a, b]}'
            where = f"[parameters] {clean(path)}"
            raise FileError(source, where, str(error), remedy) from None


def _value_in_model(sites: Sites, path: str) -> float:
    """Compute the value that a path has in a model; raise PathError if it has none."""
    return sites.value(sites.find(path))


def _read_relations(table: Tables, source: str) -> Iterator[tuple[str, str]]:
    """Read the texts of all relations."""
    for path, value in _flat(table, ""):
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            remedy = 'write "q4.origin.x" = "2*q2.origin.x"'
            where = f"[relations] {clean(path)}"
            raise FileError(source, where, "is no expression", remedy)
        yield path, str(value)


def _flat(table: Tables, head: str) -> Iterator[tuple[str, Any]]:
    """Yield paths and values: TOML makes tables of ``q2.origin.x`` without quotes."""
    for key, value in table.items():
        path = f"{head}{key}"
        nested = isinstance(value, Mapping) and not any(kind in value for kind in SAMPLED)
        if nested and value and all(isinstance(name, str) for name in value):
            yield from _flat(value, f"{path}.")
        else:
            yield path, value


def _read_sampling(table: Tables, ranges: Mapping[str, Range], source: str) -> tuple[int, int]:
    """Read how many samples to take, and their seed."""
    sampled = [path for path, each in ranges.items() if each.kind in SAMPLED]
    if sampled and "count" not in table:
        problem = f"'{clean(sampled[0])}' is sampled, but not how often"
        raise FileError(source, "[sampling]", problem, "write count = 1000")
    if "count" in table and not sampled:
        remedy = "leave it out, or sample a parameter: {uniform = [a, b]}"
        raise FileError(source, "[sampling] count", "no parameter is sampled", remedy)
    samples = _whole(table.get("count", 1), "[sampling] count", source, 1, 2**62)
    rows = samples * math.prod(each.count for each in ranges.values())
    if rows > MOST_POINTS and any(each.kind == "sobol" for each in ranges.values()):
        remedy = "take fewer, or uniform samples"
        raise FileError(source, "[sampling]", f"Sobol ends at {MOST_POINTS} points", remedy)
    return samples, _whole(table.get("seed", 0), "[sampling] seed", source, 0, 2**63)


def _read_balance(compute: dict[str, Any], source: str) -> tuple[Balance, bool]:
    """Take the options of the design space out of the table of what is computed."""
    balance, spatial = compute.pop("balance", "dynamic"), compute.pop("spatial", False)
    if balance not in ("dynamic", "force"):
        problem = f"is '{clean(str(balance))}'"
        raise FileError(source, "[compute] balance", problem, 'write "dynamic" or "force"')
    if not isinstance(spatial, bool):
        raise FileError(source, "[compute] spatial", "is neither true nor false", "write one")
    return balance, spatial


def _whole(value: object, where: str, source: str, least: int, most: int) -> int:
    """Check a whole number."""
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        problem = f"'{clean(str(value))}' is no whole number from {least} to {most:.3g}"
        raise FileError(source, where, problem, "give one")
    return value


@dataclass(frozen=True)
class _ModelText:
    """A model with the options by which it is read.

    Attributes:
        source: name of the model in messages.
        text: the elements of its file, with all loops, as URDF.
        options: keyword arguments of `kinematics.load`.
    """

    source: str
    text: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def load(self) -> Linkage:
        """Read the linkage."""
        return load(Document(self.source, self.text.encode()), **self.options)

    def to_dict(self) -> dict[str, Any]:
        """Convert to the values of a JSON object."""
        return asdict(self)


def _check_options(options: Mapping[str, Any]) -> str:
    """Say which option of a model is of a wrong type; an empty text if none is.

    Args:
        options: keyword arguments of `kinematics.load` that were read from a file.
    """
    for name, value in options.items():
        if name == "at":
            fine = isinstance(value, Mapping) and all(
                is_finite_number(x) and abs(x) <= LARGEST for x in value.values()
            )
            kind = "table of finite numbers"
        elif name in ("inputs", "massless"):
            fine = are_texts(value)
            kind = "list of texts"
        elif name == "mode":
            fine = isinstance(value, int) and not isinstance(value, bool) and value > 0
            kind = "whole number from 1"
        elif name == "fix_base":
            fine, kind = isinstance(value, bool), "true or false"
        else:
            fine, kind = isinstance(value, str), "text"
        if not fine:
            return f"{name} = '{clean(str(value))}' is no {kind}"
    return ""


def _text_of_file(
    model: str | PathLike[str], options: Mapping[str, Any]
) -> tuple[_ModelText, Linkage]:
    """Read a model of any format, and write its elements as text.

    Args:
        model: path or name, as for `kinematics.load`.
        options: keyword arguments of `kinematics.load`.

    Returns:
        The text, and the linkage that was read from it.

    Raises:
        LinkageError: the model cannot be read.
    """
    return _text_and_linkage(load(model, **options), options)


def _text_of_linkage(linkage: Linkage) -> tuple[_ModelText, Linkage]:
    """Write the elements of a linkage as text, with options that give the same linkage.

    Args:
        linkage: an assembled linkage that has the elements of its file.

    Returns:
        The text, and the linkage that was read from it.

    Raises:
        UsageError: the linkage has no elements, or differs from what its file gives.
    """
    if linkage.tree is None:
        raise UsageError(
            f"{linkage.source}: it has no elements of a file whose numbers could vary; write "
            "it by to_urdf() and load that"
        )
    body_names = set(names_of(linkage.bodies))
    options: dict[str, Any] = {"inputs": linkage.inputs}
    if any(not body.inertia.any() for body in linkage.bodies):
        options["bodies"] = "all"
    heavy = [link.name for link in linkage.tree.every("link") if link.first("inertial")]
    tops = {place.link for place in linkage.places.values() if place.link >= 0}
    bare = tops - {body.link for body in linkage.bodies}
    options["massless"] = tuple(
        name for name in heavy if name not in body_names and linkage.places[name].link in bare
    )
    if linkage.displaced is not None and linkage.at is not None:
        names = names_of(linkage.joints)
        options["at"] = dict(zip(names, linkage.displaced.tolist(), strict=True))
    text, again = _text_and_linkage(linkage, options)
    before, after = (
        [*(joint.screw for joint in x.joints), *(body.inertia for body in x.bodies)]
        for x in (linkage, again)
    )
    if len(before) != len(after) or not all(
        np.allclose(a, b, rtol=1e-9, atol=1e-9) for a, b in zip(before, after, strict=True)
    ):
        raise UsageError(
            f"{linkage.source}: its file alone does not give the same linkage; name the file "
            "and its options in the [model] table of a study"
        )
    return text, again


def _text_and_linkage(
    linkage: Linkage, options: Mapping[str, Any]
) -> tuple[_ModelText, Linkage]:
    """Write the elements of a linkage as text, and read that."""
    if linkage.tree is None:
        raise UsageError(f"{linkage.source}: it has no elements of a file")
    kept: dict[str, Any] = {"inputs": list(linkage.inputs)}
    for name, value in options.items():
        if name not in ("loops", "fix_base", "ground"):  # the elements have them
            kept[name] = list(value) if isinstance(value, tuple) else value
    text = _ModelText(linkage.source, element_text(linkage.tree), kept)
    return text, text.load()
