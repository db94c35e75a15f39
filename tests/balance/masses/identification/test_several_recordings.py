"""One estimate from several recordings: weights, covariance, drives, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.masses.identification.least_squares import ChannelRows, solve
from balance.masses.identification.load_rows import load_rows
from balance.motion.verification.trajectory import drive, random_motions
from balance.space.inertial_parameters.conversions import from_chain
from balance.support.csv_text import csv_table
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import UsageError
from tests.independent import identification_run
from tests.independent.identification_run import other_masses
from tests.support.json_answers import json_answer
from tests.support.page_elements import Elements

GRAVITY = np.array([0.3, -0.8, -9.7])
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
NAME = "four_bar_general"


def exact_loads(linkage, way, truth):
    """Wrench on the linkage and torques of the drives (N, 6), (N, inputs)."""
    rows = load_rows(linkage, way, GRAVITY, np.zeros(3))
    to_si = np.kron(np.eye(rows.bodies), from_chain(input_chain(linkage).frame, False, False))
    x = np.linalg.solve(to_si, truth.reshape(-1))
    return rows.wrench @ x, rows.drives @ x


def motions(name, samples, count=2):
    """A linkage, random motions, masses unlike those of the file, and exact loads."""
    linkage = kinematics.load(name)
    ways = list(random_motions(linkage, count, samples, seed=3))
    truth = other_masses(linkage, np.random.default_rng(5))
    return linkage, ways, truth, [exact_loads(linkage, way, truth)[0] for way in ways]


def table(time, wrench):
    """Columns of a wrench on the linkage."""
    return {"time": time, **dict(zip(WRENCH, wrench.T, strict=True))}


def noisy(wrench, share, seed):
    """A wrench with white noise of a share of the largest load."""
    rng = np.random.default_rng(seed)
    return wrench + share * np.abs(wrench).max() * rng.normal(size=wrench.shape)


def estimates(answer):
    """Values and standard errors of the combinations."""
    return np.array([(item.value, item.error) for item in answer.combinations]).T


def test_weights_are_those_of_one_large_system():
    """Dense weighted equations of all unknowns, with the noise that was estimated.

    Two recordings of two channels; friction of the second channel is common to both, its
    offsets are not; the first channel is in the first recording alone.
    """
    rng = np.random.default_rng(4)
    x, counts, noise = np.array([1.0, -2.0, 0.5]), (60, 90), ((0.2, 0.1), (None, 2.0))
    first = rng.normal(size=(60, 3))
    second = rng.normal(size=(150, 3))
    recording = np.repeat([0, 1], counts)
    F = np.column_stack([recording == 0, recording == 1, rng.normal(size=150)]).astype(float)
    sigma = np.repeat([noise[0][1], noise[1][1]], counts)
    y1 = first @ x + noise[0][0] * rng.normal(size=60)
    y2 = second @ x + F @ [3.0, -1.0, 0.7] + sigma * rng.normal(size=150)
    fit = solve(
        [
            ChannelRows(first, y1, np.empty((60, 0)), np.zeros(60, int), np.zeros(60)),
            ChannelRows(second, y2, F, recording, np.zeros(150)),
        ]
    )
    weights = 1.0 / np.concatenate(fit.noise)
    design = np.block([[first, np.zeros((60, 3))], [second, F]]) * weights[:, None]
    y = np.concatenate([y1, y2]) * weights
    covariance = np.linalg.inv(design.T @ design)
    unknowns = covariance @ design.T @ y
    assert np.abs(fit.directions @ fit.estimate - unknowns[:3]).max() < 1e-6
    spread = fit.spread(fit.directions)
    assert np.abs(spread / np.sqrt(np.diag(covariance))[:3] - 1.0).max() < 1e-6
    hat = np.einsum("ki,ij,kj->k", design, covariance, design)
    left = (y - design @ unknowns) / weights
    groups = np.concatenate([np.zeros(60, int), 1 + recording])
    for group in range(3):
        there = groups == group
        size = np.sqrt(np.square(left[there]).sum() / (1.0 - hat[there]).sum())
        assert np.abs(size * weights[there] - 1.0).max() < 1e-5
        true = (noise[0][0], noise[0][1], noise[1][1])[group]
        assert abs(size / true - 1.0) < 0.3


def test_a_recording_that_is_cut_in_two_tells_the_same():
    """The halves have their own noise, whose estimates differ by chance alone."""
    linkage, (way,), _, (wrench,) = motions(NAME, 240, 1)
    wrench = noisy(wrench, 0.01, 1)
    options = {"gravity": GRAVITY, "on_linkage": True}
    joined = balance.identify(linkage, way, table(way.time, wrench), **options)
    halves = [slice(0, 120), slice(120, 240)]
    ways = [
        drive(linkage, *(getattr(way, kind)[half] for kind in ("time", "u", "ud", "udd")))
        for half in halves
    ]
    loads = [table(way.time[half], wrench[half]) for half in halves]
    cut = balance.identify(linkage, ways, loads, **options)
    assert cut.complete and len(cut.recordings) == 2
    (value, error), (other, other_error) = estimates(joined), estimates(cut)
    assert np.abs((value - other) / error).max() < 0.2
    assert np.abs(error / other_error - 1.0).max() < 0.06
    alone = balance.identify(linkage, [way], [table(way.time, wrench)], **options)
    assert np.array_equal(estimates(alone), estimates(joined))


def test_standard_errors_shrink_with_the_noise_of_each_recording():
    """Information adds: by the root of two for equal noise, by 0.5 % for ten times as much."""
    linkage, (way,), _, (wrench,) = motions(NAME, 240, 1)
    options = {"gravity": GRAVITY, "on_linkage": True}
    first = table(way.time, noisy(wrench, 0.01, 1))
    single = estimates(balance.identify(linkage, way, first, **options))[1]
    for share, factor, within in ((0.01, 2.0**-0.5, 0.08), (0.1, 1.01**-0.5, 0.003)):
        second = table(way.time, noisy(wrench, share, 2))
        both = balance.identify(linkage, [way, way], [first, second], **options)
        assert np.abs(estimates(both)[1] / (factor * single) - 1.0).max() < within
        sizes = [[c.noise for c in each.channels] for each in both.recordings]
        ratio = np.divide(sizes[1], sizes[0])
        assert np.abs(ratio / (share / 0.01) - 1.0).max() < 0.2


def test_two_motions_determine_what_neither_does():
    """Each moves another input; exact loads give the true combinations."""
    linkage = kinematics.load("five_bar")
    truth = other_masses(linkage, np.random.default_rng(5))
    time = np.linspace(0.0, 1.0, 60)
    ways, loads = [], []
    for k in range(2):
        u, ud, udd = np.zeros((3, 60, 2))
        u[:, k] = 0.3 * np.sin(4.0 * time) ** 2
        ud[:, k], udd[:, k] = 1.2 * np.sin(8.0 * time), 9.6 * np.cos(8.0 * time)
        ways.append(drive(linkage, time, u, ud, udd))
        wrench, drives = exact_loads(linkage, ways[k], truth)
        moving = linkage.inputs[k]
        friction = 0.7 * ud[:, k] + 0.3 * np.sign(ud[:, k]) + (2.0 - k)
        loads.append({"time": time, "fx": wrench[:, 0], "mz": wrench[:, 5] + k})
        loads[k][moving] = drives[:, k] + friction
    options = {"gravity": GRAVITY, "on_linkage": True, "offset": True, "friction": True}
    alone = [
        balance.identify(linkage, *each, **options).determined
        for each in zip(ways, loads, strict=True)
    ]
    both = balance.identify(linkage, ways, loads, **options)
    assert max(alone) < both.determined == len(both.combinations)
    for item in both.combinations:
        true = identification_run.true_value(item, truth.reshape(-1), both)
        assert abs(item.value - true) < 1e-6
    first, second = linkage.inputs
    for name, value in ((f"viscous {first}", 0.7), (f"dry {second}", 0.3)):
        assert abs(both.sensors[name] - value) < 1e-6
    assert f"offset {second}, recording 1" not in both.sensors


def test_friction_is_common_and_offsets_are_not():
    """One drive in two recordings, with sensors that were set to zero between them."""
    linkage, ways, truth, _ = motions(NAME, 80)
    loads = []
    for k, way in enumerate(ways):
        torque = exact_loads(linkage, way, truth)[1][:, 0]
        torque = torque + 0.2 * way.ud[:, 0] + 0.4 * np.sign(way.ud[:, 0]) + 3.0 * k
        loads.append({"time": way.time, "u1": torque})
    answer = balance.identify(
        linkage, ways, loads, gravity=GRAVITY, offset=True, friction=True, balance="force"
    )
    assert set(answer.sensors) == {
        "offset u1, recording 1",
        "offset u1, recording 2",
        "viscous u1",
        "dry u1",
    }
    assert abs(answer.sensors["viscous u1"] - 0.2) < 1e-6
    assert abs(answer.sensors["dry u1"] - 0.4) < 1e-6
    for k in range(2):
        assert abs(answer.sensors[f"offset u1, recording {k + 1}"] - 3.0 * k) < 1e-6


@pytest.mark.slow
def test_the_noisier_recording_counts_less():
    """With one weight for both, errors are larger than with the weights of their noise."""
    linkage, ways, truth, wrenches = motions(NAME, 80)
    time = np.concatenate([ways[0].time, ways[1].time + 2.0])
    parts = (np.concatenate([getattr(way, k) for way in ways]) for k in ("u", "ud", "udd"))
    joined_way = drive(linkage, time, *parts)
    options = {"gravity": GRAVITY, "on_linkage": True}
    squares = []
    for run in range(4):
        noise = zip(wrenches, (0.002, 0.1), (2 * run, 2 * run + 1), strict=True)
        loads = [noisy(*each) for each in noise]
        tables = [table(way.time, part) for way, part in zip(ways, loads, strict=True)]
        apart = balance.identify(linkage, ways, tables, **options)
        joined = balance.identify(
            linkage, joined_way, table(time, np.concatenate(loads)), **options
        )
        errors = [
            [
                item.value - identification_run.true_value(item, truth.reshape(-1), answer)
                for item in answer.combinations
            ]
            for answer in (apart, joined)
        ]
        squares.append(np.square(errors).sum(axis=1))
    right, wrong = np.sum(squares, axis=0)
    assert 10.0 * right < wrong


def test_errors_of_two_recordings_are_those_that_are_told():
    """In 100 runs: their mean square in their covariance is 1, and 99 % are within 3 sigma."""
    linkage, ways, truth, _ = motions(NAME, 60)
    rows = [load_rows(linkage, way, GRAVITY, np.zeros(3)) for way in ways]
    to_si = from_chain(input_chain(linkage).frame, False, False)
    x = np.linalg.solve(np.kron(np.eye(rows[0].bodies), to_si), truth.reshape(-1))
    Y = np.concatenate([each.wrench for each in rows])
    recording = np.repeat([0, 1], 60)
    rng, white, within = np.random.default_rng(6), [], []
    for _ in range(100):
        channels = []
        for c in (0, 1, 5):
            exact = Y[:, c] @ x
            sigma = np.where(recording == 0, 0.01, 0.05) * np.abs(exact).max()
            loads = exact + sigma * rng.normal(size=120)
            none = np.empty((120, 0))
            channels.append(ChannelRows(Y[:, c], loads, none, recording, np.zeros(120)))
        fit = solve(channels)
        off = fit.directions.T @ x - fit.estimate
        white.append(fit.factor @ off)
        within.append(np.abs(off) <= 3.0 * fit.spread(np.eye(len(off))))
    assert 0.9 < np.mean(np.square(white)) < 1.15
    assert np.mean(within) > 0.99


@pytest.mark.slow
def test_standard_errors_of_two_recordings_hold():
    """A sample of ``python -m tests.independent.identification_run --second``."""
    first = identification_run.machine("five_bar", 8, 101)
    second = identification_run.machine("five_bar", 8, 81, seed=2, duration=1.5)
    found = identification_run.coverage("five_bar", 12, [(first, 0.01), (second, 0.05)])
    assert found.within >= 0.95
    # Errors of the combinations of a run are correlated: this is the mean of few free numbers.
    assert 0.4 < found.squares < 1.8


def test_tables_and_motions_come_in_pairs():
    linkage, ways, _, (wrench, _) = motions(NAME, 20)
    loads = table(ways[0].time, wrench)
    for given, tables, told in (
        (ways, loads, "not 1 table for 2 motions"),
        (ways[0], [loads, loads], "not 2 tables for 1 motion"),
        ([], [], "not 0 tables for 0 motions"),
    ):
        with pytest.raises(UsageError, match=told):
            balance.identify(linkage, given, tables)
    with pytest.raises(UsageError, match="time and some of fx") as told:
        balance.identify(linkage, ways, [loads, {"ghost": ways[1].time}])
    assert told.value.__notes__ == ["in recording 2 of 2"]


def test_a_recording_of_nothing_is_refused():
    """A sensor that is off has no noise: its zeros would outweigh all other recordings."""
    linkage, ways, _, (wrench, other) = motions(NAME, 20)
    tables = [table(ways[0].time, 0.0 * wrench), table(ways[1].time, other)]
    with pytest.raises(UsageError, match="all numbers are 0") as told:
        balance.identify(linkage, ways, tables)
    assert told.value.__notes__ == ["in recording 1 of 2"]


def test_a_recording_that_is_given_twice_is_refused():
    """It tells nothing more, and would make standard errors smaller."""
    linkage, ways, _, wrenches = motions(NAME, 20)
    tables = [table(way.time, wrench) for way, wrench in zip(ways, wrenches, strict=True)]
    with pytest.raises(UsageError, match="recordings 1 and 3 have the same loads"):
        balance.identify(linkage, [*ways, ways[0]], [*tables, tables[0]])


@pytest.fixture
def pairs(tmp_path):
    """Options for two recordings of different channels."""
    _, ways, _, wrenches = motions(NAME, 60)
    words = ["--gravity", "0.3,-0.8,-9.7", "--on-linkage"]
    for k, (way, wrench) in enumerate(zip(ways, wrenches, strict=True)):
        names = WRENCH[: 6 - 3 * k]
        head = ["time", "u1", "velocity u1", "acceleration u1"]
        values = [way.time, way.u[:, 0], way.ud[:, 0], way.udd[:, 0]]
        motion, loads = tmp_path / f"motion{k}.csv", tmp_path / f"loads{k}.csv"
        motion.write_bytes(csv_table(head, values))
        columns = [way.time, *noisy(wrench, 0.01, k).T[: len(names)]]
        loads.write_bytes(csv_table(["time", *names], columns))
        words += ["--motion", str(motion), "--wrench", str(loads)]
    return words


def test_the_command_takes_pairs_of_tables(capsys, pairs, tmp_path):
    code, answer = json_answer(capsys, "identify", NAME, *pairs)
    assert code == 0 and answer["samples"] == 120
    assert [len(each["channels"]) for each in answer["recordings"]] == [6, 3]
    assert main(["identify", NAME, *pairs, "--motion", "more.csv"]) == 2
    told = capsys.readouterr().err
    assert "one --wrench for each --motion, in the same order, not 2 for 3" in told
    (tmp_path / "loads1.csv").write_text("time,fx\n0,1\n", "utf-8")
    assert main(["identify", NAME, *pairs]) == 3
    told = capsys.readouterr().err
    assert "holds 1 samples, not 12" in told and "; in recording 2 of 2" in told


@pytest.mark.slow
def test_text_page_and_picture_have_both_recordings(capsys, pairs, tmp_path):
    """On the page, the second one follows the first, and its moments are gaps."""
    page, picture = tmp_path / "page.html", tmp_path / "loads.svg"
    files = ["--html", str(page), "--plot", str(picture)]
    assert main(["identify", NAME, *pairs, *files]) == 0
    text = capsys.readouterr().out
    for told in ("recording 1", "fx, fy, fz: 60 samples", "fz, recording 2"):
        assert told in text
    assert picture.read_text("utf-8").startswith("<?xml")
    (chart,) = Elements(page.read_text("utf-8")).data("figures")
    title = chart["layout"]["xaxis"]["title"]["text"]
    assert title == "time (s), recordings one after another"
    first, last = chart["data"][0], chart["data"][-1]
    assert first["x"] == last["x"] == sorted(first["x"]) and len(first["x"]) == 121
    assert [k for k, value in enumerate(first["y"]) if value is None] == [60]
    assert [k for k, value in enumerate(last["y"]) if value is None] == [*range(60, 121)]
