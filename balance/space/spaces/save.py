"""Design spaces on disk, as data without their linkage.

A file is one ``.npz``: the arrays, and a JSON text ``header`` with their origin. Nothing in it
is ever unpickled.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import Any, get_args

import numpy as np

from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.space_data import Order, SpaceData
from balance.support.atomic_files import open_atomic
from balance.support.options import Balance
from kinematics.error_text import clean
from kinematics.errors import FileError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Notice
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import first_names, repr_lines

FORMAT = "balance.space/2"
# Largest size of an unpacked file in bytes; larger ones are refused.
LARGEST_FILE = 2**30


@dataclass(frozen=True, eq=False)
class SpaceRecord(SpaceData):
    """A design space as data, without the linkage it came from.

    Attributes:
        basis: null-space basis (parameters, nullity): per body the parameters named by
            ``labels``, about the inertial origin at the reference pose, SI units. Its
            columns are orthonormal when lengths are measured from the middle of the
            mechanism in units of ``length``.
        singular_values: of all conditions, relative to the largest (rank,).
        kept: the smallest singular value that counts; 1 if there are none.
        dropped: upper bound of the largest one that does not.
        sha256: of the file when the record was made; None if it was no file.
        version: of the package that made the record.
    """

    basis: Array
    singular_values: Array
    kept: float
    dropped: float
    sha256: str | None
    version: str

    def __repr__(self) -> str:
        """Up to four lines: the space, its parts, its origin."""
        bodies, source = f"bodies {first_names(self.bodies)}", f"from {self.source}"
        return repr_lines(f"SpaceRecord: {self.parts}", bodies, source)


def record_of(space: DesignSpace) -> SpaceRecord:
    """Make the record of a design space, without its linkage."""
    from kinematics.version import __version__

    data = {item.name: getattr(space, item.name) for item in fields(SpaceData)}
    if space.linkage.at:
        pose = Notice("reference_pose", f"the reference pose is {space.linkage.pose}")
        data["notices"] = (*space.notices, pose)
    return SpaceRecord(
        **data,
        basis=space.basis,
        singular_values=space.singular_values,
        kept=space.kept,
        dropped=space.dropped,
        sha256=_sha256_of(space.source),
        version=__version__,
    )


def save_space(
    space: DesignSpace | SpaceRecord | LinkageLike, path: str | os.PathLike[str]
) -> None:
    """Write a design space to one ``.npz`` file, which `load_space` reads.

    The write is atomic. The entry ``header`` of the file is a JSON text with the version, the
    SHA-256 of the linkage's file and all options.

    Args:
        space: a design space, the record of one, or a linkage, its path or its name.
        path: the file to write.

    Raises:
        FileError: the file cannot be written.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> balance.space.save_space(space, "space.npz")
    """
    record = space if isinstance(space, SpaceRecord) else record_of(as_space(space))
    arrays = {name: getattr(record, name) for name in _array_shapes(record)}
    if record.motion:
        arrays["motion"] = record.motion.basis
    header = np.array(json.dumps(_header(record)))
    with open_atomic(path) as file:
        np.savez(file, allow_pickle=False, header=header, **arrays)


def load_space(path: str | os.PathLike[str]) -> SpaceRecord:
    """Read a design space that `save_space` wrote.

    Args:
        path: the file.

    Returns:
        The space as data, without its linkage; see `SpaceRecord`.

    Raises:
        FileError: the file is no saved design space, is damaged, or has another format.

    Example:
        >>> import balance
        >>> balance.space.save_space(balance.design_space("robot.urdf"), "space.npz")
        >>> balance.space.load_space("space.npz").nullity
        4
    """
    try:
        header, arrays = _read_archive(path)
        record = _build_record(header, arrays) if header["format"] == FORMAT else None
    except OSError as error:
        problem = f"cannot be read ({error.strerror or type(error).__name__})"
    except Exception:  # a damaged archive may raise anything
        problem = "not a saved design space, or damaged"
    else:
        if record is not None:
            return record
        problem = f"its format is {str(header['format'])[:40]!r}, not {FORMAT!r}"
    raise FileError(
        clean(os.fsdecode(path), 1000), "", problem, "give a file that save_space wrote"
    ) from None


def _sha256_of(source: str) -> str | None:
    """Compute the SHA-256 of a file; None if there is no such file."""
    with suppress(OSError, ValueError):
        return sha256(Path(source).read_bytes()).hexdigest()
    return None


def _array_shapes(record: SpaceRecord) -> dict[str, tuple[int, ...]]:
    """List the arrays of a record and their shapes."""
    return {
        "basis": (len(record.bodies) * len(record.labels), record.nullity),
        "axes": (3, 3),
        "frames": (len(record.bodies), 4, 4),
        "singular_values": (record.rank,),
    }


def _header(record: SpaceRecord) -> dict[str, object]:
    """Collect everything of a record but its arrays; ``options`` repeats the computation."""
    return {
        "format": FORMAT,
        "version": record.version,
        "source": record.source,
        "sha256": record.sha256,
        "directions": "deterministic",
        "options": {
            "inputs": record.inputs,
            "motion": record.motion.relations if record.motion else None,
            "balance": record.balance,
            "max_order": None if record.poses else record.orders[-1].order,
            "spatial": not record.planar,
        },
        "bodies": record.bodies,
        "idle": record.idle,
        "orders": record.orders,
        "serial_nullity": record.serial_nullity,
        "poses": record.poses,
        "settled": record.settled,
        "length": record.length,
        "kept": record.kept,
        "dropped": record.dropped,
        "notices": record.notices,
    }


def _read_archive(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Read header and arrays of a file, without checks of their contents."""
    with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
        if sum(member.file_size for member in archive.zip.infolist()) > LARGEST_FILE:
            raise ValueError("too large")
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(arrays.pop("header").item()), arrays


