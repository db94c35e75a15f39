"""What ``balance verify`` tells of its motions: which is plotted, how long and far they go."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance.app.answers.html.verification import panels
from balance.app.answers.html.verification_page import verification_page
from balance.app.answers.text.verification import verification_facts
from balance.app.cli.main import main
from balance.motion.verification.trajectory import drive
from balance.motion.verification.verify_motions import verify, verify_second
from kinematics.errors import PoseError
from kinematics.wording import size_text
from tests.support.laws import altered
from tests.support.page_elements import without_breaks
from tests.support.verify_command import BALANCED, FEW, SHAKING, run


@pytest.mark.parametrize(
    ("model", "seed", "decides", "other"),
    [("five_bar", 0, "force", "moment"), ("three_rsr", 1, "moment", "force")],
)
def test_the_plotted_motion_has_the_peak_that_is_told(model, seed, decides, other):
    """It decides the verdict; a peak of another motion is said to be of that one."""
    found = verify(kinematics.load(model), trajectories=4, samples=40, seed=seed)
    parts = {"force": slice(3, 6), "moment": slice(0, 3)}
    peaks = {
        part: [np.linalg.norm(x.middle[:, rows], axis=1).max() for x in found.runs]
        for part, rows in parts.items()
    }
    # Where the force is balanced, round-off is as large in every motion, and the first counts.
    worst = {
        part: 0 if max(sizes) < 1e-9 else int(np.argmax(sizes)) for part, sizes in peaks.items()
    }
    assert found.plotted == worst[decides] != worst[other]
    # The curves that are drawn have the peaks that are told.
    _, force, moment, _ = panels(found)
    drawn = {"force": force.lines, "moment": moment.lines}
    largest = {part: np.linalg.norm(lines, axis=0).max() for part, lines in drawn.items()}
    number = found.plotted + 1
    told = dict(verification_facts(found))
    scales = {"force": (found.scale, "N"), "moment": (found.scale * found.length, "N m")}
    loads = [
        f"{size_text(largest[part], '.3g', scale)} {unit}"
        for part, (scale, unit) in scales.items()
    ]
    assert told["plotted"] == f"motion {number} of 4: peaks {', '.join(loads)}"
    for part, (scale, unit) in scales.items():
        peak, motion = size_text(max(peaks[part]), ".3g", scale), worst[part] + 1
        more = ";" if peak.startswith("below") else ", rms "
        said = f"peak {peak} {unit} in motion {motion}{more}"
        assert told[f"shaking {part}"].startswith(said)
    assert largest[decides] == pytest.approx(getattr(found, decides), rel=1e-12)
    report = found.to_dict()
    assert report["plotted"] == {"motion": number} | {
        part: pytest.approx(size, rel=1e-12) for part, size in largest.items()
    }
    assert report["worst"] == {part: k + 1 for part, k in worst.items()}
    assert f"motion {number} of 4" in verification_page(found)
    assert replace(found, balance="force").plotted == worst["force"]


def test_two_linkages_are_plotted_on_one_motion():
    first = verify(kinematics.load(SHAKING), trajectories=3, samples=30)
    assert first.plotted == first.worst("force") != 0
    second = verify_second(first, kinematics.load("four_bar_antiparallelogram_balanced"))
    assert second.plotted == first.plotted != second.worst("moment") == 0
    lines = [panels(one)[0].lines for one in (first, second)]
    assert np.array_equal(*lines)


def test_round_off_decides_neither_words_nor_the_plotted_motion():
    """Loads of round-off, of any size and order, are told as one bound in the first motion."""
    found = verify(
        kinematics.load("four_bar_antiparallelogram_balanced"), trajectories=4, samples=30
    )
    texts = set()
    for seed in range(5):
        rng = np.random.default_rng(seed)
        runs = []
        for one in found.runs:
            noise = found.scale * 1e-14 * rng.standard_normal(one.middle.shape)
            runs.append(replace(one, middle=noise * rng.uniform(0.01, 1.0)))
        other = replace(found, runs=tuple(runs))
        assert other.plotted == other.worst("force") == other.worst("moment") == 0
        facts = dict(verification_facts(other))
        texts.add(tuple(facts[f"shaking {part}"] for part in ("force", "moment")))
        texts.add(repr(other))
    assert len(texts) == 2
    assert "below 1e-12 of inertia" in repr(found)


def test_duration_and_amplitude_are_told(tmp_path, capsys):
    path = tmp_path / "motion.csv"
    time = np.linspace(2.0, 5.5, 50)
    rows = "".join(f"{t!r},{float(0.3 * np.sin(t))!r}\n" for t in time.tolist())
    path.write_text(f"time,u1\n{rows}", encoding="utf-8")
    code, report = run(capsys, SHAKING, "--csv", str(path))
    far = np.abs(0.3 * np.sin(time)).max()
    assert code == 1 and report["duration"] == 3.5
    assert report["amplitude"] == {"u1": pytest.approx(far)}
    html = tmp_path / "a.html"
    assert main(["verify", SHAKING, "--csv", str(path), "--html", str(html)]) == 1
    out, page = capsys.readouterr().out, without_breaks(html.read_text("utf-8"))
    for label, value in (("duration", "3.5 s"), ("amplitude", f"u1 {far:.3g} rad")):
        assert re.search(rf"^{label} +{value}$", out, re.MULTILINE)
        assert f"<dt>{label}</dt><dd>{value}</dd>" in page
    _, report = run(capsys, "hprs", "--trajectories", "2")
    assert list(report["amplitude"]) == report["inputs"] and report["duration"] == 1.0


def test_a_page_of_two_files_names_both(tmp_path, capsys):
    """Also if both call their robot the same, and both files have one name."""
    folders = [tmp_path / name for name in ("before", "after")]
    for folder in folders:
        folder.mkdir()
    one, other = (str(altered(SHAKING, folder, lambda robot: None)) for folder in folders)
    twin = str(tmp_path / "twin & co.urdf")
    Path(twin).write_bytes(Path(one).read_bytes())
    page = tmp_path / "a.html"
    assert main(["verify", one, "--against", twin, *FEW, "--html", str(page)]) == 1
    text = without_breaks(page.read_text("utf-8"))
    for name in (f"{SHAKING}.urdf", "twin &amp; co.urdf"):
        assert f"<h2>{name}</h2>" in text and f" {name}" in text
    assert "(unchanged), from" in text
    assert f"{SHAKING}.urdf and twin &amp; co.urdf</title>" in text
    assert main(["verify", one, "--against", other, *FEW, "--html", str(page)]) == 1
    text = without_breaks(page.read_text("utf-8"))
    for folder in ("before", "after"):
        assert f"<h2>{folder}/{SHAKING}.urdf</h2>" in text
    lines = capsys.readouterr().out.splitlines()
    (files,) = {line for line in lines if line.startswith("file") and other in line}
    assert one in files


@pytest.mark.table(2)
@pytest.mark.parametrize(
    ("time", "u"),
    [
        (range(20), [0.0] * 20),
        (range(20), [0.2] * 20),
        (range(20), [0.2 + 1e-16 * (k % 3) for k in range(20)]),
        ([k * 1e200 for k in range(20)], [0.01 * k * k for k in range(20)]),
        ([k * 1e-120 for k in range(20)], [0.01 * k for k in range(20)]),
    ],
)
def test_a_motion_in_which_nothing_moves_has_no_verdict(time, u, tmp_path, capsys):
    path = tmp_path / "still.csv"
    rows = "".join(f"{float(t)!r},{x!r}\n" for t, x in zip(time, u, strict=True))
    path.write_text(f"time,u1\n{rows}", encoding="utf-8")
    for more in ([], ["--json"], ["--against", BALANCED]):
        for model in (SHAKING, BALANCED):
            assert main(["verify", model, "--csv", str(path), *more]) == 3
            streams = capsys.readouterr()
            assert streams.out == "" and streams.err == (
                f"balance: {path}: nothing moves; give inputs that change with time\n"
            )
    linkage = kinematics.load(SHAKING)
    still = drive(linkage, np.arange(9.0), np.zeros((9, 1)), *[np.zeros((9, 1))] * 2)
    for along in ([still], []):
        with pytest.raises(PoseError, match="nothing moves"):
            verify(linkage, motions=along)


def test_a_small_motion_is_a_motion(tmp_path, capsys):
    path = tmp_path / "small.csv"
    rows = "".join(f"{k},{1e-6 * k * k!r}\n" for k in range(20))
    path.write_text(f"time,u1\n{rows}", encoding="utf-8")
    assert run(capsys, SHAKING, "--csv", str(path))[0] == 1
    assert run(capsys, BALANCED, "--csv", str(path))[0] == 0
