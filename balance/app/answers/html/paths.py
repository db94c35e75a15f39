"""Page and picture of reactionless paths: the linkage on them, and what it shakes.

The shade of a pose is the smallest singular value of the momentum matrix over the momenta of
the bodies, of those that do not vanish everywhere: it vanishes where further paths meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.text.paths import path_rows, paths_facts
from balance.motion.motion_tolerances import CONDITIONING_NOTICE
from balance.motion.paths.inertia_ratios import InertiaChart
from balance.motion.paths.path import ReactionlessPath, timed_path
from balance.motion.paths.reactionless_paths import ReactionlessPaths
from balance.motion.paths.tool_paths import ToolPaths
from balance.motion.pose.workspace_map import momentum_map
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    mass_parameters,
    wrench_to_si,
)
from balance.motion.verification.trajectory import Trajectory
from kinematics.closure.joint_positions import input_chain, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import PoseError
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import count_noun, number_text

# Frames of a run, most paths on a page, and colours of paths.
FRAMES = 61
MAX_PATHS = 12
COLOURS = ("#1f5a94", "#c05a10", "#3d7a3d", "#7a3d7a", "#8a6d1a", "#1b1e22")
# Poses along each input, and every which of them has a stroke.
POSES = 61
APART = 3
# Part of the largest motion of an input below which another one rests.
RESTS = 1e-3
# Half of the width of an axis, at least, of the largest motion of an input.
NARROWEST = 0.05
ARC_LENGTH = "arc length (radians and characteristic lengths)"
LOADS = ("force", "moment", "own force", "own moment")
# Half of a stroke over the width of the workspace of a tool.
STROKE = 0.012
# Half of the width if there are no paths, radians and characteristic lengths.
HALF_WIDTH = 0.5


def paths_page(solution: ReactionlessPaths) -> str:
    """Render reactionless paths as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `ReactionlessPaths.to_dict`.
    """
    field = momentum_field(solution)
    return render_page(
        "paths.html",
        title=solution.linkage.name,
        summary=_summary(solution),
        report=solution.to_dict(),
        data={"run": _run_data(solution, field)},
        scripts=("path_run",),
        facts=facts_list(paths_facts(solution)),
        caption=escape(_caption(solution, field is not None)),
        tool="" if solution.tool is None else _tool_figure(solution.tool),
        paths=rows_table(path_rows(solution), [3, 4, *[5] * (solution.tool is not None)]),
    )


def _summary(solution: ReactionlessPaths) -> str:
    """Say whether there is a path, what rests on it, and how long the longest one is."""
    demand = solution.demand.words
    if not solution.paths:
        return f"No path with {demand}: {solution.reason}."
    longest = max(path.length for path in solution.paths)
    unit = "radians and characteristic lengths, in all joints"
    count = count_noun(len(solution.paths), "path")
    return f"{count} with {demand}, up to {number_text(longest, '.3g')} long ({unit})."


def _caption(solution: ReactionlessPaths, shaded: bool) -> str:
    """Describe the figure of the run."""
    last = "its last joint" if solution.tool is None else solution.tool.link
    text = f"Left: the linkage, seen along the last of its axes, and the way of {last}. "
    right = f"the paths in the plane of {' and '.join(solution.linkage.inputs)}"
    if len(solution.linkage.inputs) == 1:
        right = f"{solution.linkage.inputs[0]} along the path"
    elif not shaded:
        right = "the paths in the plane of the two inputs that move most on the chosen one, or "
        right += "the input that moves along its length"
    text += f"Right: {right}"
    if not solution.paths:
        text = "There is no path. The plane of the inputs around the pose" * shaded
    field = (
        "; strokes are the directions with the least momentum, and the shade is the smallest "
        "singular value of the momentum matrix over the bodies' own momenta, of those that do "
        "not vanish everywhere (scale on the right): 0 means that there is a path"
    )
    return f"{text}{field * shaded}."


def _run_data(solution: ReactionlessPaths, field: _MomentumField | None) -> dict[str, Any]:
    """Compute all that the script draws."""
    linkage = solution.linkage
    shown = None if solution.tool is None else _tool_data(linkage, solution.tool)
    ways = [None] * len(solution.paths) if solution.tool is None else solution.tool.ways
    paths = [
        _path_data(linkage, field, k, path, way)
        for k, (path, way) in enumerate(zip(solution.paths[:MAX_PATHS], ways, strict=False), 1)
    ]
    points = np.array([p for path in paths for f in path["frames"] for part in f for p in part])
    box = [[-1.0, 1.0]] * 2
    if len(points):
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.08 * float((high - low).max() or 1.0)
        box = np.column_stack([low - margin, high + margin]).tolist()
    return {
        "paths": paths,
        "inputs": _labels(linkage),
        "box": box,
        "axes": ["x (m)", "y (m)"],
        "field": None if field is None else field.to_dict(),
        "tool": shown,
    }


def _tool_figure(tool: ToolPaths) -> str:
    """Render the place of the figure of a tool, and its caption."""
    strokes = "; strokes: ways of the least momentum" * bool(len(tool.strokes))
    return (
        f"<figure>\n<h2>Where {escape(tool.link)} gets</h2>\n"
        '<div id="tool" class="traces square" role="img" aria-label="Ways of the tool in its '
        'workspace"></div>\n<figcaption><b>Figure 3.</b> Ways of the tool along the paths, in '
        f"its complete workspace (dots, at poses on a grid of the inputs){strokes}."
        "</figcaption>\n</figure>"
    )


def _in_plane(linkage: Linkage, points: Array) -> Array:
    """Compute coordinates of points (…, 3) in the plane of the drawing (…, 2)."""
    return np.asarray(points @ linkage.chain.frame.R[:2].T)


def _stroke_lines(linkage: Linkage, tool: ToolPaths) -> Array:
    """Compute points (N, 2) of strokes of a tool, apart by NaN."""
    at, way = (_in_plane(linkage, tool.strokes[:, k]) for k in range(2))
    seen = _in_plane(linkage, tool.workspace)
    half = STROKE * float(np.ptp(seen, axis=0).max()) * way if len(seen) else way
    ends = np.stack([at - half, at + half, np.full_like(at, np.nan)], axis=1)
    return ends.reshape(-1, 2)


def _tool_data(linkage: Linkage, tool: ToolPaths) -> dict[str, Any]:
    """Compute what the script draws of a tool: workspace, strokes, and all ways."""
    parts = [_in_plane(linkage, tool.workspace), _stroke_lines(linkage, tool)]
    ways = [_in_plane(linkage, way) for way in tool.ways]
    drawn = [{"x": short(points[:, 0]), "y": short(points[:, 1])} for points in (*parts, *ways)]
    return {"workspace": drawn[0], "strokes": drawn[1], "ways": drawn[2:]}


def _path_data(
    linkage: Linkage,
    field: _MomentumField | None,
    number: int,
    path: ReactionlessPath,
    way: Array | None,
) -> dict[str, Any]:
    """Compute frames, inputs and loads of one path.

    Args:
        way: positions of the tool along it (N, 3); None for those of the last joint.
    """
    try:
        along = timed_path(linkage, path)
    except PoseError:
        along = None
    picked = np.linspace(0, len(path.s) - 1, FRAMES).round().astype(int)
    q, u, time = path.q[picked], path.u[picked], np.linspace(0.0, 1.0, FRAMES)
    loads: dict[str, list[float | None]] = dict.fromkeys(LOADS, [])
    if along is not None:
        picked = np.linspace(0, len(along.time) - 1, FRAMES).round().astype(int)
        q, u, time = along.q[picked], along.u[picked], along.time[picked]
        loads = _loads(linkage, along, picked)
    frames = _frames(linkage, q)
    last = np.array([[p for part in frame for p in part][-1] for frame in frames])
    nearest = np.linalg.norm(q[:, None] - path.q, axis=2).argmin(axis=1)
    if way is not None:
        last = _in_plane(linkage, way[nearest])
    plane = _plane(linkage, [path], field)
    return {
        "label": f"{number}: {path.length:.3g} long, momentum {path.residual_text}",
        "frames": frames,
        "trace": {"x": short(last[:, 0]), "y": short(last[:, 1])},
        "u": [*map(short, u.T), short(path.s[nearest])],
        "plane": plane._asdict(),
        "time": short(time),
        "loads": loads,
        "straight": _straight_loads(linkage, path),
    }


def _straight_loads(
    linkage: Linkage, path: ReactionlessPath
) -> dict[str, list[float | None]] | None:
    """Compute the loads on a straight line between the ends; None if it cannot be followed."""
    try:
        straight = rest_to_rest(linkage, path.u[[0, -1]], samples=FRAMES)
    except PoseError:
        return None
    if straight.conditioning < CONDITIONING_NOTICE:
        return None
    return _loads(linkage, straight, np.arange(FRAMES))


def _loads(
    linkage: Linkage, along: Trajectory, picked: NDArray[np.int64]
) -> dict[str, list[float | None]]:
    """Compute sizes of shaking force and moment at samples of a motion.

    Those of ``own`` are the sums of the sizes of the bodies: what would shake if nothing
    cancelled.
    """
    chain = input_chain(linkage)
    scale = chain.units[linkage.positions_of(linkage.inputs)]
    loads = inertia_loads(
        chain,
        mass_parameters(linkage),
        along.q[picked] / chain.units,
        along.ud[picked] / scale,
        along.udd[picked] / scale,
    )
    bodies = wrench_to_si(loads.rate, chain.frame)
    forces = bodies[..., 3:]
    moments = bodies[..., :3] - np.cross(chain.frame.origin, forces)
    sums = [np.linalg.norm(part.sum(axis=1), axis=1) for part in (forces, moments)]
    scales = [np.linalg.norm(part, axis=2).sum(axis=1) for part in (forces, moments)]
    return dict(zip(LOADS, map(short, (*sums, *scales)), strict=True))


def _frames(linkage: Linkage, q: Array) -> list[list[list[list[float]]]]:
    """Compute the points of all moving parts, in the plane of the drawing, at each pose."""
    chain = si_chain(linkage, spatial=True)
    part = rigid_parts(chain.parent.size, chain.ends)
    points = np.array([[*joint.point, 1.0] for joint in linkage.joints])
    axes = linkage.chain.frame.R[:2]
    touching = []
    for p in range(1, int(part.max()) + 1):
        joints = np.flatnonzero((part[chain.parent] == p) | (part[:-1] == p))
        touching.append((int(np.flatnonzero(part[:-1] == p)[0]), points[joints]))
    frames = []
    for pose in q:
        H = forward_kinematics(chain, pose).H
        frames.append(
            [(at @ H[link].T[:, :3] @ axes.T).round(6).tolist() for link, at in touching]
        )
    return frames


def paths_picture(solution: ReactionlessPaths, kind: str = "png") -> bytes:
    """Draw the paths in the plane of the first two inputs, and the momentum along them."""
    width = 9.6 if solution.tool is None else 14.4
    return image((width, 4.2), kind, partial(_draw, solution))


def _draw(solution: ReactionlessPaths, figure: Any) -> None:
    """Draw both panels on a Matplotlib figure."""
    plane, along, *others = figure.subplots(1, 2 if solution.tool is None else 3)
    field = momentum_field(solution)
    if field is not None:
        size = field.size.T
        shade = plane.pcolormesh(field.first, field.second, size, cmap="Blues_r", vmin=0.0)
        figure.colorbar(shade, ax=plane, label="smallest singular value over the own momenta")
        plane.plot(*field.strokes.T, color="#5d6a76", linewidth=0.6)
    labels = _labels(solution.linkage)
    if solution.paths or field is not None:
        shown = _plane(solution.linkage, solution.paths, field)
        plane.set(xlim=shown.ranges[0], ylim=shown.ranges[1])
        plane.set(xlabel=labels[shown.axes[0]], ylabel=labels[shown.axes[1]])
    for k, path in enumerate(solution.paths):
        colour = COLOURS[k % len(COLOURS)]
        values = np.column_stack([path.u, path.s])
        drawn = values[:, shown.axes[0]], values[:, shown.axes[1]]
        plane.plot(*drawn, color=colour, linewidth=1.8)
        along.plot(
            path.s,
            np.maximum(path.momentum, 1e-18),
            color=colour,
            linewidth=1.2,
            label=f"path {k + 1}",
        )
    plane.set_title(f"{solution.linkage.name}: paths in the inputs", loc="left", fontsize=9)
    along.set_yscale("log")
    along.set_xlabel("arc length (radians and characteristic lengths)")
    along.set_title("momentum over the bodies' own", loc="left", fontsize=9)
    if solution.paths:
        along.legend(frameon=False, fontsize=8)
    for ax in others:
        _draw_tool(solution, ax)
    for ax in (plane, along, *others):
        tidy(ax)


def _draw_tool(solution: ReactionlessPaths, ax: Any) -> None:
    """Draw the ways of the tool in its complete workspace."""
    linkage, tool = solution.linkage, solution.tool
    assert tool is not None
    seen = _in_plane(linkage, tool.workspace)
    ax.plot(*seen.T, ".", color="#d3dae0", markersize=2.0, label="complete workspace")
    ax.plot(*_stroke_lines(linkage, tool).T, color="#5d6a76", linewidth=0.6)
    for k, way in enumerate(tool.ways):
        points = _in_plane(linkage, way)
        ax.plot(*points.T, color=COLOURS[k % len(COLOURS)], linewidth=1.8)
    ax.set_aspect("equal")
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_title(f"ways of {tool.link}", loc="left", fontsize=9)


def chart_picture(chart: InertiaChart, kind: str = "png") -> bytes:
    """Draw the paths of a chart, a colour for each factor: of the tool, or in two inputs."""
    return image((6.4, 4.8), kind, partial(_draw_chart, chart))


def _draw_chart(chart: InertiaChart, figure: Any) -> None:
    """Draw a chart on a Matplotlib figure."""
    ax = figure.subplots()
    linkage = chart.solutions[0].linkage
    paths = [path for solution in chart.solutions for path in solution.paths]
    shown = _plane(linkage, paths, None) if paths else None
    labels = _labels(linkage)
    for k, (factor, solution) in enumerate(zip(chart.factors, chart.solutions, strict=True)):
        label: str | None = f"{number_text(factor)} of the inertia of {chart.link}"
        for j, path in enumerate(solution.paths):
            if solution.tool is not None:
                points = _in_plane(linkage, solution.tool.ways[j])
                axes = "x (m)", "y (m)"
            else:
                assert shown is not None
                points = np.column_stack([path.u, path.s])[:, list(shown.axes)]
                axes = labels[shown.axes[0]], labels[shown.axes[1]]
            ax.plot(*points.T, color=COLOURS[k % len(COLOURS)], linewidth=1.8, label=label)
            ax.set(xlabel=axes[0], ylabel=axes[1])
            label = None
    ax.set_title(f"{linkage.name}: paths over ratios of inertia", loc="left", fontsize=9)
    if paths:
        ax.legend(frameon=False, fontsize=8)
    tidy(ax)


class _Plane(NamedTuple):
    """The plane in which paths are drawn.

    Attributes:
        axes: indices of the inputs along both axes; that of the arc length is the number of
            inputs.
        ranges: of both axes, rad, m, or radians and characteristic lengths.
    """

    axes: tuple[int, int]
    ranges: tuple[tuple[float, float], tuple[float, float]]


def _labels(linkage: Linkage) -> list[str]:
    """Name what may be an axis: the inputs, and the arc length."""
    kinds = {joint.name: joint.kind for joint in linkage.joints}
    units = ("m" if kinds[name] == "prismatic" else "rad" for name in linkage.inputs)
    named = zip(linkage.inputs, units, strict=True)
    return [*(f"{name} ({unit})" for name, unit in named), ARC_LENGTH]


def _plane(
    linkage: Linkage, paths: Sequence[ReactionlessPath], field: _MomentumField | None
) -> _Plane:
    """Choose the plane of paths: that of the field, or of the two inputs that move most.

    An input that rests is no axis; if one moves alone, it is drawn over the arc length.
    """
    if field is not None:
        across, along = ((float(axis[0]), float(axis[-1])) for axis in field[:2])
        return _Plane((0, 1), (across, along))
    units = input_chain(linkage).units[linkage.positions_of(linkage.inputs)]
    u = np.concatenate([path.u for path in paths])
    low, high = u.min(axis=0), u.max(axis=0)
    reach = (high - low) / units
    ranked = rank_least_first((-reach).tolist(), float(reach.max()))
    moving = sorted(k for k in ranked[:2] if reach[k] > RESTS * reach.max())
    half = np.maximum(0.55 * (high - low), NARROWEST * reach.max() * units)
    ends = np.column_stack([0.5 * (low + high) - half, 0.5 * (low + high) + half]).tolist()
    if len(moving) > 1:
        first, second = moving
        return _Plane((first, second), (tuple(ends[first]), tuple(ends[second])))
    s = np.concatenate([path.s for path in paths])
    axes = (len(linkage.inputs), ranked[0])
    return _Plane(axes, ((float(s.min()), float(s.max())), tuple(ends[ranked[0]])))


class _MomentumField(NamedTuple):
    """How quiet the poses in the plane of two inputs are.

    Attributes:
        first: positions of the first input (poses,), rad or m.
        second: those of the second input (poses,).
        size: smallest singular value that counts over the momenta of the bodies (poses, poses),
            first input first; NaN where no pose is reached.
        strokes: points (N, 2) of strokes along the directions with the least momentum, apart
            by NaN.
    """

    first: Array
    second: Array
    size: Array
    strokes: Array

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for the script of a page."""
        return {
            "x": short(self.first),
            "y": short(self.second),
            "size": [short(row) for row in self.size.T],
            "strokes": [short(values) for values in self.strokes.T],
        }


