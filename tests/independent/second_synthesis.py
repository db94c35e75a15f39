"""Balanced four-bars through positions by another method than `balance.studies.synthesis`.

The product chooses the shape of a four-bar and the angles of its crank, and moves its poles to
those of the positions. Here the pivots are points of the tool: with D_i the displacement from
position 1 to i, a crank tip W has its base G at the centre of the circle through all D_i W, and
a rocker tip Z its base H likewise. The four-bar is a

    kite:               |Z - W| = |W - G|        |H - Z| = |H - G|
    antiparallelogram:  |Z - W| = |H - G|        |H - Z| = |W - G|

- Two and three positions: on a grid of W, of ``|H - G| / |W - G|`` and of the direction of the
  base, Z is the mirror image that the kind asks for, and ``|H - D_i Z|`` has to be one number.
- Four positions: W and Z run along the circle-point curve, a cubic (L. Burmester, 1888), whose
  points are on lines through the pole of the first displacement; both relations of lengths
  change their signs in a cell of pairs of points. More positions are met by a design of the
  first four, or not at all.

Every candidate is refined by Newton's method in all pivots.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

KINDS = ("kite", "antiparallelogram")
# Base over crank: masses exist from √2; the product searches up to 12.
LOWEST, HIGHEST = np.sqrt(2.0), 12.0
# Crank over, and distance of the pivots in, sizes of the positions, as in the product.
SHORTEST, FARTHEST = 0.02, 50.0
# How far the crank stays from change points, where links are in line, for two and three
# positions: the product leaves out the ends of its angles.
APART = np.radians(8.9)
# What is left of the equations, relative to the size, of a design.
MET = 1e-10


class Pivots(NamedTuple):
    """Pivots at position 1: bases G and H, tips W and Z of crank and rocker."""

    G: complex
    H: complex
    W: complex
    Z: complex


class Task(NamedTuple):
    """Displacements from position 1 to each position, the first the identity, and the size."""

    turns: np.ndarray
    shifts: np.ndarray
    tool: complex
    size: float

    def move(self, z):
        """A point of the tool at all positions: (n, …)."""
        ones = (1,) * np.ndim(z)
        return self.turns.reshape(-1, *ones) * z + self.shifts.reshape(-1, *ones)


def task_of(positions: Sequence[tuple[float, float, float]]) -> Task:
    """The displacements of positions x, y, angle."""
    points = np.array([complex(x, y) for x, y, _ in positions])
    turns = np.exp(1j * np.array([angle - positions[0][2] for *_, angle in positions]))
    size = float(np.abs(points - points[0]).max()) or 1.0
    return Task(turns, points - turns * points[0], complex(points[0]), size)


def admissible(kind: str, task: Task, pivots: Pivots) -> bool:
    """Whether pivots are a design without defects, in the bounds of the product.

    The assembly is the mirrored one at all positions, the crank stays between two change points
    and meets the positions in their order.
    """
    G, H, W, Z = pivots
    crank, base = abs(W - G), abs(H - G)
    if min(crank, base) <= SHORTEST * task.size:
        return False
    tips, ends = task.move(W), task.move(Z)
    left = [np.abs(tips - G) - crank, np.abs(ends - H) - abs(Z - H)]
    left += [[abs(ends[0] - _mirrored(kind, G, H, W))]]
    if np.abs(np.concatenate(left)).max() > 1e-8 * task.size:
        return False
    if np.abs(ends - _mirrored(kind, G, H, tips)).max() > 1e-6 * task.size:
        return False
    angles = np.angle((tips - G) / (H - G))
    steps = np.diff(angles)
    if len(angles) < 4 and np.abs(np.sin(angles)).min() < np.sin(APART):
        return False
    return bool(
        LOWEST < base / crank <= HIGHEST
        and max(abs(z - task.tool) for z in pivots) < FARTHEST * task.size
        and len(set(np.sign(angles))) == 1
        and (np.all(steps > 0.0) or np.all(steps < 0.0))
    )


def _mirrored(kind, G, H, W):
    """The tip of the rocker: G, or the fourth corner, mirrored in the line from W to H."""
    line = (W - H) / np.abs(W - H)
    corner = G if kind == "kite" else W + H - G
    return H + line**2 * np.conj(corner - H)


def search(kind: str, positions, *, fixed=None, moving=None, dense: int = 1) -> Pivots | None:
    """Search for a design without defects; None if there is none on the grid.

    Args:
        dense: how many times denser the grid is than at least.
    """
    task = task_of(positions)
    if len(positions) < 4:
        candidates = _on_grid(kind, task, fixed, moving, dense)
    else:
        four = Task(task.turns[:4], task.shifts[:4], task.tool, task.size)
        candidates = _on_curves(kind, four, dense)
    for pivots in candidates:
        if admissible(kind, task, pivots):
            return pivots
    return None


def _cranks(task: Task, fixed, moving, dense: int) -> Iterator[tuple[complex, complex]]:
    """Crank bases and tips G, W on a grid."""
    if len(task.turns) == 2:
        # The mirror line of W and D W, or of G and the point of the tool that comes to G.
        place = moving if fixed is None else fixed
        other = task.turns[1] * place + task.shifts[1]
        if fixed is not None:
            other = (place - task.shifts[1]) / task.turns[1]
        middle, along = 0.5 * (place + other), 1j * (other - place) / abs(other - place)
        for t in np.tan(np.linspace(-1.55, 1.55, 60 * dense)):
            end = middle + t * task.size * along
            yield (end, place) if fixed is None else (place, end)
        return
    for r, angle in product(
        np.geomspace(0.03, 20.0, 14 * dense), np.linspace(0, 2 * np.pi, 24 * dense)
    ):
        W = task.tool + r * task.size * np.exp(1j * angle)
        yield _centre(task.move(W)), W


def _centre(points: np.ndarray):
    """Centres of circles through points (n, …), by least squares: ``2 Re(G* d_i) = e_i``."""
    d = points[1:] - points[0]
    e = 0.5 * np.abs(d) ** 2
    xx, xy, yy = (d.real**2).sum(0), (d.real * d.imag).sum(0), (d.imag**2).sum(0)
    u, v = (d.real * e).sum(0), (d.imag * e).sum(0)
    with np.errstate(all="ignore"):
        return points[0] + ((yy * u - xy * v) + 1j * (xx * v - xy * u)) / (xx * yy - xy**2)


def _on_grid(kind: str, task: Task, fixed, moving, dense: int) -> Iterator[Pivots]:
    """Candidates for two and three positions: cells where all equations change sign."""
    ratio = np.geomspace(1.001 * LOWEST, HIGHEST, 24 * dense)[:, None]
    angle = np.linspace(-np.pi, np.pi, 96 * dense + 1)[None, :]
    for G, W in _cranks(task, fixed, moving, dense):
        if not np.isfinite(G) or abs(W - G) <= SHORTEST * task.size:
            continue
        H = G + ratio * abs(W - G) * np.exp(1j * angle)
        Z = _mirrored(kind, G, H, W)
        radii = np.abs(task.move(Z) - H)
        cells = np.logical_and.reduce([_changes(f) for f in radii[1:] - radii[0]])
        for i, j in np.argwhere(cells).tolist():
            start = [
                0.5 * (ratio[i, 0] + ratio[i + 1, 0]),
                0.5 * (angle[0, j] + angle[0, j + 1]),
            ]
            yield from _refined_base(kind, task, G, W, start)


def _refined_base(kind: str, task: Task, G, W, start) -> Iterator[Pivots]:
    """Refine the base of a crank; of two positions the direction alone."""

    def pivots(x) -> Pivots:
        ratio, angle = (start[0], x[0]) if len(x) == 1 else x
        H = G + ratio * abs(W - G) * np.exp(1j * angle)
        return Pivots(G, complex(H), W, complex(_mirrored(kind, G, H, W)))

    def left(x):
        at = pivots(x)
        radii = np.abs(task.move(at.Z) - at.H)
        return (radii[1:] - radii[0]) / task.size

    x = start[1:] if len(task.turns) == 2 else start
    solution = root(left, x, tol=1e-14)
    if np.abs(solution.fun).max() < MET:
        yield pivots(solution.x)


def _changes(f: np.ndarray) -> np.ndarray:
    """Cells of a grid in which a function changes its sign."""
    corners = np.stack([f[:-1, :-1], f[1:, :-1], f[:-1, 1:], f[1:, 1:]])
    with np.errstate(invalid="ignore"):
        return (corners.min(0) <= 0.0) & (corners.max(0) >= 0.0)


def circle_points(task: Task, count: int) -> np.ndarray:
    """Circle points of four positions on lines through a pole (2, count + 1); NaN: none.

    With the difference of squares the rows ``(|W_i|² - |W_1|², x_i - x_1, y_i - y_1)`` are
    linear along a line, and the first vanishes at the pole: the determinant is a quadratic.
    """
    pole = task.shifts[1] / (1.0 - task.turns[1])
    angle = np.linspace(0.0, np.pi, count + 1)
    way = np.exp(1j * angle)

    def determinant(s: float) -> np.ndarray:
        W = pole + s * way
        images = task.move(W)
        d = images[1:] - images[0]
        e = np.abs(images[1:]) ** 2 - np.abs(images[0]) ** 2
        d[0], e[0] = d[0] / s, e[0] / s
        return np.linalg.det(np.stack([e, d.real, d.imag], -1).transpose(1, 0, 2))

    low, high, twice = (determinant(s * task.size) for s in (-1.0, 1.0, 2.0))
    a = (twice - low - 1.5 * (high - low)) / 3.0
    b = 0.5 * (high - low)
    c = high - a - b
    with np.errstate(all="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(b**2 - 4.0 * a * c), b))
        roots = np.sort(np.stack([q / a, c / q]), axis=0)
    return pole + task.size * roots * way


def _on_curves(kind: str, task: Task, dense: int) -> Iterator[Pivots]:
    """Candidates for four positions: pairs of circle points."""
    curves = circle_points(task, 500 * dense)
    centres = _centre(task.move(curves))
    for p, q in product(range(2), repeat=2):
        W, G = curves[p][:, None], centres[p][:, None]
        Z, H = curves[q][None, :], centres[q][None, :]
        coupler, crank = np.abs(Z - W), np.abs(W - G)
        rocker, base = np.abs(H - Z), np.abs(H - G)
        pairs = (coupler - crank, rocker - base)
        if kind == "antiparallelogram":
            pairs = (coupler - base, rocker - crank)
        cells = _changes(pairs[0]) & _changes(pairs[1])
        cells &= (crank * LOWEST / 1.1 < base)[:-1, :-1] & (base < 1.1 * HIGHEST * crank)[
            :-1, :-1
        ]
        for i, j in np.argwhere(cells).tolist():
            at = [
                0.5 * (z[k] + z[k + 1])
                for z, k in ((G[:, 0], i), (H[0], j), (W[:, 0], i), (Z[0], j))
            ]
            yield from _refined_pivots(kind, task, Pivots(*map(complex, at)))


def _refined_pivots(kind: str, task: Task, start: Pivots) -> Iterator[Pivots]:
    """Refine all pivots: eight equations for four positions."""

    def left(x):
        G, H, W, Z = x[::2] + 1j * x[1::2]
        cranks, rockers = np.abs(task.move(W) - G), np.abs(task.move(Z) - H)
        short, long = cranks[0], abs(H - G)
        if kind == "antiparallelogram":
            short, long = long, short
        more = [abs(Z - W) - short, rockers[0] - long]
        return (
            np.concatenate([cranks[1:] - cranks[0], rockers[1:] - rockers[0], more]) / task.size
        )

    x = np.array(start).view(float)
    if not np.all(np.isfinite(x)):
        return
    solution = root(left, x, tol=1e-14)
    if np.abs(solution.fun).max() < MET:
        yield Pivots(*map(complex, solution.x[::2] + 1j * solution.x[1::2]))


# Least transmission angle of the product's general four-bars, with a margin for the samples of
# a motion; shortest link and farthest pivot over the size.
TRANSMISSION, SHORT_LINK, FAR_PIVOT = np.radians(10.5), 0.05, 20.0
# Samples of the way from the first position to the last; cranks of a random grid.
WAY, RANDOM = 61, 400


def search_general(positions, *, fixed=None, moving=None, dense: int = 1) -> Pivots | None:
    """Search for a four-bar of any lengths without defects; None if none is found.

    Cranks of two and three positions are random, those of four are points of the circle-point
    curve, those of five the points of that of the first four whose fifth radius is the same.
    Every pair is moved from the first position to the last, in both directions of the crank.
    """
    task = task_of(positions)
    G, W = _guides(task, dense)
    cranks = (G, W)
    if fixed is not None or moving is not None:
        pairs = list(_cranks(task, fixed, moving, dense))
        cranks = tuple(np.array(part) for part in zip(*pairs, strict=True))
    i, j = (part.ravel() for part in np.indices((len(cranks[0]), len(G))))
    for part in np.array_split(np.arange(i.size), max(1, i.size // 100_000)):
        at = i[part], j[part]
        pivots = Pivots(cranks[0][at[0]], G[at[1]], cranks[1][at[0]], W[at[1]])
        good = np.flatnonzero(_moves(task, pivots))
        if good.size:
            return Pivots(*(complex(each[good[0]]) for each in pivots))
    return None


def _guides(task: Task, dense: int):
    """Bases and tips of cranks that guide the tool."""
    n = len(task.turns)
    rng = np.random.default_rng(n)
    if n < 4:
        radius = task.size * np.exp(rng.uniform(np.log(0.05), np.log(3.0), RANDOM * dense))
        W = task.tool + radius * np.exp(2j * np.pi * rng.random(radius.size))
        if n == 3:
            return _centre(task.move(W)), W
        start, end = task.move(W)
        away = 1j * (end - start) / np.abs(end - start) * task.size
        return 0.5 * (start + end) + away * rng.normal(size=W.size), W
    four = Task(task.turns[:4], task.shifts[:4], task.tool, task.size)
    W = circle_points(four, (400 if n == 4 else 4000) * dense)
    G = _centre(four.move(W))
    if n == 4:
        kept = np.isfinite(G) & np.isfinite(W)
        return G[kept], W[kept]
    apart = np.abs(task.move(W)[4] - G) - np.abs(W - G)
    with np.errstate(invalid="ignore"):
        at = np.argwhere(apart[:, :-1] * apart[:, 1:] <= 0.0)
    ends = [_refined_crank(task, G[b, k], W[b, k]) for b, k in at.tolist()]
    found = np.array([pair for pair in ends if pair is not None]).reshape(-1, 2)
    return found[:, 0], found[:, 1]


def _refined_crank(task: Task, G: complex, W: complex) -> tuple[complex, complex] | None:
    """Refine a crank of five positions; None at poles, where there is none."""

    def left(x):
        radii = np.abs(task.move(complex(*x[2:])) - complex(*x[:2]))
        return (radii[1:] - radii[0]) / task.size

    solution = root(left, [G.real, G.imag, W.real, W.imag], tol=1e-14)
    if np.abs(solution.fun).max() > MET:
        return None
    return complex(*solution.x[:2]), complex(*solution.x[2:])


def _moves(task: Task, pivots: Pivots) -> np.ndarray:
    """Which four-bars go from the first position to the last by all others in their order."""
    G, H, W, Z = pivots
    a, b, c, g = np.abs(W - G), np.abs(Z - W), np.abs(H - Z), np.abs(H - G)
    spread = np.max(np.abs(np.stack(pivots) - task.tool), axis=0)
    fits = (np.min([a, b, c, g], axis=0) > SHORT_LINK * task.size) & (
        spread < FAR_PIVOT * task.size
    )
    kept = np.flatnonzero(fits)
    good = np.zeros(len(G), bool)
    G, H, W, Z, a, b, c, g = (x[kept] for x in (G, H, W, Z, a, b, c, g))
    tips, ends = task.move(W), task.move(Z)
    side = np.sign(((H - tips).conj() * (ends - tips)).imag)
    for sign in (1.0, -1.0):
        turns = sign * np.angle((tips - G) / (W - G))
        turns = np.where(turns < -1e-12, turns + 2.0 * np.pi, turns)
        turns[0] = 0.0
        here = (side == side[0]).all(0) & (np.diff(turns, axis=0) > 0.0).all(0)
        at = np.flatnonzero(here)
        way = np.linspace(0.0, 1.0, WAY)[:, None] * turns[-1, at] * sign
        A = G[at] + (W[at] - G[at]) * np.exp(1j * way)
        cosine = (b[at] ** 2 + c[at] ** 2 - np.abs(H[at] - A) ** 2) / (2.0 * b[at] * c[at])
        good[kept[at[np.abs(cosine).max(axis=0) < np.cos(TRANSMISSION)]]] = True
    return good
