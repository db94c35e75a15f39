"""Claim: our decision finds every rank; rules with a tolerance on stacked derivatives do not.

Every rule with a tolerance is applied to the derivatives of one linkage up to one order, in SI
units about the origin of the file; our decision is the public call. The cases are the linkages
of the gallery in three sizes, at the origin and a thousand lengths from it, with joints as in
the file and, if the ranks stay the same, rounded to six decimals. Exact arithmetic on the
decimals of the files is the reference.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from decimal import Decimal
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import scipy.linalg
from scipy.spatial.transform import Rotation

from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from balance.space.exact.modular_ranks import ExactRanks
from balance.space.momentum.regressor import RegressorSeries
from benchmarks.inputs.geometry import placed
from kinematics.closure.joint_positions import si_chain
from kinematics.closure.series import expand
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import gallery, load
from kinematics.model.linkage import Joint, Linkage
from kinematics.numerics.array_types import Array

SIZES = (1e-3, 1.0, 1e3)
OFFSETS = (0.0, 1e3)
HIGHEST = 10
DECIMALS = 6
INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LIMIT = '<limit effort="1" velocity="1" lower="-1" upper="1"/>'


def _pivoted_qr(A: Array) -> int:
    """Count pivots above 1e-8, in the units of the rows."""
    R = scipy.linalg.qr(A, mode="r", pivoting=True)[0]
    return int(np.sum(np.abs(np.diag(R)) > 1e-8))


def _unpivoted_qr(A: Array) -> int:
    """Count diagonal entries above 1e-8, without column exchanges."""
    return int(np.sum(np.abs(np.diag(np.linalg.qr(A, mode="r"))) > 1e-8))


def _svd(tolerance: float, A: Array) -> int:
    """Count singular values above a tolerance relative to the largest."""
    values = np.linalg.svd(A, compute_uv=False)
    return int(np.sum(values > tolerance * values[0]))


RULES: dict[str, Callable[[Array], int]] = {
    "pivoted QR": _pivoted_qr,
    "unpivoted QR": _unpivoted_qr,
    "SVD 1e-6": partial(_svd, 1e-6),
    "SVD 1e-9": partial(_svd, 1e-9),
    "SVD 1e-12": partial(_svd, 1e-12),
}


class RankRulesCompared:
    """Number of right ranks of each rule, for a model in all sizes, places and orders."""

    params = tuple((name,) for name in gallery())
    claims = (("track_wrong", 0.0),)
    total = True

    def setup(self, model: str) -> None:
        """Count the right ranks."""
        self.linkage = load(model)
        exact = exact_ranks(self.linkage)
        self.rays, self.kmax = len(exact.witness.rays), exact.kmax
        self.right = Counter(dict.fromkeys(("cases", "ours", *RULES), 0))
        with TemporaryDirectory() as folder:
            for linkage, exact in _variants(model, Path(folder)):
                for size, offset in product(SIZES, OFFSETS):
                    moved = _move(linkage, size, offset)
                    for order in _orders(exact):
                        self._compare(moved, exact, order)

    def time_ours(self, model: str) -> None:
        """Our decision, conditions included."""
        design_space(self.linkage)

    def time_svd(self, model: str) -> None:
        """A rule with a tolerance, from joint screws."""
        RULES["SVD 1e-9"](_stack_rows(self.linkage, self.rays, self.kmax))

    def _compare(self, linkage: Linkage, exact: ExactRanks, order: int) -> None:
        """Count the right ranks of one case."""
        ranks = {design_space(linkage, max_order=order).rank}
        if order == exact.kmax:
            ranks.add(design_space(linkage).rank)
        rows = _stack_rows(linkage, len(exact.witness.rays), order)
        self.right["cases"] += 1
        self.right["ours"] += ranks == {exact.rank}
        for name, rule in RULES.items():
            self.right[name] += rule(rows) == exact.rank

    def track_wrong(self, model: str) -> float:
        """Number of wrong ranks of our decision."""
        return self.right["cases"] - self.right["ours"]

    def row(self, model: str) -> dict[str, int]:
        """Number of cases, and of right ranks of each rule."""
        return dict(self.right)


def _variants(model: str, folder: Path) -> Iterator[tuple[Linkage, ExactRanks]]:
    """Yield the model, and the same with rounded joints if its ranks stay the same."""
    linkage = load(model)
    exact = exact_ranks(linkage)
    yield linkage, exact
    path = folder / "rounded.urdf"
    path.write_text(_write_rounded(linkage), encoding="utf-8")
    rounded = load(path)
    try:
        found = exact_ranks(rounded)
    except LinkageError:  # An overconstrained linkage that its decimals do not close.
        return
    if found.ranks == exact.ranks:
        yield rounded, found


def _orders(exact: ExactRanks) -> Iterator[int]:
    """Yield orders at which the rank is the final one."""
    yield from range(exact.kmax, max(exact.kmax, HIGHEST) + 1, 4)


def _move(linkage: Linkage, size: float, offset: float) -> Linkage:
    """Scale a linkage, and move it by a multiple of its characteristic length."""
    shift = size * offset * linkage.chain.frame.length * np.array([2.0, -1.0, 2.0]) / 3.0
    return placed(linkage, size, shift)


def _stack_rows(linkage: Linkage, rays: int, order: int) -> Array:
    """Stack momentum derivatives of the orders 0 … order; SI units, inertial origin."""
    chain = si_chain(linkage, not linkage.planar)
    directions = np.random.default_rng(4).standard_normal((rays, chain.width))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    X = RegressorSeries(chain, expand(chain, directions, order)).rows(order)
    return X.reshape(-1, X.shape[-1])


def _write_rounded(linkage: Linkage) -> str:
    """Write a file with the same joints at rounded positions.

    Positions have six decimals of a power of ten. A planar linkage is turned in its plane
    first, for most positions in the gallery have few decimals. Every joint becomes one of the
    tree, and every loop a weld.
    """
    turn = np.eye(3)
    if linkage.planar:
        turn = Rotation.from_rotvec(0.3 * linkage.chain.frame.R[2]).as_matrix()
    unit = int(np.floor(np.log10(linkage.chain.frame.length))) - DECIMALS
    points = [np.rint(turn @ joint.point / 10.0**unit) for joint in linkage.joints]
    places = np.array([*points, np.zeros(3)]).astype(int).tolist()

    def origin(link: int, parent: int) -> str:
        steps = (a - b for a, b in zip(places[link], places[parent], strict=True))
        return f'<origin xyz="{" ".join(str(Decimal(x).scaleb(unit)) for x in steps)}"/>'

    massive = {body.link for body in linkage.bodies}
    text = ['<robot name="rounded">', '<link name="l-1"/>']
    for k, joint in enumerate(linkage.joints):
        text.append(f'<link name="l{k}">{INERTIAL if k in massive else ""}</link>')
        text.append(_joint(joint, k, origin(k, joint.parent), turn, linkage.inputs))
    for loop in linkage.loops:
        text.append(
            f'<loop name="loop{loop.end}" type="fixed"><predecessor link="l{loop.end}"/>'
            f'<successor link="l{loop.successor}">{origin(loop.end, loop.successor)}'
            "</successor></loop>"
        )
    return "\n".join([*text, "</robot>"])


def _joint(joint: Joint, k: int, origin: str, turn: Array, inputs: tuple[str, ...]) -> str:
    """Write joint k as an element, between the links of the same numbers."""
    n, v = turn @ joint.screw[:3], turn @ joint.screw[3:]
    kind, axis, rest = "continuous", n, ""
    if joint.kind == "prismatic":
        kind, axis, rest = "prismatic", v, LIMIT
    elif joint.kind == "helical":
        rest = f'<screw_thread_pitch value="{2.0 * np.pi * float(n @ v)!r}"/>'
    mark = 'independent="true"' if joint.name in inputs else ""
    return (
        f'<joint name="{joint.name}" type="{kind}" {mark}>'
        f'<parent link="l{joint.parent}"/><child link="l{k}"/>'
        f'{origin}<axis xyz="{" ".join(map(repr, axis.tolist()))}"/>{rest}</joint>'
    )
