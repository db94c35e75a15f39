"""Conditions of requirements by the second route: clouds of points at finite poses.

Nothing of the product is used but its grammar, which is written out here again.
"""

from __future__ import annotations

import numpy as np

from tests.independent.reference import (
    decoupling_rows,
    follow,
    motion_basis,
    regressor,
    velocities,
)

POSES, REACH = 14, 0.3
# Samples on the circle of complex inputs that gives derivatives, and its radius.
SAMPLES, RADIUS = 32, 0.08


def components(quantity, spatial, gravity):
    """Rows on ``[ξ; p]`` about the origin: what a quantity is about."""
    name, _, rest = quantity.partition(" ")
    words, _, point = rest.partition("about ")
    axes = ["xyz".index(axis) for axis in words.replace(",", " ").split() or "xyz"]
    if name == "gravity":
        return np.concatenate([np.zeros(3), gravity])[None]
    forces = np.eye(6)[3:][axes]
    if name == "force":
        return forces
    centre = np.array([float(x) for x in point.split(",")]) if point else np.zeros(3)
    # n · (ξ - c × p) = n · ξ - (n × c) · p
    turning = axes if spatial else [2]
    moments = np.array([[*np.eye(3)[i], *-np.cross(np.eye(3)[i], centre)] for i in turning])
    return np.concatenate([moments, forces]) if name == "dynamic" else moments


def parameters(mechanism, spatial, masses):
    """Columns that count, of ten parameters for each body."""
    columns = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9] if spatial else [0, 1, 2, 6]
    kept = [column for column in columns if column < 4 or not masses]
    return [10 * b + column for b in range(len(mechanism.links)) for column in kept]


def selected(mechanism, q, rates, select):
    """Selected components of the momentum, by motion."""
    X = regressor(mechanism, q, rates)
    return (select @ X.reshape(rates.shape[1], 6, -1)).reshape(-1, X.shape[1])


def region_of(text, names):
    """Quantity and region of the second route."""
    for word in (" along ", " up to ", " at "):
        quantity, found, rest = text.partition(word)
        if not found:
            continue
        if word == " at ":
            return quantity, f"at {rest}"
        if word == " along ":
            curved = "**" in rest
            return quantity, f"curve {rest}" if curved else f"along {rest}"
        order, _, pose = rest.removeprefix("order ").partition(" about ")
        values = dict(pair.split("=") for pair in pose.split(",")) if pose else {}
        return quantity, " ".join(["order", order, *(values.get(x, "0") for x in names)])
    return text, "along "


def poses_of(mechanism, region, rng, reach=REACH):
    """Poses of a region, and the rates of the inputs there, as pairs."""
    count = len(mechanism.inputs)
    names = [mechanism.joints[i] for i in mechanism.inputs]
    kind, _, text = region.partition(" ")
    if kind == "at":
        values = {name: float(x) for name, x in (pair.split("=") for pair in text.split(","))}
        yield np.array([values.get(name, 0.0) for name in names]), np.eye(count)
        return
    if kind == "curve":
        name, body = text.split("=")
        free = [other for other in names if other != name]
        for _ in range(POSES):
            y, h = rng.uniform(-reach, reach, len(free)), 1e-30

            def inputs(y, free=free, name=name, body=body):
                values = dict(zip(free, y, strict=True))
                values[name] = eval(body, {}, values)
                return np.array([values[other] for other in names])

            columns = [inputs(y + 1j * h * e).imag / h for e in np.eye(len(free))]
            yield inputs(y), np.array(columns).T
        return
    basis = motion_basis(mechanism, text.split(",") if text else ())
    for _ in range(POSES):
        yield basis @ rng.uniform(-reach, reach, basis.shape[1]), basis


def about(mechanism, order, goal, select, rng):
    """Taylor coefficients up to an order about a pose, along rays, by Cauchy's formula."""
    start = follow(mechanism, np.zeros(len(mechanism.joints)), goal)
    count = len(mechanism.inputs)
    for _ in range(8 if count > 1 else 1):
        ray = rng.standard_normal(count)
        ray /= np.linalg.norm(ray)
        circle = RADIUS * np.exp(2j * np.pi * np.arange(SAMPLES) / SAMPLES)
        blocks = []
        for t in circle:
            q = follow(mechanism, start.astype(complex), goal + t * ray)
            rates = velocities(mechanism, q, np.eye(count).astype(complex))
            blocks.append(selected(mechanism, q, rates, select))
        for k in range(order + 1):
            yield np.mean(
                [b * (t / RADIUS) ** -k for b, t in zip(blocks, circle, strict=True)], axis=0
            ).real


def _in_the_plane(width):
    """Rows of the momentum, and of the inertia on the base, that a plane has."""
    momenta = [6 * w + row for w in range(width) for row in (2, 3, 4)]
    return momenta + [6 * width + parameter for parameter in (0, 1, 2, 6)]


def rows_of(mechanism, quantity, region, spatial, gravity, seed, reach=REACH):
    """Conditions of a requirement (rows, 10 bodies), blocks of size 1."""
    rng, blocks = np.random.default_rng(seed), []
    if region.startswith("order"):
        _, order, *values = region.split()
        goal = np.array([float(x) for x in values])
        select = components(quantity, spatial, gravity)
        blocks = list(about(mechanism, int(order), goal, select, rng))
    else:
        start = np.zeros(len(mechanism.joints))
        for goal, basis in poses_of(mechanism, region, rng, reach):
            q = follow(mechanism, start, goal)
            rates = velocities(mechanism, q, basis)
            if quantity == "decoupled":
                X = decoupling_rows(mechanism, q, rates)
                kept = range(len(X)) if spatial else _in_the_plane(rates.shape[1])
                blocks.append(X[list(kept)])
            else:
                select = components(quantity, spatial, gravity)
                blocks.append(selected(mechanism, q, rates, select))
    return np.concatenate([block / (np.linalg.norm(block) or 1.0) for block in blocks])
