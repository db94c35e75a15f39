"""Fields of a result that are made at first use are those that are made at once."""

import pickle
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from balance import design_space
from balance.space.conditions.rank import Decision
from balance.space.spaces import compute_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.transfers.serial_part import serial_transfers
from balance.support.later_fields import LaterFields, with_later_fields
from kinematics import load


@dataclass(frozen=True, eq=False)
class Disc(LaterFields):
    radius: float
    area: float
    name: str = "disc"


class Area:
    """Counts how often the area is computed."""

    calls = 0

    def square(self):
        self.calls += 1
        return np.pi * 4.0


def test_a_field_is_made_once_and_when_it_is_asked_for():
    made = Area()
    disc = with_later_fields(Disc, {"area": made.square}, radius=2.0)
    assert (disc.radius, disc.name, made.calls) == (2.0, "disc", 0)
    assert disc.area == disc.area == np.pi * 4.0 and made.calls == 1
    assert replace(disc, radius=3.0).area == disc.area and made.calls == 1
    assert not hasattr(disc, "perimeter")
    with pytest.raises(AttributeError, match="Disc has no attribute 'diameter'"):
        print(disc.diameter)


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "bennett", "delta"])
def test_answers_of_the_first_orders_are_those_of_separate_steps(name, force, monkeypatch):
    """Transfers, conditions and null space in one call, or one after the other."""
    linkage, balance = load(name), "force" if force else "dynamic"
    space = design_space(linkage, balance=balance)
    monkeypatch.setattr(compute_space, "first_orders", lambda *_: None)
    by_steps = design_space(linkage, balance=balance)
    assert space.orders == by_steps.orders and space.notices == by_steps.notices
    assert not space.differences(by_steps) and space.doubts == by_steps.doubts
    transfers = serial_transfers(space.chain, force, space.decision.conditions.tolerance)
    assert np.array_equal(space.chain_transfers.rows, transfers.rows)
    assert np.array_equal(space.chain_transfers.owner, transfers.owner)
    # The transfers and the basis satisfy all conditions of both.
    for answer in (space, by_steps):
        assert isinstance(answer.decision, Decision)
        for rows in (space.decision.conditions.rows, by_steps.decision.conditions.rows):
            assert np.abs(rows @ answer.decision.basis).max(initial=0.0) < 1e-12
            assert np.abs(rows @ answer.chain_transfers.rows.T).max(initial=0.0) < 1e-12


def test_a_space_can_be_copied_field_by_field():
    space = design_space("four_bar_general")
    values = {item.name: getattr(space, item.name) for item in fields(DesignSpace)}
    again = DesignSpace(**values)
    assert not again.differences(space) and again.to_dict() == space.to_dict()


def test_later_fields_survive_pickling():
    area = Area()
    disc = pickle.loads(
        pickle.dumps(with_later_fields(Disc, {"area": area.square}, radius=2.0))
    )
    assert disc.area == np.pi * 4.0 and area.calls == 0
