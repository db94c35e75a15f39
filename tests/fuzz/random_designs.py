"""Random questions about designs: each verdict is checked by a route that shares nothing.

``python -m tests.fuzz.random_designs --cases 1500 --seed 0`` asks as many as it is told; a seed
stands for the cases that follow it. Momentum is that of `reference` at finite poses closed by
its own Newton method, cones, bounds and balls are written out here once more, and what the
product leaves undecided is put to solvers of its own.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

import kinematics
from balance import design_space
from balance.masses.designs.best_design import Design
from kinematics.errors import LinkageError
from tests.independent import reference
from tests.independent.second_solvers import second_opinion
from tests.support import balls
from tests.support.designs import design_of_any_density
from tests.support.shapes import functional, matrix, outside
from tests.support.small_linkages import small_linkage

MODELS = (
    "four_bar_general four_bar_kite four_bar_kite_balanced four_bar_antiparallelogram "
    "four_bar_antiparallelogram_balanced four_bar_parallelogram slider_crank five_bar hprs "
    "bennett rusr fuga_i pantograph six_bar_watt four_bar_spherical three_rrr two_rrr"
).split()
POSES, REACH = 8, 0.25
# Parts of a functional that no momentum has, and of a momentum that is not zero.
CLOSE, STILL = 1e-7, 1e-9
# Eigenvalues, over the size of a certificate, that count as zero.
ZERO = 1e-11
# Notices of a reference pose that is not that of the file.
MOVED = {"left_singular_pose", "assembled"}


class Question(NamedTuple):
    """What is asked: a linkage, a kind of balance, links that are kept, bounds on masses, and
    the radius of the balls in which the others are to be, in lengths of the links.
    """

    model: str
    balance: str
    keep: tuple[str, ...]
    bounds: dict[str, tuple[float, float]]
    within: float | None = None


def question(seed: int, folder: Path, uneven: bool = False) -> Question:
    """The question of a seed; ``uneven`` spreads masses and bounds over powers of ten."""
    rng = random.Random(seed)
    if rng.random() < 0.35:
        model = rng.choice(MODELS)
    else:
        model = str(small_linkage(rng, folder / f"small_{seed}.urdf", uneven))
    balance = rng.choice(("dynamic", "force"))
    names = [name for name, _ in _bodies(model)]
    keep = rng.sample(names, rng.choice((0, 0, 1, 1, 2)) % len(names))
    free = [name for name in names if name not in keep]
    bounded = rng.sample(free, rng.choice((0, 1, 1, 2, 3)) % (len(free) + 1))
    masses = {
        name: mass * (10.0 ** rng.uniform(-4, 4) if uneven else 1.0)
        for name, mass in _bodies(model)
    }
    bounds = {b: _range(rng, masses[b]) for b in bounded}
    within = rng.choice((None, 0.6, 1.0, 1.5, 1.5, 3.0))
    return Question(model, balance, tuple(keep), bounds, within)


def _bodies(model: str) -> list[tuple[str, float]]:
    """Names of the bodies, and their masses, by the second reading."""
    found = reference.load(_source(model), _any_input(model))
    return list(zip(found.bodies, found.inertias[:, 0].tolist(), strict=True))


def _source(model: str) -> str | Path:
    return model if model in MODELS else Path(model)


def _any_input(model: str) -> tuple[str, ...]:
    return () if model in MODELS else ("j1",)


def _range(rng: random.Random, mass: float) -> tuple[float, float]:
    low = float(f"{rng.uniform(0.0, 2.0) * mass:.4g}")
    high = float(f"{low + rng.uniform(0.05, 2.0) * mass:.4g}")
    wide = 0.01 * low, 9.0 * high
    return rng.choice(((low, high), (0.0, high), (low, inf), (high, high), wide))


def asked(one: Question) -> Design | None:
    """The product's answer; None if it refuses, or takes another pose as its reference."""
    try:
        space = _space(one.model, one.balance)
        if MOVED & {notice.code for notice in space.notices}:
            return None
        return design_of_any_density(space, keep=one.keep, bounds=one.bounds, within=one.within)
    except LinkageError:
        return None


