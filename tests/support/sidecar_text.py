"""A four-bar whose loop a YAML file closes, and files to hold both."""

import numpy as np

from tests.support.urdf_text import EYE, UNIT_INERTIA, about, along, joint, link

NAMES = ("base", "crank", "coupler", "rocker")
FRAMES = ("tip_a", "tip_b")


PAIR = "closed_loop: [['tip_a', 'tip_b']]\n"
APART = along([1.0, 0, 0]), along([1.5, 0, 0])


def bench(extra="", ends=APART, spins=()):
    """A four-bar open at the coupler, with frames ``ends`` of 1e-9 kg where it closes.

    ``spins``: joints between the coupler and its frame, about the given axes.
    """
    frames = [link(name, mass=1e-9, inertia=np.zeros((3, 3))) for name in FRAMES]
    names = ["coupler", *(f"spin{k}" for k in range(len(spins))), "tip_a"]
    chain = [
        joint(f"s{k}", "revolute", names[k], names[k + 1], ends[0] if k == 0 else EYE, axis)
        for k, axis in enumerate(spins)
    ]
    last = joint("ja", "fixed", names[-2], "tip_a", EYE if spins else ends[0])
    return (
        '<robot name="r">'
        + link("base")
        + "".join(link(name, **UNIT_INERTIA) for name in NAMES[1:])
        + "".join(link(f"spin{k}") for k in range(len(spins)))
        + "".join(frames)
        + joint("j1", "revolute", "base", "crank", about([0, 0, 1], 1.1), [0, 0, 1])
        + joint("j2", "revolute", "crank", "coupler", along([1, 0, 0]), [0, 0, 1])
        + joint("j3", "revolute", "base", "rocker", along([2, 0, 0]), [0, 0, 1])
        + "".join(chain)
        + last
        + joint("jb", "fixed", "rocker", "tip_b", ends[1])
        + extra
        + "</robot>"
    )


def written(folder, text, yaml=None, name="robot.yaml"):
    """Write ``robot.urdf`` and a YAML file next to it; returns the path of the former."""
    path = folder / "robot.urdf"
    path.write_text(text)
    if yaml is not None:
        (folder / name).write_bytes(yaml if isinstance(yaml, bytes) else yaml.encode())
    return path
