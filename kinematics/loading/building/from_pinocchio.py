"""Build linkages from a Pinocchio model and its constraints.

Only attributes of the model are read: Pinocchio itself is not imported. It puts linear parts
first in motions and forces; the angular part is first here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kinematics.error_text import clean
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.loading.building.assemble_elements import assemble_elements, faults_of
from kinematics.loading.building.check_arguments import find_by_name
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element, unused_name
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import IDENTITY_POSE_ENTRY, PINOCCHIO_AXES_COSINE

if TYPE_CHECKING:
    import pinocchio


_NEEDED = ("joints", "names", "parents", "jointPlacements", "inertias", "frames")
# Types of the file for Pinocchio joints with several degrees of freedom.
_SEVERAL = {
    "JointModelSpherical": "spherical",
    "JointModelSphericalZYX": "spherical",
    "JointModelPlanar": "planar",
    "JointModelFreeFlyer": "floating",
}
_LOOPS = {"CONTACT_6D": "fixed", "CONTACT_3D": "spherical"}


class _Step(NamedTuple):
    """A joint of the file: type, origin (4, 4) in the frame before, axes, pitch and mimic."""

    kind: str
    at: Array
    axes: tuple[str, str] = ("", "")
    pitch: float = 0.0
    mimic: tuple[str, float, float] | None = None


def from_pinocchio(
    model: pinocchio.Model,
    constraints: Iterable[pinocchio.RigidConstraintModel] = (),
    inputs: Sequence[str] | None = None,
    *,
    fix_base: bool = False,
    bodies: str = "given",
) -> Linkage:
    """Build a linkage from a Pinocchio model.

    The reference pose is Pinocchio's neutral one, and the inertial frame that of the universe.
    A body is named after its first frame of type BODY that coincides with the frame of its
    joint, or after the joint if there is none; further such frames are links fixed to it.
    Limits, friction, gravity and rotor inertia are left out.

    Revolute, prismatic, helical, mimic, universal, spherical and planar joints keep their
    type. Composite joints and translations become chains of single joints ``name.0``,
    ``name.1`` … with massless links between them. Coordinates of a spherical joint are turns
    about its own axes, not Pinocchio's quaternion. A ``CONTACT_6D`` constraint becomes a weld
    of two frames, a ``CONTACT_3D`` constraint a spherical joint at their origins.

    Args:
        model: the model.
        constraints: the loops, each a ``RigidConstraintModel``.
        inputs: names of joints to use as independent coordinates; by default a
            well-conditioned set is chosen.
        fix_base: change a free flyer on the universe into a fixed joint.
        bodies: ``"given"``: links with mass or inertia carry parameters; ``"all"``: every
            moving link does.

    Returns:
        The linkage, as `kinematics.load` returns it for a file, with the rotation matrices of
        the model. All quantities are in the inertial frame, in SI units.

    Raises:
        FileError: a joint or a constraint is not supported; the message names it.
        LinkageError: as for `kinematics.load`.
        TypeError: ``model`` is not a Pinocchio model.

    Source:
        J. Carpentier et al., "The Pinocchio C++ library", 2019 (the model).

    Example:
        >>> import pinocchio
        >>> from kinematics import from_pinocchio
        >>> model = pinocchio.buildSampleModelManipulator()
        >>> from_pinocchio(model).mobility
        6
    """
    if not all(hasattr(model, name) for name in _NEEDED):
        raise TypeError(f"expected a pinocchio.Model, not {type(model).__name__}")
    source = f"{clean(model.name or 'model')} (built from a Pinocchio model)"
    with faults_of(source):
        robot = _Model(model).robot(constraints)
    return assemble_elements(
        robot, source, inputs, ReadOptions(fix_base=fix_base, bodies=bodies)
    )


class _Model:
    """A model and the links of each joint; the first link has the frame of the joint."""

    def __init__(self, model: Any) -> None:
        """Find the links: frames of type BODY, otherwise one named after the joint."""
        self.model = model
        self.links: list[list[tuple[str, Array]]] = [[] for _ in model.joints]
        for frame in model.frames:
            if frame.type.name == "BODY":
                self.links[frame.parentJoint].append((frame.name, _pose(frame.placement)))
        self.taken = {name for frames in self.links for name, _ in frames}
        for joint, frames in enumerate(self.links):
            frames.sort(key=lambda link: not _is_identity(link[1]))
            if not frames or not _is_identity(frames[0][1]):
                name = unused_name(model.names[joint], self.taken)
                frames.insert(0, (name, np.eye(4)))
        self.between: list[str] = []

    def robot(self, constraints: Iterable[Any]) -> Element:
        """Make the elements of the linkage, the base first."""
        model, links = self.model, []
        for frames, inertia in zip(self.links, model.inertias, strict=True):
            (first, _), *others = frames
            links.append(make_elements.link(first, _inertial(inertia)))
            links += [make_elements.link(name) for name, _ in others]
        joints = [each for i in range(1, len(model.joints)) for each in self._joints_of(i)]
        joints += self._fixed_joints()
        loops = [self._make_loop(k, each) for k, each in enumerate(constraints, 1)]
        links += [make_elements.link(name) for name in self.between]
        return make_elements.robot(model.name or "model", [*links, *joints, *loops])

    def _joints_of(self, index: int) -> Iterator[Element]:
        """Make the joints of the file that form a joint of the model."""
        model, name = self.model, self.model.names[index]
        steps = _steps(model, index)
        parent, at = self.links[model.parents[index]][0][0], _pose(model.jointPlacements[index])
        for k, step in enumerate(steps):
            title = name if len(steps) == 1 else f"{name}.{k}"
            child = self.links[index][0][0]
            if k < len(steps) - 1:
                child = unused_name(title, self.taken)
                self.between.append(child)
            origin = make_elements.origin(at @ step.at)
            yield make_elements.joint(title, step.kind, parent, child, origin, *step[2:])
            parent, at = child, np.eye(4)

    def _fixed_joints(self) -> Iterator[Element]:
        """Make the joints that fix further links of a body to its first."""
        titles = set(self.model.names)
        for (first, _), *others in self.links:
            for name, pose in others:
                title = unused_name(f"{name}_fixed", titles)
                origin = make_elements.origin(pose)
                yield make_elements.joint(title, "fixed", first, name, origin)

    def _make_loop(self, number: int, constraint: Any) -> Element:
        """Make the ``<loop>`` of a constraint."""
        label, loop_types = f"constraint {number}", " or ".join(_LOOPS)
        kind = _LOOPS.get(getattr(getattr(constraint, "type", None), "name", ""))
        if kind is None:
            problem = f"a {type(constraint).__name__} of no known type"
            raise Refusal(label, problem, f"give a RigidConstraintModel of type {loop_types}")
        if not _is_identity(_pose(constraint.desired_contact_placement)):
            problem = "its desired_contact_placement is not the identity"
            raise Refusal(label, problem, "put it into the placements of its joints")
        sides: list[tuple[str, Element | None]] = [
            (self.links[joint][0][0], make_elements.origin(_pose(placement)))
            for joint, placement in (
                (constraint.joint1_id, constraint.joint1_placement),
                (constraint.joint2_id, constraint.joint2_placement),
            )
        ]
        return make_elements.loop(constraint.name or f"loop{number}", kind, sides)


def _steps(model: Any, index: int) -> list[_Step]:
    """Convert a joint of the model to joints of the file, in series.

    Raises:
        Refusal: the file has no such joint.
    """
    label, joint = find_by_name("joint", model.names[index]), model.joints[index]
    if joint.shortname() != "JointModelMimic":
        return _convert_joint(label, joint, np.zeros(model.nq))
    mimic = joint.extract()
    if mimic.scaling == 0.0:
        problem = "a mimic joint whose ratio is 0"
        raise Refusal(label, problem, "fix it, or give it another ratio")
    at = model.mimicking_joints.tolist().index(index)
    source = model.names[model.mimicked_joints[at]]
    step = _single_step(_subspace(joint, np.zeros(model.nq)) / mimic.scaling)
    return [step._replace(mimic=(source, mimic.scaling, mimic.offset))]


def _convert_joint(label: str, joint: Any, q: Array) -> list[_Step]:
    """Convert a joint that is no mimic joint; ``q`` are zeros (nq of the model)."""
    kind, concrete = joint.shortname(), joint.extract() if hasattr(joint, "extract") else joint
    if kind in _SEVERAL:
        return [_Step(_SEVERAL[kind], np.eye(4), ("0 0 1", ""))]
    if kind == "JointModelTranslation":
        return [_Step("prismatic", np.eye(4), (number_words(axis), "")) for axis in np.eye(3)]
    if kind == "JointModelUniversal":
        axes = number_words(concrete.axis1), number_words(concrete.axis2)
        if abs(concrete.axis1 @ concrete.axis2) <= PINOCCHIO_AXES_COSINE:
            return [_Step("universal", np.eye(4), axes)]
        return [_Step("continuous", np.eye(4), (axis, "")) for axis in axes]
    if kind == "JointModelComposite":
        steps = []
        for part, placement in zip(concrete.joints, concrete.jointPlacements, strict=True):
            first, *others = _convert_joint(label, part, q)
            steps += [first._replace(at=_pose(placement) @ first.at), *others]
        return steps
    if joint.nv == 1:
        return [_single_step(_subspace(joint, q))]
    problem = f"a {clean(kind)}, for which there is no joint of the file"
    raise Refusal(label, problem, "replace it by joints that turn or slide")


def _subspace(joint: Any, q: Array) -> Array:
    """Compute the motion ``[v; ω]`` (6,) of a joint of one degree of freedom in its frame.

    It is the same at all positions ``q``.
    """
    data = joint.createData()
    joint.calc(data, q)
    return np.asarray(data.S, dtype=np.float64).reshape(6)


def _single_step(motion: Array) -> _Step:
    """Convert a motion ``[λ n; n]`` to a turning joint, or ``[n; 0]`` to a sliding one."""
    v, n = motion[:3], motion[3:]
    if not n.any():
        return _Step("prismatic", np.eye(4), (number_words(v), ""))
    return _Step("continuous", np.eye(4), (number_words(n), ""), pitch=float(v @ n))


def _pose(placement: Any) -> Array:
    """Convert a ``pinocchio.SE3`` to a pose (4, 4)."""
    return np.array(placement.homogeneous)


def _is_identity(pose: Array) -> bool:
    """Whether a pose (4, 4) is the identity."""
    return bool(np.abs(pose - np.eye(4)).max() <= IDENTITY_POSE_ENTRY)


def _inertial(inertia: Any) -> Element | None:
    """Make the ``<inertial>`` of a ``pinocchio.Inertia``; None if all of it is zero."""
    tensor, at = np.array(inertia.inertia), np.eye(4)
    if inertia.mass == 0.0 and not tensor.any():
        return None
    at[:3, 3] = inertia.lever
    return make_elements.inertial(float(inertia.mass), tensor, make_elements.origin(at))
