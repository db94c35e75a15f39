"""Files whose loops were opened, and the nearest closed pose by exhaustive search.

``python -m tests.independent.nearest_closed --cases 200`` opens the joints of linkages by up to
1 rad, and compares the pose that the product takes with the nearest of those that 200 random
starts lead to. Only linkages with two branches or more count. Of the product, the search
reads the joints, their screws and the gaps of the loops; derivatives come from complex steps.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from itertools import count
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

import kinematics
from kinematics.errors import LinkageError, MobilityError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.read_options import ReadOptions
from tests.independent.families import linkage as generated
from tests.independent.plain_linkage import urdf

MODELS = (
    "five_bar",
    "four_bar_general",
    "three_rrr",
    "six_bar_watt",
    "rusr",
    "slider_crank",
    "four_bar_kite",
    "two_rrr",
    "five_bar",
    "four_bar_antiparallelogram",
    "four_bar_spherical",
    "six_bar_stephenson",
    "three_rrr",
    "delta",
    "pantograph",
    "four_rrr_parallel",
)
FAMILIES = ("grid", "single", "small_loop", "general", "embedded")
# How many of the closed poses are followed to the least motion.
FINALISTS = 10


class Compared(NamedTuple):
    """A case: motions to the pose taken and to the nearest, and how many poses there are.

    Attributes:
        name: of the file.
        taken: motion to the pose of the product.
        followed: least motion along its branch, by short steps from there.
        nearest: least motion of all poses that the search found.
        branches: how many there are.
    """

    name: str
    taken: float
    followed: float
    nearest: float
    branches: int

    @property
    def right(self) -> bool:
        """Whether the pose is on the nearest branch, or as near as the nearest to 2 %."""
        return min(self.taken, self.followed) <= 1.02 * self.nearest + 1e-3

    @property
    def least(self) -> bool:
        """Whether it also is nearly the nearest pose of its branch."""
        return self.taken <= 1.15 * self.nearest + 1e-3


def opened(source: Path, out: Path, rng, reach: float = 1.0) -> Path:
    """Write a file with its joints turned by up to ``reach`` rad, or slid by a third of it."""
    tree = ElementTree.parse(source)
    for joint in tree.getroot().findall("joint"):
        origin, axis = joint.find("origin"), joint.find("axis")
        if origin is None:
            origin = ElementTree.SubElement(joint, "origin")
        xyz = np.array(origin.get("xyz", "0 0 0").split(), float)
        R = Rotation.from_euler("xyz", np.array(origin.get("rpy", "0 0 0").split(), float))
        n = np.array((axis.get("xyz") if axis is not None else "1 0 0").split(), float)
        q, n = rng.uniform(-reach, reach), n / np.linalg.norm(n)
        kind = joint.get("type")
        if kind == "prismatic":
            xyz = xyz + R.apply(q * n / 3)
        elif kind == "spherical":
            R = R * Rotation.from_rotvec(rng.uniform(-reach, reach, 3) / 2)
        elif kind in ("revolute", "continuous", "universal"):
            R = R * Rotation.from_rotvec(q * n)
        origin.set("xyz", " ".join(repr(float(x)) for x in xyz))
        origin.set("rpy", " ".join(repr(float(x)) for x in R.as_euler("xyz")))
    tree.write(out)
    return out


class Search:
    """All loops of a draft at many poses at once, in metres over the size of its joints."""

    def __init__(self, draft) -> None:
        self.parent = [joint.parent for joint in draft.joints]
        points = np.array([joint.point for joint in draft.joints])
        ends = [(set(self._path(k.end)), set(self._path(k.successor))) for k in draft.loops]
        around = points[sorted(set().union(*(a ^ b for a, b in ends)))]
        self.size = np.linalg.norm(around - around.mean(axis=0), axis=1).max() or 1.0
        middle = np.eye(4)
        middle[:3, 3] = -points.mean(axis=0)
        middle[:3] /= self.size
        middle[:3, :3] = np.eye(3) / self.size
        self.screws = np.zeros((len(points), 4, 4))
        for S, joint in zip(self.screws, draft.joints, strict=True):
            x, y, z = joint.screw[:3]
            S[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
            S[:3, 3] = joint.screw[3:]
            S[:] = middle @ S @ np.linalg.inv(middle)
        slide = np.array([joint.kind == "prismatic" for joint in draft.joints])
        self.screws[slide] *= self.size  # positions in parts of the size
        self.units = np.where(slide, self.size, 1.0)
        gaps = [middle @ loop.gap @ np.linalg.inv(middle) for loop in draft.loops]
        self.unfit = np.linalg.inv(np.array(gaps))
        self.ends = np.array([(loop.end, loop.successor) for loop in draft.loops])
        self.turning = ~slide
        self.weights = self._weights(draft, points)

    def _weights(self, draft, points):
        found = np.full(len(points), 0.02)
        for j, joint in enumerate(draft.joints):
            if joint.kind == "prismatic":
                found[j] = 1.0
                continue
            if joint.in_loop:
                continue
            out = [points[k] for k in range(len(points)) if j in self._path(k)]
            for loop in draft.loops:
                if j in self._path(loop.successor):
                    p = points[loop.end]
                    out.append(loop.gap[:3, :3] @ p + loop.gap[:3, 3])
            far = max(np.linalg.norm(np.cross(p - joint.point, joint.screw[:3])) for p in out)
            found[j] = max(found[j], far / self.size)
        return found

    def _path(self, link):
        found = []
        while link >= 0:
            found.append(link)
            link = self.parent[link]
        return found

    def openness(self, q):
        """Entries of D - 1 of all loops at poses q (..., n), real or complex."""
        S, S2 = self.screws, self.screws @ self.screws
        x = q[..., None, None]
        E = np.eye(4) + x * S + (1 - np.cos(x)) * S2 + (x - np.sin(x)) * (S2 @ S)
        H = []
        for j, p in enumerate(self.parent):
            H.append(E[..., j, :, :] if p < 0 else H[p] @ E[..., j, :, :])
        one = np.broadcast_to(np.eye(4), H[0].shape)
        rows = []
        for (end, successor), unfit in zip(self.ends, self.unfit, strict=True):
            far = H[successor] if successor >= 0 else one
            rows.append((H[end] @ unfit - far)[..., :3, :])
        return np.stack(rows, axis=-3).reshape(*q.shape[:-1], -1)

    def slopes(self, q):
        steps = q[:, None, :] + 1e-30j * np.eye(q.shape[1])
        return np.swapaxes(self.openness(steps).imag / 1e-30, 1, 2)

    def closed(self, starts, steps=60):
        """Close the loops by damped steps from all starts, and slide to least motion."""
        w, y, mu = self.weights, starts * self.weights, np.full(len(starts), 1e-2)
        r, found = self.openness(y / w), []
        for _ in range(steps):
            done = np.abs(r).max(axis=1) < 1e-7
            found.append(y[done])
            y, r, mu = (x[~done & (mu < 1e5)] for x in (y, r, mu))
            if not len(y):
                break
            A = self.slopes(y / w) / w
            N = np.swapaxes(A, 1, 2) @ A
            size = np.trace(N, axis1=1, axis2=2)[:, None, None] / y.shape[1]
            N = N + mu[:, None, None] * size * np.eye(y.shape[1])
            step = np.linalg.solve(N, (np.swapaxes(A, 1, 2) @ r[..., None]))[..., 0]
            ahead = self.openness((y - step) / w)
            better = np.sum(ahead**2, axis=1) < np.sum(r**2, axis=1)
            y, r = np.where(better[:, None], y - step, y), np.where(better[:, None], ahead, r)
            mu = np.maximum(np.where(better, mu / 10, mu * 8), 1e-9)
        y = self.wrapped(np.concatenate(found) / w) * w
        return self.slid(apart(self.slid(y, 5))[:FINALISTS], 30)

    def slid(self, y, steps, longest=np.inf):
        """Least motion along the branches: projected steps, each pulled back to closure."""
        w, share = self.weights, np.full(len(y), 0.7)
        for _ in range(steps if len(y) else 0):
            A = self.slopes(y / w) / w
            G = np.linalg.pinv(A, rcond=1e-6)
            along = y - (G @ (A @ y[..., None]))[..., 0]
            along *= share[:, None]
            along *= np.minimum(1.0, longest / np.linalg.norm(along, axis=1).clip(1e-9))[
                :, None
            ]
            ahead = y - along
            for _ in range(3):
                ahead = ahead - (G @ self.openness(ahead / w)[..., None])[..., 0]
            good = np.abs(self.openness(ahead / w)).max(axis=1) < 1e-6
            good &= np.linalg.norm(ahead, axis=1) < np.linalg.norm(y, axis=1) + 1e-12
            y, share = np.where(good[:, None], ahead, y), np.where(good, share, share / 2)
        return y[np.argsort(np.linalg.norm(y, axis=1))]

    def wrapped(self, q):
        return q - self.turning * 2 * np.pi * np.rint(q / (2 * np.pi))


def apart(y):
    """Those of some poses, by their motion, that are apart by a fifth of the least motion."""
    kept: list[np.ndarray] = []
    for pose in y:
        if all(np.linalg.norm(pose - other) > 0.2 * np.linalg.norm(y[0]) for other in kept):
            kept.append(pose)
    return np.array(kept).reshape(-1, y.shape[1])


def compare(path: Path, seed: int, starts: int = 200) -> Compared | None:
    """Compare the pose taken with the nearest; None if the search finds fewer than two."""
    draft = read_unassembled(path, None, ReadOptions(bodies="all"))
    if draft.mimics or any(joint.kind == "helical" for joint in draft.joints):
        return None
    search, rng = Search(draft), np.random.default_rng(seed)
    reaches = [r * np.ones((starts // 4, 1)) for r in (0.0, 0.6, 1.5, 3.0)]
    reach = np.concatenate(reaches)
    y = search.closed(reach * rng.uniform(-1, 1, (len(reach), len(draft.joints))))
    kept = apart(y)
    if len(kept) < 2 or np.linalg.norm(y[0]) < 1e-3:
        return None
    try:
        linkage = kinematics.load(path, bodies="all")
    except MobilityError:
        return None
    assert linkage.displaced is not None
    left = {notice.code for notice in linkage.notices} & {"left_singular_pose"}
    q = search.wrapped(linkage.displaced / search.units)
    if left:
        return None
    followed = search.slid((q * search.weights)[None], 150, 0.05)
    motions = (float(np.linalg.norm(x)) for x in (q * search.weights, followed[0], y[0]))
    return Compared(path.stem, *motions, len(kept))


def cases(folder: Path, seed: int = 0):
    """Yield files of opened linkages: models of the gallery, and random families."""
    for number in count(seed):
        rng = np.random.default_rng([number, 19])
        source, name = kinematics.gallery()[MODELS[number // 2 % len(MODELS)]], ""
        if number % 2:
            family = FAMILIES[number // 2 % len(FAMILIES)]
            source, name = folder / "closed.urdf", family
            source.write_text(urdf(generated(family, number)))
            try:
                if not kinematics.load(source, bodies="all").loops:
                    continue
            except LinkageError:
                continue
        yield opened(source, folder / f"{number}_{name or source.stem}.urdf", rng), number


def main() -> int:
    """Compare cases from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--starts", type=int, default=200)
    options = parser.parse_args()
    found: list[Compared] = []
    with tempfile.TemporaryDirectory() as folder:
        for path, number in cases(Path(folder), options.seed):
            case = compare(path, number, options.starts)
            if case is None:
                continue
            found.append(case)
            if len(found) % 20 == 0:
                print(f"{len(found)} cases", file=sys.stderr, flush=True)
            if not case.right:
                print(
                    f"{case.name}: {case.taken:.4f} taken, {case.followed:.4f} followed, "
                    f"{case.nearest:.4f} nearest of {case.branches}",
                    flush=True,
                )
            if len(found) == options.cases:
                break
    right = sum(case.right for case in found)
    excess = np.array([case.taken / case.nearest for case in found])
    least = sum(case.least for case in found)
    print(
        f"{right} of {len(found)} took the nearest branch ({least} within 15 % of the least "
        f"motion) of {min(c.branches for c in found)} to "
        f"{max(c.branches for c in found)} poses; motion over the least: median "
        f"{np.median(excess):.3f}, largest {excess.max():.3f}"
    )
    return int(right < len(found))


if __name__ == "__main__":
    sys.exit(main())