def _build_record(header: dict[str, Any], arrays: dict[str, Array]) -> SpaceRecord:
    """Build the record, if everything has its type and fits together."""
    options, motion = header["options"], None
    inputs = _check_texts(options["inputs"])
    if options["motion"] is not None:
        basis = _check_array(arrays.pop("motion"), (len(inputs), -1))
        motion = Motion(inputs, _check_texts(options["motion"]), basis)
    record = SpaceRecord(
        source=_check_type(str, header["source"]),
        sha256=None if header["sha256"] is None else _check_type(str, header["sha256"]),
        version=_check_type(str, header["version"]),
        balance=options["balance"],
        planar=not _check_type(bool, options["spatial"]),
        bodies=_check_texts(header["bodies"]),
        inputs=inputs,
        idle=_check_texts(header["idle"]),
        motion=motion,
        orders=tuple(
            Order(*(_check_type(int, n) for n in order)) for order in header["orders"]
        ),
        serial_nullity=_check_type(int, header["serial_nullity"]),
        poses=_check_type(int, header["poses"]),
        settled=_check_type(bool, header["settled"]),
        length=_check_type(float, header["length"]),
        kept=_check_type(float, header["kept"]),
        dropped=_check_type(float, header["dropped"]),
        notices=tuple(Notice(*_check_texts(notice)) for notice in header["notices"]),
        **arrays,
    )
    shapes = _array_shapes(record)
    sums = {record.rank + record.nullity, *(o.rank + o.nullity for o in record.orders)}
    last = record.orders[-1].rank
    fits = (
        record.balance in get_args(Balance)
        and sums == {shapes["basis"][0]}
        and [order.order for order in record.orders] == list(range(len(record.orders)))
        and 0 <= record.serial_nullity <= record.nullity
        and (last == record.rank if record.poses == 0 else last <= record.rank)
    )
    if not fits or record.poses < 0:
        raise ValueError("header")
    for name, shape in shapes.items():
        object.__setattr__(record, name, _check_array(arrays[name], shape))
    return record


def _check_type(kind: type, value: Any) -> Any:
    """Return the value, if it is of that type."""
    if type(value) is not kind:
        raise TypeError(kind.__name__)
    return value


def _check_texts(values: Any) -> tuple[str, ...]:
    """Convert a list of texts to a tuple."""
    return tuple(_check_type(str, value) for value in _check_type(list, values))


def _check_array(array: Array, shape: tuple[int, ...]) -> Array:
    """Copy an array read-only, if it is finite and has that shape (-1 for any length)."""
    fits = len(shape) == array.ndim and all(
        n in (m, -1) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype != np.float64 or not np.isfinite(array).all():
        raise ValueError("array")
    return freeze(array)
