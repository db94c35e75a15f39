"""The stacked chains of [B] G. Becht, MSc thesis, TU Delft, 2020, Fig. 4.1."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.momentum import momentum_regressor
from balance.studies import StackedChains, stacked_urdf
from balance.studies.synthesis.confirm import confirm_balance
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document

LONGER = StackedChains(leg=0.4, leg_angle=0.9, crank=0.15, slider_mass=0.7, platform_mass=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("chains", [StackedChains(), LONGER])
def test_two_freedoms_without_momentum(chains):
    """Balanced in every motion of both inputs, by the design space and by Pinocchio."""
    urdf = stacked_urdf(chains)
    linkage = load(Document("stacked", urdf))
    assert linkage.mobility == 2 and linkage.inputs == ("lift", "crank_joint")
    found = confirm_balance(urdf)
    assert found.confirmed and found.momentum < 1e-10, found


def test_each_chain_is_balanced_alone():
    """A little more mass on the slider, or on the platform, and its own input shakes."""
    for change, shaken in (
        ({"slider_mass": 0.41}, (True, True)),
        ({"platform_mass": 1.01}, (True, False)),
    ):
        right = stacked_urdf().decode()
        wrong = stacked_urdf(StackedChains()._replace(**change)).decode()
        name = next(iter(change)).partition("_")[0]
        # The mass alone is changed, not the counter-masses that belong to it.
        mixed = right.replace(_mass(right, name), _mass(wrong, name))
        linkage = load(Document("stacked", mixed.encode()))
        z = np.concatenate([body.inertia for body in linkage.bodies])
        h = momentum_regressor(linkage, {"lift": 0.1, "crank_joint": 0.2}, spatial=True) @ z
        assert tuple(np.abs(h).max(axis=1) > 1e-4) == shaken
        assert not balance.design_space(linkage).as_given.balanced


def _mass(text, name):
    """The text of a link up to its mass."""
    start = text.index(f'<link name="{name}">')
    return text[start : text.index("<inertia ", start)]


def test_the_platform_only_rises():
    """By the Jacobian of the first input: the platform does not turn or move sideways."""
    linkage = load(Document("stacked", stacked_urdf()))
    X = momentum_regressor(linkage, {"lift": 0.2, "crank_joint": 0.0}, spatial=True)
    number = [body.name for body in linkage.bodies].index("platform")
    per_mass = X.reshape(2, 6, -1, 10)[0, :, number]
    force, moment = per_mass[3:, 0], per_mass[:3, 4:]
    assert abs(force[2]) > 0.1 and np.abs(force[:2]).max() < 1e-12
    assert np.abs(moment).max() < 1e-12


@pytest.mark.parametrize(
    "change",
    [{"leg": 0.0}, {"leg_angle": 1.57}, {"crank_mass": -1.0}, {"plane_angle": 3.14159}],
)
def test_flat_and_empty_chains_are_refused(change):
    with pytest.raises(UsageError, match=next(iter(change))):
        stacked_urdf(StackedChains()._replace(**change))
