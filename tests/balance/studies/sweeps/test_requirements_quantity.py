"""Requirements as a quantity of sweeps: each row is what a linkage of that geometry gives."""

from __future__ import annotations

import pytest

import balance
from balance.studies.sweeps.study import Study
from kinematics.errors import FileError


def study(**options):
    """Two lengths of the rocker of a general four-bar, which change no rank."""
    return Study.from_tables(
        {
            "model": {"file": "four_bar_general"},
            "parameters": {"rocker.length": ["0.9", "1.1"]},
            "compute": {"quantities": ["requirements"], "requirements": options},
        }
    )


@pytest.mark.lanes
def test_rows_are_those_of_linkages():
    table = study(require="force; dynamic at u1=0", gravity=[0.0, -1.0, 0.0]).run()
    space = balance.require("four_bar_general", "force; dynamic at u1=0")
    assert list(table["required_rank"]) == [space.rank] * 2
    assert list(table["required_nullity"]) == [space.nullity] * 2
    assert set(table["required_design"]) == {balance.design(space, density=None).verdict}


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({}, "nothing is required"),
        ({"require": "force q"}, "cannot be read"),
        ({"require": "force at u7=1"}, "u7 is not an input"),
        ({"require": 3}, "has no meaning"),
        ({"require": "gravity", "gravity": [0.0, 0.0, 0.0]}, "not all 0"),
    ],
)
def test_what_cannot_be_required_is_one_line(options, told):
    with pytest.raises(FileError) as raised:
        study(**options).job()
    assert told in str(raised.value) and "\n" not in str(raised.value)
