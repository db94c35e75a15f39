"""Dynamic balance of linkages: which mass distributions do not shake the base.

Parameters of a body are ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the
inertial origin; momentum is ``[moment; force]``; SI units. ``kinematics.load`` reads linkages.

The space of balanced mass distributions:

- ``design_space``: the space of a linkage, by floating-point arithmetic
- ``design_space_many``: spaces of one topology in many geometries, on all cores
- ``certify``: confirm or correct the integers of a space, and state how sure they are
- ``exact_ranks``: ranks of the conditions by order, as whole numbers without a tolerance
- ``distance_to_rank_drop``: smallest change of geometry that lowers the rank
- ``save_space``: write a space to a file
- ``load_space``: read a space that was saved
- ``DesignSpace``: mass distributions with vanishing momentum in every motion of a linkage
- ``CertifiedSpace``: a space whose integers were confirmed or corrected
- ``ManySpaces``: results of ``design_space_many``, geometry by geometry
- ``SpaceRecord``: a space as data, without the linkage it came from
- ``BodyInertia``: inertial parameters of a body, and what follows from them
- ``Certainty``: certainty of the integers, by exact arithmetic and fresh poses
- ``Exact``: ranks by exact arithmetic
- ``Proof``: lower bounds on rank and nullity that add up to the number of parameters

Many geometries of a model:

- ``sweep``: compute quantities of a model in many geometries
- ``read_study``: read what varies and what is computed from a TOML file
- ``Study``: a model, what varies in it, what must hold, and what is computed
- ``SweepTable``: result of ``sweep``, column by column

Modes of motion that meet at a pose:

- ``motion_modes``: the space of each mode, and whether its masses can be built
- ``ModeAnswer``: a mode of motion, and which masses balance the linkage on it
- ``ModeAnswers``: result of ``motion_modes``

Decoupling, inertia on a base that moves:

- ``decoupling``: balanced distributions that keep the inertia on the base constant
- ``locked_inertia``: inertia of the linkage on its base at a pose, joints locked
- ``Decoupling``: the space of these distributions, and whether the masses of the file are in it

Its meaning:

- ``explain``: explain a space joint by joint, and what the loops add
- ``Explanation``: a space in terms of point masses, displacements and pure-inertia rods
- ``Freedom``: one way to change the masses that leaves the linkage balanced
- ``Primitive``: one element of a mass distribution
- ``Transfer``: inertial parameters that bodies can exchange across one joint

Masses that bodies can have:

- ``design``: the best design of a space, or a certificate that there is none
- ``counterweights``: the least matter, added inside regions of links, that balances
- ``feasible``: whether a space holds a distribution that can be built
- ``check_certificate``: check a certificate without the solver
- ``check_design``: check a design without the solver
- ``CertificateCheck``: what the check of a certificate found
- ``Counterweights``: added matter, or why none balances
- ``Design``: a design, or why there is none
- ``DesignCheck``: what the check of a design found
- ``Feasibility``: the verdict on a space
- ``Region``: a convex region of a link frame in which matter may be added

Masses of equal momentum:

- ``pure_inertia``: move all point masses of a planar linkage, until it has inertias alone
- ``buildable_masses``: masses that can be built, from chosen pure inertias
- ``BuildableMasses``: these masses, or why there are none
- ``PureInertia``: pure inertias, masses moved, relations of angular velocities

Least shaking for a budget:

- ``partial``: the matter within a budget that lets a linkage shake least along motions
- ``pareto``: designs between nothing added and the least shaking
- ``ElasticFrame``: a frame on springs and dampers that carries a linkage
- ``ParetoFront``: result of ``pareto``
- ``PartialBalance``: result of ``partial``

What to build in where no masses balance:

- ``compare_remedies``: apply the remedies of the literature, and compare what each costs
- ``fewest_rotors``: the smallest sets of counter-rotations with which masses balance
- ``AppliedRemedy``: one remedy, its verdict and its cost
- ``FewestRotors``: result of ``fewest_rotors``
- ``RemedyComparison``: result of ``compare_remedies``
- ``RotorSet``: one of the smallest sets

Mechanisms that are balanced by design:

- ``synthesize``: balanced mechanisms whose tool passes through two or three positions
- ``PantographMasses``: lengths and masses of a pantograph
- ``Synthesis``: result of ``synthesize``
- ``SynthesizedMechanism``: one mechanism, its file and what confirms it

Shaking in motion:

- ``shaking``: shaking force and moment along a motion
- ``verify``: whether a linkage shakes its base, by Pinocchio and by our own series
- ``Trajectory``: a motion sampled in time
- ``Verification``: the verdict of ``verify`` and what it rests on

Links that bend, in the plane:

- ``simulate_flexible``: simulate a linkage of which named links bend, and its shaking
- ``supported_modes``: bending modes of a beam, free or on supports
- ``free_modes``: bending modes of a free beam, to full precision
- ``support_points``: points and weights on which a beam shakes its mount in no low mode
- ``similar_arm``: the counter-arm that bends like an arm
- ``compare_arms``: conditions under which two arms bend alike
- ``Arm``: a beam clamped on a hub, with a body at its tip
- ``Beam``: a uniform beam
- ``Clamp``: a clamp of a beam
- ``EndBody``: a body at the end of a beam
- ``FlexibleSimulation``: result of ``simulate_flexible``
- ``FreeMode``: a mode of a free beam
- ``Similarity``: result of ``compare_arms``
- ``Support``: a pin of a beam, or a whippletree
- ``SupportPoints``: result of ``support_points``
- ``SupportedModes``: result of ``supported_modes``

On a base that floats, or stands on springs:

- ``simulate_floating_base``: simulate the motion of the base that a linkage causes
- ``FloatingBase``: a base with mass, inertia and springs
- ``FloatingBaseMotion``: result of ``simulate_floating_base``

Momentum as a function of the pose:

- ``momentum_regressor``: regressor of the total momentum at a finite pose
- ``momentum_taylor``: the regressor as a polynomial about the reference pose
- ``MomentumTaylor``: that polynomial

Balance in one pose:

- ``balance_pose``: bodies on input joints solved so that a linkage is balanced in a pose
- ``balancing_family``: all bodies that have a given momentum for a given twist
- ``BalancingFamily``: result of ``balancing_family``
- ``PoseBalance``: result of ``balance_pose``

Velocities without reaction:

- ``momentum_matrix``: total momentum per unit rate of each input, for given masses
- ``momentum_map``: the momentum matrix over a grid of poses
- ``reaction_null_space``: input rates that leave the base at rest in a pose
- ``MomentumMap``: result of ``momentum_map``
- ``ReactionNullSpace``: result of ``reaction_null_space``

Paths without reaction:

- ``find_paths``: integrate such velocities into paths, and find where several of them meet
- ``ReactionlessPaths``: result of ``find_paths``
- ``ReactionlessPath``: one path, and the momentum along it
- ``timed_path``: a motion along a path, from rest to rest
- ``Base``: a base that floats, with a mass of its own

Momentum as lines:

- ``momentum_wrenches``: momentum of each body for unit rates of the coordinates
- ``momentum_lines``: the same as lines with a pitch
- ``meeting``: the point nearest to lines
- ``common_normal``: the line that lines meet at right angles
- ``screw_figure``: a picture of the lines at a pose
- ``Meeting``: the point nearest to several lines
- ``ScrewLine``: the line of a body's momentum

Parameters of one body:

- ``parameters``: from mass, centre of mass and inertia about that centre
- ``mass_properties``: mass, centre of mass and central inertia of parameters
- ``pseudo_inertia``: the matrix (4, 4) that is positive for physical bodies
- ``violations``: inequalities of physical bodies that parameters break
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from balance.public_names import MODULES_OF_NAMES
from kinematics.numerics.compiled.background import register_warm_up

if TYPE_CHECKING:
    from balance.masses.counterweights.answer import Counterweights
    from balance.masses.counterweights.counterweights import counterweights
    from balance.masses.counterweights.regions import Region
    from balance.masses.designs.best_design import Design, design
    from balance.masses.designs.certificate import CertificateCheck, check_certificate
    from balance.masses.designs.design_check import DesignCheck, check_design
    from balance.masses.designs.feasibility import Feasibility, feasible
    from balance.masses.modes.mode_answers import ModeAnswer, ModeAnswers, motion_modes
    from balance.masses.partial.budgets import pareto, partial
    from balance.masses.partial.elastic_frame import ElasticFrame
    from balance.masses.partial.results import ParetoFront, PartialBalance
    from balance.masses.pure_inertias.buildable_masses import BuildableMasses, buildable_masses
    from balance.masses.pure_inertias.pure_inertia import PureInertia, pure_inertia
    from balance.masses.remedies.applied import AppliedRemedy
    from balance.masses.remedies.compare import RemedyComparison, compare_remedies
    from balance.masses.remedies.counter_rotations.fewest_rotors import (
        FewestRotors,
        RotorSet,
        fewest_rotors,
    )
    from balance.motion.flexible.beam import Beam
    from balance.motion.flexible.free_modes import FreeMode, free_modes
    from balance.motion.flexible.linkage_motion import FlexibleSimulation, simulate_flexible
    from balance.motion.flexible.similarity import Arm, Similarity, compare_arms, similar_arm
    from balance.motion.flexible.support_points import SupportPoints, support_points
    from balance.motion.flexible.supported_modes import (
        Clamp,
        EndBody,
        Support,
        SupportedModes,
        supported_modes,
    )
    from balance.motion.floating_base.base import FloatingBase
    from balance.motion.floating_base.result import FloatingBaseMotion
    from balance.motion.floating_base.simulate import simulate_floating_base
    from balance.motion.paths.demand import Base
    from balance.motion.paths.found_paths import ReactionlessPaths
    from balance.motion.paths.path import ReactionlessPath, timed_path
    from balance.motion.paths.path_search import find_paths
    from balance.motion.pose.body_family import BalancingFamily, balancing_family
    from balance.motion.pose.momentum_of_masses import momentum_matrix
    from balance.motion.pose.null_space import ReactionNullSpace, reaction_null_space
    from balance.motion.pose.proximal_bodies import PoseBalance, balance_pose
    from balance.motion.pose.workspace_map import MomentumMap, momentum_map
    from balance.motion.verification.result import Verification
    from balance.motion.verification.shaking_wrench import shaking
    from balance.motion.verification.to_pinocchio import verify
    from balance.motion.verification.trajectory import Trajectory
    from balance.space.certification.certified_space import CertifiedSpace
    from balance.space.certification.certify_space import certify
    from balance.space.certification.exact_ranks import exact_ranks
    from balance.space.decoupled.decoupling import Decoupling, decoupling
    from balance.space.decoupled.locked_inertia import locked_inertia
    from balance.space.exact.modular_ranks import Exact
    from balance.space.exact.proof import Proof
    from balance.space.inertial_parameters.body_inertia import BodyInertia
    from balance.space.inertial_parameters.conversions import (
        mass_properties,
        parameters,
        pseudo_inertia,
        violations,
    )
    from balance.space.inertial_parameters.multipole import Primitive
    from balance.space.interpretation.explain import Explanation, explain
    from balance.space.interpretation.freedoms import Freedom
    from balance.space.many.many_geometries import design_space_many
    from balance.space.many.many_spaces import ManySpaces
    from balance.space.momentum.momentum_figure import screw_figure
    from balance.space.momentum.momentum_lines import (
        Meeting,
        ScrewLine,
        common_normal,
        meeting,
        momentum_lines,
        momentum_wrenches,
    )
    from balance.space.momentum.momentum_taylor_series import MomentumTaylor, momentum_taylor
    from balance.space.momentum.regressor import momentum_regressor
    from balance.space.spaces.certainty import Certainty
    from balance.space.spaces.compute_space import design_space
    from balance.space.spaces.design_space import DesignSpace
    from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
    from balance.space.spaces.save import SpaceRecord, load_space, save_space
    from balance.space.transfers.by_joint import Transfer
    from balance.studies.sweeps.study import Study, read_study
    from balance.studies.sweeps.sweep import sweep
    from balance.studies.sweeps.sweep_table import SweepTable
    from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
    from balance.studies.synthesis.pantograph import PantographMasses
    from balance.studies.synthesis.synthesize import synthesize

__all__ = [
    "AppliedRemedy", "Arm", "BalancingFamily", "Base", "Beam", "BodyInertia", "BuildableMasses",
    "Certainty", "CertificateCheck", "CertifiedSpace", "Clamp", "Counterweights", "Decoupling",
    "Design", "DesignCheck", "DesignSpace", "ElasticFrame", "EndBody", "Exact", "Explanation",
    "Feasibility", "FewestRotors", "FlexibleSimulation", "FloatingBase", "FloatingBaseMotion",
    "FreeMode", "Freedom", "ManySpaces", "Meeting", "ModeAnswer", "ModeAnswers", "MomentumMap",
    "MomentumTaylor", "PantographMasses", "ParetoFront", "PartialBalance", "PoseBalance",
    "Primitive", "Proof", "PureInertia", "ReactionNullSpace", "ReactionlessPath",
    "ReactionlessPaths", "Region", "RemedyComparison", "RotorSet", "ScrewLine", "Similarity",
    "SpaceRecord", "Study", "Support", "SupportPoints", "SupportedModes", "SweepTable",
    "Synthesis", "SynthesizedMechanism", "Trajectory", "Transfer", "Verification",
    "balance_pose", "balancing_family", "buildable_masses", "certify", "check_certificate",
    "check_design", "common_normal", "compare_arms", "compare_remedies", "counterweights",
    "decoupling", "design", "design_space", "design_space_many", "distance_to_rank_drop",
    "exact_ranks", "explain", "feasible", "fewest_rotors", "find_paths", "free_modes",
    "load_space", "locked_inertia", "mass_properties", "meeting", "momentum_lines",
    "momentum_map", "momentum_matrix", "momentum_regressor", "momentum_taylor",
    "momentum_wrenches", "motion_modes", "parameters", "pareto", "partial", "pseudo_inertia",
    "pure_inertia", "reaction_null_space", "read_study", "save_space", "screw_figure",
    "shaking", "similar_arm", "simulate_flexible", "simulate_floating_base", "support_points",
    "supported_modes", "sweep", "synthesize", "timed_path", "verify", "violations",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a public name when it is first used: the command line needs few of them."""
    from importlib import import_module

    if name == "__version__":
        from kinematics.version import __version__

        return __version__
    if name in MODULES_OF_NAMES:
        value = getattr(import_module(f"balance.{MODULES_OF_NAMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'balance' has no attribute '{name}'")


def __dir__() -> list[str]:
    """List the public names, for help and for completion, imported or not."""
    return sorted({*globals(), *__all__, "__version__"})


def _warm_up() -> Iterator[None]:
    """Run all kernels of this package and of `kinematics`, stage by stage."""
    from balance.app.warmup import warm_up_balance

    yield from warm_up_balance()


register_warm_up("balance", _warm_up)
