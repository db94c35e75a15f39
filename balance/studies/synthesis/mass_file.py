"""Files of masses of a pantograph, in JSON."""

from __future__ import annotations

import json
import sys
from dataclasses import fields
from os import PathLike, fsdecode

from balance.studies.synthesis.pantograph import PantographMasses
from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError

# Largest file, bytes.
LARGEST = 100_000
OPTIONAL = {"s5": None}
FOLLOWS = ("l1", "s1", "s2")


def read_masses(path: str | PathLike[str]) -> PantographMasses:
    """Read the masses of a pantograph from an object of JSON with the names of the fields.

    Args:
        path: the file; SI units. Without ``s5`` the payload is at the point of the tool.

    Returns:
        The masses.

    Raises:
        FileError: the file is none, a name is unknown or missing, or a value is no number.
        UsageError: a number is out of range.
    """
    name = clean(fsdecode(path), 1000)
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST + 1)
        entries = json.loads(data[:LARGEST].decode("utf-8"))
    except OSError as error:
        raise FileError(name, "", f"cannot be read ({error.strerror})", "give a file") from None
    except (ValueError, RecursionError):
        raise FileError(name, "", "is no JSON", "write one object of numbers") from None
    if not isinstance(entries, dict):
        raise FileError(name, "", "is no object", "write one object of numbers")
    field_names = [field.name for field in fields(PantographMasses)]
    for key, value in entries.items():
        if key in FOLLOWS:
            raise FileError(name, key, "follows from the balance of forces", "leave it out")
        if key not in field_names:
            near = closest_names(key, field_names)
            raise FileError(name, clean(key), "is no mass or length", f"the names are {near}")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        number = number and abs(value) <= sys.float_info.max
        if not (number or (value is None and key in OPTIONAL)):
            raise FileError(name, key, "is no number", "give a number in SI units")
    missing = [key for key in field_names if key not in entries and key not in OPTIONAL]
    if missing:
        raise FileError(name, "", f"lacks {', '.join(missing)}", "give all masses and lengths")
    numbers = {key: float(value) for key, value in entries.items() if value is not None}
    masses = PantographMasses(**{**OPTIONAL, **numbers})  # type: ignore[arg-type]
    masses.check()
    return masses
