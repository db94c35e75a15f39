"""Formulas evaluated as printed, and masses in the frames that the documents describe."""

from __future__ import annotations

import numpy as np


def matrix(formulas, values):
    """Call the printed Python function with values of dimensions by name."""
    room = {}
    exec(compile(formulas.python(), "formulas", "exec"), room)
    function = room["conditions"]
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    return function(*(values[name] for name in names))


def file_values(answer):
    """Values of the dimensions in the file, by name, from the JSON of the formulas."""
    values = {}
    for each in answer["dimensions"]:
        x, y = (*each["value"], 0.0)[:2]
        values[each["name"]] = complex(x, y) if each["kind"] == "point" else x
        if each["kind"] == "point":
            values["x" + each["name"][1:]], values["y" + each["name"][1:]] = x, y
    return values


def _path(linkage, link):
    """Names of the joints from a link down to the ground."""
    names = []
    while link >= 0:
        names.append(linkage.joints[link].name)
        link = linkage.joints[link].parent
    return names


def _frames(linkage):
    """Origin and direction of the x-axis of each link; from joints alone."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    joints = {}
    for k, joint in enumerate(linkage.joints):
        for link in (joint.parent, k):
            joints.setdefault(welded.get(link, link), []).append(joint)
    in_loops = set()
    for loop in linkage.loops:
        in_loops |= set(_path(linkage, loop.end)) ^ set(_path(linkage, loop.successor))
    frames = {}
    for link, own in joints.items():
        own[1:] = sorted(own[1:], key=lambda joint: joint.name not in in_loops)
        turning = [complex(*joint.point[:2]) for joint in own if joint.kind == "revolute"]
        sliding = [complex(*joint.screw[3:5]) for joint in own if joint.kind == "prismatic"]
        origin = turning[0]
        apart = [z - origin for z in turning if abs(z - origin) > 1e-9]
        axis = sliding[0] if sliding else apart[0] if apart else 1.0 + 0j
        frames[link] = origin, axis / abs(axis)
    return frames


def parameters_in_frames(space):
    """Balanced masses (parameters, nullity) as the formulas name them, from the space."""
    frames, count = _frames(space.linkage), len(space.labels)
    z = space.basis.reshape(len(space.bodies), count, -1)
    moments, seconds = [], []
    for body, own in zip(space.linkage.bodies, z, strict=True):
        origin, axis = frames[body.link]
        m, mc = own[0], own[1] + 1j * own[2]
        moments.append((mc - m * origin) * axis.conjugate())
        if count == 4:
            seconds.append(own[3] - 2 * (origin.conjugate() * mc).real + m * abs(origin) ** 2)
    masses = z[:, 0]
    if count == 3:
        return np.vstack([moments, masses])
    return np.vstack([np.real(moments), np.imag(moments), seconds, masses])


def violation(formulas, space, values):
    """Largest violation of the formulas by balanced masses, over the sizes of their terms."""
    rows, z = matrix(formulas, values).astype(complex), parameters_in_frames(space)
    sizes = (abs(rows) @ abs(z)).max(axis=1, keepdims=True)
    # A condition that one parameter vanishes has no terms to compare with.
    return float((abs(rows @ z) / np.maximum(sizes, 1e-3 * abs(z).max())).max())
