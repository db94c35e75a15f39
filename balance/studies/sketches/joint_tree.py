"""The joints of a sketch: a tree that grows from the base, and the joints that close loops."""

from __future__ import annotations

from collections.abc import Sequence

from balance.studies.sketches.sketch import Sketch
from balance.studies.sketches.sketched_linkage import BASE, SketchedJoint
from kinematics.errors import SynthesisError
from kinematics.model.document.element import unused_name


def plan_joints(sketch: Sketch) -> list[SketchedJoint]:
    """List the joints: those of the tree in the order of the links, then those of loops.

    From the base outwards, each link is joined to all others at its points.

    Raises:
        SynthesisError: a link is not connected to the base.
    """
    reached, done, joints = [BASE], set[str](), list[SketchedJoint]()
    carried = {BASE: sketch.base, **sketch.links}
    taken = set[str]()
    # Links that are reached are appended, and have their turn.
    for body in reached:
        for point in carried[body]:
            others = [name for name in carried if name != body and point in carried[name]]
            for other in () if point in done else others:
                label = point if len(others) == 1 else f"{point}_{other}"
                name, closes = unused_name(label, taken), other in reached
                joints.append(SketchedJoint(name, "revolute", body, other, point, closes))
                reached += [] if closes else [other]
            done.add(point)
        for slider in sketch.sliders if body == BASE else ():
            name = unused_name(f"{slider}_slide", taken)
            point = carried[slider][0]
            joints.append(SketchedJoint(name, "prismatic", BASE, slider, point))
            reached.append(slider)
    for link in carried:
        if link not in reached:
            problem = f"link '{link}' hangs on nothing: no links lead from it to the base"
            remedy = "let it share a point with another link, or name its points in base=…"
            raise SynthesisError(problem, remedy)
    order = list(carried)
    return sorted(joints, key=lambda joint: (joint.closes_loop, order.index(joint.child)))


def place_frames(sketch: Sketch, joints: Sequence[SketchedJoint]) -> dict[str, complex]:
    """Place the frame of each link at the joint that carries it; metres."""
    carried = {j.child: sketch.places[j.point] for j in joints if not j.closes_loop}
    return {BASE: 0j, **carried}
