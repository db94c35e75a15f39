"""Masses of a double pendulum from a public recording, by the equations in the plane.

``python -m tests.independent.recorded_pendulum trajectory_04.csv`` prints the mass moments that
`balance identify` finds on docs/machines/double_pendulum.md, and those of a regression that
shares no code with it: the equations of motion of two links written out by hand, positions
filtered by a moving polynomial (Savitzky and Golay, Analytical Chemistry 36(8), 1964), and
torques averaged over windows.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

import balance

FILE = Path(__file__).parents[2] / "docs" / "machines" / "double_pendulum.urdf"
UPPER, GRAVITY = 0.3, 9.81
NAMES = ("shoulder", "elbow")
COLUMNS = "pos_meas", "tau_meas"


def recording(path):
    """Time, positions and torques (N, 2) of a recording."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    pick = (np.column_stack([table[f"{name}1"], table[f"{name}2"]]) for name in COLUMNS)
    return table["time"], *pick


def by_hand(time, positions, torques, window=0.1):
    """First moments (along and across both links, the upper with the lower at its end).

    Unknowns: inertias about the joints, first moments, the rotor of the elbow, and friction.
    """
    even = np.linspace(time[0], time[-1], len(time))
    step = even[1] - even[0]
    q = np.column_stack([np.interp(even, time, x) for x in positions.T])
    y = np.column_stack([np.interp(even, time, x) for x in torques.T])
    width = 2 * int(0.5 * window / step) + 1
    q, v, a = (savgol_filter(q, width, 4, k, step, axis=0) for k in range(3))
    (v1, v2), (a1, a2) = v.T, a.T
    s, c = np.sin(q[:, 1]), np.cos(q[:, 1])
    both, zero = a1 + a2, np.zeros_like(a1)
    turned = q.sum(axis=1)
    along = c * (2.0 * a1 + a2) - s * (2.0 * v1 * v2 + v2**2)
    across = -s * (2.0 * a1 + a2) - c * (2.0 * v1 * v2 + v2**2)
    shoulder = [
        a1,
        both,
        GRAVITY * np.sin(q[:, 0]),
        GRAVITY * np.cos(q[:, 0]),
        UPPER * along + GRAVITY * np.sin(turned),
        UPPER * across + GRAVITY * np.cos(turned),
        zero,
        v1,
        np.sign(v1),
        zero,
        zero,
    ]
    elbow = [
        zero,
        both,
        zero,
        zero,
        UPPER * (c * a1 + s * v1**2) + GRAVITY * np.sin(turned),
        UPPER * (c * v1**2 - s * a1) + GRAVITY * np.cos(turned),
        a2,
        zero,
        zero,
        v2,
        np.sign(v2),
    ]
    rows = [np.column_stack(part) for part in (shoulder, elbow)]
    block = int(0.17 / step)
    count = len(even) // block
    mean = [x[: count * block].reshape(count, block, -1).mean(axis=1) for x in (*rows, y)]
    sizes = np.ones(2)
    for _ in range(10):
        Y = np.concatenate([mean[k] / sizes[k] for k in range(2)])
        loads = np.concatenate([mean[2][:, k] / sizes[k] for k in range(2)])
        x = np.linalg.lstsq(Y, loads, rcond=None)[0]
        sizes = np.array([np.std(mean[k] @ x - mean[2][:, k]) for k in range(2)])
    return x[2:6]


def main():
    """Print both answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="+")
    for file in parser.parse_args().file:
        time, positions, torques = recording(file)
        rows = np.column_stack([time, positions])
        table = Path("motion.csv")
        np.savetxt(table, rows, "%.9f", ",", comments="", header=",".join(["time", *NAMES]))
        loads = {"time": time, **dict(zip(NAMES, torques.T, strict=True))}
        answer = balance.identify(
            FILE, table, loads, cutoff=3.0, friction=True, rotors=True, balance="force"
        )
        told = (f"{item.value:.4f} ± {item.error:.4f}" for item in answer.combinations)
        print(file, "balance identify", *told, sep=", ")
        hand = (f"{x:.4f}" for x in by_hand(time, positions, torques))
        print(file, "by hand", *hand, sep=", ")


if __name__ == "__main__":
    main()
