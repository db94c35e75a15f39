"""Least added matter against linear programs over cells, and against random searches.

    python -m tests.independent.least_matter_run cells --cases 100 --count 60000
    python -m tests.independent.least_matter_run search --cases 60

``cells`` asks for the least mass that balances forces, of a density that counts: cells of the
regions bound it from both sides (`tests.independent.filled_cells`). ``search`` asks for the
least mass, largest inertia, and rotor inertia, of points and of filled matter, and looks for
something better among mixtures of feasible designs: corners of linear programs with random
prices over points or cells of the regions. Half of the points have half the lever, and with
it scaled masses.
"""

from __future__ import annotations

import argparse
import random
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import linprog

import balance
from balance.masses.counterweights.added_program import added_objective, build_added_program
from tests.independent.counterweight_requests import random_request
from tests.independent.filled_cells import cells, least_masses
from tests.independent.second_counterweights import (
    conditions,
    given_parameters,
    point_parameters,
    samples,
    to_inertial,
)
from tests.support.points import point_counterweights

OBJECTIVES = ("mass", "inertia", "rotor")


def dense_request(seed: int, path: Path):
    """A random request that points balance, and a density that counts; None if they do not."""
    space, add, regions = random_request(seed, path)
    points = point_counterweights(space, add, regions, relax=False)
    if not points.weights:
        return None
    mean = max(weight.mean_density for weight in points.weights)
    return space, add, regions, mean * random.Random(seed).uniform(1.0, 8.0), points


def against_cells(seed: int, path: Path, count: int) -> tuple[str, float, float, float] | None:
    """Verdict, lower bound by cells, least mass, and upper bound by cells, kg."""
    request = dense_request(seed, path)
    if request is None:
        return None
    space, add, regions, density, _ = request
    found = balance.counterweights(space, add, regions, density=density, relax=False)
    lower, upper = least_masses(space, found.regions, density, count)
    mass = found.added_mass if found.weights else np.inf
    return found.verdict, lower, mass, upper


def searched(seed: int, path: Path, minimise: str, filled: bool, designs: int = 20_000):
    """Proved bound, value of the answer, and the least of random feasible designs.

    None if the request has no answer, or its matter no second feasible design.
    """
    request = dense_request(seed, path)
    if request is None:
        return None
    space, add, texts, density, _ = request
    given = 2.0 * density if filled else None
    found = balance.counterweights(space, add, texts, minimise, density=given, relax=False)
    if not found.weights:
        return None
    rng, rows = np.random.default_rng(seed), conditions(space)
    per_link = rows.reshape(len(rows), len(space.bodies), -1)
    columns, blocks, most = [], [], []
    for name, region in found.regions.items():
        x, own, cap = _matter(region, rng, given)
        columns.append(
            per_link[:, space.bodies.index(name)]
            @ point_parameters(space, to_inertial(space, name, x)).T
        )
        p = np.column_stack([region.to_unit(x), np.ones(len(x))])
        blocks.append(p[:, :, None] * p[:, None, :] + own)
        most.append(np.full(len(x), cap))
    A, target = np.hstack(columns), -rows @ given_parameters(space).reshape(-1)
    bounds = np.column_stack([np.zeros(A.shape[1]), np.concatenate(most)])
    corners = []
    for _ in range(24):
        answer = linprog(rng.uniform(0.1, 1.0, A.shape[1]), A_eq=A, b_eq=target, bounds=bounds)
        corners += [answer.x] if answer.status == 0 else []
    if len(corners) < 2:
        return None
    regions = {space.bodies.index(name): region for name, region in found.regions.items()}
    program = build_added_program(space, regions, minimise)
    ends = np.cumsum([0, *(len(block) for block in blocks)])
    moments = np.array(
        [
            [
                np.tensordot(m[a:b], block, 1) / program.unit
                for a, b, block in _parts(ends, blocks)
            ]
            for m in corners
        ]
    )
    least = np.inf
    for share in rng.dirichlet(np.full(len(corners), 0.2), size=designs):
        mixed = np.tensordot(share, moments, 1)
        value, _ = added_objective(program, list(mixed))
        least = min(least, value + found.price * program.unit * mixed[:, 3, 3].sum())
    return found.priced * (1.0 - found.gap), found.priced, least


def _matter(region, rng, density):
    """Points of a region or middles of its cells, own moments of a cell, and its mass."""
    if density is None:
        x = samples(region, rng, 300)
        half = region.centre + 0.5 * (x - region.centre)
        return np.concatenate([x, half]), np.zeros((4, 4)), np.inf
    middles, size, inside = cells(region, 3000)
    own, back = np.zeros((4, 4)), np.linalg.inv(region.place[:3, :3])
    own[:3, :3] = back @ np.diag(size**2 / 12.0) @ back.T
    return middles[inside], own, density * float(np.prod(size))


def _parts(ends, blocks):
    return zip(ends[:-1], ends[1:], blocks, strict=True)


def main() -> None:
    """Compare questions, and print a row for each."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=("cells", "search"))
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=60_000)
    options = parser.parse_args()
    seed, done, bad, start = options.first, 0, 0, time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        while done < options.cases:
            path = Path(folder) / "a.urdf"
            if options.what == "cells":
                row = against_cells(seed, path, options.count)
                label = "" if row is None else row[0]
                numbers = () if row is None else row[1:]
            else:
                label = f"{OBJECTIVES[done % 3]} {'filled' if done // 3 % 2 else 'points'}"
                numbers = searched(seed, path, *label.split()[:1], done // 3 % 2 == 1) or ()
            if numbers:
                low, value, high = numbers
                wrong = not (low <= value * (1.0 + 1e-8) and value <= high * (1.0 + 1e-8))
                bad, done = bad + wrong, done + 1
                print(
                    f"{seed:4d} {label:16s} {low:12.7g} {value:12.7g} {high:12.7g}", flush=True
                )
                if wrong:
                    print(f"seed {seed}: out of order", flush=True)
            seed += 1
    print(f"{done} questions, {bad} out of order, {time.perf_counter() - start:.0f} s")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
