"""Dynamic balance of linkages: which mass distributions do not shake the base.

Parameters of a body are ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the
inertial origin; momentum is ``[moment; force]``; SI units. Functions take a linkage, its path
or its name, or a space; results have ``to_dict``, and where there is something to write or to
show, ``to_urdf``, ``to_html`` and ``plot``.

Linkages:

- ``load``: a linkage from a file, from its text, or by its name (`kinematics.load`)

The space of balanced mass distributions:

- ``design_space``: the space of a linkage, by floating-point arithmetic
- ``certify``: confirm or correct the integers of a space, and state how sure they are
- ``DesignSpace``: mass distributions with vanishing momentum in every motion of a linkage
- ``CertifiedSpace``: a space whose integers were confirmed or corrected
- ``require``: the space of several requirements at once, in poses, along motions or everywhere
- ``RequiredSpace``: result of ``require``

Conditions as formulas:

- ``formulas``: the conditions of balance of a planar linkage in its dimensions
- ``Formulas``: result of ``formulas``

Many geometries of a model:

- ``sweep``: compute quantities of a model in many geometries
- ``SweepTable``: result of ``sweep``, column by column

Modes of motion that meet at a pose:

- ``motion_modes``: the space of each mode, and whether its masses can be built
- ``ModeAnswers``: result of ``motion_modes``

Its meaning:

- ``explain``: explain a space joint by joint, and what the loops add
- ``Explanation``: a space in terms of point masses, displacements and pure-inertia rods

Masses that bodies can have:

- ``design``: the best design of a space, or a certificate that there is none
- ``counterweights``: the least matter, added inside regions of links, that balances
- ``Counterweights``: added matter, or why none balances
- ``Design``: a design, or why there is none

Masses from measurements:

- ``identify``: masses from measured motions and loads, as far as balance depends on them
- ``Identification``: result of ``identify``

Least shaking for a budget:

- ``partial``: the matter within a budget that lets a linkage shake least along motions
- ``pareto``: designs between nothing added and the least shaking
- ``ParetoFront``: result of ``pareto``
- ``PartialBalance``: result of ``partial``

What to build in where no masses balance:

- ``compare_remedies``: apply the remedies of the literature, and compare what each costs
- ``RemedyComparison``: result of ``compare_remedies``

Springs that carry the weight:

- ``springs``: springs between links that balance gravity in every pose, or leave least torque
- ``SpringBalance``: result of ``springs``

Mechanisms that are balanced by design:

- ``synthesize``: balanced mechanisms whose tool passes through positions
- ``Synthesis``: result of ``synthesize``

Motions that shake least, with the masses as they are:

- ``quiet_motion``: the motion between two poses that shakes the base least
- ``quiet_timing``: the timing of a given path that shakes it least
- ``QuietMotion``: result of both

Shaking in motion:

- ``verify``: whether a linkage shakes its base, by Pinocchio and by our own series
- ``Verification``: the verdict of ``verify`` and what it rests on

Paths without reaction:

- ``find_paths``: integrate such velocities into paths, and find where several of them meet
- ``path_to_pose``: find such a path to a given pose, or one that turns a base that floats
- ``ReactionlessPaths``: result of ``find_paths`` and of ``path_to_pose``

Further names are in these modules:

- ``bodies``: parameters of one body
- ``checks``: checks of answers by another route
- ``flexible``: links that bend
- ``masses``: regions of matter, feasibility, pure inertias, sets of counter-rotations
- ``momentum``: momentum as a function of the pose, and as lines
- ``motion``: motions sampled in time, floating bases, paths
- ``pose``: balance in one pose, velocities without reaction
- ``space``: many geometries, decoupling, distance to a lower rank, files of spaces
- ``studies``: study files, synthesized mechanisms
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import lazy_loader

from balance.support.result_files import register_file_maker
from kinematics.numerics.compiled.background import register_warm_up
from kinematics.version import __version__ as __version__

# The names are in the file __init__.pyi; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _warm_up() -> Iterator[None]:
    """Run all kernels of this package and of `kinematics`, stage by stage."""
    from balance.app.warmup import warm_up_balance

    yield from warm_up_balance()


def _make_result_file(result: object, kind: str, **options: Any) -> bytes:
    """Make a page or a picture of a result."""
    from balance.app.answers.result_files import make_result_file

    return make_result_file(result, kind, **options)


register_warm_up("balance", _warm_up)
register_file_maker(_make_result_file)
