"""A short run of every kernel of this package and of `kinematics`, to compile them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import numpy as np

from balance.motion.pose.momentum_of_masses import MassedChain
from balance.motion.pose.workspace_map import momentum_map
from balance.motion.taylor_poses.prediction import predict
from balance.motion.verification.shaking_wrench import (
    load_regressors,
    motion_in_chain,
    shaking,
    shaking_along,
)
from balance.motion.verification.trajectory import random_motions
from balance.space.certification.certify_space import certify
from balance.space.interpretation.explain import explain
from balance.space.many.many_geometries import design_space_many
from balance.space.many.placing_kernels import points_on_axes
from balance.space.momentum.regressor import momentum_regressor
from balance.space.momentum.regressor_polynomial import momentum_taylor
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from balance.studies.sweeps.sweep import sweep
from balance.support.options import Balance
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.taylor.taylor_motion import taylor_motion
from kinematics.errors import LinkageError
from kinematics.loading.warmup import (
    smallest_linkages,
    warm_up_many_poses,
    warm_up_single_poses,
)
from kinematics.model.linkage import Linkage
from kinematics.numerics.compiled.background import waiting_verb

SMALL_STEP = 0.01
# Kinds of balance, and whether in space, that need kernels of their own.
OPTIONS: tuple[tuple[Balance, bool], ...] = (("force", False), ("dynamic", True))


def warm_up_balance() -> Iterator[None]:
    """Run the work of the commands on the smallest linkage of each kind.

    The kernels of the first answer come first, those of many poses and geometries last. Yields
    after each stage.
    """
    linkages = smallest_linkages()
    yield
    yield from warm_up_single(linkages)
    yield from _run_stages(linkages, _map_momentum, _find_spaces_of_many)
    yield from warm_up_many_poses(linkages)


def warm_up_single(linkages: Sequence[Linkage]) -> Iterator[None]:
    """Run what is done with linkages in one pose and geometry; yields after each stage.

    What the command that waits for kernels does most comes first.
    """
    first = NEEDED.get(waiting_verb(), (_find_space,))
    stages = (_find_space, _follow, _move, _predict, _find_other_spaces)
    yield from _run_stages(linkages, *sorted(stages, key=lambda work: work not in first))
    yield from warm_up_single_poses(linkages)


def _run_stages(
    linkages: Sequence[Linkage], *stages: Callable[[Linkage], None]
) -> Iterator[None]:
    for work in stages:
        for linkage in linkages:
            with suppress(LinkageError):
                work(linkage)
            yield


def _find_space(linkage: Linkage) -> None:
    space = certify(design_space(linkage))
    explain(space)
    distance_to_rank_drop(space)
    points = np.array([joint.point for joint in linkage.joints])
    points_on_axes(np.array([joint.screw for joint in linkage.joints]), points.copy(), points)


def _follow(linkage: Linkage) -> None:
    list(random_motions(linkage, 1, 3))


def _move(linkage: Linkage) -> None:
    chain = input_chain(linkage)
    for way in random_motions(linkage, 1, 3):
        shaking(linkage, way.q, way.qd, way.qdd)
        shaking_along(linkage, way)
        load_regressors(chain, *motion_in_chain(linkage, chain, way))


# What a verb does most, if that is not to find a design space. Uncompiled, remedies for a
# four-bar spend nine tenths of their time in the two kernels of these stages.
NEEDED = dict.fromkeys(("verify", "remedies"), (_follow, _move))


def _predict(linkage: Linkage) -> None:
    inputs = np.full(linkage.mobility, SMALL_STEP)
    predict(taylor_motion(linkage, 2), inputs)
    momentum_regressor(linkage, inputs)
    momentum_taylor(linkage, 2)
    massed, rest = MassedChain.of(linkage), np.zeros((1, len(linkage.joints)))
    massed.momenta(rest)
    massed.body_momenta(rest)


def _find_other_spaces(linkage: Linkage) -> None:
    for balance, spatial in OPTIONS:
        certify(design_space(linkage, None, balance, max_order=2, spatial=spatial))


def _map_momentum(linkage: Linkage) -> None:
    momentum_map(linkage, {linkage.inputs[0]: [0.0, SMALL_STEP]})


def _find_spaces_of_many(linkage: Linkage) -> None:
    screws = np.array([joint.screw for joint in linkage.joints])[None]
    for balance, spatial in OPTIONS:
        design_space_many(linkage, screws, balance, spatial=spatial, bases=True)
    first = linkage.joints[0]
    sweep(linkage, {f"{first.whole}.origin.x": [float(first.point[0])]})
