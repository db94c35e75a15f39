"""Load linkages: by path, or by name from the gallery or from example-robot-data."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from os.path import exists, isfile
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias

from kinematics.errors import (
    FileError,
    LinkageError,
    MeetingModesError,
    MobilityError,
    OpenLoopError,
)

if TYPE_CHECKING:
    from yourdfpy import URDF

    from kinematics.files.urdf.read_options import ReadOptions
    from kinematics.model.document.element import Document
    from kinematics.model.linkage import Linkage, Notice, UnassembledLinkage


BODIES = ("given", "all")
# Metres between links above which a file may be in millimetres.
LARGEST_MACHINE = 100.0
# Names that end so are paths, also if there is no such file.
SUFFIXES = (".urdf", ".xml", ".sdf", ".world", ".xacro")


class HasLinkage(Protocol):
    """A result on a linkage, such as a design space."""

    @property
    def linkage(self) -> Linkage:
        """The linkage."""


LinkageLike: TypeAlias = "Linkage | HasLinkage | str | bytes | PathLike[str] | URDF"
"""A linkage, a result on one, or an argument of `load`; see `as_linkage`."""


def gallery() -> dict[str, Path]:
    """List the linkages that come with the package.

    Returns:
        The path of each URDF file, by name.

    Example:
        >>> import kinematics
        >>> {path.suffix for path in kinematics.gallery().values()}
        {'.urdf'}
    """
    import urdf_models

    folder = Path(next(iter(urdf_models.__path__)))
    return {path.stem: path for path in sorted(folder.glob("*.urdf"))}


def robots() -> dict[str, Path]:
    """List the robots of example-robot-data, if it is installed.

    The name of a robot is the stem of its file without ``_robot``. Where files in several
    folders share that name, it is the name of the folder without ``_description``.

    Returns:
        The path of each URDF file, by name.
    """
    files: dict[str, dict[str, Path]] = {}
    for folder in _shares():
        # 'x_robot.urdf' sorts after 'x.urdf', which is then its empty wrapper.
        for path in sorted(folder.glob("*/*/*.urdf")):
            home = path.parents[1].name.removesuffix("_description")
            files.setdefault(path.stem.removesuffix("_robot"), {})[home] = path
    return {
        name if len(homes) == 1 else home: path
        for name, homes in sorted(files.items())
        for home, path in homes.items()
    }


def _shares() -> Iterator[Path]:
    """Folders of the robots of example-robot-data, which has no Python module."""
    prefixes = [Path(entry) / "cmeel.prefix" for entry in sys.path if entry]
    for prefix in [*prefixes, Path(sys.prefix)]:
        folder = prefix / "share" / "example-robot-data" / "robots"
        if folder.is_dir():
            yield folder


def describe(path: Path) -> str:
    """Read the first sentence of the comment at the head of a model's file."""
    text = path.read_text(encoding="utf-8")
    comment = text.partition("<!--")[2].partition("-->")[0]
    return " ".join(comment.split()).partition(". ")[0].rstrip(".")


def find(model: str | PathLike[str]) -> Path:
    """Find the file of a model by path, or by name in the gallery or among the robots.

    A file that exists takes precedence, then the gallery.

    Args:
        model: a path, or a name.

    Returns:
        The path of the file.

    Raises:
        FileError: there is no such file and no such name.
    """
    from kinematics.error_text import clean, closest_names

    path = Path(model)
    models = gallery()
    if isfile(path) or len(path.parts) != 1 or path.suffix.lower() in SUFFIXES:
        if path.stem in models and len(path.parts) == 1 and not exists(path):
            remedy = f"check the path, or give the name of the model, {path.stem}"
            raise FileError(clean(str(model), 1000), "", "no such file", remedy)
        return path
    for name in (path.name, path.name.replace("-", "_")):
        if name in models:
            return models[name]
    others = robots()
    name = path.name.removesuffix("_robot")
    if name in others:
        return others[name]
    named = [*models, *(other for other in others if other not in models)]
    like = [other for other in named if name in other] or named
    remedy = f"give a path, or a name such as {closest_names(name, like)}"
    if not others:
        remedy += "; for robots such as ur5, install example-robot-data"
    raise FileError(
        clean(str(model), 1000), "", "no such file, and no model of this name", remedy
    )


