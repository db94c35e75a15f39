"""The serial design space from its definition: every way of opening the loops, one by one.

A loop is opened by splitting a moving body: joints let go of it, and each takes a copy of
the body along, whose parameters count for the body. What is left is a tree, so every joint
moves freely; random finite poses, momentum in the form of products of 4 × 4 matrices, and a
singular value decomposition give its design space. Nothing here knows of transfers.

A ``Chain`` is only read for its arrays. Coordinates are those of the chain.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain as joined
from itertools import combinations

import numpy as np
from scipy.linalg import svd

GROUND = -1
# Random poses are far apart and lengths near 1: what is not below round-off is far above.
ZERO, SURE = 1e-12, 1e-8

HalfEdge = tuple[int, int]


@dataclass(frozen=True)
class Graph:
    """Rigid parts and the joints between them.

    Attributes:
        sides: the two parts that each joint connects, the one before it first.
        bodies: numbers of the bodies with parameters on each part.
    """

    sides: tuple[tuple[int, int], ...]
    bodies: dict[int, tuple[int, ...]]

    @classmethod
    def of(cls, chain) -> Graph:
        """The graph of a chain, with welded links taken together."""
        part = {link: link for link in range(-1, chain.parent.size)}
        for one, other in chain.ends.tolist():
            keep, drop = sorted((part[one], part[other]))
            part = {link: keep if p == drop else p for link, p in part.items()}
        sides = tuple((part[p], part[j]) for j, p in enumerate(chain.parent.tolist()))
        bodies: dict[int, tuple[int, ...]] = {p: () for p in part.values()}
        for body, link in enumerate(chain.links.tolist()):
            bodies[part[link]] += (body,)
        return cls(sides, bodies)

    @property
    def loops(self) -> int:
        """How many splits open all loops."""
        return len(self.sides) - len(self.bodies) + 1

    def splits(self) -> dict[int, list[tuple[HalfEdge, ...]]]:
        """For every part, the sets of ends of joints that may let go of it.

        If all but one let go, it is as if all did: of these ways only one is listed.
        """
        found = {}
        for part, bodies in self.bodies.items():
            ends = [
                (j, s) for j, pair in enumerate(self.sides) for s in (0, 1) if pair[s] == part
            ]
            found[part] = [()]
            if bodies and part != GROUND and len(ends) > 1:
                some = (combinations(ends, n) for n in range(1, len(ends) - 1))
                found[part] += [*joined.from_iterable(some), tuple(ends[1:])]
        return found


def openings(graph: Graph) -> Iterator[tuple[HalfEdge, ...]]:
    """Every set of ends of joints that, letting go, leaves a tree on the ground."""

    def choose(parts: list[int], left: int) -> Iterator[tuple[HalfEdge, ...]]:
        if not parts:
            if left == 0:
                yield ()
            return
        for way in splits[parts[0]]:
            if len(way) <= left:
                for rest in choose(parts[1:], left - len(way)):
                    yield way + rest

    splits = graph.splits()
    for way in choose(sorted(graph.bodies), graph.loops):
        if len(_walk(graph, way)) == len(graph.sides):
            yield way


def _walk(graph: Graph, way: tuple[HalfEdge, ...]) -> list[tuple[int, int, int, object]]:
    """Joints from the ground upwards: joint, place of the one before, side it starts, part.

    A part that a joint takes as a copy is ``(joint, side)``.
    """
    pairs = [list(pair) for pair in graph.sides]
    for j, s in way:
        pairs[j][s] = (j, s)
    order, reached = [], {GROUND: -1}
    growing = True
    while growing:
        growing = False
        for j, pair in enumerate(pairs):
            for s in (0, 1):
                if pair[s] in reached and pair[1 - s] not in reached:
                    order.append((j, reached[pair[s]], s, pair[1 - s]))
                    reached[pair[1 - s]] = len(order) - 1
                    growing = True
    return order


class Poses:
    """Displacements of every joint of a chain at random positions.

    Attributes:
        hats: twists (n, 4, 4).
        steps: displacements along the joint and back (2, poses, n, 4, 4).
    """

    def __init__(self, chain, poses: int, seed: int = 5) -> None:
        """Draw positions up to a radian, or a length of the chain."""
        self.hats = np.array([hat(s) for s in chain.screws]).reshape(-1, 4, 4)
        q = np.random.default_rng(seed).uniform(-1.2, 1.2, (poses, len(self.hats), 1, 1))
        square = self.hats @ self.hats
        even = np.eye(4) + (1 - np.cos(q)) * square
        odd = q * self.hats + (q - np.sin(q)) * (square @ self.hats)
        self.steps = np.array([even + odd, even - odd])


def hat(screw: np.ndarray) -> np.ndarray:
    """Twist of a screw of a spatial chain (6,), or of a planar one (3,); shape (4, 4)."""
    if screw.size == 3:
        screw = np.array([0.0, 0.0, screw[0], screw[1], screw[2], 0.0])
    (a, b, c), v = screw[:3], screw[3:]
    twist = np.zeros((4, 4))
    twist[:3] = np.column_stack([[[0, -c, b], [c, 0, -a], [-b, a, 0]], v])
    return twist


def moments() -> np.ndarray:
    """Second moments ``∫ [r; 1] [r; 1]ᵀ dm`` of each unit parameter; shape (10, 4, 4)."""
    J = np.zeros((10, 4, 4))
    J[0, 3, 3] = 1.0
    for i in range(3):
        J[1 + i, i, 3] = J[1 + i, 3, i] = 1.0
        # S = tr(E)/2 - E.
        J[4 + i, :3, :3] = np.eye(3) / 2.0
        J[4 + i, i, i] -= 1.0
    for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2))):
        J[7 + k, i, j] = J[7 + k, j, i] = -1.0
    return J


def selection(planar: bool, force: bool) -> tuple[list[int], list[int]]:
    """Rows of the momentum ``[ξ; p]`` and parameters that count."""
    rows, columns = ([2, 3, 4], [0, 1, 2, 6]) if planar else (list(range(6)), list(range(10)))
    if force:
        return [r for r in rows if r > 2], [c for c in columns if c < 4]
    return rows, columns


def regressor(chain, walk, carried: list[tuple[int, int]], poses: Poses, force) -> np.ndarray:
    """Momentum per parameter of an opened linkage, all joints free, at all poses.

    Args:
        chain: the linkage.
        walk: its joints from the ground upwards.
        carried: place in the walk, -1 for the ground, and number of every body or copy.
        poses: of the joints.
        force: whether only the linear momentum counts.

    Returns:
        Shape (poses · joints · rows, bodies and copies · parameters).
    """
    count, n = poses.steps.shape[1], len(walk)
    H = np.empty((count, n + 1, 4, 4))
    H[:, -1] = np.eye(4)
    T, above = np.empty((count, n, 4, 4)), np.zeros((n, n + 1))
    for k, (j, before, side, _) in enumerate(walk):
        H[:, k] = H[:, before] @ poses.steps[side, :, j]
        T[:, k] = H[:, before] @ poses.hats[j] @ np.linalg.inv(H[:, before])
        above[: k + 1, k] = above[: k + 1, before]
        above[k, k] = 1.0
    place = [at for at, _ in carried]
    rows, columns = selection(chain.planar, force)
    moved = np.einsum("plab,cbd,pled->plcae", H[:, place], moments()[columns], H[:, place])
    K = np.einsum("pjab,plcbe->pjlcae", T, moved) * above[:, place, None, None, None]
    # K = ∫ ρ̇ ρᵀ dm, so that ξ is its skew part and p its last column.
    xi = [K[..., 2, 1] - K[..., 1, 2], K[..., 0, 2] - K[..., 2, 0], K[..., 1, 0] - K[..., 0, 1]]
    X = np.stack([*xi, *(K[..., i, 3] for i in range(3))], axis=2)[:, :, rows]
    return X.reshape(count * n * len(rows), len(carried) * len(columns))


def gapped(values: np.ndarray) -> int:
    """How many singular values, relative to 1, are not zero; refuses to guess.

    Raises:
        ValueError: one is neither zero nor clearly not.
    """
    doubtful = values[(values > ZERO) & (values < SURE)]
    if doubtful.size:
        raise ValueError(f"no clear gap: {doubtful}")
    return int(np.sum(values > ZERO))


def nullspace(A: np.ndarray) -> np.ndarray:
    """Orthonormal null space of A, with a clear gap."""
    if not A.any():
        return np.eye(A.shape[1])
    # NumPy's driver does not converge for some ways of opening the Stewart platform.
    _, values, Vt = svd(np.linalg.qr(A, mode="r"), lapack_driver="gesvd")
    return Vt[gapped(values / values[0]) :].T


def union(*spaces: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the sum of spaces, with a clear gap."""
    U, values, _ = svd(np.hstack(spaces), full_matrices=False, lapack_driver="gesvd")
    return U[:, : gapped(values / values.max(initial=1e-300))]


