"""Counterweights by second routes: cvxpy, plain linear programs over points, own certificates.

Nothing here uses `balance.masses.counterweights` beyond the data of a region: point masses,
cones and conditions are written anew.
``python -m tests.independent.second_counterweights --cases 120`` compares that many random
requests; with ``--balance dynamic``, of dynamic balance.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import linprog, minimize
from scipy.spatial import Delaunay

from tests.independent.counterweight_requests import random_request
from tests.support.points import point_counterweights


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
    return np.column_stack(
        [
            np.ones(len(x)),
            x,
            b * b + c * c,
            a * a + c * c,
            a * a + b * b,
            -a * b,
            -a * c,
            -b * c,
        ]
    )


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


def first_moments(region):
    """Mass, its first moment in unit coordinates (m, m u), and exact limits on them."""
    import cvxpy as cp

    m, s = cp.Variable(nonneg=True), cp.Variable(3)
    if region.kind == "cylinder":
        return m, s, [cp.norm(s[:2]) <= m, cp.abs(s[2]) <= m]
    if region.kind in ("box", "hull"):
        w = cp.Variable(len(region.vertices), nonneg=True)
        return m, s, [s == region.vertices.T @ w, m == cp.sum(w)]
    return m, s, [cp.norm(s) <= m]


def second_moments(region):
    """A matrix of moments (4, 4) in unit coordinates; limits, exact but for cylinders.

    Boxes are split by another triangulation. Those of cylinders hold for all matter inside,
    but not only for it.
    """
    import cvxpy as cp

    if region.kind in ("box", "hull"):
        parts, limits = [], []
        for corners in Delaunay(region.vertices, qhull_options="Qbb Qc Qz Qt").simplices:
            V = np.vstack([region.vertices[corners].T, np.ones(4)])
            if abs(np.linalg.det(V)) > 1e-9:
                Y = cp.Variable((4, 4), PSD=True)
                limits.append(Y >= 0)
                parts.append(V @ Y @ V.T)
        return sum(parts), limits
    P = cp.Variable((4, 4), PSD=True)
    if region.kind != "cylinder":
        return P, [P[3, 3] >= P[0, 0] + P[1, 1] + P[2, 2]]
    limits = [P[3, 3] >= P[0, 0] + P[1, 1], P[3, 3] >= P[2, 2]]
    for sign in (-1.0, 1.0):  # (1 - z) (1 - |xy|) and (1 + z) (1 - |xy|) are not negative
        limits.append(cp.norm(P[:2, 3] + sign * P[:2, 2]) <= P[3, 3] + sign * P[2, 3])
    return P, limits


def quadratic_parameters(space, name, region):
    """Matrices (count, 4, 4) of the counted parameters of a unit mass at u, by fitting."""
    corners = [np.eye(3)[i] + np.eye(3)[j] for i in range(3) for j in range(i + 1, 3)]
    u = np.vstack([np.zeros(3), np.eye(3), -np.eye(3), corners])
    p = np.column_stack([u, np.ones(len(u))])
    i, j = np.triu_indices(4)
    products = p[:, i] * p[:, j]
    place = u @ region.place[:3, :3].T + region.place[:3, 3]
    fitted = np.linalg.solve(products, point_parameters(space, to_inertial(space, name, place)))
    found = np.zeros((fitted.shape[1], 4, 4))
    found[:, i, j] += 0.5 * fitted.T
    found[:, j, i] += 0.5 * fitted.T
    return found


def by_cvxpy(space, regions, move=None):
    """Verdict and least added mass, from cones over the moments of each link.

    Shares of the given masses in ``move`` may be taken, at a hundredth of the price, if at
    least their mass is placed on the link again.
    """
    import cvxpy as cp

    C, given = conditions(space), given_parameters(space)
    count, unit = len(space.labels), given[:, 0].sum() / len(given)
    total, limits, masses = C @ (given.reshape(-1) / unit), [], []
    for name, region in regions.items():
        b = space.bodies.index(name)
        own = C[:, b * count : (b + 1) * count]
        forms = quadratic_parameters(space, name, region)
        if space.balance == "force":
            m, s, more = first_moments(region)
            total = total + own @ (forms[:, 3, 3] * m + 2.0 * forms[:, 3, :3] @ s)
        else:
            P, more = second_moments(region)
            m = P[3, 3]
            total = total + own @ forms.reshape(count, 16) @ cp.vec(P, order="C")
        limits += more
        masses.append(m)
        if move and name in move:
            theta, mass = cp.Variable(nonneg=True), given[b, 0] / unit
            limits += [theta <= move[name], m >= theta * mass]
            total = total - own @ given[b] / unit * theta
            masses.append(-0.99 * mass * theta)
    size = np.abs(C @ (given.reshape(-1) / unit)).max()
    problem = cp.Problem(cp.Minimize(cp.sum(cp.hstack(masses))), [*limits, total == 0])
    for solver, options in ((cp.CLARABEL, {}), (cp.SCS, {"eps": 1e-9, "max_iters": 50_000})):
        try:
            problem.solve(solver=solver, **options)
        except cp.error.SolverError:
            continue
        if not problem.status.endswith("_inaccurate"):
            break
    status = problem.status or "unsolved"
    if status == "optimal":
        return "feasible", float(problem.value) * unit, size
    return (status if status == "infeasible" else "unsolved"), None, size


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


def compare(seed: int, folder: Path, balanced: str = "force") -> str:
    """What two routes disagree about for one request; empty if they agree.

    It begins with "unsolved" if neither of two conic solvers answers, and with "between" if
    limits on cylinders leave a verdict open.
    """
    space, add, texts = random_request(seed, folder / f"{seed}.urdf", balanced)
    found = point_counterweights(space, add, texts, relax=False)
    space, rng = found.space, np.random.default_rng(seed)
    verdict, mass, size = by_cvxpy(space, found.regions)
    if size <= 1e-9:
        return "" if found.verdict == "feasible" else f"{found.verdict}, but balanced as given"
    if found.verdict == "infeasible" and (fault := certificate_fault(found, rng)):
        return fault
    if found.verdict == "feasible" and (fault := answer_fault(found)):
        return fault
    if verdict == "unsolved":
        return f"unsolved by cvxpy, {found.verdict} here"
    round_ones = [one for one in found.regions.values() if one.kind == "cylinder"]
    if balanced == "dynamic" and round_ones and verdict == "feasible":
        if found.verdict == "infeasible":
            return "between: limits on cylinders are met, and a certificate holds"
        if found.verdict == "feasible" and mass <= found.added_mass * (1 + 1e-6):
            return ""
    if found.verdict != verdict:
        return f"{found.words} here, {verdict} by cvxpy"
    if mass is not None and abs(mass - found.added_mass) > 1e-5 * max(mass, 1e-3):
        return f"{found.added_mass} kg here, {mass} kg by cvxpy"
    return ""


def answer_fault(found):
    """What is wrong with counterweights; empty if their matter is inside and balances."""
    space = found.space
    total = given_parameters(space)
    for weight in found.weights:
        region = weight.region
        if weight.lumps:
            x = np.array([lump.position for lump in weight.lumps])
            if not region.contains(x, 1e-9).all():
                return f"a lump of {weight.link} is outside its region"
            own = np.array([lump.mass for lump in weight.lumps]) @ point_parameters(
                space, to_inertial(space, weight.link, x)
            )
        else:
            c, w, V = weight.com, *np.linalg.eigh(weight.inertia)
            half = np.sqrt(np.maximum(0.5 * w.sum() - w, 0.0) / weight.mass) * np.sqrt(3.0)
            x = np.vstack([c + half[i] * V[:, i] * s for i in range(3) for s in (-1, 1)])
            own = (
                weight.mass
                / 6.0
                * point_parameters(space, to_inertial(space, weight.link, x)).sum(axis=0)
            )
        total[space.bodies.index(weight.link)] += own
    left = np.abs(conditions(space) @ total.reshape(-1)).max()
    if left > 1e-9 * np.linalg.norm(total, axis=1).sum():
        return f"the conditions are missed by {left:.1e}"
    return ""


def main() -> None:
    """Compare random requests and print how they end."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=120)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--balance", choices=("force", "dynamic"), default="force")
    options = parser.parse_args()
    bad, ends = 0, Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.first, options.first + options.cases):
            fault = compare(seed, Path(folder), options.balance)
            left_open = fault.startswith(("unsolved", "between"))
            ends[fault.split()[0] if left_open else "differ" if fault else "agree"] += 1
            bad += bool(fault) and not left_open
            if fault:
                print(f"seed {seed}: {fault}", flush=True)
    print(f"{options.cases} requests, {bad} disagreements, {dict(ends)}")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