@cache
def _space(model: str, balance: str):
    return design_space(kinematics.load(model), balance=balance)


@cache
def mechanism_of(model: str, inputs: tuple[str, ...], names: tuple[str, ...]):
    """The linkage by the second reading, its bodies in some order."""
    found = reference.load(_source(model), inputs)
    at = [found.bodies.index(name) for name in names]
    assert len(at) == len(found.bodies)
    links = tuple(found.links[b] for b in at)
    return replace(found, bodies=names, links=links, inertias=found.inertias[at])


def follow(mechanism, start, u):
    """Joint positions at a pose on the way to u: nearer, where a singular pose is near."""
    for part in (1.0, 0.1, 0.01):
        try:
            return reference.follow(mechanism, start, part * u)
        except ValueError:
            continue
    return reference.follow(mechanism, start, 0.001 * u)


@cache
def rows_of(model: str, balance: str, inputs: tuple[str, ...], names: tuple[str, ...]):
    """Momentum at finite poses per parameter, ten of each body (rows, 10 bodies)."""
    mechanism = mechanism_of(model, inputs, names)
    rng, unit = np.random.default_rng(5), np.eye(len(inputs))
    rows, start = [], np.zeros(len(mechanism.joints))
    for u in rng.uniform(-REACH, REACH, (POSES, len(inputs))):
        q = follow(mechanism, start, u)
        moving = reference.velocities(mechanism, q, unit)
        X = reference.regressor(mechanism, q, moving, "dynamic")
        rows.append(X.reshape(len(inputs), 6, -1)[:, 3 * (balance == "force") :])
    return np.concatenate([block.reshape(-1, block.shape[-1]) for block in rows])


def check(one: Question, found: Design) -> str:
    """The verdict, once it has been checked.

    Raises:
        AssertionError: it is wrong, or undecided where others decide it.
    """
    mechanism = mechanism_of(one.model, found.space.inputs, found.space.bodies)
    rows = rows_of(one.model, one.balance, found.space.inputs, found.space.bodies)
    forms = forms_of(one, found.space, mechanism)
    if found.verdict == "feasible":
        _check_design(one, found.z, rows, mechanism, forms)
    elif found.verdict == "infeasible":
        _check_certificate(one, found, rows, mechanism, forms)
    else:
        settled = second_opinion(one, rows, mechanism, forms)
        assert settled == "undecided", f"undecided, but {settled}: {found.words}"
    return found.verdict + _check_anywhere(one, found)


def _check_anywhere(one: Question, found: Design) -> str:
    """The second verdict: there is one exactly if there may be a design beyond the balls."""
    beyond = found.anywhere
    if beyond is None:
        assert found.verdict != "infeasible" or not found.multipliers.any()
        return ""
    assert one.within is not None and found.verdict != "feasible"
    assert beyond.verdict in ("feasible", "undecided")
    check(one._replace(within=None), beyond)
    return f" within, {beyond.verdict} anywhere"


def forms_of(one: Question, space, mechanism) -> dict[str, np.ndarray]:
    """``∫ (r² - |x - c|²) dm`` of each body that is not kept, per parameter (10,)."""
    if one.within is None:
        return {}
    flat, found = balls.still(space), {}
    for name in set(mechanism.bodies) - set(one.keep):
        places = balls.places(mechanism, name) @ flat
        centre, radius = balls.ball(places, one.within, space.length)
        found[name] = balls.inside(centre, radius, flat)
    return found


def _check_design(one: Question, z, rows, mechanism, forms) -> None:
    """Momentum vanishes, bodies are definite, what is asked is heeded."""
    left = np.abs(rows @ z.reshape(-1)).max()
    assert left <= STILL * np.abs(rows).max() * np.abs(z).sum(), f"momentum {left:.1e}"
    for b, name in enumerate(mechanism.bodies):
        if name in one.keep:
            assert np.allclose(z[b], mechanism.inertias[b], rtol=1e-12, atol=1e-14)
        else:
            assert np.linalg.eigvalsh(matrix(z[b]))[0] > 0.0
        if name in forms:
            terms = forms[name] * z[b]
            assert terms.sum() >= -1e-7 * np.abs(terms).sum(), f"{name} beyond its ball"
        low, high = one.bounds.get(name, (0.0, inf))
        assert low * (1.0 - 1e-7) <= z[b, 0] <= high * (1.0 + 1e-7), name


