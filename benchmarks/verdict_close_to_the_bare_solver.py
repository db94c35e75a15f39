"""Claim: a checked verdict takes at most half as long again as the bare solver's answer.

The bare solver gets the same cone program, its matrices ready made, and its answer is neither
polished nor checked.
"""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory

import clarabel
from scipy.sparse import csc_matrix

from balance import design_space
from balance.designs.conic import Part
from balance.designs.feasibility import feasible, least_traces
from balance.designs.restriction import Restriction, program
from balance.space import DesignSpace
from benchmarks.geometry import resized
from kinematics.models import load


def _spaces(model: str) -> list[DesignSpace]:
    """Design spaces of several sizes, or of one arm of so many links."""
    if not model.isdigit():
        name, _, motion = model.partition("+")
        return [design_space(a, motion or None) for a in resized(name, 8, seed=5)]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(_arm(int(model)), encoding="utf-8")
        return [design_space(load(path))]


class VerdictCloseToTheBareSolver:
    """Spatial linkages of 3, 7, 13 and 30 bodies, with designs and without."""

    params = (
        (3, "bennett"), (7, "three_rsr"), (7, "three_rsr+u2=u3"), (13, "stewart_6ups"),
        (30, "30"),
    )  # fmt: skip
    claims = (("time_verdict", "time_bare", 1.5),)

    def setup(self, bodies: int, model: str) -> None:
        """Design spaces, and their programs as the solver takes them."""
        spaces = _spaces(model)
        assert {len(space.bodies) for space in spaces} == {bodies}
        self.spaces = cycle(spaces)
        self.programs = cycle([_bare(space) for space in spaces])

    def time_verdict(self, bodies: int, model: str) -> None:
        """The public call."""
        feasible(next(self.spaces))

    def time_bare(self, bodies: int, model: str) -> None:
        """Only the solver."""
        clarabel.DefaultSolver(*next(self.programs)).solve()


class PlanarVerdictAddsAFewTenthsOfAMillisecond(VerdictCloseToTheBareSolver):
    """Planar linkages of three bodies, without a design and with one.

    The solver takes 0.1 ms for them, less than the polish and the check of any answer, which
    take 0.3 ms: the claim of the spatial ones cannot hold here.
    """

    params = ((3, "four_bar_general"), (3, "four_bar_antiparallelogram"))
    claims = (("time_verdict", "time_bare", 8.0),)


def _bare(space: DesignSpace) -> tuple:
    """Arguments of the solver."""
    q, rows, offset, parts = least_traces(program(space, Restriction()))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    cones = [_cone(part) for part in parts]
    return csc_matrix((q.size, q.size)), q, csc_matrix(-rows), offset, cones, settings


def _cone(part: Part) -> object:
    kinds = {"matrix": clarabel.PSDTriangleConeT, "lorentz": clarabel.SecondOrderConeT}
    return kinds[part.kind](part.size)


def _arm(count: int) -> str:
    """A file with a serial arm whose hinges are square to each other in turn."""
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    links = ['<link name="l0"/>']
    for k in range(1, count + 1):
        axis = " ".join("1" if k % 3 == i else "0.3" for i in range(3))
        links.append(
            f'<link name="l{k}"><inertial><mass value="1"/>{inertia}</inertial></link>'
            f'<joint name="j{k}" type="continuous"><parent link="l{k - 1}"/>'
            f'<child link="l{k}"/><origin xyz="0.3 0.1 0.2"/><axis xyz="{axis}"/></joint>'
        )
    return "\n".join(['<robot name="arm">', *links, "</robot>"])
