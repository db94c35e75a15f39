"""Formulas of random linkages against design spaces: in the plane, special, in space."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from kinematics import ScrewJoint, from_screws
from kinematics.errors import LinkageError
from tests.support.formula_rows import file_values, matrix, violation
from tests.support.spatial_frames import masses_in, size_of_violation


def _point(rng):
    return (*np.round(rng.uniform(-2, 2, 2), 3).tolist(), 0.0)


class Builder:
    """A linkage to which cranks and dyads are added at random."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.links, self.joints, self.loops = ["base"], [], []

    def new_link(self):
        self.links.append(f"link{len(self.links)}")
        return self.links[-1]

    def name(self):
        return f"j{len(self.joints) + len(self.loops)}"

    def crank(self):
        """A link on a revolute joint."""
        parent = self.links[self.rng.integers(len(self.links))]
        joint = ScrewJoint(self.name(), parent, self.new_link(), point=_point(self.rng))
        self.joints.append(joint)

    def dyad(self):
        """Two links between two others, now and then with a slider at its end."""
        a, b = self.rng.choice(len(self.links), 2, replace=False).tolist()
        a, b = self.links[a], self.links[b]
        first, second = self.new_link(), self.new_link()
        elbow, end = _point(self.rng), _point(self.rng)
        self.joints.append(ScrewJoint(self.name(), a, first, point=_point(self.rng)))
        if self.rng.random() < 0.25:
            axis = np.array(_point(self.rng))
            slide = ScrewJoint(self.name(), b, second, axis=axis, point=end, kind="prismatic")
            self.joints.append(slide)
            self.loops.append(ScrewJoint(self.name(), first, second, point=elbow))
        else:
            self.joints.append(ScrewJoint(self.name(), first, second, point=elbow))
            self.loops.append(ScrewJoint(self.name(), second, b, point=end))

    def linkage(self):
        self.crank()
        while len(self.links) < self.rng.integers(4, 8):
            self.crank() if self.rng.random() < 0.2 else self.dyad()
        return from_screws(self.joints, self.loops)


def checked(seed, kind):
    """Derive the formulas of a random linkage, and compare; None for one that is refused."""
    try:
        linkage = Builder(seed).linkage()
    except LinkageError:
        return None
    try:
        return compared(linkage, kind)
    except LinkageError as error:
        assert "two directions" in str(error), error
        return None


def compared(linkage, kind):
    """Derive formulas, and compare their span with the design space."""
    space = balance.design_space(linkage, balance=kind)
    formulas = balance.formulas(linkage, kind)
    values = file_values(formulas.to_dict())
    assert formulas.confirmed
    # The basis has an error of round-off over the smallest singular value.
    assert violation(formulas, space, values) < 1e-14 / min(space.kept, 1e-2)
    rows = matrix(formulas, values)
    assert np.linalg.matrix_rank(rows) == len(rows)
    assert len(rows) * (2 if kind == "force" else 1) == space.rank
    return formulas


# Of these seeds some make linkages that are refused, for a link slides in two directions.
FORCE_SEEDS, LEAST_FORCE = range(70), 50
DYNAMIC_SEEDS = range(100, 106)


@pytest.mark.slow
def test_fifty_random_linkages_force():
    """Links without the ground: three to eight."""
    formulas = [each for seed in FORCE_SEEDS if (each := checked(seed, "force")) is not None]
    sizes = sorted(len(each.parts.parts) - 1 for each in formulas)
    print(f"{len(formulas)} random topologies, {sizes[0]} to {sizes[-1]} moving links")
    assert len(formulas) >= LEAST_FORCE and sizes[-1] >= 7


@pytest.mark.slow
@pytest.mark.parametrize("seed", DYNAMIC_SEEDS)
def test_random_linkages_dynamic(seed):
    checked(seed, "dynamic")


def special_four_bar(rng, kind):
    """Places of the four joints of a kite, an antiparallelogram or a parallelogram."""
    a, d = sorted(rng.uniform(0.5, 2.0, 2).tolist())
    crank = a * np.exp(1j * rng.uniform(0.4, 1.2))
    line = (d - crank) / abs(d - crank)
    if kind == "parallelogram":
        return 0j, crank, crank + d, complex(d)
    if kind == "kite":  # the crank and the coupler mirrored in the line from elbow to elbow
        return 0j, crank, line * ((0 - crank) / line).conjugate() + crank, complex(d)
    mirrored = crank + d  # the elbow of the parallelogram, on the other side
    return 0j, crank, line * ((mirrored - crank) / line).conjugate() + crank, complex(d)


