"""Four-bars with known pivots, and the motion of the joints of a file of one."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np


def place_tips(alpha, lengths, side):
    """Tips of crank and rocker for angles of the crank from the base, from 0 to 1."""
    a, b, c = lengths
    A = a * np.exp(1j * np.asarray(alpha))
    gap = np.abs(1.0 - A)
    along = (b**2 - c**2 + gap**2) / (2.0 * gap)
    return A, A + (along + 1j * side * np.sqrt(b**2 - along**2)) * (1.0 - A) / gap


def planted_loop(count, seed, longest=1.2):
    """A four-bar on 0 and 1 with few folded poses: crank angles, lengths and side.

    Transmission angles stay above 17°, twice the bound of the product. Also the generator.
    """
    rng = np.random.default_rng(seed)
    while True:
        a, b, c = rng.uniform(0.2, longest, 3)
        turned = np.concatenate([[0.0], np.sort(rng.uniform(0.3, 3.5, count - 1))])
        alpha = rng.uniform(0.0, 2.0 * np.pi) + rng.choice([-1.0, 1.0]) * turned
        way = np.abs(1.0 - a * np.exp(1j * np.linspace(alpha[0], alpha[-1], 400)))
        if np.abs((b**2 + c**2 - way**2) / (2.0 * b * c)).max() > np.cos(0.3):
            continue
        side = rng.choice([-1.0, 1.0])
        if np.diff(turned).min() > (0.2 if count < 6 else 0.1):
            return alpha, (a, b, c), side, rng


def planted_point(count, seed):
    """A four-bar and a point of its coupler: crank angles, both tips, the point, its arm."""
    for extra in range(1000):
        alpha, lengths, side, rng = planted_loop(count, [seed, extra])
        A, B = place_tips(alpha, lengths, side)
        arm = complex(*rng.normal(size=2))
        points = A + arm * (B - A)
        if np.abs(points - points[0]).max() > 0.3:
            return alpha, A, B, points, arm
    raise AssertionError("no such four-bar")


def planted_function(count, seed):
    """A four-bar as a function: angles of crank and rocker, continued, and both tips."""
    alpha, lengths, side, _ = planted_loop(count, seed, 2.0)
    way = np.linspace(alpha[0], alpha[-1], 2001)
    psi = np.unwrap(np.angle(place_tips(way, lengths, side)[1] - 1.0))
    A, B = place_tips(alpha, lengths, side)
    near = np.interp(np.abs(alpha - alpha[0]), np.abs(way - way[0]), psi)
    exact = np.angle(B - 1.0)
    return alpha, exact + 2.0 * np.pi * np.round((near - exact) / (2.0 * np.pi)), A, B


def vector(element):
    x, y, _ = map(float, element.find("origin").get("xyz").split())
    return complex(x, y)


def move_file(urdf, angles):
    """Tools and turns of rockers of a file, its crank turned by angles.

    Newton's method on the loop, in small steps, so that the branch of the file is kept. The
    tool is on the coupler or on the rocker.
    """
    root = ElementTree.fromstring(urdf)
    at = {each.get("name"): vector(each) for each in root.iter("joint")}
    carrier = root.find("joint[@name='tool_fixed']").find("parent").get("link")
    loop = root.find("loop")
    on_coupler, on_rocker = vector(loop.find("predecessor")), vector(loop.find("successor"))
    coupler = rocker = last = 0.0
    points, turns = [], []
    for goal in angles:
        for angle in np.linspace(last, goal, 25)[1:] if goal != last else [goal]:
            for _ in range(8):
                tip = at["crank_joint"] + np.exp(1j * angle) * at["coupler_joint"]
                arm = np.exp(1j * coupler) * on_coupler
                leg = np.exp(1j * rocker) * on_rocker
                gap = tip + arm - at["rocker_joint"] - leg
                columns = np.array([1j * arm, -1j * leg])
                step = np.linalg.solve(
                    np.array([columns.real, columns.imag]), [gap.real, gap.imag]
                )
                coupler, rocker = coupler - step[0], rocker - step[1]
            assert abs(gap) < 1e-12
        last = goal
        foot, turn = (tip, coupler) if carrier == "coupler" else (at["rocker_joint"], rocker)
        points.append(foot + np.exp(1j * turn) * at["tool_fixed"])
        turns.append(rocker)
    return np.array(points), np.array(turns)
