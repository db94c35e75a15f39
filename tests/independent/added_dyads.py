"""How many random four-bars can be balanced by an added dyad.

``python -m tests.independent.added_dyads --cases 200 --seed 0 --out DIR`` draws four-bars with
hinges at random decimals, none of which masses of its own balance, tries the known dyads of
`balance.masses.remedies.dyads.added_dyad` on each, and walks from random ones with
``--walks N``. The first dyad with buildable masses is written to DIR, with masses, and read
again. Pinocchio must confirm the file to 1e-9; how sure the rank of its conditions is, is
counted.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from balance import certify, design_space, verify
from balance.masses import feasible
from balance.masses.designs.write_urdf import replace_inertials
from balance.masses.remedies.dyads.added_dyad import buildable_space, walks_from_random
from balance.masses.remedies.dyads.dyad_geometry import dyad_document
from balance.masses.remedies.dyads.known_dyads import DyadSeed, dyad_seeds
from balance.masses.remedies.request import RemedyRequest
from kinematics import ScrewJoint, from_screws, load
from kinematics.errors import LinkageError
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage

VERIFIED = 1e-9


class Member(NamedTuple):
    """A dyad that balances a four-bar.

    Attributes:
        words: what it is.
        urdf: the four-bar with it, and masses.
        residual: largest shaking by Pinocchio, relative to the bodies' own inertia wrenches.
        certainty: of its design space.
    """

    words: str
    urdf: bytes
    residual: float
    certainty: str


def four_bar(a: complex, b: complex, d: complex) -> Linkage:
    """Build a four-bar with hinges at 0 and d on the ground, a and b on the coupler."""
    points = [(point.real, point.imag, 0.0) for point in (a, b, d)]
    joints = [
        ScrewJoint("u1", "base", "crank"),
        ScrewJoint("q2", "crank", "coupler", point=points[0]),
        ScrewJoint("q4", "base", "rocker", point=points[2]),
    ]
    loop = ScrewJoint("q3", "coupler", "rocker", point=points[1])
    return from_screws(joints, [loop], inputs=["u1"], name="four_bar")


def random_four_bars(seed: int) -> Iterator[tuple[Linkage, list[float]]]:
    """Yield four-bars that no masses of their own balance, and their lengths."""
    rng = np.random.default_rng(seed)
    while True:
        x = np.round(rng.uniform(-1.5, 1.5, 4), 3)
        a, b, d = complex(x[0], x[1]), complex(x[2], x[3]), 1.0 + 0.0j
        lengths = [1.0, abs(a), abs(b - a), abs(d - b)]
        if min(lengths) < 0.2:
            continue
        try:
            linkage = four_bar(a, b, d)
            own = feasible(design_space(linkage))
        except LinkageError:
            continue
        if linkage.mobility == 1 and own.verdict == "infeasible":
            yield linkage, lengths


def find_member(linkage: Linkage, walks: int) -> tuple[Member | None, float]:
    """Find a dyad that balances a linkage, and the best residual of the walks."""
    request = RemedyRequest(linkage)
    for seed in dyad_seeds(linkage):
        if buildable_space(request, seed) is not None:
            found = _member(request, seed)
            if found is not None:
                return found, 0.0
    best = np.inf
    for ended, dyad in walks_from_random(request, False, walks):
        best, seed = min(best, ended.residual), DyadSeed(dyad, ended.numbers, "a general dyad")
        if ended.related and buildable_space(request, seed) is not None:
            found = _member(request, seed)
            if found is not None:
                return found, 0.0
    return None, best


def _member(request: RemedyRequest, seed: DyadSeed) -> Member | None:
    """Write a linkage with a dyad and masses, and verify the file; None if it shakes."""
    linkage = request.linkage
    document, _, _ = dyad_document(request.base, seed.dyad, seed.numbers, linkage.chain.frame)
    space = certify(design_space(load(document, None, linkage.inputs, bodies="all")))
    found = feasible(space)
    if found.y is None:
        return None
    masses = {body.name: body.urdf for body in space.bodies_of(found.y)}
    urdf = replace_inertials(space.linkage, masses)
    checked = verify(load(Document("four_bar.urdf", urdf)), trajectories=3)
    residual = max(checked.force_residual, checked.moment_residual)
    if not residual <= VERIFIED:
        return None
    words = f"{seed.words}, {seed.dyad.sides[0].name} to {seed.dyad.sides[1].name}"
    return Member(words, urdf, residual, space.certainty.level)


def main(arguments: list[str] | None = None) -> Counter[str]:
    """Run the cases, print each that gains, and return how many are of each kind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--walks", type=int, default=0, help="from random dyads, where none helps"
    )
    parser.add_argument("--out", type=Path, help="folder for the files of the members")
    options = parser.parse_args(arguments)
    counts, worst, start = Counter[str](), 0.0, time.time()
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
    for case, (linkage, lengths) in zip(
        range(options.cases), random_four_bars(options.seed), strict=False
    ):
        member, best = find_member(linkage, options.walks)
        counts["cases"] += 1
        text = " ".join(f"{length:.3f}" for length in lengths)
        if member is None:
            counts["none"] += 1
            print(f"{case:4} {text}  none, best residual {best:.1e}", flush=True)
            continue
        counts["gain"] += 1
        counts[member.words] += 1
        counts[member.certainty] += 1
        worst = max(worst, member.residual)
        print(
            f"{case:4} {text}  {member.words}, {member.residual:.1e}, {member.certainty}",
            flush=True,
        )
        if options.out is not None:
            (options.out / f"four_bar_{case:03}.urdf").write_bytes(member.urdf)
    print(dict(counts), f"worst residual {worst:.1e}, {time.time() - start:.0f} s")
    return counts


if __name__ == "__main__":
    main()
