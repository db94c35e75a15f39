"""Linkages of which special dimensions are off by digits that floating point does not see.

The true integers come from series modulo primes in which the squared lengths of all axes are
squares, by a program that shares no code with the product.
"""

import json
from pathlib import Path

import pytest

import kinematics
from balance.app.cli.main import main

FOLDER = Path(__file__).parents[3] / "data" / "digits"
# Mobility, ranks by order, serial and parallel part.
EXACT = {
    "min_geared_kite_1_0_12": (1, [6, 12, 15, 17], 22, 1),
    "min_geared_par_1_0_14": (1, [6, 12, 15, 17], 22, 1),
    "float_route_nearmimic_7_8": (1, [6, 12, 15, 18], 20, 2),
    "float_route_nearmimic_53_12": (1, [6, 12, 15, 18], 20, 2),
    "float_route_nearmimic_27_13": (2, [11, 26, 29, 30], 37, 3),
    "float_route_fbtilt_20_14": (1, [6, 12, 17, 20, 22], 25, 3),
    "float_route_fbtilt_93_16": (1, [6, 12, 17, 20, 23, 25], 26, 9),
    "four_yokes": (1, [3] * 15 + [5], 3, 0),
    "five_yokes_known_hole": (1, [3] * 31 + [5], 3, 0),
    "mended_regular_1298": (2, [9, 15, 21, 25, 28, 31, 34, 37, 38], 32, 0),
    "mended_regular_1497": (2, [9, 15, 19, 22, 25, 28], 22, 0),
    "float_route_benntilt2_92_9": (2, [11, 22, 27], 22, 1),
    "parallelogram_turned_30deg_17digits": (1, [3, 4, 5], 4, 3),
    "mended_regular_7R_estimated_exit0": (1, [6, 12, 18, 22, 25, 28, 31, 34, 35], 25, 0),
}
# What is said of the ones that exact arithmetic cannot decide.
DOUBTFUL = {
    "bennett17_drives_two_yokes_10mm": "rank: the least condition",
    "float_route_bennfb_101_13": "rank: the least condition",
    "float_route_benntilt2_105_12": "rank: the least condition",
    "structure_two_yokes_welded": "mobility: ",
    "structure_five_yokes_welded_known_hole": "mobility: ",
}


def report(name, capsys, *options):
    """The exit code of the report on a file, and the report."""
    code = main(["report", str(FOLDER / f"{name}.urdf"), "--json", *options])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.table(1)
@pytest.mark.parametrize("name", EXACT)
def test_the_true_integers_are_reported(name, capsys):
    mobility, ranks, serial, parallel = EXACT[name]
    code, found = report(name, capsys)
    assert [order["rank"] for order in found["orders"]] == ranks
    assert (found["mobility"], found["serial"]) == (mobility, serial)
    assert found["parallel"] == parallel and found["idle"] == []
    assert (code, found["certainty"]) == (0, "verified" if parallel else "proved")


@pytest.mark.slow
@pytest.mark.parametrize("name", DOUBTFUL)
def test_what_floating_point_alone_decides_is_in_doubt(name, capsys):
    code, found = report(name, capsys)
    assert (code, found["certainty"]) == (4, "estimated")
    assert any(doubt.startswith(DOUBTFUL[name]) for doubt in found["evidence"]["doubts"])


def test_a_motion_between_axes_of_irrational_ratio_is_exact(capsys):
    words = ["--motion", "e1=e2"]
    _, found = report("two_yokes_1mm_irrational_relation", capsys, *words)
    assert [order["rank"] for order in found["orders"]] == [11, 15, 16, 19]
    assert (found["serial"], found["parallel"], found["idle"]) == (20, 1, [])


@pytest.mark.parametrize("angles", ["nominal", "as_written"])
@pytest.mark.parametrize("digits", [7, 8, 9, 10])
def test_axes_tilted_by_little_are_not_mended_where_the_loop_is_regular(
    digits, angles, tmp_path
):
    """A loop of four tilted axes and a ball, 7 - 6, and the slide that it stands on."""
    text = (FOLDER / "mended_regular_1497.urdf").read_text("utf-8")
    path = tmp_path / "tilted.urdf"
    path.write_text(text.replace("0.0000000000", "0." + "0" * digits), encoding="utf-8")
    linkage = kinematics.load(path, angles=angles)
    assert linkage.mobility == 2
    codes = [notice.code for notice in linkage.notices]
    assert "nearly_special" in codes and "closes_to_rounding" not in codes


def test_limits_of_one_position_are_told(tmp_path):
    text = (FOLDER / "four_yokes.urdf").read_text("utf-8")
    path = tmp_path / "limited.urdf"
    path.write_text(text.replace('lower="-10" upper="10"', 'lower="0" upper="0.0"', 1))
    (notice,) = (n for n in kinematics.load(path).notices if n.code == "oddities")
    assert "joint 'y0' (line 16) has limits of one position" in notice.message
    assert 'type="fixed"' in notice.message