def momentum_field(solution: ReactionlessPaths) -> _MomentumField | None:
    """Compute the field around paths, or around the first start if there are none.

    Returns:
        The field; None if the linkage has not two inputs, if its base floats, if the moment is
        about another point than the origin, or if no pose is reached.
    """
    linkage = solution.linkage
    demand = solution.demand
    components = demand.components
    if len(linkage.inputs) != 2 or components is None or solution.motion is not None:
        return None
    first, second = _axes(solution)
    grid = dict(zip(linkage.inputs, (first, second), strict=True))
    try:
        field = momentum_map(linkage, grid, components)
    except PoseError:
        return None
    counted = max(0, len(linkage.inputs) - 1 - solution.dimension)
    size = field.singular_values[..., counted] / field.scale
    picked = (slice(None, None, APART),) * 2
    at = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)[picked]
    way = field.quietest[picked]
    step = max(first[1] - first[0], second[1] - second[0])
    half = 0.4 * APART * step * way / np.linalg.norm(way, axis=-1, keepdims=True)
    strokes = np.stack([at - half, at + half, np.full_like(at, np.nan)], axis=2)
    return _MomentumField(first, second, size, strokes.reshape(-1, 2))


def _axes(solution: ReactionlessPaths) -> list[Array]:
    """Choose positions of both inputs: around the paths, alike in width."""
    linkage = solution.linkage
    units = input_chain(linkage).units[linkage.positions_of(linkage.inputs)]
    if solution.paths:
        u = np.concatenate([path.u for path in solution.paths])
        low, high = u.min(axis=0), u.max(axis=0)
        half = 0.6 * max(float(((high - low) / units).max()), 1e-3) * units
    else:
        low = high = solution.starts[0].u
        half = HALF_WIDTH * units
    middle, spread = 0.5 * (low + high), np.linspace(-1.0, 1.0, POSES)
    return [middle[k] + half[k] * spread for k in range(2)]