def special_linkage(seed):
    """A special four-bar, now and then with one more link, or with its image beside it."""
    rng = np.random.default_rng(seed)
    kind = ("kite", "antiparallelogram", "parallelogram")[seed % 3]
    a, b, c, d = special_four_bar(rng, kind)
    turn = np.exp(1j * rng.uniform(0, 2 * np.pi))
    p = [(z.real, z.imag, 0.0) for z in (a * turn, b * turn, c * turn, d * turn)]
    joints = [
        ScrewJoint("u1", "base", "crank", point=p[0]),
        ScrewJoint("q2", "crank", "coupler", point=p[1]),
        ScrewJoint("q4", "base", "rocker", point=p[3]),
    ]
    loops = [ScrewJoint("q3", "coupler", "rocker", point=p[2])]
    if seed % 2:
        carrier = ("crank", "coupler", "rocker")[seed // 2 % 3]
        joints.append(ScrewJoint("e", carrier, "extra", point=_point(rng)))
    return kind, from_screws(joints, loops)


@pytest.mark.slow
def test_twenty_special_linkages_dynamic():
    """Kites, antiparallelograms and parallelograms of random lengths, some with a link more."""
    kinds = []
    for seed in range(24):
        kind, linkage = special_linkage(seed)
        formulas = compared(linkage, "dynamic")
        assert formulas.relations
        kinds.append(kind)
    print({kind: kinds.count(kind) for kind in set(kinds)})
    assert len(kinds) >= 20 and len(set(kinds)) == 3


@pytest.mark.slow
def test_an_antiparallelogram_beside_a_parallelogram():
    """The same lengths move as two parallelograms, with as many conditions."""
    a, d = 0.8 * np.exp(0.9j), 2.0
    line = (d - a) / abs(d - a)
    c = a + line * ((a + d - a) / line).conjugate()
    places = {"u1": 0j, "q2": a, "q4": d, "q3": c, "q5": c, "q6": 3.0 + 0j, "q7": c + 1.0}

    def joint(name, parent, child):
        z = complex(places[name])
        return ScrewJoint(name, parent, child, point=(z.real, z.imag, 0.0))

    tree = [joint("u1", "base", "crank"), joint("q2", "crank", "coupler")]
    tree += [joint("q4", "base", "rocker"), joint("q5", "rocker", "bar")]
    tree += [joint("q6", "base", "follower")]
    loops = [joint("q3", "coupler", "rocker"), joint("q7", "bar", "follower")]
    assert len(compared(from_screws(tree, loops), "dynamic").conditions) == 9


def spatial_linkage(seed):
    """An arm, a tree or a loop, whose joints turn, slide, or are points."""
    rng = np.random.default_rng(seed)

    def joint(name, parent, child, kind="revolute"):
        axis = None if kind == "spherical" else rng.normal(size=3)
        return ScrewJoint(name, parent, child, axis=axis, point=rng.normal(size=3), kind=kind)

    links = ["base", *"abcdefg"]
    if seed < 4:  # an arm
        kinds = ["revolute", *rng.choice(["revolute", "revolute", "prismatic"], seed // 2 + 1)]
        return from_screws(
            [joint(f"q{k}", links[k], links[k + 1], k_) for k, k_ in enumerate(kinds)]
        )
    if seed < 6:  # a tree
        arm = [joint(f"q{k}", links[k], links[k + 1]) for k in range(2)]
        last = ("spherical", "revolute")[seed % 2]
        return from_screws([*arm, joint("side", "a", "c"), joint("end", "c", "d", last)])
    rows = {
        6: ["revolute"] * 7,
        7: ["revolute", "prismatic", *["revolute"] * 5],
        8: ["revolute", "cylindrical", "cylindrical", "cylindrical"],
        9: ["revolute", "spherical", "spherical", "revolute"],
        10: ["revolute", "universal", "spherical", "revolute"],
        11: ["revolute", "revolute", "spherical", "cylindrical"],
    }[seed]
    joints = []
    for k, kind in enumerate(rows):
        one = joint(f"q{k}", links[k], links[k + 1], kind)
        if kind == "universal":
            one = one._replace(axis2=np.cross(one.axis, rng.normal(size=3)))
        joints.append(one)
    return from_screws(joints[:-1], [joints[-1]._replace(child="base")])


@pytest.mark.slow
def test_ten_spatial_linkages():
    """Twelve; those of open chains with dynamic balance too."""
    checked_ones = []
    for seed in range(12):
        linkage = spatial_linkage(seed)
        for kind in ("force", "dynamic") if seed < 4 or seed == 9 else ("force",):
            formulas = balance.formulas(linkage, kind)
            space = balance.design_space(linkage, balance=kind)
            assert formulas.confirmed, (seed, kind)
            assert len(formulas.conditions) == space.rank
            rows = matrix(formulas, spatial_values(formulas))
            frames = [
                (formulas.parts.parts[k].origin, formulas.parts.parts[k].axes)
                for k in formulas.parts.body_parts
            ]
            tolerance = 1e-14 / min(space.kept, 1e-2)
            assert size_of_violation(rows, masses_in(frames, space)) < tolerance, (seed, kind)
            checked_ones.append((seed, kind))
    print(f"{len(checked_ones)} sets of formulas of {seed + 1} spatial linkages")


def spatial_values(formulas):
    """Values of the dimensions in the file, from the JSON of the formulas."""
    values = {}
    for each in formulas.to_dict()["dimensions"]:
        (x,) = each["value"]
        if each["kind"] == "angle":
            values |= {f"c_{each['name']}": np.cos(x), f"s_{each['name']}": np.sin(x)}
        else:
            values[each["name"]] = x
    return values


def test_one_random_linkage_and_a_wrong_dimension():
    """The comparison notices a dimension that is off by a thousandth."""
    linkage = Builder(1).linkage()
    space = balance.design_space(linkage, balance="force")
    formulas = balance.formulas(linkage, "force")
    values = file_values(formulas.to_dict())
    assert violation(formulas, space, values) < 1e-12
    names = [name for name in values if name in formulas.text()]
    wrong = values | {names[0]: 1.001 * values[names[0]]}
    assert violation(formulas, space, wrong) > 1e-6
