"""The model of a study as text, from which every process reads the same linkage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from os import PathLike
from typing import Any

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.document.write_numbers import element_text
from kinematics.model.linkage import Linkage, names_of

# Largest coordinate of a pose: radians or metres.
LARGEST = 1e9


@dataclass(frozen=True)
class ModelText:
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


def check_options(options: Mapping[str, Any]) -> str:
    """Say which option of a model is of a wrong type; an empty text if none is.

    Args:
        options: keyword arguments of `kinematics.load` that were read from a file.
    """
    for name, value in options.items():
        if name == "at":
            fine = isinstance(value, Mapping) and all(map(_is_number, value.values()))
            kind = "table of finite numbers"
        elif name in ("inputs", "massless"):
            fine = isinstance(value, list | tuple) and all(isinstance(x, str) for x in value)
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


def _is_number(value: object) -> bool:
    """Whether a value is a finite number that is neither true nor false."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST


def text_of_file(
    model: str | PathLike[str], options: Mapping[str, Any]
) -> tuple[ModelText, Linkage]:
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


def text_of_linkage(linkage: Linkage) -> tuple[ModelText, Linkage]:
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
) -> tuple[ModelText, Linkage]:
    """Write the elements of a linkage as text, and read that."""
    if linkage.tree is None:
        raise UsageError(f"{linkage.source}: it has no elements of a file")
    kept: dict[str, Any] = {"inputs": list(linkage.inputs)}
    for name, value in options.items():
        if name not in ("loops", "fix_base", "ground"):  # the elements have them
            kept[name] = list(value) if isinstance(value, tuple) else value
    text = ModelText(linkage.source, element_text(linkage.tree), kept)
    return text, text.load()
