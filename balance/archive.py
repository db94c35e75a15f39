"""Design spaces on disk: what is known of one, without the linkage it came from.

A file is one ``.npz``: the arrays, and a JSON text ``header`` that says where they come
from. Nothing in it is ever unpickled.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.bodies import BodyInertia, body_inertias, in_link_frames
from balance.files import replacing
from balance.inertia import parameter_labels
from kinematics.errors import FileError
from kinematics.linkage import Notice, frozen
from kinematics.motion import Motion
from kinematics.reader.markup import shown

__all__ = ["Balance", "Order", "SpaceRecord", "digest", "load_space"]

Array = NDArray[np.float64]
Balance = Literal["dynamic", "force"]

FORMAT = "balance.space/2"
COMPARED = "balance planar bodies inputs rank nullity serial_nullity kmax".split()
# Files that unpack to more bytes are refused.
LARGEST = 2**30
# Spaces whose largest angle has a smaller sine count as one.
SAME = 1e-6


class Order(NamedTuple):
    """Rank and nullity after all conditions up to an order."""

    order: int
    rank: int
    nullity: int


@dataclass(frozen=True, eq=False)
class SpaceRecord:
    """A design space as data, with or without the linkage it came from.

    Attributes:
        source: file of the linkage.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        planar: whether planar parameters are counted.
        bodies: names of the bodies, in the order of the parameters.
        inputs: names of the independent coordinates, whether or not the motion moves them.
        idle: names of joints that do not move in the motion.
        motion: the motion asked of the linkage, None if every input is free.
        orders: rank and nullity by order of derivative.
        poses: how many finite poses were added, because the orders were not enough.
        settled: whether the conditions are all there are: nothing is left to be conditioned,
            or finite poses that were not used add nothing.
        basis: null-space basis (parameters, nullity): per body the parameters named by
            ``labels``, about the inertial origin at the reference pose, SI units. Its
            columns are orthonormal when lengths are measured from the middle of the
            mechanism in units of ``length``.
        serial_nullity: how many columns of the basis, the first ones, span the serial part:
            the inertia transfers of its joints, with all loops opened.
        axes: rows are the axes in which planar parameters are expressed (3, 3).
        frames: poses of the link frames of the bodies (bodies, 4, 4).
        length: characteristic length of the mechanism, metres.
        singular_values: of all conditions, relative to the largest (rank,).
        kept: the smallest singular value that counts.
        dropped: upper bound of the largest one that does not.
        notices: remarks.
        sha256: of the file when the record was made; None if it was no file, or is not known.
        version: of the package that made the record.
    """

    source: str
    balance: Balance
    planar: bool
    bodies: tuple[str, ...]
    inputs: tuple[str, ...]
    idle: tuple[str, ...]
    motion: Motion | None
    orders: tuple[Order, ...]
    poses: int
    settled: bool
    basis: Array
    serial_nullity: int
    axes: Array
    frames: Array
    length: float
    singular_values: Array
    kept: float
    dropped: float
    notices: tuple[Notice, ...]
    sha256: str | None = None
    version: str = "unknown"

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return self.singular_values.size

    @property
    def nullity(self) -> int:
        """Dimension of the space."""
        return self.basis.shape[1]

    @property
    def serial(self) -> Array:
        """The columns of the basis that the linkage has with its loops opened."""
        return self.basis[:, : self.serial_nullity]

    @property
    def parallel(self) -> Array:
        """The other columns: what only the closure of the loops opens."""
        return self.basis[:, self.serial_nullity :]

    @property
    def kmax(self) -> int | None:
        """First order at which the rank has its final value; None if poses decided it."""
        return (
            None
            if self.poses
            else next(order.order for order in self.orders if order.rank == self.rank)
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters of one body."""
        return parameter_labels(self.planar, self.balance == "force")

    def bodies_of(self, y: ArrayLike) -> tuple[BodyInertia, ...]:
        """The mass distribution ``basis @ y``, body by body, as a designer edits it.

        Args:
            y: coordinates in the basis (nullity,); they need not give physical bodies.

        Returns:
            Mass, centre of mass and inertia about it, in the inertial frame at the
            reference pose, in the link frame of the file, and as the file's element.
        """
        return body_inertias(
            self.bodies, self.basis, y, self.frames, self.axes, self.labels, self.length
        )

    def basis_in_link_frames(self) -> Array:
        """The basis (parameters, nullity), each body about the origin of its link frame.

        Parameters are those of ``labels``, in the axes of the link frame of the file, SI
        units; they keep their values when the linkage moves. Planar ones are in the axes
        ``kinematics.chain.plane_axes(n)``, n being the normal in that frame: x and y if it
        is the z axis.
        """
        return in_link_frames(self.basis, self.frames, self.axes, self.labels)

    def differences(self, other: SpaceRecord) -> tuple[str, ...]:
        """One line per respect in which another design space differs; none if they agree.

        Spaces are compared as such, not their bases; files are not compared.
        """
        found = [
            f"{name}: {mine} here, {its} there"
            for name in COMPARED
            if (mine := getattr(self, name)) != (its := getattr(other, name))
        ]
        if self.basis.shape == other.basis.shape:
            sine = _sine(self.basis, other.basis, self.labels)
            if not sine <= SAME:
                found.append(f"basis: the spaces are apart by an angle with sine {sine:.1e}")
        return tuple(found)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the record to one ``.npz`` file, which `load_space` reads.

        The file appears whole or not at all. Its entry ``header`` is a JSON text with the
        version, the SHA-256 of the linkage's file and all options.

        Raises:
            FileError: it cannot be written.
        """
        arrays = {name: getattr(self, name) for name in _shapes(self)}
        if self.motion:
            arrays["motion"] = self.motion.basis
        with replacing(path) as file:
            np.savez(
                file, allow_pickle=False, header=np.array(json.dumps(_header(self))), **arrays
            )


def load_space(path: str | os.PathLike[str]) -> SpaceRecord:
    """Read a design space that `DesignSpace.save` or `SpaceRecord.save` wrote.

    Raises:
        FileError: it is not such a file, is damaged, or has another format.
    """
    try:
        header, arrays = _read(path)
        record = _record(header, arrays) if header["format"] == FORMAT else None
    except OSError as error:
        problem = f"cannot be read ({error.strerror or type(error).__name__})"
    except Exception:  # a damaged archive may raise anything
        problem = "not a saved design space, or damaged"
    else:
        if record is not None:
            return record
        problem = f"its format is {str(header['format'])[:40]!r}, not {FORMAT!r}"
    raise FileError(
        shown(os.fsdecode(path), 1000), "", problem, "give a file that DesignSpace.save wrote"
    ) from None


def digest(source: str) -> str | None:
    """SHA-256 of a file, None if there is no such file."""
    with suppress(OSError, ValueError):
        return sha256(Path(source).read_bytes()).hexdigest()
    return None


def _sine(one: Array, other: Array, labels: Sequence[str]) -> float:
    """Sine of the largest angle between spaces of one dimension, in any unit of length."""
    kinds = np.array([label.rstrip("xyz") for label in labels] * (len(one) // len(labels)))
    scale = np.ones((len(one), 1))
    for kind in set(kinds):
        size = max(np.abs(basis[kinds == kind]).max(initial=0.0) for basis in (one, other))
        scale[kinds == kind] = size or 1.0
    P, Q = np.linalg.qr(one / scale)[0], np.linalg.qr(other / scale)[0]
    outside = Q - P @ (P.T @ Q)
    return float(np.linalg.norm(outside, 2)) if outside.size else 0.0


def _shapes(record: SpaceRecord) -> dict[str, tuple[int, ...]]:
    """The arrays of a record and their shapes."""
    return {
        "basis": (len(record.bodies) * len(record.labels), record.nullity),
        "axes": (3, 3),
        "frames": (len(record.bodies), 4, 4),
        "singular_values": (record.rank,),
    }


def _header(record: SpaceRecord) -> dict[str, object]:
    """All of a record but its arrays; ``options`` repeats the computation."""
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


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Header and arrays as they stand in the file."""
    with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
        if sum(member.file_size for member in archive.zip.infolist()) > LARGEST:
            raise ValueError("too large")
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(arrays.pop("header").item()), arrays


