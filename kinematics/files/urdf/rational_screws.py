"""The joint screws of a file as rational numbers, from its decimals.

Directions keep the length that they have in the file, for a unit vector is rarely rational.
Other irrational numbers are replaced, and a notice names them; see
`kinematics.files.urdf.rational_joints`.

Programs write a robot with threefold symmetry in a frame that is turned at random: then no
number is a root. In the frame of two of its axes they are, but for round-off. A displacement of
the whole linkage changes no rank.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import islice
from typing import NamedTuple, TypeVar

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import ExactError
from kinematics.files.urdf.closed_forms import NumberVector, NumberWord, read_closed_forms
from kinematics.files.urdf.rational_joints import RationalJoints
from kinematics.files.urdf.rational_poses import equate_sizes, move_screws
from kinematics.files.urdf.read_roots import FileRoots, has_many_digits, read_roots
from kinematics.model.chain import extent
from kinematics.model.full_turns import position_text
from kinematics.model.linkage import Joint, Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.cyclotomic import degree_of_field
from kinematics.numerics.linalg.rational import BITS, Vector, cross, dot
from kinematics.numerics.tolerances import EXACT_SCREW_DIFFERENCE

T = TypeVar("T")

# Largest change of a replaced number: radians, and parts of a length. It is far above any
# tolerance, so that a rank that rests on such a number changes with it.
CHANGE = Fraction(1, 64)
# Most pairs of axes whose frames are tried, and the least sine of the angle between two.
MAX_FRAMES, LEAST_SINE = 4, 0.1
# Errors of directions, and of places in parts of the size: products of a dozen rotations.
ROUND_OFF = 2.0**-49
# Most joints.
MAX_JOINTS = 200


class Geometry(NamedTuple):
    """Joints of a linkage in rational numbers, at its reference pose.

    Attributes:
        screws: ``[n; r × n + λ n]``, or ``[0; n]`` if prismatic, of each joint, with n of
            any length; (6,) each, inertial frame, SI units.
        squares: squared length of each n. A rate of the screw is that of the joint over
            the length.
        ratios: ratio of each mimic joint, in the units of its joint over those of its source.
        notices: replaced numbers and rounded roots (``not_exact``), numbers that are read as
            roots (``read_as_root``), loops that their decimals leave open
            (``open_in_decimals``), and axes whose length is nearly 1 (``as_written``).
    """

    screws: tuple[Vector, ...]
    squares: tuple[Fraction, ...]
    ratios: tuple[Fraction, ...]
    notices: tuple[Notice, ...]


def exact_geometry(linkage: Linkage, roots: FileRoots | None = None) -> Geometry:
    """Compute the joint screws of a linkage as rational numbers, from the decimals of its file.

    Where the loops of the file are open at its own pose, the joints move to rational positions
    next to those of the reference pose. Loops are closed there at their predecessors, so the
    links differ from those of the file by round-off.

    Args:
        linkage: a linkage that was read from a file.
        roots: numbers of the file that are read as roots, sines and cosines, in place of their
            decimals.

    Returns:
        Screws, squared lengths, mimic ratios and notices.

    Raises:
        ExactError: the linkage was not read from a file, or its axes are not those of the
            file.
    """
    source = clean(linkage.source, 1000)
    if linkage.tree is None:
        raise ExactError(
            f"{source}: exact arithmetic works from the decimals of a URDF file; load one"
        )
    rational = RationalJoints(linkage.tree, linkage.displaced is None, roots=roots)
    joints = [rational.joints.get(joint.name) for joint in linkage.joints]
    screws = tuple(joint[1] for joint in joints if joint)
    if linkage.displaced is not None and len(screws) == len(joints):
        screws = move_screws(linkage.joints, screws, equate_sizes(linkage.displaced.tolist()))
        rational.notices += _position_notices(linkage)
    if len(screws) < len(joints) or not _is_reference_pose(linkage, screws):
        raise ExactError(
            f"{source}: exact arithmetic needs the axes that are in the file: these were moved "
            "to close its loops; write axes that let them close"
        )
    ratios = tuple(
        rational.mimics[linkage.joints[mimic.joint].name][1] for mimic in linkage.mimics
    )
    squares = tuple(dot(n, n) for n in (_direction(screw) for screw in screws))
    return Geometry(screws, squares, ratios, tuple(rational.notices))


def _rational_geometries(linkage: Linkage) -> Iterator[Geometry]:
    """Yield the joint screws of a linkage in rational numbers, the first choice first.

    Where relations are meant that the digits of the file round, the geometry that has them
    exactly is the only choice. Otherwise it is that of the decimals of the file, and then one
    inside the intervals of its digits, whose axes are exactly parallel, or exactly meet; the
    latter comes first if axes coincide that do not in decimals. If the links have relations in
    decimals, and the pose rounds them, the geometry of lower rank is meant.

    Yields:
        Geometries, computed when they are asked for.

    Raises:
        ExactError: there is none.
    """
    meant = linkage.meant
    if meant is None or not _is_reference_pose(linkage, meant.screws):
        yield exact_geometry(linkage)
        return
    geometries = [geometry_of(linkage, meant.screws)]
    if meant.in_decimals:
        with suppress(ExactError):
            written = exact_geometry(linkage)
            first = linkage.as_written or _lines_coincide(written.screws, meant.screws)
            geometries.insert(0 if first else 1, written)
    yield from geometries


def _lines_coincide(screws: Sequence[Vector], meant: Sequence[Vector]) -> bool:
    """Whether the axes of joints coincide that coincide in another geometry."""
    joints_on: dict[Vector, int] = {}
    firsts = [joints_on.setdefault(_scaled_line(screw), j) for j, screw in enumerate(meant)]
    return all(
        _scaled_line(screws[j]) == _scaled_line(screws[first]) for j, first in enumerate(firsts)
    )


def _scaled_line(screw: Vector) -> Vector:
    """Scale a screw so that its first component that is not zero is one."""
    scale = next(x for x in screw if x)
    return tuple(x / scale for x in screw)


def of_lowest_rank(
    linkage: Linkage,
    compute: Callable[[Geometry], T],
    rank: Callable[[T], tuple[int, ...]],
    confirms: Callable[[T], bool],
) -> T:
    """Compute something with the geometry that a linkage means; see `_rational_geometries`.

    Where that does not confirm what floating point finds, numbers of the file are read as
    roots; see `kinematics.files.urdf.read_roots`.

    Args:
        compute: computes it from a geometry; may raise an `ExactError`.
        rank: rank of the conditions that it has, and ranks by order.
        confirms: whether it has the integers that floating point finds.

    Raises:
        ExactError: no geometry serves; the error of the first.
    """
    meant, answers = linkage.meant, list[T]()
    first: ExactError | None = None
    for geometry in _rational_geometries(linkage):
        try:
            answers.append(compute(geometry))
        except ExactError as error:
            if linkage.as_written:  # axes that are moved by round-off are those of another
                raise
            first = first or error
        single = meant is None or not (meant.relations or linkage.displaced is not None)
        if answers and single:
            break
    if not any(map(confirms, answers)):
        with suppress(ExactError):
            answers += [compute(geometry) for geometry in _geometries_of_roots(linkage)]
    if not any(map(confirms, answers)):
        # Other frames have other transfers: only integers that are confirmed serve.
        with suppress(ExactError):
            turned = map(compute, _turned_geometries(linkage))
            answers += islice(filter(confirms, turned), 1)
    if answers:
        return min(answers, key=rank)
    assert first is not None
    raise first


def _geometries_of_roots(linkage: Linkage) -> Iterator[Geometry]:
    """Yield the geometry whose numbers are roots, if there is one and it is wanted."""
    if linkage.tree is not None and not linkage.as_written:
        roots = read_roots(linkage.tree)
        if roots is not None:
            yield exact_geometry(linkage, roots)


def _turned_geometries(linkage: Linkage) -> Iterator[Geometry]:
    """Yield geometries in turned frames whose numbers are roots, if they are wanted."""
    if linkage.tree is None or linkage.as_written or not has_many_digits(linkage.tree):
        return
    for screws, count in _turned_screws(linkage):
        text = "a number in the frame of two axes is read as a root, sine or cosine"
        notices = (Notice("read_as_root", text),) * count
        yield geometry_of(linkage, screws)._replace(notices=notices)


def geometry_of(linkage: Linkage, screws: tuple[Vector, ...]) -> Geometry:
    """Make the geometry of other screws of the joints of a linkage.

    Args:
        screws: screws (n, 6) of any length, inertial frame, SI units.
    """
    squares = tuple(dot(n, n) for n in map(_direction, screws))
    ratios = tuple(Fraction(repr(float(mimic.ratio))) for mimic in linkage.mimics)
    return Geometry(screws, squares, ratios, ())


def change_replaced_numbers(linkage: Linkage) -> tuple[Vector, ...]:
    """Compute the joint screws with changed values of all numbers that were replaced.

    `exact_geometry` replaces irrational numbers. Equal ones change equally, and opposite ones
    oppositely; no other relation is kept.

    Args:
        linkage: a linkage that `exact_geometry` accepts.

    Returns:
        Screws of any length, (6,) each, in the inertial frame, SI units.
    """
    assert linkage.tree is not None
    length, positions = Fraction(linkage.chain.frame.length), linkage.displaced
    rational = RationalJoints(linkage.tree, positions is None, CHANGE, length)
    screws = tuple(rational.joints[joint.name][1] for joint in linkage.joints)
    if positions is None:
        return screws
    sizes = [length if joint.kind == "prismatic" else Fraction(1) for joint in linkage.joints]
    moved = [
        float(rational.change_number(Fraction(q), size)) if q else 0.0
        for q, size in zip(equate_sizes(positions.tolist()), sizes, strict=True)
    ]
    return move_screws(linkage.joints, screws, moved)


def _position_notices(linkage: Linkage) -> Iterator[Notice]:
    """Notices of the joints whose positions at the reference pose are rounded to fractions."""
    assert linkage.displaced is not None
    how = "closed" if linkage.at is None else "placed"
    carriers = {joint.parent for joint in linkage.joints}
    for j, (joint, q) in enumerate(zip(linkage.joints, linkage.displaced, strict=True)):
        if q and j in carriers:
            text = (
                f"joint '{joint.name}': {how} by Newton's method at "
                f"{position_text(joint, q, 6)} "
                f"from the pose of the file: taken within 2^-{BITS} of it; so are link lengths"
            )
            yield Notice("not_exact", text)


def _is_reference_pose(linkage: Linkage, screws: tuple[Vector, ...]) -> bool:
    """Whether the screws are those of the reference pose of the linkage."""
    reference = np.array([joint.screw for joint in linkage.joints])
    floats = np.array([[float(x) for x in screw] for screw in screws])
    if floats.shape != reference.shape:
        return False  # the joints of a base that moves were added to those of the file
    lengths = [float(dot(n, n)) ** 0.5 for n in map(_direction, screws)]
    difference = np.abs(floats / np.reshape(lengths, (-1, 1)) - reference)
    return bool(difference.max() <= EXACT_SCREW_DIFFERENCE * max(1.0, np.abs(reference).max()))


def _direction(screw: Vector) -> Vector:
    """Extract the part n of a screw."""
    return screw[:3] if any(screw[:3]) else screw[3:]


def _turned_screws(linkage: Linkage) -> Iterator[tuple[tuple[Vector, ...], int]]:
    """Yield the screws of a linkage in frames of two of its axes, read as roots.

    Args:
        linkage: an assembled linkage without screw joints.

    Yields:
        Screws ``[n; r × n]`` or ``[0; n]`` (n, 6) in one field, in that frame, and how many
        numbers were read.
    """
    joints = linkage.joints
    if len(joints) > MAX_JOINTS or any(joint.kind == "helical" for joint in joints):
        return
    size = max(extent(linkage).length, 1e-300)
    for R in islice(_frames([joint.direction for joint in joints]), MAX_FRAMES):
        vectors = []
        for j, joint in enumerate(joints):
            place = R @ (joint.point - joints[0].point)
            vectors.append(_make_vector((j, "n"), R @ joint.direction, ROUND_OFF))
            vectors.append(_make_vector((j, "p"), place, ROUND_OFF * size))
        forms = read_closed_forms(vectors)
        if degree_of_field(forms.conductor) == 1:
            continue
        read = {
            vector.key: tuple(
                forms.numbers.get((vector.key, k), x) for k, x in enumerate(vector.values)
            )
            for vector in vectors
        }
        yield (
            tuple(_make_screw(x, read[j, "n"], read[j, "p"]) for j, x in enumerate(joints)),
            len(forms.numbers),
        )


def _frames(axes: list[Array]) -> Iterator[Array]:
    """Yield rotations to frames with x along one axis and z across it and another."""
    first = axes[0]
    seen: list[Array] = []
    for other in axes[1:]:
        z = np.cross(first, other)
        sine = float(np.linalg.norm(z))
        if sine < LEAST_SINE:
            continue
        z /= sine
        if any(abs(float(z @ normal)) > 1.0 - ROUND_OFF * 8 for normal in seen):
            continue
        seen.append(z)
        yield np.array([first, np.cross(z, first), z])


def _make_vector(key: tuple[int, str], values: Array, error: float) -> NumberVector:
    """Make a vector of numbers that may each be off by an error."""
    numbers = tuple(Fraction(float(x)) for x in values)
    width = Fraction(error)
    words = tuple(NumberWord((key, k), x, width, width) for k, x in enumerate(numbers))
    return NumberVector(key, numbers, words)


def _make_screw(joint: Joint, n: Vector, point: Vector) -> Vector:
    """Make the screw of a joint from its direction and a point."""
    return (Fraction(0),) * 3 + n if joint.kind == "prismatic" else n + cross(point, n)
