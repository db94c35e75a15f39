"""Finding and loading linkages: by path, or by name from the gallery."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from kinematics.errors import FileError

if TYPE_CHECKING:
    from kinematics.linkage import Linkage

__all__ = ["describe", "find", "gallery", "load"]


def gallery() -> dict[str, Path]:
    """Paths of the linkages that come with the package, by name."""
    folder = Path(str(files("urdf_models")))
    return {path.stem: path for path in sorted(folder.glob("*.urdf"))}


def describe(path: Path) -> str:
    """First sentence of the comment at the head of a model's file."""
    text = path.read_text(encoding="utf-8")
    comment = text.partition("<!--")[2].partition("-->")[0]
    return " ".join(comment.split()).partition(". ")[0].rstrip(".")


def find(model: str | PathLike[str]) -> Path:
    """Path of a model given by path or by its name in the gallery.

    Raises:
        FileError: there is no such file and no such name.
    """
    path = Path(model)
    if path.exists() or path.suffix or len(path.parts) > 1:
        return path
    known = gallery()
    if path.name not in known:
        raise FileError(
            str(model), "", "no such file, and no such model in the gallery",
            f"give a path, or one of {', '.join(known)}",
        )  # fmt: skip
    return known[path.name]


def load(
    model: str | PathLike[str],
    loops: str | PathLike[str] | None = None,
    inputs: Sequence[str] | None = None,
) -> Linkage:
    """Read a linkage from a URDF file, close its loops and choose its coordinates.

    Args:
        model: path of a URDF file, or name of a model in the gallery.
        loops: path of a file that describes the loops; by default they are ``<loop>``
            elements of the URDF file.
        inputs: names of joints to use as independent coordinates.

    Returns:
        The linkage at its reference pose, the pose of the file.

    Raises:
        LinkageError: the file or the linkage cannot be used; the subclass says why.
    """
    from kinematics import urdf

    draft = urdf.read(find(model))
    from kinematics.assembly import assemble

    return assemble(draft, inputs)