def _record(header: dict[str, Any], arrays: dict[str, Array]) -> SpaceRecord:
    """The record, if everything has its type and fits together."""
    options, motion = header["options"], None
    inputs = _texts(options["inputs"])
    if options["motion"] is not None:
        basis = _array(arrays.pop("motion"), (len(inputs), -1))
        motion = Motion(inputs, _texts(options["motion"]), basis)
    record = SpaceRecord(
        source=_a(str, header["source"]),
        sha256=None if header["sha256"] is None else _a(str, header["sha256"]),
        version=_a(str, header["version"]),
        balance=options["balance"],
        planar=not _a(bool, options["spatial"]),
        bodies=_texts(header["bodies"]),
        inputs=inputs,
        idle=_texts(header["idle"]),
        motion=motion,
        orders=tuple(Order(*(_a(int, n) for n in order)) for order in header["orders"]),
        serial_nullity=_a(int, header["serial_nullity"]),
        poses=_a(int, header["poses"]),
        settled=_a(bool, header["settled"]),
        length=_a(float, header["length"]),
        kept=_a(float, header["kept"]),
        dropped=_a(float, header["dropped"]),
        notices=tuple(Notice(*_texts(notice)) for notice in header["notices"]),
        **arrays,
    )
    shapes = _shapes(record)
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
        object.__setattr__(record, name, _array(arrays[name], shape))
    return record


def _a(kind: type, value: Any) -> Any:
    """The value, if it is of that type."""
    if type(value) is not kind:
        raise TypeError(kind.__name__)
    return value


def _texts(values: Any) -> tuple[str, ...]:
    """A list of texts as a tuple."""
    return tuple(_a(str, value) for value in _a(list, values))


def _array(array: Array, shape: tuple[int, ...]) -> Array:
    """A read-only copy, if the array holds finite numbers and has that shape (-1: any)."""
    fits = len(shape) == array.ndim and all(
        n in (m, -1) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype != np.float64 or not np.isfinite(array).all():
        raise ValueError("array")
    return frozen(array)
