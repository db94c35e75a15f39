"""Paths of the linkages of the gallery with two or more inputs, from five starts each.

Three of them, or with ``ALL_CASES=1`` all. Where a linkage has no path without any reaction,
one without force or without moment is followed: `balance verify --csv` cannot accept the last.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.app.cli.main import main
from balance.motion.paths.follow import follow_arc
from balance.motion.paths.path import path_table
from balance.motion.paths.rest_equations import RestEquations
from kinematics import gallery, load
from kinematics.errors import LinkageError
from tests.support.covering import ALL_CASES, number_of_cases

LENGTH = 0.4
STARTS = 5


def first_paths(linkage, starts):
    """Paths of the largest part of the momentum that has some."""
    for kept in ("all", "force", "moment"):
        found = balance.find_paths(linkage, starts, kept=kept, length=LENGTH)
        if found.paths:
            return found
    return found


def check_linkage(name, folder, count=STARTS):
    """Momentum, way back, and verification of the paths from some starts; counts of each."""
    linkage = load(name)
    rng = np.random.default_rng(2)
    size = 0.05 * linkage.spatial_chain.frame.length
    slides = [
        linkage.joints[j].kind == "prismatic" for j in linkage.positions_of(linkage.inputs)
    ]
    starts = []
    for _ in range(20 * count):
        if len(starts) == count:
            break
        u = rng.uniform(-1, 1, linkage.mobility) * np.where(slides, size, 0.15)
        try:
            balance.find_paths(linkage, [u], kept="force", length=1e-3)
        except LinkageError:
            continue
        starts.append(u)
    found = first_paths(linkage, starts)
    equations = RestEquations(linkage, found.demand)
    units = equations.chain.units
    verified = 0
    for path in found.paths:
        assert path.residual <= 1e-8 and path.closure <= 1e-12, (name, path)
        if found.dimension == 1:
            there = equations.at(path.q[-1] / units)
            slope = path.u[-2] - path.u[-1]
            back = equations.basis.T @ (slope / equations.units)
            arc = follow_arc(equations, there.q, back / np.linalg.norm(back), path.s[-1], 1)
            end = equations.close(arc.positions(float(path.s[-1])))
            start = found.starts[path.start].q / units
            assert np.abs(end - start).max() <= 1e-8, (name, np.abs(end - start).max())
        if found.demand.kept != "moment":
            table = folder / "path.csv"
            table.write_bytes(path_table(linkage, path))
            words = ["--balance", "force"] * (found.demand.kept == "force")
            assert main(["verify", name, "--csv", str(table), *words]) == 0, name
            verified += 1
    return found.demand.kept, found.dimension, len(found.paths), verified


# One path and a family of several; of the force, of the moment, of both.
NAMES = ["five_bar", "three_rrr", "zero_reaction_arm"]


@pytest.mark.table(2)
@pytest.mark.parametrize("name", sorted(gallery()) if ALL_CASES else NAMES)
def test_paths_of_the_gallery(name, tmp_path, capsys):
    """One start of three linkages; five of all that have paths with ``ALL_CASES=1``."""
    if load(name).mobility < 2 or name == "delta":
        pytest.skip("one input, or as many components as inputs")
    count = number_of_cases(1, STARTS)
    kept, dimension, paths, verified = check_linkage(name, tmp_path, count)
    assert paths >= count and dimension >= 1 and (verified or kept == "moment")
