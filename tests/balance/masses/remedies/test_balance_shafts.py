"""Balance shafts: Lanchester's formulas, and Fourier coefficients of momenta at finite poses.

At a crank of unit rate the force is the rate of the momentum, so that both lack the same
harmonics. The momenta come from the independent route (``tests/independent/reference.py``).
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.integrate import quad

import balance
from balance.app.cli.main import main
from balance.masses.remedies.matter_on_links import apply_force_masses
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.shafts.balance_shafts import apply_balance_shafts
from balance.masses.remedies.shafts.harmonic_shafts import harmonics_of, shafts_against
from kinematics.loading.model_gallery import as_linkage, load
from kinematics.model.document.element import Document
from tests.independent import reference

CRANK, ROD, PIN, SLIDER, RADIUS = 0.12, 0.37, 0.4, 0.9, 0.05
# The crank stands across the way of the slider.
ENGINE = f"""<robot name="engine">
  <link name="base"/>
  <link name="crank"><inertial><origin xyz="0 {CRANK} 0"/><mass value="{PIN}"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rod"/>
  <link name="slider"><inertial><mass value="{SLIDER}"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="u1" type="continuous" independent="true">
    <parent link="base"/><child link="crank"/><axis xyz="0 0 1"/></joint>
  <joint name="q2" type="continuous"><origin xyz="0 {CRANK} 0"/>
    <parent link="crank"/><child link="rod"/><axis xyz="0 0 1"/></joint>
  <joint name="q3" type="prismatic"><origin xyz="0.35 0 0"/><parent link="base"/>
    <child link="slider"/><axis xyz="1 0 0"/>
    <limit effort="1" velocity="1" lower="-1" upper="1"/></joint>
  <loop name="q4" type="revolute">
    <predecessor link="rod"><origin xyz="0.35 -{CRANK} 0"/></predecessor>
    <successor link="slider"><origin xyz="0 0 0"/></successor><axis xyz="0 0 1"/></loop>