def load(
    model: str | bytes | PathLike[str] | Document | URDF,
    loops: str | PathLike[str] | None = None,
    inputs: Sequence[str] | None = None,
    *,
    fix_base: bool = False,
    bodies: str = "given",
    massless: Sequence[str] = (),
    angles: str = "nominal",
    at: Mapping[str, float] | None = None,
    ground: str | None = None,
    mode: int | None = None,
) -> Linkage:
    """Read a linkage from a robot file, close its loops and choose its coordinates.

    A loop closes where the poses of its frame on both links agree, ``T_P = T_S``, up to a
    motion that its joint allows.

    Args:
        model: path of a URDF, SDF or xacro file, name of a model in the gallery or of a robot
            in example-robot-data, the text of a file (it begins with ``<``) or its bytes, or a
            model that yourdfpy has loaded (its rotation matrices are read as they are). The
            file may come through a pipe, or ``-``, standard input.
        loops: path of a YAML file with the loops; by default ``<loop>`` elements of the URDF
            file, or a YAML file beside a file on disk, with the same stem.
        inputs: names of joints to use as independent coordinates; by default a
            well-conditioned set is chosen, of joints on the base first.
        fix_base: change the floating joint of a base into a fixed one; other bodies that float
            keep six freedoms.
        bodies: ``"given"``: links with mass or inertia in the file carry parameters;
            ``"all"``: every moving link does.
        massless: names of links that carry no parameters, even with mass in the file.
        angles: interpretation of an angle that looks rounded, such as 1.5708. ``"nominal"``:
            the multiple of π/12 within 1e-4 rad of it. ``"as_written"``: its digits, and no
            axis is moved to close loops that close only to rounding. A notice names them.
        at: positions of joints at another reference pose, such as ``{"u1": 0.3}``, relative
            to the pose of the file, rad and m. Inputs are set to them, and the other joints
            follow, on the same branch. Positions of joints that are no inputs are starting
            values, from which the loops are closed at the nearest pose: they choose the
            branch. A pose that closes stays as given, even next to a singular one; from a
            singular one the linkage moves away, with a notice, and ``Linkage.at`` says to
            where.
        ground: name of the link that is the ground, if joints leave several links uncarried
            or an SDF model is not fixed to the world.
        mode: number of a mode of motion, from 1, where several meet at the pose of the file,
            or else at that of ``at``; `kinematics.errors.MeetingModesError` lists them. The
            reference pose is on that mode, away from where they meet.

    Returns:
        The linkage at its reference pose, in the frame of its root link, SI units.

    Raises:
        LinkageError: the file or the linkage cannot be used; the subclass gives the reason.
            A note on an error of closure or mobility names the angles that look rounded.
        TypeError: ``model`` is neither a path, a name, a text nor a model of yourdfpy.

    Source:
        ROS, URDF specification (extended by ``<loop>``); Gepetto, example-parallel-robots.

    Example:
        >>> import kinematics
        >>> linkage = kinematics.load("robot.urdf")
        >>> linkage.inputs, linkage.mobility, linkage.planar
        (('u1',), 1, True)
    """
    from kinematics.files.urdf.read_options import ReadOptions

    _check_options(bodies, angles)
    names = (massless,) if isinstance(massless, str) else tuple(massless)
    exactly = angles == "as_written"
    draft = _read(model, loops, ReadOptions(fix_base, bodies, names, angles, ground))
    return _assemble(replace(draft, as_written=exactly), inputs, at, mode, exactly)


def _check_options(bodies: str, angles: str) -> None:
    """Refuse unknown values of options."""
    from kinematics.error_text import clean
    from kinematics.files.urdf.rounded_angles import ANGLE_READINGS

    for option, value, choices in (
        ("bodies", bodies, BODIES),
        ("angles", angles, ANGLE_READINGS),
    ):
        if value not in choices:
            problem = f"{option} '{clean(str(value))}' unknown"
            raise LinkageError(f"{problem}; choose from {', '.join(choices)}")


