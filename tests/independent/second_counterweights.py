"""Counterweights by second routes: cvxpy, plain linear programs over points, own certificates.

Nothing here uses `balance.added_masses` beyond the data of a region: point masses, cones and
conditions are written anew. ``python tests/independent/second_counterweights.py --cases 120``
compares that many random requests.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from pathlib import Path

import cvxpy as cp
import numpy as np
from scipy.linalg import null_space
from scipy.optimize import linprog, minimize

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))
    sys.path.insert(0, str(Path(__file__).parents[2]))

from small_linkages import small_linkage

import balance

__all__ = ["by_cvxpy", "by_points", "certificate_fault", "random_request", "samples"]


def random_request(seed: int, path: Path):
    """A space, links to add matter to, and texts of regions; all of them follow from a seed."""
    rng = random.Random(seed)
    space = balance.design_space(str(small_linkage(rng, path)), balance="force")
    names = list(space.bodies)
    add = rng.sample(names, rng.randint(1, len(names)))
    return space, add, {name: random_region(rng) for name in add if rng.random() < 0.8}


def random_region(rng: random.Random) -> str:
    """A region near the origin of the link: a ball, a box, a cylinder or an ellipsoid."""
    x, y, z = (round(rng.uniform(-0.6, 0.6), 3) for _ in range(3))
    a, b, c = (round(rng.uniform(0.1, 0.8), 3) for _ in range(3))
    u, v, w = (round(rng.uniform(-1.0, 1.0), 3) for _ in range(3))
    return rng.choice((
        f"ball({x},{y},{z},{a})",
        f"box({x - a}:{x + a},{y - b}:{y + b},{z - c}:{z + c})",
        f"cylinder({x},{y},{z},{u},{v},{w},{a},{b})",
        f"ellipsoid({x},{y},{z},{a},{b},{c},{u},{v},{w})",
    ))  # fmt: skip


def conditions(space):
    """Orthonormal rows that vanish on the space, in the units of its chain."""
    if space.scaled_basis.shape[1] == 0:
        return np.eye(len(space.scaled_basis))
    return null_space(space.scaled_basis.T).T


def point_parameters(space, points):
    """Counted parameters (n, count) of unit masses at points (n, 3) of the inertial frame."""
    frame = space.chain.frame
    x = (points - frame.origin) @ frame.R.T / frame.length
    if "Exx" not in space.labels:
        flat = x[:, :2] if space.planar else x
        columns = [np.ones((len(x), 1)), flat]
        if "Ezz" in space.labels:
            columns.append((flat**2).sum(axis=1, keepdims=True))
        return np.hstack(columns)
    a, b, c = x.T
    return np.column_stack([np.ones(len(x)), x, b * b + c * c, a * a + c * c, a * a + b * b,
                            -a * b, -a * c, -b * c])  # fmt: skip


def given_parameters(space):
    """Counted parameters (bodies, count) of the masses in the file, from point masses."""
    from scipy.linalg import eigh

    found = []
    for body in space.linkage.bodies:
        m, mc, E = body.inertia[0], body.inertia[1:4], body.inertia[4:]
        J = np.array([[E[0], E[3], E[4]], [E[3], E[1], E[5]], [E[4], E[5], E[2]]])
        P = np.zeros((4, 4))
        P[:3, :3], P[:3, 3], P[3, :3], P[3, 3] = 0.5 * np.trace(J) * np.eye(3) - J, mc, mc, m
        # Any split into signed products gives the parameters, which are linear.
        w, V = eigh(P + 0.0)
        total = np.zeros(len(space.labels))
        for value, p in zip(w, V.T, strict=True):
            if abs(p[3]) > 1e-9:
                total += value * p[3] ** 2 * point_parameters(space, (p[:3] / p[3])[None])[0]
            else:  # a pure second moment: the limit of two far masses
                far = point_parameters(space, np.array([p[:3], -p[:3], np.zeros(3)]))
                total += value * (0.5 * (far[0] + far[1]) - far[2])
        found.append(total)
    return np.array(found)


def to_inertial(space, name, points):
    """Points (n, 3) of a link frame in the inertial frame."""
    F = space.frames[space.bodies.index(name)]
    return points @ F[:3, :3].T + F[:3, 3]


def samples(region, rng, count):
    """Random points (n, 3) of the link frame inside a region, many on its surface."""
    if region.kind in ("box", "hull"):
        w = rng.dirichlet(np.full(len(region.vertices), 0.3), size=count)
        u = np.vstack([region.vertices, w @ region.vertices])
    elif region.kind == "cylinder":
        turn, r = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(0, 1, count))
        r[: count // 2] = 1.0
        h = rng.uniform(-1, 1, count)
        h[::3] = np.sign(h[::3])
        u = np.column_stack([r * np.cos(turn), r * np.sin(turn), h])
    else:
        u = rng.normal(size=(count, 3))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        u[count // 2 :] *= rng.uniform(0, 1, (count - count // 2, 1)) ** (1 / 3)
    return u @ region.place[:3, :3].T + region.place[:3, 3]


def by_cvxpy(space, regions):
    """Verdict and least added mass for force balance, from cones over (m, mc) of each link."""
    C, given = conditions(space), given_parameters(space)
    count, unit = len(space.labels), given[:, 0].sum() / len(given)
    total, limits, masses = C @ (given.reshape(-1) / unit), [], []
    for name, region in regions.items():
        m, s = cp.Variable(nonneg=True), cp.Variable(3)
        masses.append(m)
        A, centre = region.place[:3, :3], region.place[:3, 3]
        # s is the first moment in unit coordinates: m u.
        if region.kind == "cylinder":
            limits += [cp.norm(s[:2]) <= m, cp.abs(s[2]) <= m]
        elif region.kind in ("box", "hull"):
            w = cp.Variable(len(region.vertices), nonneg=True)
            limits += [s == region.vertices.T @ w, m == cp.sum(w)]
        else:
            limits.append(cp.norm(s) <= m)
        b = space.bodies.index(name)
        at = point_parameters(
            space, to_inertial(space, name, np.vstack([centre, centre + A.T]))
        )
        slope = (at[1:] - at[0]).T
        total = total + C[:, b * count : (b + 1) * count] @ (at[0] * m + slope @ s)
    size = np.abs(C @ (given.reshape(-1) / unit)).max()
    problem = cp.Problem(cp.Minimize(cp.sum(cp.hstack(masses))), [*limits, total == 0])
    for solver, options in ((cp.CLARABEL, {}), (cp.SCS, {"eps": 1e-9, "max_iters": 50_000})):
        try:
            problem.solve(solver=solver, **options)
            break
        except cp.error.SolverError:
            continue
    else:
        return "unsolved", None, size
    if problem.status.startswith("optimal"):
        return "feasible", float(problem.value) * unit, size
    return problem.status.removesuffix("_inaccurate"), None, size


def by_points(space, regions, rng, count=20_000):
    """Least added mass over random points, and a bound that its dual proves, by HiGHS."""
    C, given = conditions(space), given_parameters(space)
    width, columns, places = len(space.labels), [], []
    for name, region in regions.items():
        x = samples(region, rng, count)
        b = space.bodies.index(name)
        own = C[:, b * width : (b + 1) * width]
        places.append((own, name, region))
        columns.append(own @ point_parameters(space, to_inertial(space, name, x)).T)
    A = np.hstack(columns)
    found = linprog(np.ones(A.shape[1]), A_eq=A, b_eq=-C @ given.reshape(-1), method="highs")
    if found.status != 0:
        return None, None
    y = found.eqlin.marginals
    worst = 0.0
    for own, name, region in places:
        x = samples(region, rng, count)
        price = 1.0 - point_parameters(space, to_inertial(space, name, x)) @ (own.T @ y)
        worst = min(worst, float(price.min()))
    # y / (1 + error) is feasible for all points, up to the points between the fresh ones.
    return float(found.fun), float(found.fun) / (1.0 - 2.0 * worst)


def certificate_fault(found, rng, count=4000):
    """What is wrong with a certificate; empty if it proves its verdict."""
    space, w = found.space, np.asarray(found.certificate)
    if not np.abs(space.scaled_basis.T @ w).max() <= 1e-12 * np.linalg.norm(w):
        return "not zero on balanced distributions"
    given = given_parameters(space)
    left = -float(w @ given.reshape(-1))
    if not left > 0.0:
        return "not negative on the given masses"
    allowed = left / (1e6 * given[:, 0].sum())
    for name, region in found.regions.items():
        b, width = space.bodies.index(name), len(space.labels)
        own = w[b * width : (b + 1) * width]

        def value(x, name=name, own=own):
            return float(point_parameters(space, to_inertial(space, name, x[None]))[0] @ own)

        x = samples(region, rng, count)
        all_values = point_parameters(space, to_inertial(space, name, x)) @ own
        if all_values.max() > allowed:
            return f"positive in the region of {name}: {all_values.max():.1e}"
        if region.kind in ("ball", "ellipsoid"):
            A, centre = region.place[:3, :3], region.place[:3, 3]

            def negative(u, A=A, centre=centre, value=value):
                return -value(centre + A @ (u / max(1.0, np.linalg.norm(u))))

            start = np.linalg.solve(A, x[np.argmax(all_values)] - centre)
            if -minimize(negative, start, method="Nelder-Mead").fun > allowed:
                return f"positive in the region of {name}"
    return ""


def compare(seed: int, folder: Path) -> str:
    """What two routes disagree about for one request; empty if they agree."""
    space, add, texts = random_request(seed, folder / f"{seed}.urdf")
    found = balance.counterweights(space, add, texts, relax=False)
    verdict, mass, size = by_cvxpy(space, found.regions)
    if size <= 1e-9:
        return "" if found.verdict == "feasible" else f"{found.verdict}, but balanced as given"
    if found.verdict != verdict and verdict != "unsolved":
        return f"{found.words} here, {verdict} by cvxpy"
    if mass is not None and abs(mass - found.added_mass) > 1e-5 * max(mass, 1e-3):
        return f"{found.added_mass} kg here, {mass} kg by cvxpy"
    if found.verdict == "infeasible":
        return certificate_fault(found, np.random.default_rng(seed))
    return ""


def main() -> None:
    """Compare random requests and print how they end."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=120)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    bad, ends = 0, {}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.first, options.first + options.cases):
            fault = compare(seed, Path(folder))
            ends[fault[:10] or "agree"] = ends.get(fault[:10] or "agree", 0) + 1
            if fault:
                bad += 1
                print(f"seed {seed}: {fault}")
    print(f"{options.cases} requests, {bad} disagreements, {ends}")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