def serial(chain, graph: Graph, way, poses: Poses, force: bool = False) -> np.ndarray:
    """Orthonormal design space of one opened linkage, copies added to their bodies."""
    walk = _walk(graph, way)
    at = {GROUND: -1} | {part: k for k, (*_, part) in enumerate(walk)}
    carried = [(at[part], body) for part, some in graph.bodies.items() for body in some]
    carried += [(at[(j, s)], graph.bodies[graph.sides[j][s]][0]) for j, s in way]
    X = regressor(chain, walk, carried, poses, force)
    size = X.shape[1] // len(carried)
    fold = np.zeros((chain.links.size, len(carried)))
    fold[[body for _, body in carried], range(len(carried))] = 1.0
    return union(np.kron(fold, np.eye(size)) @ nullspace(X))


def serials(chain, force: bool = False, ways=None) -> list[np.ndarray]:
    """Design spaces of the linkage opened in every way, or in the given ones."""
    graph = Graph.of(chain)
    rows, columns = selection(chain.planar, force)
    unknowns = (chain.links.size + graph.loops) * len(columns)
    # Each body beyond a joint shows its parameters only where the joints below it differ.
    poses = Poses(chain, 8 + 2 * unknowns // (len(rows) * max(len(graph.sides), 1)))
    found = openings(graph) if ways is None else ways
    return [serial(chain, graph, way, poses, force) for way in found]