def _check_certificate(one: Question, found: Design, rows, mechanism, forms) -> None:
    """It vanishes on balanced masses, and is positive on what is asked for.

    In balls, their forms with multipliers that are not negative belong to it.
    """
    Z, area = np.array(found.certificate), found.space.length**2
    value = functional(found.space, Z)
    for b, name in enumerate(mechanism.bodies):
        assert found.multipliers[b] >= 0.0 and (name in forms or not found.multipliers[b])
        if name in forms:
            value[10 * b : 10 * b + 10] += found.multipliers[b] * forms[name] / area
    if one.balance == "force" or found.space.planar:
        # What no condition sees must not count.
        seen = np.abs(rows).max(axis=0) > 0.0
        assert np.abs(value[~seen]).max(initial=0.0) <= CLOSE * np.abs(value).max()
    assert outside(value, rows) < CLOSE
    least, weight, scale = 0.0, 0.0, np.abs(Z).sum()
    for b, name in enumerate(mechanism.bodies):
        if name in one.keep:
            z = mechanism.inertias[b]
            least += float(value[10 * b : 10 * b + 10] @ z)
            continue
        low, high = one.bounds.get(name, (0.0, inf))
        surplus = _per_mass(Z[b], scale)
        if name not in one.bounds:
            assert surplus >= -ZERO * scale, name
        elif abs(surplus) > ZERO * scale:
            least += min(surplus * low, surplus * high)
        weight += float(np.trace(Z[b]))
    assert least >= -ZERO * scale, least
    assert least > ZERO * scale or weight > ZERO * scale


def _per_mass(Z, scale: float) -> float:
    """The least of ``<Z, P>`` over matrices P that are positive semidefinite, of mass 1.

    That is the largest λ for which Z stays positive semidefinite if λ is taken from its
    corner: found by bisection, with eigenvalues alone.
    """
    corner = np.zeros_like(Z)
    corner[-1, -1] = 1.0

    def definite(part: float) -> bool:
        noise = max(ZERO, 1e-15 * abs(part)) * scale
        return bool(np.linalg.eigvalsh(Z - part * scale * corner)[0] > -noise)

    low, high = -1.0, 1.0
    while not definite(low):
        low *= 10.0
        assert low > -1e9, "not definite"
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if definite(middle) else (low, middle)
    return low * scale


def run(seeds: range, uneven: bool = False):
    """Ask questions; yields the seed, the question, how it ends, and what is wrong."""
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            one = question(seed, Path(folder), uneven)
            if one.model not in MODELS:
                _space.cache_clear()
                rows_of.cache_clear()
            mechanism_of.cache_clear()
            try:
                found = asked(one)
                yield seed, one, "skipped" if found is None else check(one, found), ""
            except Exception as error:
                yield seed, one, "wrong", f"{type(error).__name__}: {error}"


def main() -> int:
    """Ask questions from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--uneven", action="store_true", help="masses over powers of ten")
    cases, begin, counts = parser.parse_args(), time.perf_counter(), Counter()
    seeds = range(cases.seed, cases.seed + cases.cases)
    for seed, one, end, wrong in run(seeds, cases.uneven):
        counts[f"{one.balance} {end}"] += 1
        if wrong:
            print(f"seed {seed}: {one}: {wrong}", flush=True)
    failed = sum(count for end, count in counts.items() if end.endswith("wrong"))
    print(
        f"{cases.cases} questions from seed {cases.seed} in "
        f"{time.perf_counter() - begin:.0f} s, {failed} wrong"
    )
    print("  ".join(f"{name} ×{count}" for name, count in sorted(counts.items())))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
