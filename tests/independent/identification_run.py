"""How often identified combinations are within three standard errors of the truth.

``python -m tests.independent.identification_run --runs 200`` prints a line for each machine.
A run draws masses unlike those of the file, computes the loads along an exciting motion by
another route (`measured_loads`), adds white noise of 1 % of the peak of each channel, rounds
the positions of the inputs like an encoder, writes both tables and identifies from these.
With ``--second`` each run has a second recording: another motion, twice as fast, and a sensor
that is five times as noisy.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import balance
import kinematics
from balance.masses.identification.identification import Identification
from tests.independent import reference
from tests.independent.measured_loads import Arm, load_regressor
from tests.support.laws import point_masses, sums

# Machines: open chains and closed loops, in the plane and in space.
MACHINES = (
    "hprs",
    "double_pendulum_counter_rotary",
    "four_bar_general",
    "five_bar",
    "rusr",
    "three_rsr",
)
GRAVITY = np.array([0.3, -0.8, -9.7])
NOISE = 0.01
# Decimals of the positions of the inputs, rad and m.
DECIMALS = 7
SAMPLES = 301
DURATION = 3.0
# Masses of a run differ from those of the file by this part of a body of its own.
CHANGE = 0.3


class Machine(NamedTuple):
    """A machine that moves, and its loads as linear functions of its masses.

    Attributes:
        linkage: as the package reads it.
        time: of the samples (N,).
        inputs: positions (N, mobility).
        channels: names of the loads.
        rows: loads (N, channels, parameters).
        file: parameters of the file (parameters,).
    """

    linkage: Any
    time: Any
    inputs: Any
    channels: tuple[str, ...]
    rows: Any
    file: Any


class Coverage(NamedTuple):
    """How many identified values were within three standard errors.

    Attributes:
        machine: its name.
        combinations: number of combinations on which balance depends.
        runs: number of runs.
        within: share of all values within three standard errors.
        every: share of runs in which all of them were.
        squares: mean square of the errors over their standard errors.
        shaking: share of runs whose shaking force was within three standard errors.
    """

    machine: str
    combinations: int
    runs: int
    within: float
    every: float
    squares: float
    shaking: float


def machine(
    name: str,
    tries: int = 60,
    samples: int = SAMPLES,
    seed: int = 1,
    duration: float = DURATION,
) -> Machine:
    """Plan a motion of a machine, and compute its loads by another route."""
    linkage = kinematics.load(name)
    plan = balance.masses.exciting_motion(linkage, duration, tries=tries, seed=seed)
    time = np.linspace(0.0, duration, samples)
    u, ud, udd = plan.path.at(time)
    file = np.array([body.inertia for body in linkage.bodies]).reshape(-1)
    wrench = ("fx", "fy", "fz", "mx", "my", "mz")
    if not linkage.loops and len(linkage.inputs) == len(linkage.joints):
        arm, rows = Arm(linkage, GRAVITY), []
        order = linkage.positions_of(linkage.inputs)
        q, qd, qdd = (np.zeros_like(x) for x in (u, ud, udd))
        q[:, order], qd[:, order], qdd[:, order] = u, ud, udd
        base = np.concatenate(arm.loads(file.reshape(-1, 10), q, qd, qdd), axis=1)
        # The parameters are changed one by one by as much as leaves masses positive.
        for k in range(file.size):
            changed = file.copy()
            changed[k] += 0.1
            there = np.concatenate(arm.loads(changed.reshape(-1, 10), q, qd, qdd), axis=1)
            rows.append((there - base) / 0.1)
        loads = np.moveaxis(np.array(rows), 0, 2)
        loads[:, 6:] = loads[:, 6:][:, order]
        return Machine(linkage, time, u, (*wrench, *linkage.inputs), loads, file)
    mechanism = reference.load(kinematics.gallery()[name], linkage.inputs)
    order = [linkage.inputs.index(mechanism.joints[i]) for i in mechanism.inputs]

    def path(now: float) -> tuple[Any, Any]:
        there = plan.path.at(np.array([now]))
        return there[0][0, order], there[1][0, order]

    bodies = [mechanism.bodies.index(body.name) for body in linkage.bodies]
    loads = load_regressor(mechanism, path, time, GRAVITY)
    loads = loads.reshape(samples, 6, -1, 10)[:, :, bodies].reshape(samples, 6, -1)
    return Machine(linkage, time, u, wrench, loads, file)


def other_masses(linkage: Any, rng: np.random.Generator) -> Any:
    """Masses (nb, 10) unlike those of the file: points are added to a part of each body."""
    length = linkage.spatial_chain.frame.length
    truth = np.array([body.inertia for body in linkage.bodies])
    for own, body in zip(truth, linkage.bodies, strict=True):
        masses, points = point_masses(rng, 6, 0.1 * length)
        other = sums(masses, points + body.inertia[1:4] / body.inertia[0])
        own += CHANGE * own[0] / other[0] * other - 0.5 * CHANGE * own
    return truth


def write_recording(
    moving: Machine, truth: Any, rng: np.random.Generator, folder: Path, noise: float
) -> tuple[Path, Path]:
    """Write the tables of a motion and its loads with the true parameters (parameters,)."""
    loads = moving.rows @ truth
    loads = loads + noise * np.abs(loads).max(axis=0) * rng.normal(size=loads.shape)
    loads[:, :6] *= -1.0
    folder.mkdir(exist_ok=True)
    for file, names, columns, decimals in (
        ("motion.csv", moving.linkage.inputs, moving.inputs, DECIMALS),
        ("loads.csv", moving.channels, loads, 12),
    ):
        table = np.column_stack([moving.time, columns])
        np.savetxt(
            folder / file,
            table,
            f"%.{decimals}f",
            ",",
            comments="",
            header=",".join(["time", *names]),
        )
    return folder / "motion.csv", folder / "loads.csv"


def coverage(name: str, runs: int, recordings: Sequence[tuple[Machine, float]]) -> Coverage:
    """Identify a machine many times, from recordings with noise relative to the peaks."""
    linkage = recordings[0][0].linkage
    counts, errors, shaking = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):
            rng = np.random.default_rng([7, run])
            truth = other_masses(linkage, rng).reshape(-1)
            tables = [
                write_recording(moving, truth, rng, Path(folder) / str(k), noise)
                for k, (moving, noise) in enumerate(recordings)
            ]
            found = balance.identify(
                linkage, *map(list, zip(*tables, strict=True)), gravity=GRAVITY
            )
            assert found.complete, found.words
            off = deviations(found, truth)
            counts.append(np.abs(off) <= 3.0)
            errors.append(off**2)
            shaking.append(shaking_within(found, truth))
    within = np.array(counts)
    return Coverage(
        name,
        within.shape[1],
        runs,
        float(within.mean()),
        float(within.all(axis=1).mean()),
        float(np.mean(errors)),
        float(np.mean(shaking)),
    )


def deviations(found: Identification, truth: Any) -> Any:
    """Errors of the combinations over their standard errors."""
    return np.array(
        [
            (item.value - true_value(item, truth, found)) / item.error
            for item in found.combinations
        ]
    )


def true_value(item: Any, truth: Any, found: Identification) -> float:
    """A combination of the true parameters, from its terms in the frames of the links."""
    parameters = link_parameters(found, truth)
    return float(
        sum(factor * parameters[link][label] for label, link, factor in item.combination.terms)
    )


def link_parameters(found: Identification, truth: Any) -> dict[str, dict[str, float]]:
    """Parameters of each body about the origin of its link, in its axes, as points have them.

    In a plane, axes are those that are in it: the one after the normal in x, y, z, x first.
    """
    labels = {}
    normal = found.space.axes[2] if found.space.planar else None
    for body, z in zip(found.space.linkage.bodies, truth.reshape(-1, 10), strict=True):
        R, r = body.frame[:3, :3], body.frame[:3, 3]
        axes = R.T
        if normal is not None:
            n = R.T @ normal
            first = np.eye(3)[(int(np.argmax(np.abs(n) > 0.999999)) + 1) % 3]
            assert np.abs(n).max() > 0.999999, "a link frame that is askew to the plane"
            axes = np.array([first, np.cross(n, first), n]) @ R.T
            r = r + normal * (normal @ (z[1:4] / z[0] - r))
        m, mc = z[0], z[1:4]
        E = np.array([[z[4], z[7], z[8]], [z[7], z[5], z[9]], [z[8], z[9], z[6]]])
        # About r: E' = E - 2 shifts of the first moment + m of the shift.
        E = E - 2.0 * (mc @ r) * np.eye(3) + np.outer(mc, r) + np.outer(r, mc)
        E = axes @ (E + m * (r @ r * np.eye(3) - np.outer(r, r))) @ axes.T
        local = axes @ (mc - m * r)
        labels[body.name] = {
            "m": m,
            "mcx": local[0],
            "mcy": local[1],
            "mcz": local[2],
            "Exx": E[0, 0],
            "Eyy": E[1, 1],
            "Ezz": E[2, 2],
            "Exy": E[0, 1],
            "Exz": E[0, 2],
            "Eyz": E[1, 2],
        }
    return labels


def shaking_within(found: Identification, truth: Any) -> bool:
    """Whether the shaking force of the likeliest masses is within three standard errors."""
    ways = [recording.trajectory for recording in found.recordings]
    motions = (
        np.concatenate([getattr(way, kind) for way in ways]) for kind in ("u", "ud", "udd")
    )
    wrench = balance.motion.shaking(found.space.linkage, *motions, truth)
    force = np.sqrt(np.square(wrench[:, 3:]).sum(axis=1).mean())
    return bool(abs(found.after.force - force) <= 3.0 * found.after.force_error)


def main() -> None:
    """Print a table of the coverage of each machine."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--second", action="store_true", help="a second, noisier recording")
    parser.add_argument("machines", nargs="*", default=MACHINES)
    chosen = parser.parse_args()
    head = (
        "combinations",
        "values within 3 sigma",
        "runs with all",
        "mean square",
        "force within 3 sigma",
    )
    print(f"{'machine':32}", *(f"{word:>22}" for word in head))
    for name in chosen.machines:
        recordings = [(machine(name), NOISE)]
        if chosen.second:
            faster = machine(name, seed=2, duration=0.5 * DURATION)
            recordings.append((faster, 5.0 * NOISE))
        found = coverage(name, chosen.runs, recordings)
        shown = (
            f"{found.combinations}",
            f"{100 * found.within:.1f} %",
            f"{100 * found.every:.1f} %",
            f"{found.squares:.3f}",
            f"{100 * found.shaking:.1f} %",
        )
        print(f"{name:32}", *(f"{word:>22}" for word in shown), flush=True)


if __name__ == "__main__":
    main()
