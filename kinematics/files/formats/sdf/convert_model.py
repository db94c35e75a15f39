"""Convert an SDF file to the elements of a URDF file with loops, and say what was decided."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from kinematics.error_text import clean, closest_names, quoted
from kinematics.files.formats.sdf.expand_includes import expand_sdf_includes
from kinematics.files.formats.sdf.find_model import find_model, version_of
from kinematics.files.formats.sdf.flatten_models import flatten_models
from kinematics.files.formats.sdf.frames import WORLD, read_frames
from kinematics.files.formats.sdf.inertials import has_inertial, uses_defaults
from kinematics.files.formats.sdf.model_joints import LinkNames, ModelJoint, read_joint
from kinematics.files.formats.sdf.spanning_tree import choose_root, span_all
from kinematics.files.formats.sdf.tags import check_tags
from kinematics.files.formats.sdf.write_model import ModelWriter
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element


def convert_sdf(
    root: Element, wanted: str | None = None, path: str | None = None
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Convert an SDF file.

    The ground is the world, if joints fix the model to it, and else the link that the user
    names, the root of a tree, or the canonical link. Links that joints connect to one another
    and not to the ground float.

    Args:
        root: the ``<sdf>`` element.
        wanted: name of the link that is the ground; None for the default.
        path: the file, beside which included models are; None for a stream.

    Returns:
        The ``<robot>`` element, and code and message of each remark.

    Raises:
        Refusal: the file has something that cannot be converted.
    """
    version = version_of(root)
    model = flatten_models(find_model(expand_sdf_includes(root, path)))
    check_tags(model)
    frames, names = read_frames(model), LinkNames(model)
    if not names.links:
        raise Refusal(model.label, "no <link>", "give a model with links and joints")
    joints = [read_joint(item, names, frames, version) for item in model.every("joint")]
    pairs = [(joint.parent, joint.child) for joint in joints]
    ground = _choose_ground(names, pairs, wanted)
    tree, roots = span_all(list(names.links), pairs, ground)
    floating = [root for root in roots if any(root in pair for pair in pairs)]
    writer = ModelWriter(names.links, frames, joints, ground, tree, floating)
    attributes = {"name": model.name} if model.name else {}
    robot = Element("robot", attributes, writer.parts(model.line), model.line)
    moved = writer.moved_links()
    links = list(names.links.values())
    return robot, tuple(_remarks(links, joints, ground, moved, wanted is not None))


def _choose_ground(
    names: LinkNames, pairs: Sequence[tuple[str, str]], wanted: str | None
) -> str:
    """Choose the ground: the world, the wanted link, or the root or canonical link.

    Raises:
        Refusal: there is no such link, or the ground is the world.
    """
    world = any(WORLD in pair for pair in pairs)
    if wanted is None or wanted == WORLD:
        if world:
            return WORLD
        return choose_root(list(names.links), pairs, names.canonical)
    label = f"ground '{clean(wanted)}'"
    if wanted not in names.links:
        remedy = f"choose from {closest_names(wanted, names.links)}"
        raise Refusal(label, "there is no such link", remedy)
    if world:
        remedy = "leave --ground out, or remove the joints whose parent is world"
        raise Refusal(label, "joints fix the model to the world, which is the ground", remedy)
    return wanted


def _remarks(
    links: Sequence[Element], joints: Sequence[ModelJoint], ground: str, moved: Sequence[str],
    chosen: bool,
) -> Iterator[tuple[str, str]]:  # fmt: skip
    """Remarks on what the file leaves to its reader."""
    if ground != WORLD and not chosen:
        text = f"no joint fixes the model to the world: its link {quoted([ground])} is taken "
        yield "base_taken_as_fixed", f"{text}as the ground; --ground LINK takes another"
    still = _still_links(joints, ground)
    carrying = [link for link in links if link.name not in still]
    bare = [link.name for link in carrying if not has_inertial(link)]
    if bare:
        text = "links without <inertial> have no mass here, where Gazebo takes 1 kg and 1 kg m²"
        yield "no_inertial", f"{text}: {quoted(bare)}"
    filled = [link.name for link in carrying if has_inertial(link) and uses_defaults(link)]
    if filled:
        text = "masses of 1 kg or moments of 1 kg m², the defaults of SDF, are taken for what "
        yield "default_inertial", f"{text}the <inertial> leaves out: {quoted(filled)}"
    locked = [joint.name for joint in joints if joint.locked]
    if locked:
        text = "joints move here, though their limits are one position; write type fixed if "
        yield "locked_joints", f"{text}they are to be fixed: {quoted(locked)}"
    if moved:
        text = "link frames are those of the joints that carry the links, not those of the file"
        yield "link_frames", f"{text}: {quoted(moved)}"


def _still_links(joints: Sequence[ModelJoint], ground: str) -> set[str]:
    """Find the links that fixed joints connect to the ground."""
    pairs = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    beside: dict[str, list[str]] = {}
    for start, other in (*pairs, *((child, parent) for parent, child in pairs)):
        beside.setdefault(start, []).append(other)
    still, ready = {ground}, [ground]
    while ready:
        for link in beside.get(ready.pop(), ()):
            if link not in still:
                still.add(link)
                ready.append(link)
    return still
