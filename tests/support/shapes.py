"""Random linkages of types whose buildability is known, and judges that solve nothing."""

from __future__ import annotations

import numpy as np

from balance.momentum import momentum_regressor
from kinematics.closure.assembly.assemble import assemble
from tests.support.drafts import axis_edge, linked, spatial_edge
from tests.support.laws import unit_vector

Z_AXIS = np.array([0.0, 0.0, 1.0])


def loop_of(points, axes, base, rng):
    """A closed chain of hinges through points (4, 3) along axes; ``base`` is the fixed side."""
    count = len(points)
    edges = [
        axis_edge(
            "revolute",
            axes[i] / np.linalg.norm(axes[i]),
            points[i],
            ((i - 1 - base) % count, (i - base) % count),
            f"j{i}",
        )
        for i in range(count)
    ]
    return assemble(linked(edges, range(1, count), rng))


def quadrilateral(points, base, rng):
    """A planar 4R linkage; side i joins the points i and i + 1."""
    flat = np.column_stack([points, np.zeros(4)])
    return loop_of(flat, np.tile(Z_AXIS, (4, 1)), base, rng)


def kite(rng):
    """Corners of a kite (4, 2): sides 0 and 1 are equal and short, 2 and 3 equal and long."""
    x, y, d = rng.uniform(0.2, 0.5), rng.uniform(0.4, 0.7), rng.uniform(1.3, 1.8)
    return np.array([[x, y], [0.0, 0.0], [x, -y], [d, 0.0]])


def antiparallelogram(rng):
    """Corners of an antiparallelogram (4, 2): sides 0 and 2, which cross, are longer."""
    a, b, h = rng.uniform(0.6, 1.0), rng.uniform(0.2, 0.5), rng.uniform(0.3, 0.8)
    return np.array([[-a, 0.0], [b, h], [a, 0.0], [-b, h]])


def general(rng):
    """Corners of any quadrilateral (4, 2)."""
    corners = np.array([[0.0, 0.0], [0.1, 0.8], [1.1, 1.0], [1.3, 0.0]])
    return corners + rng.uniform(-0.12, 0.12, (4, 2))


def bennett(rng):
    """A Bennett linkage: corners of a skew quadrilateral with equal opposite sides.

    Turned by half about the z axis it is itself. Its hinges are square to the sides that
    meet in them; then sines of twists are as the lengths.
    """
    (x, y, z), (u, v) = rng.uniform(0.3, 1.0, 3), rng.uniform(-1.0, -0.3, 2)
    A, B = np.array([x, y, z]), np.array([u, -v, -z])
    points = np.array([A, B, A * [-1, -1, 1], B * [-1, -1, 1]])
    sides = np.roll(points, -1, axis=0) - points
    return loop_of(points, np.cross(np.roll(sides, 1, axis=0), sides), 3, rng)


def spherical(rng):
    """A spherical 4R linkage: all axes through the origin, none near another."""
    while True:
        axes = np.array([unit_vector(rng) for _ in range(4)])
        triple = [abs(np.linalg.det(np.delete(axes, i, axis=0))) for i in range(4)]
        if min(triple) > 0.2:
            return loop_of(np.zeros((4, 3)), axes, 3, rng)


def arm(rng, count=3):
    """A serial arm of any joints."""
    edges = [spatial_edge(rng, (i, i + 1), f"j{i}") for i in range(count)]
    return assemble(linked(edges, range(1, count + 1), rng))


def units(space):
    """Axes (3, 3), origin and length of the coordinates of a certificate."""
    frame = space.chain.frame
    return frame.R, frame.origin, frame.length


def matrix(z):
    """``[[S, mc], [mcᵀ, m]]`` of parameters (10,), entry by entry."""
    m, x, y, w, xx, yy, zz, xy, xz, yz = z
    return np.array(
        [
            [(yy + zz - xx) / 2, -xy, -xz, x],
            [-xy, (xx + zz - yy) / 2, -yz, y],
            [-xz, -yz, (xx + yy - zz) / 2, w],
            [x, y, w, m],
        ]
    )


def functional(space, certificate):
    """``Σ_b <Z_b, P_b>`` as a function of ten parameters per body about the inertial origin."""
    R, origin, length = units(space)
    G = np.eye(4)
    G[:3, :3], G[:3, 3] = R / length, -R @ origin / length
    seen = [0, 1, 3] if space.planar else range(4)
    values = []
    for Z in certificate:
        for unit in np.eye(10):
            P = (G @ matrix(unit) @ G.T)[np.ix_(seen, seen)]
            values.append(np.sum(Z * P))
    return np.array(values)


def conditions(space, poses=8, seed=0, reach=0.25):
    """Momentum of random finite poses per parameter, ten of each body (rows, parameters)."""
    linkage, rng = space.linkage, np.random.default_rng(seed)
    basis = space.motion.basis if space.motion else np.eye(linkage.mobility)
    rows = []
    for _ in range(poses):
        u = basis @ rng.uniform(-reach, reach, basis.shape[1])
        X = momentum_regressor(linkage, dict(zip(linkage.inputs, u, strict=True)), spatial=True)
        rows += list(np.einsum("wv,wrp->vrp", basis, X).reshape(-1, X.shape[2]))
    return np.array(rows)


def outside(value, rows):
    """Part of a functional that is no combination of some rows."""
    _, sizes, V = np.linalg.svd(rows, full_matrices=False)
    V = V[sizes > 1e-11 * sizes[0]]
    return float(np.linalg.norm(value - V.T @ (V @ value)) / np.linalg.norm(value))
