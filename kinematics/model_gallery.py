"""Finding and loading linkages: by path, or by name from the gallery or example-robot-data."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from kinematics.errors import FileError, LinkageError, MobilityError, OpenLoopError

if TYPE_CHECKING:
    from yourdfpy import URDF

    from kinematics.model.linkage import Linkage, UnassembledLinkage
    from kinematics.urdf.input_files import ReadOptions
    from kinematics.urdf_elements.element import Document

__all__ = ["LinkageLike", "as_linkage", "describe", "find", "gallery", "load", "robots"]

BODIES = ("given", "all")
# What stands for a linkage: see `as_linkage`.
LinkageLike: TypeAlias = "Linkage | str | PathLike[str] | URDF"


def gallery() -> dict[str, Path]:
    """Paths of the linkages that come with the package, by name."""
    import urdf_models

    folder = Path(next(iter(urdf_models.__path__)))
    return {path.stem: path for path in sorted(folder.glob("*.urdf"))}


def robots() -> dict[str, Path]:
    """Paths of the robots of example-robot-data, by name, if it is installed.

    A robot goes by the stem of its file without ``_robot``. Where files in several folders
    share that name, each goes by the name of its folder without ``_description``.
    """
    found: dict[str, dict[str, Path]] = {}
    for folder in _shares():
        # 'x_robot.urdf' sorts after 'x.urdf', which is then its empty wrapper.
        for path in sorted(folder.glob("*/*/*.urdf")):
            home = path.parents[1].name.removesuffix("_description")
            found.setdefault(path.stem.removesuffix("_robot"), {})[home] = path
    return {
        name if len(homes) == 1 else home: path
        for name, homes in sorted(found.items())
        for home, path in homes.items()
    }


def _shares() -> Iterator[Path]:
    """Folders where example-robot-data keeps its robots: it has no Python module."""
    prefixes = [Path(entry) / "cmeel.prefix" for entry in sys.path if entry]
    for prefix in [*prefixes, Path(sys.prefix)]:
        folder = prefix / "share" / "example-robot-data" / "robots"
        if folder.is_dir():
            yield folder


def describe(path: Path) -> str:
    """First sentence of the comment at the head of a model's file."""
    text = path.read_text(encoding="utf-8")
    comment = text.partition("<!--")[2].partition("-->")[0]
    return " ".join(comment.split()).partition(". ")[0].rstrip(".")


def find(model: str | PathLike[str]) -> Path:
    """Path of a model given by path, or by its name in the gallery or among the robots.

    A file that exists comes first, then the gallery.

    Raises:
        FileError: there is no such file and no such name.
    """
    path = Path(model)
    if isfile(path) or len(path.parts) != 1 or path.suffix.lower() in (".urdf", ".xml"):
        return path
    known = gallery()
    if path.name in known:
        return known[path.name]
    from kinematics.error_text import clean, closest_names

    others = robots()
    name = path.name.removesuffix("_robot")
    if name in others:
        return others[name]
    named = [*known, *(other for other in others if other not in known)]
    like = [other for other in named if name in other] or named
    remedy = f"give a path, or a name such as {closest_names(name, like)}"
    if not others:
        remedy += "; for robots such as ur5, install example-robot-data"
    raise FileError(
        clean(str(model), 1000), "", "no such file, and no model of this name", remedy
    )


