"""Platforms with three- and sixfold symmetry, whose numbers are roots: read as such.

The integers are those of `tests.independent.symmetric_truth`, modulo a prime that has √3.
"""

import json

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from balance.checks import exact_ranks
from tests.independent.meant_linkages import random_rotation
from tests.independent.symmetric_truth import platform_truth
from tests.support.symmetric_platforms import STYLES, platform_text

# Mobility, ranks by order, serial part.
TRUE = {
    "3_ruu": (3, (18, 42, 43), 21),
    "3_rsr": (3, (15, 39, 43), 27),
    "6_ups": (6, (33, 82), 48),
}
# Angle of the first leg, degrees, and angles of the base.
PLACES = ((0, ""), (30, ""), (20, ""), (0, "0.3 0.2 0.7"), (15, "0 0.5235987755982988 0"))
ORIGINAL = platform_text("3_ruu")


def load(tmp_path, text, **options):
    """The linkage of a text."""
    path = tmp_path / "platform.urdf"
    path.write_text(text)
    return kinematics.load(str(path), **options)


def answer(space):
    """Mobility, ranks by order, serial part."""
    ranks = tuple(order.rank for order in space.orders)
    return space.linkage.mobility, ranks, space.serial_nullity


@pytest.mark.slow
@pytest.mark.parametrize("kind", TRUE)
def test_the_figures_are_those_modulo_a_prime_with_the_root(kind):
    found = platform_truth(kind)
    assert (found.mobility, found.ranks, found.serial) == TRUE[kind]


@pytest.mark.slow
def test_a_delta_is_verified_with_its_numbers_read_as_roots(tmp_path):
    space = certify(design_space(load(tmp_path, ORIGINAL)))
    assert answer(space) == TRUE["3_ruu"] and space.level == "verified" and not space.doubts
    assert "numbers of the file read as roots (see --exact)" in space.certainty.reason
    assert space.certainty.proof is None
    (notice,) = (n for n in space.notices if n.code == "read_as_roots")
    assert notice.message.startswith("as written: 49 conditions; with ")
    (reading,) = space.readings
    assert (reading.held, reading.written, reading.special) == ("as_meant", 49, 43)
    exact = exact_ranks(space)
    assert exact.ranks[:3] == TRUE["3_ruu"][1]
    assert any("is read as 1/2 √3" in line for line in exact.to_dict()["replaced"])


def test_as_written_keeps_the_decimals(tmp_path):
    linkage = load(tmp_path, ORIGINAL, angles="as_written")
    assert exact_ranks(linkage).rank == 49
    space = certify(design_space(linkage))
    assert space.level == "estimated" and not space.readings


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("size", ["1", "0.125", "0.24"])
@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("kind", TRUE)
def test_platforms_are_read_as_meant(kind, style, size, place, tmp_path):
    space = certify(design_space(load(tmp_path, platform_text(kind, size, style, *place))))
    assert answer(space) == TRUE[kind] and not space.doubts
    assert space.level in ("proved", "verified")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", TRUE)
def test_platforms_in_a_frame_that_is_turned_at_random(kind, seed, tmp_path):
    turn = random_rotation(np.random.default_rng(seed))
    space = certify(design_space(load(tmp_path, platform_text(kind, turn=turn))))
    assert answer(space) == TRUE[kind] and not space.doubts and space.level == "verified"
    assert "read as roots" in space.certainty.reason


@pytest.mark.slow
def test_a_root_that_is_off_is_not_read_so(tmp_path):
    """The axis of one arm is turned by 1e-9: the platform turns."""
    text = ORIGINAL.replace('axis xyz="-0.8660254037844386', 'axis xyz="-0.8660254047844386', 1)
    space = certify(design_space(load(tmp_path, text)))
    assert space.level == "estimated" or answer(space) != TRUE["3_ruu"]


def test_report_exits_with_0(tmp_path, capsys):
    path = tmp_path / "delta.urdf"
    path.write_text(ORIGINAL)
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["rank"] == 43 and report["certainty"] == "verified"
    assert report["readings"][0]["conditions_as_written"] == 49
