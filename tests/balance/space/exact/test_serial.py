"""Masses that pass a joint below which all can move, against the table and finite motions."""

import numpy as np
import pytest
from scipy.linalg import expm

from balance.space.exact.chain import exact_chain
from balance.space.exact.modular import Echelon
from balance.space.exact.modular_ranks import ranks_of
from balance.space.exact.serial import exact_transfers
from kinematics import ScrewJoint, from_screws
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.model.spatial.inertia import pseudo_inertia
from kinematics.model.spatial.screws import hat
from tests.support.laws import unit_vector

# J. J. de Jong, PhD thesis, table 5.1: transfers across a joint that is skew to those below.
SKEW = {"revolute": 3, "helical": 1, "prismatic": 6}


def arm_with_last(kind: str, seed: int):
    """Six joints in general position, which attain every twist, and one of a kind."""
    rng = np.random.default_rng(seed)
    names = ["base", *(f"link{k}" for k in range(7))]
    kinds = ["revolute"] * 6 + [kind]
    joints = [
        ScrewJoint(
            f"q{k}",
            names[k],
            names[k + 1],
            axis=unit_vector(rng),
            point=rng.standard_normal(3),
            kind=kind,
            pitch=0.3 if kind == "helical" else 0.0,
        )
        for k, kind in enumerate(kinds)
    ]
    return from_screws(joints)


@pytest.mark.parametrize("kind", SKEW)
def test_masses_that_pass_a_joint_do_not_notice_its_motion(kind):
    """A finite displacement leaves ``P`` as it is, and ``ŝ P`` has no antisymmetric part."""
    linkage = arm_with_last(kind, 3)
    transfers = exact_transfers(exact_chain(linkage, exact_geometry(linkage), spatial=True))
    z = np.array([t.z for t in transfers if t.joints == (6,)], dtype=np.float64)
    assert z.shape == (SKEW[kind], 10) and np.linalg.matrix_rank(z, tol=1e-9) == SKEW[kind]
    s = hat(linkage.joints[6].screw)
    for P in pseudo_inertia(z):
        moved = expm(0.7 * s) @ P @ expm(0.7 * s).T
        scale = np.abs(P).max()
        assert np.abs(moved - P).max() < 1e-12 * scale
        assert np.abs(s @ P - (s @ P).T).max() < 1e-12 * scale


@pytest.mark.parametrize("kind", SKEW)
def test_each_has_an_entry_of_its_own(kind):
    linkage = arm_with_last(kind, 4)
    transfers = exact_transfers(exact_chain(linkage, exact_geometry(linkage), spatial=True))
    z = [t.z for t in transfers if t.joints == (6,)]
    last = [max(i for i, x in enumerate(row) if x) for row in z]
    assert last == sorted(set(last))
    assert [[row[c] for c in last] for row in z] == np.eye(len(z)).tolist()


def test_an_open_chain_is_not_followed_beyond_a_rank_that_is_known(monkeypatch):
    """The same ranks and the same minor, and no more rays at the last order."""
    linkage = arm_with_last("revolute", 6)
    chain = exact_chain(linkage, exact_geometry(linkage), spatial=True)
    calls, samples = [], []
    absorb, implies = Echelon.absorb, Echelon.implies

    def counted(echelon, rows):
        added = absorb(echelon, rows)
        calls.append(len(added))
        return added

    def compared(echelon, rows):
        samples.append(len(rows))
        return implies(echelon, rows)

    monkeypatch.setattr(Echelon, "absorb", counted)
    monkeypatch.setattr(Echelon, "implies", compared)
    free = ranks_of("arm", chain, ())
    followed = len(samples)
    bounded = ranks_of("arm", chain, (), upper_bound=free.rank)
    assert bounded.ranks == free.ranks[: free.kmax + 1] and bounded.witness == free.witness
    assert len(samples) - followed < followed and calls[-1] > 0
