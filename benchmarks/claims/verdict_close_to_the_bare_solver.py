"""Claim: a checked verdict takes at most half as long again as the bare solver's answer.

The bare solver gets the same cone program with assembled matrices, and its result is neither
polished nor checked. The error is that of the verdict at finite poses: the residual momentum of
a design, or the part of the functional of a certificate outside the row space of the momentum
conditions. Either is infinite if a matrix is not positive semidefinite.
"""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory

import clarabel
import numpy as np
from scipy.sparse import csc_matrix

from balance import design_space
from balance.masses.designs.constraints import Constraints, build_program
from balance.masses.designs.feasibility import Feasibility, feasible, least_traces
from balance.masses.designs.pseudo_inertia_cone import from_si, parameters_by_body
from balance.space.inertial_parameters.conversions import pseudo_inertia
from balance.space.momentum.regressor import rows_at
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock
from benchmarks.inputs.geometry import resized
from kinematics.closure.newton import forward_kinematics, solve_positions
from kinematics.loading.model_gallery import load
from kinematics.model.spatial.inertia import from_pseudo_inertia

# Number of poses at which verdicts are tested.
POSES = 16
# Largest displacement of an input at these poses, on the same branch.
SIZE = 0.1


def _spaces(model: str) -> list[DesignSpace]:
    """Compute design spaces of several sizes of a model, or of a serial arm."""
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
        (3, "bennett"),
        (7, "three_rsr"),
        (7, "three_rsr+u2=u3"),
        (13, "stewart_6ups"),
        (30, "30"),
    )
    claims = (("time_verdict", "time_bare", 1.5), ("track_error", 1e-9))

    def setup(self, bodies: int, model: str) -> None:
        """Prepare design spaces, and their programs for the solver."""
        spaces = _spaces(model)
        assert {len(space.bodies) for space in spaces} == {bodies}
        self.own, self.spaces = spaces, cycle(spaces)
        self.programs = cycle([_bare(space) for space in spaces])

    def time_verdict(self, bodies: int, model: str) -> None:
        """The public call."""
        feasible(next(self.spaces))

    def time_bare(self, bodies: int, model: str) -> None:
        """The solver alone."""
        clarabel.DefaultSolver(*next(self.programs)).solve()

    def track_error(self, bodies: int, model: str) -> float:
        """Largest error over three sizes."""
        return max(_error(space, feasible(space)) for space in self.own[:3])


class PlanarVerdictAddsAFewTenthsOfAMillisecond(VerdictCloseToTheBareSolver):
    """Planar linkages of three bodies, without a design and with one.

    The solver takes 0.1 ms for them, less than the polish and the check of any answer, which
    take 0.3 ms: the claim of the spatial ones cannot hold here.
    """

    params = ((3, "four_bar_general"), (3, "four_bar_antiparallelogram"))
    claims = (("time_verdict", "time_bare", 8.0), ("track_error", 1e-9))


def _bare(space: DesignSpace) -> tuple:
    """Arguments of the solver."""
    q, rows, offset, parts = least_traces(build_program(space, Constraints()))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    cones = [_cone(part) for part in parts]
    return csc_matrix((q.size, q.size)), q, csc_matrix(-rows), offset, cones, settings


def _error(space: DesignSpace, found: Feasibility) -> float:
    """Relative residual of a design or a certificate at poses that were not used."""
    chain = space.chain
    poses = SIZE * np.random.default_rng(8).uniform(-1.0, 1.0, (POSES, chain.width))
    closed = [solve_positions(chain, chain.columns @ v)[0] for v in poses]
    X = np.concatenate([rows_at(chain, forward_kinematics(chain, q)) for q in closed])
    if found.z is not None:
        P = from_si(found.z, chain.frame)
        z = from_pseudo_inertia(P)[:, parameters_by_body(space)].reshape(-1)
        left = np.abs(X @ z).max() / (np.abs(X) @ np.abs(z)).max()
        return float(left) if np.linalg.eigvalsh(P).min() > 0.0 else np.inf
    if found.certificate is None:
        return np.inf
    Z = np.array(found.certificate)
    if np.linalg.eigvalsh(Z).min() < -1e-12 * np.abs(Z).max():
        return np.inf
    c = _functional(Z).reshape(-1)
    y = np.linalg.lstsq(X.T, c, rcond=1e-13)[0]
    return float(np.abs(X.T @ y - c).max() / np.abs(c).max())


def _functional(Z: np.ndarray) -> np.ndarray:
    """``<Z, P>`` of unit parameters; in a plane the trace of the second moments is Ezz."""
    if Z.shape[1] == 3:
        return np.column_stack([Z[:, 2, 2], 2.0 * Z[:, 0, 2], 2.0 * Z[:, 1, 2], Z[:, 0, 0]])
    units = [pseudo_inertia(unit) for unit in np.eye(10)]
    return np.einsum("bij,pij->bp", Z, units)


def _cone(part: ConstraintBlock) -> object:
    kinds = {
        "psd_triangle": clarabel.PSDTriangleConeT,
        "second_order": clarabel.SecondOrderConeT,
    }
    return kinds[part.kind](part.size)


def _arm(count: int) -> str:
    """Write a serial arm whose revolute axes point in three directions in turn."""
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
