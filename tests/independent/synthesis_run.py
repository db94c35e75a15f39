"""Synthesis on random tasks: its files are followed, and its "none" is searched again.

    python -m tests.independent.synthesis_run --count 50 --search 20 --table tasks.jsonl
    python -m tests.independent.synthesis_run --planted --kinds four-bar

draws positions of two to five, or with ``--planted`` takes those through which the coupler of a
random kite or antiparallelogram goes. For each kind of mechanism that is found `verify` reads
the best file, and another program moves its links from position to position. Where the answer
is "none", `tests.independent.second_synthesis` searches by another method, for the first so
many tasks. Of a stack Pinocchio alone turns the cranks, finds the tool at the positions, and
the mass matrix on a free base without a term between base and drives, or two drives. The exit
code is 1 if a file fails or if a search finds what was said not to be.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
import tempfile
import time
from collections import defaultdict
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from balance import synthesize, verify
from balance.studies.synthesis.mechanism import SynthesizedMechanism
from kinematics import load
from kinematics.errors import LinkageError
from tests.independent import second_synthesis as second
from tests.support.planar_in_pinocchio import PlanarFile

KINDS = ("pantograph", "four-bar", "slider-crank", "geared-four-bar", "six-bar", "stack")
# Kinds of which "none" is searched again; those of one solution have no other.
SEARCHED = ("four-bar", "geared-four-bar")
COLUMNS = (
    "tasks", "found", "verified", "met", "none", "searched", "confirmed", "wrong", "undecided"
)  # fmt: skip
# Farthest that the tool of a file may be from a position, over their size.
MET = 1e-8
# Largest term of a scaled mass matrix of a stack beside its diagonal.
COUPLED = 1e-9
# Steps of the crank from one position to the next.
STEPS = 400


def random_task(count: int, seed: int):
    """Positions in a square of 1 m, and a pivot for two: options of `synthesize`."""
    rng = np.random.default_rng([count, seed])
    points = rng.uniform(-0.5, 0.5, (count, 2))
    angles = rng.uniform(-1.0, 1.0, count)
    places = [(*point, angle) for point, angle in zip(points.tolist(), angles, strict=True)]
    return places, _pivot(rng, count)


def planted_task(count: int, seed: int):
    """Positions of the coupler of a kite or, for odd seeds, an antiparallelogram."""
    rng = np.random.default_rng([count, seed, 1])
    kind = second.KINDS[seed % 2]
    base = rng.uniform(1.5, 5.0)
    scale = rng.uniform(0.2, 0.6) * np.exp(2j * np.pi * rng.random())
    # Apart by a twelfth of the way or more, so that positions differ.
    way = np.cumsum(rng.uniform(0.3, 1.0, count + 1))
    alpha = (0.2 + (np.pi - 0.4) * way[:count] / way[-1]) * rng.choice([-1.0, 1.0])
    A = np.exp(1j * alpha)
    B = second._mirrored(kind, 0j, complex(base), A)
    U = (B - A) / np.abs(B - A)
    points = (
        scale * A + complex(*rng.uniform(-0.5, 0.5, 2)) + complex(*rng.normal(0, 0.4, 2)) * U
    )
    places = [
        (z.real, z.imag, angle) for z, angle in zip(points, np.unwrap(np.angle(U)), strict=True)
    ]
    return places, _pivot(rng, count)


def _pivot(rng, count: int) -> dict[str, complex]:
    """The pivot that two positions leave free."""
    if count > 2:
        return {}
    return {str(rng.choice(["fixed", "moving"])): complex(*rng.uniform(-0.5, 0.5, 2))}


def miss_of_file(path: Path, mechanism: SynthesizedMechanism, places) -> float:
    """How far the tool of a written linkage is from the positions, by its links alone.

    The crank turns step by step, and the end of the coupler goes to the nearer crossing of its
    circle and that of the rocker, or the line of a slider; the angle counts as an arc of the
    size.
    """
    root = ElementTree.parse(path).getroot()
    at = {
        joint.get("name"): complex(*map(float, joint.find("origin").get("xyz").split()[:2]))
        for joint in root.iter("joint")
    }
    yaw = next(
        float(joint.find("origin").get("rpy", "0 0 0").split()[2])
        for joint in root.iter("joint")
        if joint.get("name") == "tool_fixed"
    )
    ends = next(root.iter("loop"))
    on_coupler = complex(*map(float, ends.find("predecessor/origin").get("xyz").split()[:2]))
    G, arm, coupler = at["crank_joint"], at["coupler_joint"], abs(on_coupler)
    if mechanism.kind == "slider-crank":
        (slide,) = (x for x in root.iter("joint") if x.get("type") == "prismatic")
        way = complex(*map(float, slide.find("axis").get("xyz").split()[:2]))
        crossings = partial(_line_and_circle, at["slide"], way, coupler)
    else:
        on_rocker = complex(*map(float, ends.find("successor/origin").get("xyz").split()[:2]))
        crossings = partial(_two_circles, at["rocker_joint"], abs(on_rocker), coupler)
    Z, angle, worst = G + arm + on_coupler, 0.0, 0.0
    size = max(abs(complex(*p[:2]) - complex(*places[0][:2])) for p in places)
    for end, (x, y, wanted) in zip(mechanism.link_turns, places, strict=True):
        for turn in np.linspace(angle, end, STEPS):
            A = G + arm * np.exp(1j * turn)
            Z = min(crossings(A), key=lambda z, last=Z: abs(z - last))
        angle, way = end, (Z - A) / on_coupler
        tool = A + at["tool_fixed"] * way
        turned = abs(np.angle(way * np.exp(1j * (yaw - wanted))))
        worst = max(worst, abs(tool - complex(x, y)), size * turned)
    return worst / size


def check_stack(path: Path, mechanism: SynthesizedMechanism, places) -> tuple[float, float]:
    """How far the tool of a written stack is from the positions, and how it is coupled.

    Its cranks turn from the first position to each, and Pinocchio closes the loops. Coupled is
    the largest term of the mass matrix beside its diagonal in the columns of the drives, over
    the geometric mean of the two terms of the diagonal.
    """
    model = PlanarFile(path.read_bytes(), mechanism.input_turns)
    size = max(abs(complex(*p[:2]) - complex(*places[0][:2])) for p in places)
    miss, coupled = 0.0, 0.0
    for turns, (x, y, wanted) in zip(
        zip(*mechanism.input_turns.values(), strict=True), places, strict=True
    ):
        if model.turn_to(turns) == np.inf:
            return np.inf, np.inf
        tool = model.frame("tool")
        angle = np.arctan2(tool.rotation[1, 0], tool.rotation[0, 0])
        turned = abs(np.angle(np.exp(1j * (angle - wanted))))
        apart = np.hypot(*(tool.translation[:2] - [x, y]))
        miss = max(miss, apart / size, turned)
        M = model.mass_matrix()
        own = np.sqrt(np.diagonal(M))
        beside = np.abs(M / np.outer(own, own) - np.eye(len(M)))
        coupled = max(coupled, beside[:, len(model.base) :].max())
    return miss, coupled


def _two_circles(H: complex, rocker: float, coupler: float, A: complex) -> list[complex]:
    """Cross the circles about the base of the rocker and the tip of the crank."""
    gap = abs(H - A)
    along = (coupler**2 - rocker**2 + gap**2) / (2.0 * gap)
    beside = 1j * np.sqrt(max(coupler**2 - along**2, 0.0))
    return [A + (along + s * beside) * (H - A) / gap for s in (1, -1)]


def _line_and_circle(H: complex, way: complex, coupler: float, A: complex) -> list[complex]:
    """Cross the line of the slider and the circle about the tip of the crank."""
    foot = ((A - H) * way.conjugate()).real
    half = np.sqrt(max(coupler**2 - abs(A - H - foot * way) ** 2, 0.0))
    return [H + (foot + s * half) * way for s in (1, -1)]


def judge_task(kind: str, count: int, seed: int, planted: bool, search: bool, folder: Path):
    """Run a task through the product, and judge the answer: a line of the table file."""
    places, pivot = (planted_task if planted else random_task)(count, seed)
    line = {"kind": kind, "count": count, "seed": seed, "outcome": "", "detail": ""}
    begin = time.process_time()
    try:
        # Planted four-bars are of any ratio of base and crank; short bases take denser matter.
        matter = {"density": None} if planted else {}
        if kind == "stack":
            pivot = {}
        synthesis = synthesize(places, kind=kind, **pivot, **matter)
        verdict = synthesis.verdict
    except LinkageError as error:
        synthesis, verdict = None, "infeasible"
        line["detail"] = str(error)
    line["seconds"] = round(time.process_time() - begin, 3)
    line["tasks"] = 1
    if verdict == "undecided":
        return line | {"undecided": 1, "detail": synthesis.words}
    if verdict == "feasible":
        best = synthesis.mechanisms[0]
        path = folder / f"{kind}_{count}_{seed}.urdf"
        path.write_bytes(best.urdf)
        good, miss = judge_file(kind, path, best, places)
        line |= {"found": 1, "verified": int(good), "met": int(miss < MET)}
        wrong = not (good and miss < MET)
        return line | {"wrong": int(wrong), "detail": f"{best.kind}, misses {miss:.1e}"}
    line["none"] = 1
    if kind not in SEARCHED or not (search or planted and kind == "four-bar"):
        return line | {"wrong": int(planted and kind == "four-bar" and count > 2)}
    begin = time.process_time()
    if kind == "four-bar":
        searches = [second.search(each, places, **pivot) for each in second.KINDS]
        pivots = next((each for each in searches if each is not None), None)
    else:
        pivots = second.search_general(places, **pivot)
    line["search_seconds"] = round(time.process_time() - begin, 3)
    wrong = pivots is not None or (planted and kind == "four-bar" and count > 2)
    detail = "" if pivots is None else " ".join(f"{z:.4g}" for z in pivots)
    line |= {"searched": 1, "confirmed": int(not wrong), "wrong": int(wrong)}
    return line | {"detail": f"{line['detail']} {detail}".strip()}


def judge_file(kind: str, path: Path, best: SynthesizedMechanism, places) -> tuple[bool, float]:
    """Whether a written mechanism is balanced, and how far it is from its positions."""
    if kind == "pantograph" and best.table is not None:
        return best.confirmation.confirmed, 0.0
    good = verify(load(path), trajectories=2).balanced
    if kind == "stack":
        miss, coupled = check_stack(path, best, places)
        return good and coupled < COUPLED, miss
    return good, 0.0 if kind == "pantograph" else miss_of_file(path, best, places)


def table(lines: list[dict]) -> list[str]:
    """A row for each kind and number of positions."""
    rows: dict[tuple, list[dict]] = defaultdict(list)
    for line in lines:
        rows[line["count"], line["kind"]].append(line)
    text = [f"{'':18}" + "".join(f"{name:>10}" for name in COLUMNS) + "  median s     max s"]
    for (count, kind), group in sorted(rows.items()):
        sums = [sum(line.get(name, 0) for line in group) for name in COLUMNS]
        seconds = [line["seconds"] for line in group]
        times = f"{np.median(seconds):10.2f}{max(seconds):10.2f}"
        text.append(f"{count} {kind:16}" + "".join(f"{x:>10}" for x in sums) + times)
    return text


def main(words: list[str] | None = None) -> int:
    """Run tasks from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50, help="tasks of a number")
    parser.add_argument("--search", type=int, default=20, help="of none, searched")
    parser.add_argument("--seed", type=int, default=0, help="of the first task")
    parser.add_argument("--positions", type=int, nargs="+", default=[2, 3, 4, 5])
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--planted", action="store_true")
    parser.add_argument("--table", type=Path, help="JSON lines, to go on with")
    options = parser.parse_args(words)
    lines = []
    if options.table and options.table.exists():
        lines = [json.loads(x) for x in options.table.read_text().splitlines()]
    done = {(line["kind"], line["count"], line["seed"]) for line in lines}
    searched: dict[tuple, int] = defaultdict(int)
    for line in lines:
        searched[line["kind"], line["count"]] += line.get("searched", 0)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.seed, options.seed + options.count):
            for count in options.positions:
                for kind in options.kinds:
                    if (kind, count, seed) in done or (kind == KINDS[0] and count > 3):
                        continue
                    more = searched[kind, count] < options.search
                    line = judge_task(kind, count, seed, options.planted, more, Path(folder))
                    searched[kind, count] += line.get("searched", 0)
                    lines.append(line)
                    if options.table:
                        with options.table.open("a") as file:
                            file.write(json.dumps(line) + "\n")
                    if line.get("wrong"):
                        print(json.dumps(line), flush=True)
    print("\n".join(table(lines)))
    return 1 if any(line.get("wrong") for line in lines) else 0


if __name__ == "__main__":
    sys.exit(main())
