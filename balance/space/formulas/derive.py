"""Derivation of formulas: relations, solved parameters, entries, and checks of them.

They are checked at fresh geometries modulo another prime, and in the geometry of the file.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from time import monotonic

import numpy as np

from balance.space.formulas.formula_data import (
    Condition,
    Formulas,
    FormulaTerm,
    require_sympy,
)
from balance.space.formulas.geometry_samples import ConditionSamples, OutOfTimeError
from balance.space.formulas.interpolation import Degrees, TooManyTermsError
from balance.space.formulas.length_bounds import LengthBounds
from balance.space.formulas.modular_pose import UnclosedError
from balance.space.formulas.parameters import Parameter, name_parameters
from balance.space.formulas.polynomials import FactorPool, Polynomial, in_fewest_terms
from balance.space.formulas.problem import Dimensions, Parts, Problem, problem_of
from balance.space.formulas.relations import DimensionRelation
from balance.space.formulas.solved_parameters import choose_solved, interpolation_of
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import Balance
from balance.support.tolerances import FORMULA_AGREES
from kinematics.errors import ExactError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS

MAX_UNKNOWNS = 600
"""Most monomials of an entry; the time of a fit grows with their cube."""
SAME_GEOMETRY = 4
"""Number of times that two poses of one geometry are compared."""


RelationChoice = Callable[
    [Problem, DesignSpace, list[DimensionRelation], float | None],
    tuple[list[DimensionRelation], ConditionSamples],
]

# Size of a row over the largest, or singular value of unit rows: below this they vanish.
ROW_VANISHES = 1e-9
# Terms of a condition over the largest mass: below this it says that parameters are zero.
ROW_OF_ZEROS = 1e-3
# Smallest singular value of a space above which its basis is accurate to round-off.
KEPT_ACCURATELY = 1e-3
FRESH_GEOMETRIES = 20
"""Number of geometries at which formulas are checked."""


class SeveralMotionsError(ExactError):
    """Dimensions do not determine the conditions: they have several motions."""


def formulas(
    linkage: LinkageLike,
    balance: Balance = "dynamic",
    motion: Motion | str | Sequence[str] | None = None,
    *,
    where: str | Sequence[str] = (),
    solve: Sequence[str] = (),
    seconds: float | None = None,
    buildable: bool = False,
) -> Formulas:
    """Derive the conditions of balance of a linkage as formulas in its dimensions.

    Conditions at random geometries, which close exactly modulo a prime of 61 bits, are brought
    to reduced echelon form; its entries are rational functions of few dimensions, found by
    interpolation. Relations of the linkage, such as equal sides, are used where they lower the
    rank. All formulas are checked at fresh geometries and finite poses modulo another prime,
    and in the dimensions of the file against `balance.design_space`.

    The first moment ``s = m (x + i y)`` of a body is in the frame of its link, whose origin is
    its first joint and whose x-axis goes through its second one; so is the second moment J
    about that origin.

    Spatial linkages are open chains, or single loops with the ground. The frame of a link has
    its z-axis along its first joint, and its x-axis along the common normal to its second one,
    whose foot is the origin; there are the first moments sx, sy and sz, and the elements Jxx …
    Jyz of the inertia tensor.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        balance: ``"force"`` for complex conditions on m and s, or ``"dynamic"`` for real ones
            on m, s and J; those of spatial linkages are real.
        motion: restriction of the inputs, as for `balance.design_space`.
        where: relations between distances of joints, such as ``"AB=CD"``, that hold too; of
            spatial linkages between common normals, or dimensions by their names.
        solve: names of parameters to solve for, such as ``"s_crank"``; by default those that
            leave the fewest terms.
        seconds: return what is known after this time.
        buildable: find the lengths, too, for which balanced masses can be built; where they are
            in two lengths, a ratio of which is decided exactly.

    Returns:
        The conditions, each solved for a parameter; see `Formulas`.

    Raises:
        ExactError: the linkage is planar and its parts cannot be placed two at a time, or it
            is spatial with several loops; or its formulas are too large, or its special
            geometry is not understood; or a distance or parameter does not exist.
        UsageError: a relation is not written as one.
        PackageError: bounds need SymPy, which is not installed.

    Source:
        R. S. Berkof, G. G. Lowen, A new method for completely force balancing simple
        linkages, Journal of Engineering for Industry 91 (1969); R. Zippel, Effective
        Polynomial Computation, chapter 14; J. Denavit, R. S. Hartenberg, A kinematic notation
        for lower-pair mechanisms, Journal of Applied Mechanics 22 (1955).

    Example:
        >>> import balance
        >>> print(balance.formulas("robot.urdf", "force"))
        s_crank + (l_crank/l_rocker) s_rocker + l_crank m_coupler = 0
        s_coupler + (l_coupler/l_rocker) s_rocker = 0
    """
    space = design_space(linkage, motion, balance=balance)
    problem = problem_of(space, balance == "force")
    deadline = None if seconds is None else monotonic() + seconds
    given = problem.given_relations() + problem.parse(
        [where] if isinstance(where, str) else where
    )
    try:
        answer = _derived(problem, space, _fewest_relations, given, solve, deadline)
    except SeveralMotionsError:
        if not problem.choose_motion():
            raise
        answer = _derived(problem, space, _fewest_relations, given, solve, deadline)
        if not answer.unknown and not answer.residual <= FORMULA_AGREES:
            raise
    if not answer.unknown and answer.residual > FORMULA_AGREES:
        # Dimensions with fewer relations have conditions as many, and not those of the file.
        again = _derived(problem, space, _all_relations, given, solve, deadline)
        answer = again if again.confirmed else answer
    return replace(answer, bounds=_bounds(answer)) if buildable else answer


def _derived(
    problem: Problem,
    space: DesignSpace,
    choose_relations: RelationChoice,
    given: list[DimensionRelation],
    solve: Sequence[str],
    deadline: float | None,
) -> Formulas:
    """Derive formulas under relations that are chosen, and check them."""
    parameters = name_parameters(space.bodies, problem.force, space.chain.planar)
    relations, free = given, problem.free(given)
    conditions: tuple[Condition, ...] = ()
    unknown, geometries = space.rank, 0
    try:
        relations, samples = choose_relations(problem, space, given, deadline)
        free = samples.free
        samples.solve_for(choose_solved(samples, parameters, solve, space.chain.planar))
        conditions, unknown = _conditions(samples, space, parameters)
        samples.deadline = None
        geometries = 0 if unknown else fresh_geometries(samples, parameters, conditions)
    except OutOfTimeError:
        pass
    return Formulas(
        source=space.source,
        linkage=space.linkage,
        motion=space.motion,
        balance=space.balance,
        parts=problem.parts,
        relations=(*(relation.words for relation in relations), *free.further_words()),
        free=free,
        parameters=parameters,
        conditions=conditions,
        unknown=unknown,
        rank=space.rank,
        residual=file_residual(space, problem.parts, free, conditions, complete=not unknown),
        geometries=geometries,
    )


def _bounds(formulas: Formulas) -> LengthBounds:
    """Find the lengths for which balanced masses can be built."""
    require_sympy("a bound")
    from balance.space.formulas.bounds import length_bounds

    return length_bounds(formulas)


def _all_relations(
    problem: Problem,
    space: DesignSpace,
    given: list[DimensionRelation],
    deadline: float | None,
) -> tuple[list[DimensionRelation], ConditionSamples]:
    """Find all relations of the linkage; the conditions under them have its rank."""
    relations = given + problem.relations()
    samples = _samples(problem, relations, deadline)
    if samples is None:
        raise ExactError(_no_relations(space))
    return relations, samples


def _fewest_relations(
    problem: Problem,
    space: DesignSpace,
    given: list[DimensionRelation],
    deadline: float | None,
) -> tuple[list[DimensionRelation], ConditionSamples]:
    """Find relations of the linkage without which the conditions have another rank."""
    samples = _samples(problem, given, deadline)
    if samples is not None:
        return given, samples
    relations, samples = _all_relations(problem, space, given, deadline)
    for relation in relations[len(given) :]:
        fewer = [each for each in relations if each is not relation]
        simpler = _samples(problem, fewer, deadline)
        if simpler is not None:
            relations, samples = fewer, simpler
    return relations, samples


def _no_relations(space: DesignSpace) -> str:
    """Say that no relations explain the rank."""
    if space.chain.planar:
        return (
            f"{space.source}: its conditions have a lower rank than those of general "
            "dimensions, and equal lengths do not explain it: give relations (--where)"
        )
    return (
        f"{space.source}: it moves, or balances, for special dimensions alone; formulas of "
        "spatial loops know equal dimensions and Bennett's relations: give others (--where)"
    )


def _samples(
    problem: Problem, relations: Sequence[DimensionRelation], deadline: float | None
) -> ConditionSamples | None:
    """Prepare geometries under relations; None if their conditions have another rank."""
    try:
        return problem.samples(relations, deadline)
    except UnclosedError:
        return None


def _conditions(
    samples: ConditionSamples, space: DesignSpace, parameters: Sequence[Parameter]
) -> tuple[tuple[Condition, ...], int]:
    """Interpolate all entries; count the conditions that time did not suffice for."""
    entries, source = samples.entries, space.source
    fitted: dict[int, tuple[Polynomial, Polynomial]] = {}
    try:
        _check_one_motion(samples, source)
        interpolation = interpolation_of(samples, MAX_UNKNOWNS)
        degrees = interpolation.degrees(range(len(entries)))
        for e in sorted(degrees, key=lambda e: _size(degrees[e])):
            degree = degrees[e]
            if degree is None:
                raise ExactError(
                    f"{source}: its formulas have a degree above 30: they fill pages"
                )
            try:
                fit = interpolation.fit(e, degree)
            except TooManyTermsError as error:
                raise ExactError(_too_large(source, degree, error.unknowns)) from None
            if fit is None:
                raise ExactError(
                    f"{source}: the coefficients of a formula are too large for one prime; "
                    "give relations (--where)"
                )
            fitted[e] = fit
    except OutOfTimeError:
        pass
    return _write(samples, parameters, fitted, turns=space.chain.planar)


def _check_one_motion(samples: ConditionSamples, source: str) -> None:
    """Check that the dimensions determine the conditions, whatever the pose.

    Raises:
        SeveralMotionsError: several motions of these dimensions have the same rank.
    """
    point = samples.free.draw(PRIMES_OF_61_BITS[0], random.Random(7))
    try:
        first = samples.fresh_values(point)
        same = all(samples.fresh_values(point) == first for _ in range(SAME_GEOMETRY))
    except UnclosedError:  # other columns have pivots
        same = False
    if not same:
        raise SeveralMotionsError(f"{source}: {_what_differs(samples)}")


def _what_differs(samples: ConditionSamples) -> str:
    """Say on what conditions depend beside dimensions."""
    if samples.free.linkage.relations:
        return (
            "under this motion its conditions depend on the pose in which the file has it, not "
            "on its dimensions alone"
        )
    return (
        "several motions of its dimensions have as many conditions: formulas do not tell them "
        "apart"
    )


def _size(degrees: Degrees | None) -> int:
    return MAX_UNKNOWNS + 1 if degrees is None else degrees.unknowns()


def _too_large(source: str, degrees: Degrees, unknowns: int) -> str:
    """Say how large a formula is that is refused."""
    pairs = zip(degrees.single, degrees.angles, strict=True)
    angles = sum(pair != (0, 0) for pair, angle in pairs if angle)
    of_angles = f" and in {angles} angles" * bool(angles)
    return (
        f"{source}: a formula of degree {degrees.total[0]} over {degrees.total[1]}{of_angles} "
        f"has up to {degrees.unknowns()} terms, of which {unknowns} are left after those that "
        f"vanish, more than the {MAX_UNKNOWNS} that are fitted; give relations (--where), or "
        "other parameters (--solve)"
    )


def _write(
    samples: ConditionSamples,
    parameters: Sequence[Parameter],
    fitted: dict[int, tuple[Polynomial, Polynomial]],
    turns: bool,
) -> tuple[tuple[Condition, ...], int]:
    """Factorise the entries that were fitted, and collect them in conditions.

    Args:
        samples: say which entries they are.
        parameters: of the columns.
        fitted: numerator and denominator by the number of the entry.
        turns: whether a column of sy is i times it.
    """
    pool = FactorPool()
    pairs = _angle_pairs(samples.free.angles)
    for e, (numerator, denominator) in fitted.items():
        fitted[e] = in_fewest_terms(numerator, pairs), in_fewest_terms(denominator, pairs)
    for numerator, denominator in fitted.values():
        pool.learn(denominator)
        pool.learn(numerator)
    conditions, unknown = [], 0
    for row, pivot in enumerate(samples.solved):
        here = [e for e, (r, _) in enumerate(samples.entries) if r == row]
        if any(e not in fitted for e in here):
            unknown += 1
            continue
        solved = parameters[pivot]
        terms = []
        for e in here:
            parameter = parameters[samples.entries[e][1]]
            power = ((parameter.kind == "sy") - (solved.kind == "sy")) % 4 if turns else 0
            terms.append(FormulaTerm(parameter, pool.factorise(*fitted[e]), power))
        conditions.append(Condition(solved, tuple(terms)))
    return tuple(conditions), unknown


def _angle_pairs(angles: Sequence[bool]) -> list[int]:
    """Find the places of cosines among the variables; a sine follows each."""
    places, at = [], 0
    for angle in angles:
        if angle:
            places.append(at)
        at += 2 if angle else 1
    return places


def fresh_geometries(
    samples: ConditionSamples, parameters: Sequence[Parameter], conditions: Sequence[Condition]
) -> int:
    """Count the fresh geometries, up to 20, at which formulas hold modulo another prime.

    At each geometry velocities at finite poses, without series, give the conditions: they and
    the formulas span the same space.

    Returns:
        20, or the number of geometries before one at which they do not.
    """
    p, rng = PRIMES_OF_61_BITS[1], random.Random(11)
    place = {parameter: i for i, parameter in enumerate(parameters)}

    def rows_modulo(point: Sequence[int], modulus: int) -> list[list[int]]:
        values = samples.free.spread(point, modulus)
        rows = []
        for condition in conditions:
            row = [0] * len(parameters)
            row[place[condition.solved]] = 1
            for term in condition.terms:
                row[place[term.parameter]] = term.coefficient.remainder(values, modulus)
            rows.append(row)
        return rows

    for done in range(FRESH_GEOMETRIES):
        point = samples.free.draw(p, rng)
        if not samples.agree(partial(rows_modulo, point), point, p):
            return done
    return FRESH_GEOMETRIES


def file_residual(
    space: DesignSpace,
    parts: Parts,
    free: Dimensions,
    conditions: Sequence[Condition],
    complete: bool,
) -> float:
    """Compute how far masses of the design space of the file violate the formulas.

    Returns:
        The largest violation over the sum of the sizes of its terms, times the smallest
        singular value of the space where it is below 1e-3, for its basis has an error of
        round-off over this value; infinite if the formulas are complete and fewer than the
        conditions.
    """
    rows = _real_rows(space, parts, free, conditions)
    if not rows.size:
        return 0.0 if space.rank == 0 or not complete else float("inf")
    powers = [0 if label == "m" else 2 if label[0] == "E" else 1 for label in space.labels]
    scale = space.length ** np.array(powers, float)
    units = np.tile(scale, len(space.bodies))
    scaled, basis = rows * units, space.basis / units[:, None]
    scaled = scaled[np.abs(scaled).max(axis=1) > ROW_VANISHES * np.abs(scaled).max()]
    scaled /= np.linalg.norm(scaled, axis=1)[:, None]
    if complete and np.linalg.matrix_rank(scaled, tol=ROW_VANISHES) != space.rank:
        return float("inf")
    sizes = (np.abs(scaled) @ np.abs(basis)).max(axis=1, keepdims=True)
    sizes = np.maximum(sizes, ROW_OF_ZEROS * np.abs(basis).max(initial=0.0))
    violation = float((np.abs(scaled @ basis) / sizes).max(initial=0.0))
    return violation * min(1.0, space.kept / KEPT_ACCURATELY)


def _real_rows(
    space: DesignSpace,
    parts: Parts,
    free: Dimensions,
    conditions: Sequence[Condition],
) -> Array:
    """Evaluate formulas in the numbers of the file, as rows for the parameters of the space."""
    count, values = len(space.labels), free.values_in_file()
    rows = []
    for condition in conditions:
        row = np.zeros(len(space.bodies) * count, complex)
        for parameter, coefficient in [
            (condition.solved, 1 + 0j),
            *(
                (each.parameter, 1j**each.turns * each.coefficient.value(values))
                for each in condition.terms
            ),
        ]:
            start = parameter.body * count
            row[start : start + count] += coefficient * parts.in_file(parameter)[:count]
        rows += [row.real, row.imag]
    return np.array(rows)
