"""Webs: bars that join shapes to the nearest joint of their link, counted as part of them.

The web of a disc, block or cylinder that does not reach a joint is a bar of its thickness and
density from the joint to the middle of the shape, as wide as the radius of the disc or
cylinder, or as half the side of the block. The matter of the web that is outside the shape is
counted: with t towards the joint and y across, from the middle of the shape, it is where
``τ(y) ≤ t ≤ D`` and ``|y| ≤ w/2``, with the width w, the distance D of the joint, and the rim
τ of the shape. Mass and first moments of the web then are given matter, and the shapes are
sought again, until they do not change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight, filled_counterweight
from balance.masses.counterweights.regions import Region, box_region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, nearest_joint
from balance.masses.counterweights.shaped.shape_holder import MASS, WHOLE, ShapeHolder, X, Y
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import ARM_ZERO, PART_ROUND_OFF, SHAPE_INSIDE
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Nodes of Gauss's rule across a web: of the smooth rim of a disc the error is round-off.
NODES = 24
# Part of the mass of all shapes up to which one with a web is left out: the width of a web
# falls with the root of the mass alone.
SLIGHT = 1e-5
# Most steps until shapes settle beside their webs, and what is settled, over the whole mass.
MOST_STEPS, SETTLED = 100, 1e-6
# Steps without half the change, from which on what is left is the round-off of the solver.
PATIENCE = 3
# Parts of a change that a step takes, the second one where the first does not settle; halvings
# of the share of shapes for a start; steps that are remembered; and the share of the largest
# singular value below which a direction of them is left alone.
LONG, SHORT, HALVINGS, REMEMBERED, DEGENERATE = 0.5, 0.1, 20, 5, 1e-6


def web_of(space: DesignSpace, body: int, shape: Region, region: Region) -> Region | None:
    """Make the web of a shape: a box whose first axis points from the joint to the shape.

    Args:
        space: a design space of the linkage, which is planar.
        body: position of the body.
        shape: a disc or cylinder across the plane, or a block.
        region: where matter may be.

    Returns:
        The web; None where the shape reaches a joint, or the web would leave the region.
    """
    arm, joint = nearest_joint(space, body, shape)
    if not arm > ARM_ZERO * shape.size:
        return None
    axes, _ = axes_and_height(space, body)
    distance = float(np.linalg.norm(joint))
    towards = -(joint / distance) @ axes[:2]
    half_width = 0.5 * float(np.linalg.norm(shape.place[:3, 0]))
    half_thickness = float(np.linalg.norm(shape.place[:3, 2]))
    place = np.eye(4)
    place[:3, 0], place[:3, 2] = 0.5 * distance * towards, half_thickness * axes[2]
    place[:3, 1] = half_width * np.cross(axes[2], towards)
    place[:3, 3] = shape.centre - place[:3, 0]
    wide, long = number_text(2.0 * half_width), number_text(distance, ".3g")
    text = f"a web {wide} m wide, {long} m long"
    web = replace(box_region([-1.0] * 3, [1.0] * 3), place=freeze(place), text=text)
    return web if region.contains(web.rim, SHAPE_INSIDE).all() else None


def web_volume(web: Region, shape: Region) -> Array:
    """Compute ``∫ [x; 1][x; 1]ᵀ dV`` (4, 4) over the part of a web that is outside its shape.

    Args:
        web: from `web_of`, in the link frame.
        shape: its shape.
    """
    halves = np.linalg.norm(web.place[:3, :3], axis=0)
    axes = web.place[:3, :3] / halves * [-1.0, 1.0, 1.0]
    far, (_, side, deep) = 2.0 * float(halves[0]), halves.tolist()
    faces = _faces_ahead(shape, axes)
    edges = np.array(sorted([-side, *(y for y in _bends(faces, far) if abs(y) < side), side]))
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    half = 0.5 * np.diff(edges)[:, None]
    y = (0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes).reshape(-1)
    w = (half * weights).reshape(-1)
    if shape.offsets.size:
        a, b, c = faces.T
        rim = np.minimum(((c - y[:, None] * b) / a).min(axis=1), far)
    else:
        rim = np.sqrt(float(np.sum(shape.place[:3, 0] ** 2)) - y * y)
    powers = [(far ** (k + 1) - rim ** (k + 1)) / (k + 1) for k in range(3)]
    mass, t, tt = (float(w @ power) for power in powers)
    across, yy, ty = (float(w @ (y**k * powers[j])) for k, j in ((1, 0), (2, 0), (1, 1)))
    zz = mass * deep**2 / 3.0
    S = np.array([[tt, ty, 0, t], [ty, yy, 0, across], [0, 0, zz, 0], [t, across, 0, mass]])
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = axes, shape.centre
    return np.asarray(2.0 * deep * (H @ S @ H.T))


def _faces_ahead(shape: Region, axes: Array) -> Array:
    """List sides ``a t + b y = c`` of a block that are towards the joint: rows (n, 3)."""
    sides = shape.place[:3, :2] if shape.offsets.size else np.empty((3, 0))
    sizes = np.linalg.norm(sides, axis=0)
    normals = np.hstack([sides, -sides]) / np.tile(sizes, 2)
    faces = np.column_stack([normals.T @ axes[:, :2], np.tile(sizes, 2)])
    return np.asarray(faces[faces[:, 0] > PART_ROUND_OFF])


def _bends(faces: Array, far: float) -> list[float]:
    """List places y across a web where its end is at a corner of sides, or they are ``far``."""
    places = [
        (c * f - g * a) / (b * f - e * a)
        for k, (a, b, c) in enumerate(faces.tolist())
        for f, e, g in faces[:k].tolist()
    ]
    return places + [(c - a * far) / b for a, b, c in faces.tolist() if b]


def shape_weight(
    space: DesignSpace, body: int, stock: Stock, region: Region | None
) -> tuple[Counterweight, Array]:
    """Make the counterweight of a shape, and its moments (4, 4), kg, link frame.

    Args:
        space: a design space of the linkage.
        body: position of the body.
        stock: the shape and its density.
        region: where its web may be; None if webs are not counted.
    """
    place, matter = stock.region.place, fill(stock, WHOLE)
    web = None if region is None else web_of(space, body, stock.region, region)
    moments, arm = place @ matter @ place.T, nearest_joint(space, body, stock.region)[0]
    if web is not None:
        arm, moments = 0.0, moments + stock.density * web_volume(web, stock.region)
        back = np.linalg.inv(place)
        matter = back @ moments @ back.T
    weight = filled_counterweight(space.bodies[body], stock, WHOLE, matter, arm, web)
    return weight, moments


def web_coordinates(
    space: DesignSpace, holders: Mapping[int, ShapeHolder], unit: float, x: Array
) -> Array:
    """Compute mass and first moments (links, 3) of the webs of shapes, in units of the shapes.

    Args:
        space: a design space of the linkage.
        holders: what holds the shapes, by position of the body.
        unit: kilograms per unit of mass.
        x: mass and first moments of the shapes (links, 3 or more).
    """
    webs = np.zeros((len(holders), 3))
    for k, ((b, holder), row) in enumerate(
        zip(holders.items(), without_slight(x), strict=True)
    ):
        if not row[MASS]:
            continue
        stock = holder.fill(unit * row[MASS], space.length * row[X : Y + 1] / row[MASS])
        web = web_of(space, b, stock.region, holder.region)
        if web is not None:
            P = stock.density * web_volume(web, stock.region) / unit
            webs[k] = P[3, 3], *(holder.axes[:2] @ P[:3, 3] / space.length)
    return webs


def without_slight(x: Array) -> Array:
    """Leave out shapes (links, variables) that are too slight for a web."""
    kept = x[:, MASS] > max(0.0, SLIGHT * float(x[:, MASS].sum()))
    return np.where(kept[:, None], x, 0.0)


def settle_webs(
    webs_of: Callable[[Array], Array],
    solve: Callable[[Array], tuple[Array, float]],
    first: Array,
) -> tuple[Array, float] | None:
    """Find shapes that are the best ones beside their webs.

    There may be several such shapes, of which the first that are found are taken.

    Args:
        webs_of: computes mass and first moments of webs (links, 3) from variables of shapes.
        solve: finds the variables of shapes beside given webs, without mass where there are
            none, and a bound.
        first: the variables of shapes without webs (links, variables), some of which get one.

    Returns:
        The shapes and the bound beside their webs, as exactly as the solver has them; None if
        they do not settle.
    """
    webs = webs_of(first)
    heavy = float(webs[:, MASS].sum() / first[:, MASS].sum())
    for start, part in (
        (webs * min(1.0, 0.5 / heavy), LONG),
        (_webs_within(webs_of, first), SHORT),
    ):
        settled = _settle_from(start, part, webs_of, solve)
        if settled is not None:
            return settled
    return None


def _settle_from(
    webs: Array,
    part: float,
    webs_of: Callable[[Array], Array],
    solve: Callable[[Array], tuple[Array, float]],
) -> tuple[Array, float] | None:
    """Find shapes that are the best ones beside their webs, from webs to start with.

    Args:
        webs: mass and first moments of webs (links, 3).
        part: part of a change that a step takes.
        webs_of: see `settle_webs`.
        solve: see `settle_webs`.
    """
    settled, least, worse = None, SETTLED, 0
    points, changes = list[Array](), list[Array]()
    for _ in range(MOST_STEPS):
        x, bound = solve(webs)
        if not x[:, MASS].any():
            break
        change = webs_of(x) - webs
        size = float(np.abs(change).max() / (x[:, MASS].sum() + webs[:, MASS].sum()))
        if size <= least:
            worse = 0 if size <= 0.5 * least else worse + 1
            settled, least = (without_slight(x), bound), size
        elif settled is not None:
            worse += 1
        if worse == PATIENCE:
            break
        points, changes = [*points[-REMEMBERED:], webs], [*changes[-REMEMBERED:], change]
        webs = _next_webs(points, changes, part)
    return settled


def _webs_within(webs_of: Callable[[Array], Array], first: Array) -> Array:
    """Compute the webs of shapes that together with them have the mass of shapes without."""
    whole, low, high = float(first[:, MASS].sum()), 0.0, 1.0
    for _ in range(HALVINGS):
        part = 0.5 * (low + high)
        more = part * whole + float(webs_of(part * first)[:, MASS].sum()) > whole
        low, high = (low, part) if more else (part, high)
    return webs_of(high * first)


def _next_webs(points: list[Array], changes: list[Array], part: float) -> Array:
    """Extrapolate to where webs do not change.

    What combination of the last changes is least is taken to be that of the next (D. G. M.
    Anderson, Iterative procedures for nonlinear integral equations, J. ACM 12, 1965). Where a
    web would have a negative mass, a part of the last change is taken.
    """
    webs, change = points[-1], changes[-1]
    steps = np.diff(np.reshape(points, (len(points), -1)), axis=0).T
    turns = np.diff(np.reshape(changes, (len(points), -1)), axis=0).T
    shares = np.linalg.lstsq(turns, change.reshape(-1), rcond=DEGENERATE)[0]
    rest = change.reshape(-1) - turns @ shares
    following = webs + (part * rest - steps @ shares).reshape(webs.shape)
    return following if (following[:, MASS] >= 0.0).all() else webs + part * change