def load(
    model: str | PathLike[str] | Document | URDF,
    loops: str | PathLike[str] | None = None,
    inputs: Sequence[str] | None = None,
    *,
    fix_base: bool = False,
    bodies: str = "given",
    massless: Sequence[str] = (),
    angles: str = "nominal",
    at: Mapping[str, float] | None = None,
) -> Linkage:
    """Read a linkage from a URDF file, close its loops and choose its coordinates.

    Args:
        model: path of a URDF file, name of a model in the gallery or of a robot in
            example-robot-data, or a model that yourdfpy has loaded. A file may come through
            a pipe, or ``-``, standard input; no other file is then looked for beside it.
        loops: path of a YAML file that describes the loops; by default they are ``<loop>``
            elements of the URDF file, or in a YAML file next to it with the same stem.
        inputs: names of joints to use as independent coordinates.
        fix_base: turn a floating joint between ground and base into a fixed one.
        bodies: ``"given"``: links with mass or inertia in the file carry parameters;
            ``"all"``: every moving link does.
        massless: names of links that carry no parameters whatever the file says.
        angles: what is meant by an angle that looks rounded, such as 1.5708. ``"nominal"``:
            the multiple of π/12 within 1e-4 rad of it. ``"as_written"``: its digits, and no
            axis is moved to close loops that close only to rounding. A notice names such
            angles. A model that yourdfpy has loaded holds matrices in place of angles, and
            they are taken as they are.
        at: coordinates of inputs at another reference pose than that of the file, such as
            ``{"u1": 0.3}``: counted from the pose of the file, in radians and metres. Inputs
            that are not named stay; all other joints follow, without a change of branch.

    Returns:
        The linkage at its reference pose: that of the file with its loops closed, or ``at``.

    Raises:
        LinkageError: the file or the linkage cannot be used; the subclass says why. A note
            on an error of closure or mobility names the angles that look rounded.
    """
    from kinematics.error_text import clean
    from kinematics.urdf.input_files import ReadOptions
    from kinematics.urdf.rounded_angles import ANGLE_READINGS, ROUNDED_ANGLES

    for option, value, known in (
        ("bodies", bodies, BODIES),
        ("angles", angles, ANGLE_READINGS),
    ):
        if value not in known:
            wrong = f"{option} '{clean(str(value))}' unknown"
            raise LinkageError(f"{wrong}; choose from {', '.join(known)}")
    closed = (massless,) if isinstance(massless, str) else tuple(massless)
    draft = _draft(model, loops, ReadOptions(fix_base, bodies, closed, angles))
    try:
        return _assembled(draft, inputs, at, angles == "as_written")
    except (OpenLoopError, MobilityError) as error:
        for notice in draft.notices:
            if notice.code == ROUNDED_ANGLES:
                error.add_note(notice.message.removeprefix(f"{clean(draft.source, 1000)}: "))
        raise


def as_linkage(model: LinkageLike) -> Linkage:
    """The linkage that an argument stands for: itself, or what `load` reads.

    Args:
        model: a linkage, or a path, a name or a model as `load` accepts them.

    Raises:
        LinkageError: the file or the linkage cannot be used.
        TypeError: it is something else.
    """
    from kinematics.model.linkage import Linkage

    if isinstance(model, Linkage):
        return model
    if not (isinstance(model, (str, PathLike)) or hasattr(model, "robot")):
        raise TypeError(
            "expected a kinematics.Linkage, a path, the name of a model or a yourdfpy.URDF, "
            f"not {type(model).__name__}"
        )
    return load(model)


def _assembled(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None,
    at: Mapping[str, float] | None,
    exactly: bool,
) -> Linkage:
    """The linkage of a draft, at its own pose or at another."""
    from kinematics.assembly.assemble import assemble

    linkage = assemble(draft, inputs, exactly=exactly)
    if not at:
        return linkage
    from kinematics.assembly.reference_pose import move_reference_pose

    return move_reference_pose(linkage, at, exactly=exactly)


def _draft(
    model: str | PathLike[str] | Document | URDF,
    loops: str | PathLike[str] | None,
    options: ReadOptions,
) -> UnassembledLinkage:
    """The linkage as its file, or a loaded model, describes it."""
    from kinematics.urdf.input_files import read_files
    from kinematics.urdf.input_streams import read_stream
    from kinematics.urdf_elements.element import Document

    if isinstance(model, (str, PathLike)):
        model = read_stream(model) or find(model)
    if isinstance(model, (Document, Path)):
        side = read_files(model, loops, options)
        # The file has been accepted; only now is it worth loading libraries.
        from kinematics.urdf.read import read_linkage

        return read_linkage(model, side, options)
    if not hasattr(model, "robot"):
        raise TypeError(f"model is a path, a name or a yourdfpy.URDF, not {type(model)}")
    from kinematics.urdf.read import read_loaded_model

    return read_loaded_model(model, loops, options)
