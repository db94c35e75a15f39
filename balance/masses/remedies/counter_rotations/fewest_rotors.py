"""The fewest counter-rotations that make a linkage feasible.

All sets of candidate joints are decided, smallest first. Most need no program of their own: a
set that contains a feasible one is feasible, and a certificate decides every set in which no
joint has a negative weight, so that each further set must contain one that has. (Implicit
hitting sets: E. Moreno-Centeno, R. M. Karp, Operations Research 61(2), 2013.) A certificate is
widened until it excludes as many joints as it can before the search goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from balance.masses.counterweights.added_program import IDLE_MASS_PRICE
from balance.masses.designs.feasibility import Verdict
from balance.masses.designs.pseudo_inertia_cone import cone_of_columns, given_parameters
from balance.masses.remedies.counter_rotations.counter_rotors import (
    RotorConditions,
    rotor_conditions,
)
from balance.masses.remedies.counter_rotations.rotor_sets import (
    RotorCertificate,
    RotorDesign,
    decide_rotors,
    rotor_basis,
)
from balance.space.inertial_parameters.conversions import mass_properties
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from balance.support.options import Balance
from balance.support.tolerances import MASSES_EQUAL
from kinematics.loading.model_gallery import LinkageLike
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import count_noun, number_text, repr_lines

Progress = Callable[[int, int], None]

# Most candidates of which all sets are decided; of more, sets of the smallest size alone.
MOST_CANDIDATES = 12


@dataclass(frozen=True)
class RotorSet:
    """Counter-rotations on a smallest set of joints.

    Attributes:
        joints: the joints, in the order of the file.
        momenta: J of each rotor with the least sum, kg m²: its momentum is ``-J n q̇_j``.
        ratio: that sum over the linkage's own rotational inertia; see `own_inertia`.
    """

    joints: tuple[str, ...]
    momenta: tuple[float, ...]
    ratio: float

    def __repr__(self) -> str:
        """One line: the joints, and the ratio."""
        names = ", ".join(self.joints)
        return repr_lines(
            f"RotorSet on {names}: {number_text(self.ratio)} of the own rotational inertia"
        )


@dataclass(frozen=True, eq=False)
class FewestRotors:
    """Result of `fewest_rotors`.

    Attributes:
        verdict: ``"feasible"`` if some set of counter-rotations does, ``"infeasible"`` if none
            does, ``"undecided"``.
        candidates: joints that may have a counter-rotor.
        count: the fewest counter-rotations; None unless feasible.
        sets: all sets of that size, least sum of momenta first.
        minimal: all feasible sets that contain no smaller one; up to 12 candidates.
        certificates: proofs that exclude all other sets; see
            `balance.masses.remedies.counter_rotations.rotor_sets.check_rotor_certificate`.
        conditions: the conditions that they are about.
        words: the verdict in one line.
    """

    verdict: Verdict
    candidates: tuple[str, ...]
    count: int | None
    sets: tuple[RotorSet, ...]
    minimal: tuple[tuple[str, ...], ...]
    certificates: tuple[RotorCertificate, ...] = field(repr=False)
    conditions: RotorConditions = field(repr=False)
    words: str

    def __repr__(self) -> str:
        """One line: the verdict."""
        return repr_lines(f"FewestRotors: {self.words}")


def fewest_rotors(
    space: DesignSpace | LinkageLike,
    gear: float = np.inf,
    progress: Progress | None = None,
    *,
    balance: Balance | None = None,
) -> FewestRotors:
    """Find the fewest counter-rotations that make a linkage feasible.

    A counter-rotor on joint j adds the momentum ``-J n q̇_j``, ``J ≥ 0``, and its mass belongs
    to its carrier. A set of joints is feasible if masses ``P_b ≻ 0`` of all bodies and momenta
    balance the linkage. Candidates are the revolute joints of
    `balance.masses.remedies.counter_rotations.counter_rotors.candidate_joints`; up to 12, all
    their sets are decided.

    Args:
        space: the design space of the linkage, for dynamic balance, or the linkage, its path or
            its name.
        gear: turns of a rotor for one turn of its joint, which sets the share of its inertia
            in its carrier; by default it has none.
        progress: called with the number of sets decided, and of all sets.
        balance: as for other functions: ``"dynamic"``, or None for that of the space.

    Returns:
        All smallest sets, each with the least sum of momenta for which every body has at least
        the matter of the file (at least ``P_b ⪰ 1`` kg m² and kg if it has none), with a
        price of 0.01 squares of ``space.length`` on mass; or certificates that no set does.

    Raises:
        ValueError: the space is that of force balance.

    Example:
        >>> import balance
        >>> balance.masses.fewest_rotors(balance.design_space("robot.urdf")).count
        2
    """
    space = as_space(space, balance=balance)
    if space.balance != "dynamic":
        raise ValueError("counter-rotations balance moments: give a space of dynamic balance")
    return fewest_of(rotor_conditions(space, gear=gear), progress)


def fewest_of(conditions: RotorConditions, progress: Progress | None = None) -> FewestRotors:
    """Find the fewest counter-rotations among some; see `fewest_rotors`.

    Args:
        conditions: the conditions with all of them; names of links stand for rotors on the
            ground that turn against these links.
        progress: called with the number of sets decided, and of all sets.
    """
    space = conditions.space
    search = search_sets(conditions, progress)
    names = np.array(conditions.joints, dtype=object)
    minimal = tuple(tuple(names[list(rotor_set)]) for rotor_set in search.minimal)
    size = min(map(len, search.minimal), default=None)
    sure = space.encloses and (size is None or space.sure)
    if search.open and (size is None or min(map(len, search.open)) < size):
        sure = False
    smallest = [rotor_set for rotor_set in search.minimal if len(rotor_set) == size]
    sets = [_rotor_set(conditions, rotor_set) for rotor_set in smallest] if sure else []
    verdict: Verdict = "undecided"
    if sure:
        verdict = "infeasible" if size is None else "feasible"
    sets.sort(key=lambda rotor_set: rotor_set.joints)
    ratios = [rotor_set.ratio for rotor_set in sets]
    sets = [sets[k] for k in rank_least_first(ratios, relative=MASSES_EQUAL)]
    return FewestRotors(
        verdict,
        conditions.joints,
        size if sure else None,
        tuple(sets),
        minimal,
        tuple(search.certificates),
        conditions,
        _words(verdict, conditions, sets),
    )


def own_inertia(space: DesignSpace) -> float:
    """Compute the linkage's own rotational inertia, kg m².

    It is the sum over the bodies of the file of the moment of inertia about the centre of
    mass: about the normal in a plane, and the mean of the principal moments in space.
    """
    total = 0.0
    for z in given_parameters(space):
        if z[0] > 0.0:
            inertia = mass_properties(z).inertia
            n = space.axes[2]
            total += float(n @ inertia @ n if space.planar else np.trace(inertia) / 3.0)
    return total


@dataclass
class SetSearch:
    """Which sets of rotors are feasible, found so far.

    Attributes:
        minimal: feasible sets that contain no smaller one.
        certificates: proofs that exclude sets.
        open: sets that neither a design nor a certificate decides.
        programs: number of sets for which a program was solved.
    """

    minimal: list[tuple[int, ...]] = field(default_factory=list)
    certificates: list[RotorCertificate] = field(default_factory=list)
    open: list[tuple[int, ...]] = field(default_factory=list)
    programs: int = 0

    def feasible(self, chosen: Sequence[int]) -> bool | None:
        """Return the verdict on a set that follows from those found; None if none does."""
        if any(set(rotor_set) <= set(chosen) for rotor_set in self.minimal):
            return True
        if any(proof.excluded[list(chosen)].all() for proof in self.certificates):
            return False
        return None


def search_sets(conditions: RotorConditions, progress: Progress | None = None) -> SetSearch:
    """Decide all sets of rotors, smallest first; see `fewest_rotors`.

    Args:
        progress: called with the number of sets decided, and of all sets.
    """
    search, count = SetSearch(), len(conditions.joints)
    everything = _decide(conditions, search, range(count))
    if isinstance(everything, RotorCertificate):
        search.certificates.append(everything)
        return search
    done, total = 0, 2**count
    for size in range(count + 1):
        if search.minimal and count > MOST_CANDIDATES:
            break
        for chosen in combinations(range(count), size):
            if search.feasible(chosen) is None:
                _settle(conditions, search, chosen)
            done += 1
            if progress is not None:
                progress(done, total)
    return search


def _settle(conditions: RotorConditions, search: SetSearch, chosen: tuple[int, ...]) -> None:
    """Decide one set, all smaller sets of which are decided, and keep what is found."""
    decision = _decide(conditions, search, chosen)
    if isinstance(decision, RotorDesign):
        search.minimal.append(tuple(np.flatnonzero(decision.J).tolist()))
    elif isinstance(decision, RotorCertificate):
        search.certificates.append(_widen(conditions, search, decision))
    else:
        search.open.append(chosen)


def _widen(
    conditions: RotorConditions, search: SetSearch, proof: RotorCertificate
) -> RotorCertificate:
    """Find a certificate that excludes these joints, and as many others as any that does."""
    for j in range(len(conditions.joints)):
        if proof.excluded[j]:
            continue
        chosen = [*np.flatnonzero(proof.excluded).tolist(), j]
        if search.feasible(chosen):
            continue
        wider = _decide(conditions, search, chosen)
        if isinstance(wider, RotorCertificate):
            proof = wider
    return proof


def _decide(
    conditions: RotorConditions, search: SetSearch, chosen: Sequence[int]
) -> RotorDesign | RotorCertificate | None:
    """Decide a set by a program of its own."""
    search.programs += 1
    return decide_rotors(conditions, sorted(chosen))


def _rotor_set(conditions: RotorConditions, chosen: tuple[int, ...]) -> RotorSet:
    """Find the least momenta of the rotors of a feasible set."""
    momenta = _least_momenta(conditions, chosen)
    names = tuple(conditions.joints[j] for j in chosen)
    inertia = own_inertia(conditions.space)
    ratio = float(momenta.sum()) / inertia if inertia > 0.0 else np.inf
    return RotorSet(names, tuple(momenta.tolist()), ratio)


def _words(verdict: Verdict, conditions: RotorConditions, sets: Sequence[RotorSet]) -> str:
    """Describe the verdict in one line."""
    listed = ", ".join(conditions.joints)
    if verdict == "undecided":
        return "undecided: neither designs nor certificates of all sets stand up to their check"
    if verdict == "infeasible" and not listed:
        return "infeasible: no revolute joint between links with masses, so no counter-rotation"
    if verdict == "infeasible":
        return (
            f"infeasible: a certificate excludes all counter-rotations together (on {listed})"
        )
    if not sets[0].joints:
        return "feasible without counter-rotations"
    number = count_noun(len(sets[0].joints), "counter-rotation")
    best = ", ".join(sets[0].joints)
    others = f"; {count_noun(len(sets), 'set')} of that size do" if len(sets) > 1 else ""
    return (
        f"feasible with {number}, and not with fewer: on {best}, with "
        f"{number_text(sets[0].ratio)} of "
        f"the linkage's own rotational inertia{others}"
    )


def _least_momenta(conditions: RotorConditions, chosen: Sequence[int]) -> Array:
    """Compute the momenta with the least sum that balance a linkage.

    Every body has at least the matter of the file, ``P_b ⪰ P_b(file)``, so that matter is
    added only. If the file has no masses, ``P_b ⪰ 1`` in kg and characteristic lengths. Without
    a price on the mass the least sum would not be reached: the same counterweight has the less
    inertia, the heavier and the nearer to its joint it is.

    Args:
        chosen: positions of the rotors of a feasible set.

    Returns:
        J of the chosen rotors (s,), kg m².
    """
    if not chosen:
        return np.zeros(0)
    z, J = rotor_basis(conditions, chosen)
    cone = cone_of_columns(conditions.space, z)
    # Masses in units of their mean, as the tolerances of the solver are absolute.
    file = cone_of_columns(conditions.space, conditions.given[:, None]).blocks[:, 0]
    unit = float(file[:, -1, -1].mean()) or 1.0
    least = file / unit if file.any() else np.tile(np.eye(cone.size), (len(file), 1, 1))
    rows = np.concatenate([cone.stack_rows(cone.blocks), J])
    offset = np.concatenate([-cone.rows(least).reshape(-1), np.zeros(len(J))])
    masses = cone.blocks[:, :, -1, -1].sum(axis=0)
    parts = [cone.part] * len(file) + [ConstraintBlock("nonnegative", len(J))]
    solution = solve_conic(J.sum(axis=0) + IDLE_MASS_PRICE * masses, rows, offset, parts)
    return np.maximum(unit * conditions.space.length**2 * (J @ solution.x), 0.0)
