"""Springs at constant speed: a slider by hand, and energies of a four-bar from finite poses."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.optimize import least_squares

from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.shafts.crank_turn import turn_of_crank
from balance.masses.remedies.shafts.harmonic_springs import apply_harmonic_springs
from kinematics.loading.model_gallery import as_linkage
from tests.support.remedy_files import momentum, placed
from tests.support.remedy_requests import PENDULUM, request_of, rod

CRANK, SLIDER = 0.2, 0.9
# A slider-crank whose rod is as long as its crank: the slider is at 2 r cos u.
YOKE = (
    rod("crank", "base", "0 0 0", 0.1, "0 0 0", (0.0, 0.0, 1e-3), joint="u1"),
    rod("rod", "crank", f"{CRANK * 0.6} {CRANK * 0.8} 0", 1e-9, "0 0 0", (0.0, 0.0, 0.0)),
    rod(
        "slider",
        "base",
        f"{CRANK * 1.2} 0 0",
        SLIDER,
        "0 0 0",
        (0.0, 0.0, 0.0),
        kind="prismatic",
        axis="1 0 0",
    ),
    f'<loop name="pin" type="revolute"><predecessor link="rod"><origin xyz="{CRANK * 0.6} '
    f'{-CRANK * 0.8} 0"/></predecessor><successor link="slider"><origin xyz="0 0 0"/>'
    '</successor><axis xyz="0 0 1"/></loop>',
)


@pytest.mark.slow
def test_a_slider_that_moves_as_a_cosine_swings_on_its_spring():
    """``m ẍ = -κ x`` with κ = m at the unit speed, about the axis of the crank."""
    applied, *_ = apply_harmonic_springs(request_of(*YOKE))
    assert applied.verdict == "partial" and applied.added_mass == 0.0
    (spring,) = json.loads(applied.files["springs.json"])["springs"]
    assert spring["link"] == "slider"
    assert spring["stiffness"] == pytest.approx(SLIDER, rel=1e-5)
    assert spring["base"][0] == pytest.approx(0.0, abs=1e-6)
    assert applied.residual < 1e-6


def energies(linkage, turn, points, springs):
    """Kinetic energy over a turn at the unit rate (N,), and that of the springs."""
    kinetic, stored = [], []
    for q, qd in zip(turn.q[:-1], turn.qd[:-1], strict=True):
        poses, twists = placed(linkage, q, qd)
        momenta = momentum(linkage, q, qd)
        links = [body.link for body in linkage.bodies]
        kinetic.append(0.5 * np.einsum("bi,bi->", np.array(twists)[links], momenta))
        ways = [(poses[link] @ [*point, 1.0])[:3] for link, point in points]
        stored.append(
            sum(0.5 * k * (p - a) @ (p - a) for (k, a), p in zip(springs, ways, strict=True))
        )
    return np.array(kinetic), np.array(stored)


def slope(values):
    """Derivative over a turn of even samples, by its Fourier series."""
    orders = np.fft.rfftfreq(len(values), 1.0 / len(values))
    return np.fft.irfft(1j * orders * np.fft.rfft(values), len(values))


@pytest.mark.slow
def test_energies_of_a_four_bar_vary_as_little_as_is_said():
    """The torque of the drive is the slope of all energies; random starts end no lower."""
    linkage = as_linkage("four_bar_general")
    request = RemedyRequest(linkage)
    turn = turn_of_crank(request).trajectory
    results = list(apply_harmonic_springs(request))
    assert [len(each.details["springs"]) for each in results] == [1, 2]
    for applied in results:
        listed = applied.details["springs"]
        points = [(linkage.places[each["link"]].link, each["at"]) for each in listed]
        springs = [(each["stiffness"], np.array(each["base"])) for each in listed]
        kinetic, stored = energies(linkage, turn, points, springs)
        left = np.sqrt(np.mean(slope(kinetic + stored) ** 2) / np.mean(slope(kinetic) ** 2))
        assert left == pytest.approx(applied.residual, rel=1e-6)
    assert results[1].residual < results[0].residual < 0.5

    # The best spring on the same point, by another program from twenty random starts.
    (spring,) = results[0].details["springs"]
    link, point = linkage.places[spring["link"]].link, spring["at"]
    kinetic, _ = energies(linkage, turn, [], [])
    poses = [placed(linkage, q, 0.0 * q)[0][link] for q in turn.q[:-1]]
    ways = np.array([(pose @ [*point, 1.0])[:2] for pose in poses])

    def torque(x):
        stored = 0.5 * x[0] ** 2 * ((ways - x[1:]) ** 2).sum(axis=1)
        return slope(kinetic + stored) / unit

    rng, unit = np.random.default_rng(4), np.sqrt(np.sum(slope(kinetic) ** 2))
    for _ in range(20):
        start = [rng.uniform(0.5, 2.0), *rng.uniform(-1.0, 1.0, 2)]
        solved = least_squares(torque, start, xtol=1e-12, ftol=1e-12, gtol=1e-12)
        assert np.linalg.norm(solved.fun) == pytest.approx(results[0].residual, rel=0.01)


def test_where_springs_are_no_remedy():
    """Several freedoms, force balance, and a crank that needs no torque."""
    for request, why in (
        (request_of(*PENDULUM), "2 degrees of freedom"),
        (request_of(*YOKE, balance="force"), "only the force"),
        (request_of(PENDULUM[0]), "needs no torque"),
    ):
        (applied,) = apply_harmonic_springs(request)
        assert applied.verdict == "refused" and why in applied.reason