</robot>
"""


def test_a_slider_crank_has_the_shafts_of_lanchester():
    """The slider is at ``r cos θ + √(l² - r² sin² θ)``, with the harmonic r, and an integral.

    Half of the slider's part goes to each shaft; that of the pin turns with the crank.
    """
    linkage = load(Document("engine", ENGINE.encode()))
    first, both = apply_balance_shafts(RemedyRequest(linkage, radius=RADIUS))
    assert [first.verdict, both.verdict] == ["partial", "partial"]

    def second_order(angle):
        return np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2) * np.cos(2.0 * angle) / np.pi

    a2 = quad(second_order, 0.0, 2.0 * np.pi, epsabs=1e-14)[0]
    expected = {
        1: PIN * CRANK + SLIDER * CRANK / 2.0,
        -1: SLIDER * CRANK / 2.0,
        2: SLIDER * a2 / 2.0,
        -2: SLIDER * a2 / 2.0,
    }
    unbalance = {shaft["ratio"]: shaft["unbalance"] for shaft in both.details["shafts"]}
    assert unbalance == pytest.approx(expected, rel=1e-8)
    # The answer names them, in g m: 102 and 54 for the first harmonic.
    assert "unbalances 102 g m at +1, 54 g m at -1 times the speed" in first.reason
    assert both.added_mass == pytest.approx(sum(expected.values()) / RADIUS, rel=1e-8)
    # No force has a moment about the axis of the crank, where all shafts stand therefore.
    places = [shaft["place"] for shaft in both.details["shafts"]]
    np.testing.assert_allclose(places, 0.0, atol=1e-9)
    before = PIN * CRANK**2 + SLIDER * CRANK**2  # the slider moves with the pin there
    shafts = RADIUS * sum(k**2 * size for k, size in expected.items())
    balls = both.input_inertia["u1"] - before - shafts
    assert 0.0 < balls < 0.5 * shafts  # inertia of the balls about their own centres
    # The crank in the file stands at 90 degrees: its shaft points the other way.
    text = first.urdf.decode()
    at = text[text.index('<link name="balance_shaft">') :]
    assert at.split('xyz="')[1].split('"')[0].split()[1].startswith("-0.05")
    assert 0.0 < both.residual < first.residual < 0.3


@pytest.mark.slow
def test_momenta_of_the_file_have_no_first_and_second_harmonic(tmp_path):
    """Both of force and moment, in a four-bar; the third stays."""
    request = RemedyRequest(as_linkage("four_bar_general"))
    _, both = apply_balance_shafts(request)
    assert both.details["moment_taken"]
    path = tmp_path / "shafts.urdf"
    both.to_urdf(path)
    sizes = [_harmonics("four_bar_general"), _harmonics(path)]
    assert (sizes[0][1:] > 1e-3).all()
    assert (sizes[1][1:3] < 1e-9 * sizes[0][1:3].max()).all()
    np.testing.assert_allclose(sizes[1][3], sizes[0][3], rtol=1e-6)


def _harmonics(model, count=48):
    """Amplitudes of moment and force by order, 0 … 3, over a turn of the crank (4, 2)."""
    mechanism = reference.load(model)
    q, momenta = np.zeros(len(mechanism.joints)), []
    for u in np.arange(count) * 2.0 * np.pi / count:
        q = reference.follow(mechanism, q, np.array([u]))
        rates = reference.velocities(mechanism, q, np.ones((1, 1)))
        momenta.append(
            reference.regressor(mechanism, q, rates)[0:6] @ mechanism.inertias.ravel()
        )
    waves = np.fft.fft(np.array(momenta), axis=0)[:4] / count
    return np.stack([np.abs(waves[:, 2]), np.linalg.norm(waves[:, 3:5], axis=1)], axis=1)


@pytest.mark.parametrize("size", [0.3, 300.0])
def test_shafts_take_any_force_and_the_moment_if_they_can(size):
    """Forces of the shafts add up in time; a moment that asks for far places stays."""
    u = np.arange(24) * 2.0 * np.pi / 24
    force = (1.0 + 2.0j) * np.exp(2j * u) + (0.4 - 0.3j) * np.exp(-2j * u)
    moment = size * np.cos(2.0 * u + 0.4)
    near, furthest = 0.2 - 0.1j, 5.0
    shafts = shafts_against(harmonics_of(u, force, moment, np.array([2])), near, furthest)
    assert [shaft.ratio for shaft in shafts] == [2, -2]
    for shaft in shafts:
        taken = -(shaft.ratio**2) * shaft.unbalance * np.exp(1j * shaft.ratio * u)
        force = force + taken
        moment = moment + (shaft.place.conjugate() * taken).imag
    assert np.abs(force).max() < 1e-12
    near_enough = size < 100.0
    assert (np.abs(moment).max() < 1e-12) == near_enough
    assert all((shaft.place == near) != near_enough for shaft in shafts)


def test_where_shafts_are_no_remedy():
    """Several freedoms, or a spatial linkage."""
    for model, why in (
        ("five_bar", "2 degrees of freedom"),
        ("bennett", "a spatial linkage"),
    ):
        (applied,) = apply_balance_shafts(RemedyRequest(as_linkage(model)))
        assert applied.verdict == "refused" and why in applied.reason, applied


@pytest.mark.slow
def test_counterweights_for_the_force_leave_a_moment():
    """The momentum of the file is that of a couple, whose size was stated."""
    request = RemedyRequest(as_linkage("four_bar_general"))
    (applied,) = apply_force_masses(request)
    assert applied.verdict == "partial" and applied.residual > 0.0
    details = applied.details
    assert details["moment_after"] / details["moment_before"] == pytest.approx(applied.residual)
    assert details["force_after"] < 1e-9 * details["force_before"]
    # Pinocchio, along the motions of `balance verify` and `balance reduce`.
    seen = [
        run.rms("moment")
        for run in balance.verify(load(Document("made.urdf", applied.urdf))).runs
    ]
    mean = np.sqrt(np.mean(np.square(seen)))
    assert details["moment_after"] == pytest.approx(mean, rel=1e-9)
    shaking = balance.partial("four_bar_general", ["crank"], 0.1).given
    assert (details["force_before"], details["moment_before"]) == pytest.approx(
        (shaking.force, shaking.moment), rel=1e-9
    )
    (again,) = apply_force_masses(
        RemedyRequest(as_linkage("four_bar_general"), balance="force")
    )
    assert again.verdict == "refused"


@pytest.mark.slow
def test_results_are_printed_as_they_come(capsys, monkeypatch):
    """On a terminal each remedy has a line on standard error before the table."""
    monkeypatch.setattr("balance.app.cli.progress.os.isatty", lambda _: True)
    words = ["remedies", "four_bar_general", "--only", "balance_shafts,partial", "--json"]
    assert main(words) == 0
    done = capsys.readouterr()
    names = [each["short"] for each in json.loads(done.out)["remedies"]]
    assert [line.split(":")[0] for line in done.err.splitlines()[: len(names)]] == names
