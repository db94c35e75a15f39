"""Tables with few decimals: the printed range holds the loads of the motion that was meant."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.verification.given_motions import from_csv
from balance.motion.verification.table_rounding import even_times, smooth_spline
from balance.motion.verification.trajectory import drive
from balance.support.csv_columns import read_table
from kinematics.errors import FileError
from tests.support.verify_command import run

MODELS = ("four_bar_general", "slider_crank", "five_bar", "slider_pantograph")
TURN = 2.0 * np.pi


def waves(number, time, width):
    """Sums of sines with exact derivatives, or a line between two rests (3, N, width)."""
    rng = np.random.default_rng(number)
    found = np.zeros((3, time.size, width))
    for w in range(width):
        if number % 5 == 4:
            x = time / time[-1]
            path = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
            found[:, :, w] += [
                0.2 * path.deriv(k)(x) / time[-1] ** k if k else 0.2 * path(x) for k in range(3)
            ]
            continue
        for k in range(1, 1 + rng.integers(1, 4)):
            size, phase, rate = rng.uniform(0.02, 0.1), rng.uniform(0.0, TURN), TURN * k
            angle = rate * time + phase
            found[0, :, w] += size * (np.sin(angle) - np.sin(phase))
            found[1, :, w] += size * rate * np.cos(angle)
            found[2, :, w] -= size * rate**2 * np.sin(angle)
    return found


def write(path, linkage, time, u, decimals):
    """Write a table with so many decimals of all numbers."""
    np.savetxt(
        path,
        np.column_stack([time, u]),
        fmt=f"%.{decimals}f",
        delimiter=",",
        header=",".join(["time", *linkage.inputs]),
        comments="",
    )
    return path


def check_range(tmp_path, number, decimals, samples):
    """The printed ranges hold the peaks of the exact motion, by Pinocchio."""
    linkage = kinematics.load(MODELS[number % len(MODELS)])
    time = np.linspace(0.0, 1.0, samples)
    u, ud, udd = waves(number, time, linkage.mobility)
    truth = balance.verify(linkage, motions=[drive(linkage, time, u, ud, udd)])
    path = write(tmp_path / "a.csv", linkage, time, u, decimals)
    try:
        found = balance.verify(linkage, motions=[from_csv(linkage, path)])
    except FileError as error:
        assert "nothing of the accelerations" in str(error) and decimals == 4
        return
    for part, peak in (("force", truth.force), ("moment", truth.moment)):
        text = found.range_text(part)
        if text.startswith("below"):
            assert peak <= float(text.split()[1])
            continue
        least, most = map(float, re.findall(r"[0-9][0-9.e-]*", text)[:2])
        assert least <= peak <= most, (number, decimals, part, least, peak, most)
        if decimals >= 7:
            assert most - least < 0.05 * peak


@pytest.mark.table(1)
@pytest.mark.parametrize(("number", "decimals"), [(0, 4), (4, 5), (2, 6), (3, 8)])
def test_the_printed_range_holds_the_truth(tmp_path, number, decimals):
    check_range(tmp_path, number, decimals, 201)


@pytest.mark.slow
@pytest.mark.parametrize("decimals", range(4, 10))
def test_printed_ranges_hold_the_truth_of_twenty_motions(tmp_path, decimals):
    for number in range(20):
        check_range(tmp_path, number, decimals, (201, 1001, 400)[number % 3])


@pytest.mark.slow
def test_rounding_does_not_shake(tmp_path, capsys):
    """The table of issue 38: 0.3 (1 - cos 2πt) with 4 decimals gave 428 N instead of 5.262."""
    linkage = kinematics.load("four_bar_general")
    time = np.linspace(0.0, 1.0, 1001)
    path = write(tmp_path / "a.csv", linkage, time, 0.3 * (1.0 - np.cos(TURN * time)), 4)
    code, found = run(capsys, "four_bar_general", "--csv", str(path))
    assert code == 1
    least, most = found["range"]["force"]
    assert found["range"]["decimals"] == 4
    assert least <= 5.2617 <= most and most - least < 0.2
    assert abs(found["shaking"]["force"] - 5.2617) < 0.02


def test_bounds_hold_for_the_worst_rounding():
    """The bound on rounding alone is the sum over all samples: it is reached by signs."""
    time = np.linspace(0.0, 1.0, 80)
    u = np.cos(3.0 * time)[:, None]
    fit = smooth_spline(time, u, np.full((80, 1), 1e-4))
    # Columns of the map from samples to accelerations, by unit samples on the same knots.
    from scipy.interpolate import make_lsq_spline

    spline = fit.spline
    rows = np.array([make_lsq_spline(time, e, spline.t, spline.k)(time, 2) for e in np.eye(80)])
    worst = 1e-4 * np.abs(rows).sum(axis=0)
    assert np.all(fit.errors[2][:, 0] >= worst * (1.0 - 1e-6))
    assert np.min(fit.errors[2][:, 0] / worst) < 6.0


def test_nothing_left_is_refused(tmp_path):
    linkage = kinematics.load("four_bar_general")
    time = np.linspace(0.0, 1.0, 101)
    path = write(tmp_path / "a.csv", linkage, time, 0.02 * np.sin(TURN * time) ** 2, 2)
    with pytest.raises(FileError, match="nothing of the accelerations.*write more decimals"):
        from_csv(linkage, path)


def test_digits_and_times_are_read_as_they_are_written(tmp_path):
    """Fixed decimals, significant digits, dropped zeros; times that are even up to rounding."""
    path = tmp_path / "a.csv"
    path.write_text("time,a,b,c\n0,1.25e-3,0.5,2\n1,12.5,0.125,2\n2,1.5e2,0.1,2\n")
    table = read_table(path, ["time", "a", "b", "c"])
    assert table.decimals == (0, 5, 3, 0)
    assert np.allclose(table.rounding[:, 1], [5e-6, 5e-2, 5e-1])
    assert np.allclose(table.rounding[:, 2], 5e-4) and not table.rounding[:, 3].any()
    even = np.linspace(0.0, 1.0, 200)
    written = np.round(even, 4)
    times, off = even_times(written, np.full(200, 5e-5))
    assert np.allclose(times, even, atol=1e-15) and off == pytest.approx(1e-4)
    assert even_times(even, np.full(200, 1e-16))[1] == 0.0
    assert even_times(even**2, np.full(200, 5e-5)) is None


def test_balanced_linkages_stay_balanced(tmp_path):
    """What does not shake in any motion does not shake in a rounded one."""
    linkage = kinematics.load("four_bar_kite_balanced")
    time = np.linspace(0.0, 1.0, 201)
    u = 0.3 * (1.0 - np.cos(TURN * time))
    path = write(tmp_path / "a.csv", linkage, time, u, 5)
    found = balance.verify(linkage, motions=[from_csv(linkage, path)])
    assert found.balanced and found.decided
    assert found.range_text("force").startswith("below")


def test_partial_balance_says_how_far_it_is_off(tmp_path):
    """The root mean square before, from exact rates, is within the bound that is printed."""
    linkage = kinematics.load("four_bar_general")
    time = np.linspace(0.0, 1.0, 201)
    u, ud, udd = waves(0, time, 1)
    exact = balance.partial(linkage, ["crank"], 0.1, motions=[drive(linkage, time, u, ud, udd)])
    path = write(tmp_path / "a.csv", linkage, time, u, 5)
    found = balance.partial(linkage, ["crank"], 0.1, motions=[from_csv(linkage, path)])
    for name in ("force", "moment"):
        off, truth = getattr(found.given, f"{name}_off"), getattr(exact.given, name)
        assert abs(getattr(found.given, name) - truth) <= off < 0.1 * truth
    assert exact.given.force_off == 0.0
    assert json.dumps(found.to_dict())