def as_linkage(model: LinkageLike) -> Linkage:
    """Convert an argument to a linkage: itself, that of a result, or the result of `load`.

    Args:
        model: a linkage, a result that has one, such as a design space, or a path, a name, a
            text or a model as `load` accepts them.

    Returns:
        The linkage.

    Raises:
        LinkageError: the file or the linkage cannot be used.
        TypeError: the argument is of another type.
    """
    from kinematics.model.linkage import Linkage

    if isinstance(model, Linkage):
        return model
    held = getattr(model, "linkage", None)
    if isinstance(held, Linkage):
        return held
    if not (isinstance(model, (str, bytes, PathLike)) or hasattr(model, "robot")):
        raise TypeError(
            "expected a kinematics.Linkage, a path, the name of a model or a yourdfpy.URDF, "
            f"not {type(model).__name__}"
        )
    return load(model)


def _assemble(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None,
    at: Mapping[str, float] | None,
    mode: int | None,
    exactly: bool,
) -> Linkage:
    """Assemble a linkage, at its own pose or at another.

    Errors of closure and mobility get a note on the angles that look rounded.
    """
    from kinematics.closure.assembly.assemble import assemble
    from kinematics.error_text import clean
    from kinematics.files.urdf.rounded_angles import DEGREES, ROUNDED_ANGLES
    from kinematics.loading.meant.as_meant import as_meant

    try:
        if at:
            from kinematics.closure.assembly.reference_pose import assemble_at

            linkage = assemble_at(draft, inputs, at, exactly=exactly, mode=mode)
        else:
            linkage = assemble(draft, inputs, exactly=exactly, mode=mode)
    except (OpenLoopError, MobilityError) as error:
        if isinstance(error, MeetingModesError):
            error.modes = tuple(
                mode
                if isinstance(mode.linkage, LinkageError)
                else mode._replace(linkage=as_meant(mode.linkage, exactly=exactly))
                for mode in error.modes
            )
        for notice in draft.notices:
            if notice.code in (DEGREES, ROUNDED_ANGLES):
                error.add_note(notice.message.removeprefix(f"{clean(draft.source, 1000)}: "))
        raise
    from kinematics.loading.forgotten_loops import forgotten_loop
    from kinematics.loading.implausible_masses import implausible_masses

    linkage = as_meant(linkage, exactly=exactly)
    size = _size_notices(draft)
    told = (*size, *forgotten_loop(draft), *(() if size else implausible_masses(draft)))
    return replace(linkage, notices=(*linkage.notices, *told))


def _size_notices(draft: UnassembledLinkage) -> list[Notice]:
    """Note links that are further apart than those of a machine in metres."""
    import numpy as np

    from kinematics.model.linkage import Notice
    from kinematics.wording import number_text

    origins = np.array([place.pose[:3, 3] for place in draft.places.values()])
    size = float(np.linalg.norm(np.ptp(origins, axis=0))) if len(origins) else 0.0
    if not size > LARGEST_MACHINE:
        return []
    text = (
        f"its links are up to {number_text(size, '.3g')} m apart: if the file is in "
        "millimetres, divide its lengths by 1000, and its moments of inertia by 1e6"
    )
    return [Notice("large_machine", text)]


def _read(
    model: str | bytes | PathLike[str] | Document | URDF,
    loops: str | PathLike[str] | None,
    options: ReadOptions,
) -> UnassembledLinkage:
    """Read a linkage from a file or a loaded model, its loops not yet closed."""
    from kinematics.files.formats.robot_files import read_unassembled
    from kinematics.files.urdf.input_streams import read_stream
    from kinematics.model.document.element import Document

    if isinstance(model, bytes) or (isinstance(model, str) and model.lstrip().startswith("<")):
        model = Document("<text>", model if isinstance(model, bytes) else model.encode())
    if isinstance(model, (str, PathLike)):
        model = read_stream(model) or find(model)
    if isinstance(model, (Document, Path)):
        return read_unassembled(model, loops, options)
    if not hasattr(model, "robot"):
        raise TypeError(f"model is a path, a name or a yourdfpy.URDF, not {type(model)}")
    from kinematics.files.urdf.read import read_loaded_model

    return read_loaded_model(model, loops, options)
