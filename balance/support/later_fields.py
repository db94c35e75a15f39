"""Fields of frozen dataclasses that are made when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

Made = TypeVar("Made", bound="LaterFields")


class LaterFields:
    """A frozen dataclass whose fields may be made at first use; see `with_later_fields`."""

    if not TYPE_CHECKING:  # or no wrong name of an attribute would be seen

        def __getattr__(self, name: str) -> Any:
            """Make a field that has been left for later."""
            later = self.__dict__.get("later", {})
            if name not in later:
                raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
            value = self.__dict__[name] = later[name]()
            return value


def with_later_fields(
    kind: type[Made], later: Mapping[str, Callable[[], Any]], **values: Any
) -> Made:
    """Make an object of a frozen dataclass, with some fields left for later.

    Its ``__init__`` would set one field after the other, which takes four times as long.

    Args:
        kind: the class.
        later: functions that make the fields left for later, by name.
        values: the other fields; those with a default may be left out.
    """
    made = kind.__new__(kind)
    made.__dict__.update(values, later=later)
    return made
