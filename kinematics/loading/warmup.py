"""Run every kernel of this package once on small linkages, so that all are compiled.

The linkages are those of the gallery, the smallest of each kind: a kernel is compiled for types
of arrays, and these depend on the kind of linkage alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

from kinematics.closure.assembly.tool_frame import tool
from kinematics.closure.taylor.many_poses import taylor_motion_many
from kinematics.closure.taylor.taylor_motion import taylor_motion
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import gallery, load
from kinematics.model.linkage import Linkage
from kinematics.numerics.compiled.background import compile_mode

ORDER = 2


def warm_up_kinematics() -> Iterator[None]:
    """Run all kernels once, on the smallest linkages; yields after each stage."""
    linkages = smallest_linkages()
    yield
    yield from warm_up_single_poses(linkages)
    yield from warm_up_many_poses(linkages)


def warm_up_single_poses(linkages: Sequence[Linkage]) -> Iterator[None]:
    """Run the kernels of single poses: expand motions of linkages and of a tool."""
    for linkage in linkages:
        taylor_motion(linkage, ORDER)
        yield
        for body, direction in product(linkage.bodies, "xyz"):
            try:
                taylor_motion(tool(linkage, body.name, direction), ORDER)
            except LinkageError:
                continue  # the link cannot move that way
            break
        yield
    yield from _compile_inner_kernels()


def warm_up_many_poses(linkages: Sequence[Linkage]) -> Iterator[None]:
    """Run the kernels that expand motions of linkages at many poses."""
    for linkage in linkages:
        taylor_motion_many(linkage, [[0.0] * len(linkage.joints)], ORDER)
        yield
    yield from _compile_inner_kernels()


def _compile_inner_kernels() -> Iterator[None]:
    """Compile kernels that have run inside others, where kernels are compiled."""
    if compile_mode() != "never":
        from kinematics.numerics.compiled.numba_compiler import compile_inner_kernels

        yield from compile_inner_kernels()


def smallest_linkages() -> list[Linkage]:
    """Find the smallest linkage of each kind in the gallery."""
    linkages: dict[tuple[bool, ...], Linkage] = {}
    for linkage in sorted(
        map(load, gallery().values()), key=lambda linkage: len(linkage.joints)
    ):
        kind = linkage.planar, linkage.mobility > 1, bool(linkage.loops), bool(linkage.mimics)
        linkages.setdefault(kind, linkage)
    return list(linkages.values())
