"""The motion of a synthesised mechanism through its positions, to play on its page."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import COLOURS
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.trajectory import drive
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from kinematics.closure.joint_positions import si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.chain import rigid_parts
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Links that carry the tool, in the files of the kinds.
TOOLS = {"pantograph": "link2", "stack": "coupler_3"}
COUPLER = "coupler"
# Samples of the motion, and most of a table.
SAMPLES = 121


class _MechanismMotion(NamedTuple):
    """A motion of a mechanism.

    Attributes:
        linkage: the linkage of its file.
        time: seconds (N,).
        u: displacements of its inputs (N, mobility), radians.
        q: positions of all joints (N, n).
    """

    linkage: Linkage
    time: Array
    u: Array
    q: Array


def mechanism_motion(synthesis: Synthesis) -> dict[str, Any] | None:
    """Collect what the page moves: the best mechanism, from position to position.

    Returns:
        ``scene``, ``tool`` and ``runs``, as for the page of a Taylor motion, and ``at``, the
        sample at which the tool is nearest to each position; None if there is no mechanism, or
        if it does not go from position to position.
    """
    if not synthesis.mechanisms:
        return None
    best = synthesis.mechanisms[0]
    try:
        motion = _move_mechanism(best)
    except LinkageError:
        return None
    linkage = motion.linkage
    body = next(body for body in linkage.bodies if body.name == TOOLS.get(best.kind, COUPLER))
    chain = si_chain(linkage, spatial=True)
    H = np.array([forward_kinematics(chain, q).H[body.link] for q in motion.q])
    first = synthesis.positions[0].point
    start = H[0, :3, :3].T @ ([first.real, first.imag, 0.0] - H[0, :3, 3])
    ways = (H[:, :2, :3] @ start) + H[:, :2, 3]
    goals = np.array([[each.point.real, each.point.imag] for each in synthesis.positions])
    at = np.linalg.norm(ways[:, None] - goals, axis=2).argmin(axis=0)
    part = rigid_parts(chain.parent.size, chain.ends)
    run = {
        "label": "the motion through the positions",
        "x": short(motion.time),
        "q": [short(q) for q in motion.q],
        "chart": _chart(motion, at.tolist()),
    }
    name = "the tip of the rocker" if synthesis.function else "the tool"
    tool = {"name": name, "part": int(part[body.link]), "point": start.tolist()}
    return {"scene": scene(linkage), "tool": tool, "runs": [run], "at": at.tolist()}


def _move_mechanism(mechanism: SynthesizedMechanism) -> _MechanismMotion:
    """Compute the motion of the file of a mechanism, from its first position to the last."""
    linkage = load(Document("the synthesised mechanism", mechanism.urdf))
    table = mechanism.table
    if table is not None:
        picked = np.linspace(0, len(table.time) - 1, SAMPLES).round().astype(int)
        rows = (values[picked] for values in (table.time, table.u, table.ud, table.udd))
        moved = drive(linkage, *rows)
    else:
        start = np.array([mechanism.first_position.get(name, 0.0) for name in linkage.inputs])
        poses = start + np.array(mechanism.link_turns)[:, None] * np.eye(len(start))[0]
        moved = rest_to_rest(linkage, poses, samples=SAMPLES)
    return _MechanismMotion(linkage, moved.time, moved.u, moved.q)


def _chart(motion: _MechanismMotion, at: list[int]) -> dict[str, Any]:
    """Build the curves of the inputs over time, with a line at each position."""
    traces = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "x": short(motion.time),
            "y": short(motion.u[:, k]),
            "line": {"color": COLOURS[k], "width": 1.8},
        }
        for k, name in enumerate(motion.linkage.inputs)
    ]
    layout = {
        "hovermode": "x",
        "showlegend": True,
        "xaxis": {"title": {"text": "time (s)"}},
        "yaxis": {"title": {"text": "inputs (rad)"}},
        "shapes": [
            {
                "type": "line",
                "x0": float(motion.time[k]),
                "x1": float(motion.time[k]),
                "line": {"color": "#5a626b", "width": 1, "dash": "dash"},
            }
            for k in at
        ],
    }
    return {"data": traces, "layout": layout}
