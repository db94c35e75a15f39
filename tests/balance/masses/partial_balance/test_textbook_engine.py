"""A single-cylinder engine in closed form: the best balance of its crank, by the command.

Crank 50 mm, rod 200 mm, piston 0.5 kg, 3000 rpm; a crank of 1 kg with its centre half-way, and
a rod of 0.3 kg with its centre at two fifths, chosen here. The rod shakes as 0.18 kg at the
crank pin and 0.12 kg at the piston do. At the crank angle t the piston is at
``x = r cos t + sqrt(l² - r² sin² t)``, and a first moment B opposite to the crank pin adds
``B ω² (cos t, sin t)`` to the force.
"""

import json

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import balance
from balance.app.cli.main import main

CRANK, ROD, PISTON, SPEED = 0.05, 0.2, 0.5, 3000.0 * np.pi / 30.0
STEEL = 7850.0
MOVING, TURNING = PISTON + 0.12, 1.0 * CRANK / 2.0 + 0.18 * CRANK
INERTIAL = (
    '<inertial><origin xyz="{} 0 0"/><mass value="{}"/>'
    '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>'
)
ENGINE = f"""<robot name="engine"><link name="base"/>
<link name="crank">{INERTIAL.format(0.5 * CRANK, 1.0)}</link>
<link name="rod">{INERTIAL.format(0.4 * ROD, 0.3)}</link>
<link name="piston">{INERTIAL.format(0.0, PISTON)}</link>
<joint name="u1" type="continuous"><parent link="base"/><child link="crank"/>
<axis xyz="0 0 1"/></joint>
<joint name="q2" type="continuous"><parent link="crank"/><child link="rod"/>
<origin xyz="{CRANK} 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="slide" type="prismatic"><parent link="base"/><child link="piston"/>
<origin xyz="{CRANK + ROD} 0 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/>
</joint>
<loop name="pin" type="revolute"><predecessor link="rod"><origin xyz="{ROD} 0 0"/></predecessor>
<successor link="piston"/><axis xyz="0 0 1"/></loop></robot>"""


def forces(B, angle):
    """Sizes of the shaking force, N, by the closed form."""
    c, s = np.cos(angle), np.sin(angle)
    root = np.sqrt(ROD**2 - CRANK**2 * s**2)
    bend = -(CRANK**2) * np.cos(2 * angle) / root - CRANK**4 * (s * c) ** 2 / root**3
    x = MOVING * (-CRANK * c + bend)  # second derivative by the angle
    rest = B - TURNING
    return SPEED**2 * np.hypot(x + rest * c, rest * s)


@pytest.fixture
def engine(tmp_path):
    path = tmp_path / "engine.urdf"
    path.write_text(ENGINE)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("minimise", ["rms", "peak"])
@pytest.mark.parametrize("matter", ["--points", "steel"])
def test_the_best_balance_of_the_crank(matter, minimise, engine, capsys):
    """The rms is least at B = 0.04949 kg m, the peak, 2020 N, at 0.0523 kg m."""
    words = ["reduce", str(engine), "--balance", "force", "--links", "crank", "--json"]
    words += ["--speed", "3000rpm", "--budget", "20", "--minimise", minimise]
    words += ["--density", matter] if matter == "steel" else [matter]
    assert main([*words, "--region", "crank=box(-0.1:-0.02,-0.05:0.05,-0.02:0.02)"]) == 0
    (design,) = json.loads(capsys.readouterr().out)["designs"]
    (weight,) = design["weights"]
    B = -weight["mass"] * weight["com"][0]
    angle = np.linspace(0.0, 2.0 * np.pi, 3601)
    trials = np.linspace(0.0485, 0.0535, 501)
    if minimise == "rms":
        means = [np.sqrt(np.mean(forces(b, angle[:-1]) ** 2)) for b in trials]
        assert trials[np.argmin(means)] == pytest.approx(0.04949, abs=2e-5)
        assert B == pytest.approx(0.04949, abs=5e-5)
        assert design["found"]["objective"] == pytest.approx(min(means), rel=1e-3)
    else:
        peaks = [forces(b, angle).max() for b in trials]
        assert min(peaks) == pytest.approx(2020.0, abs=1.0)
        assert trials[np.argmin(peaks)] == pytest.approx(0.0523, abs=5e-5)
        assert design["found"]["peak_force"] == pytest.approx(min(peaks), rel=1e-3)
        assert B == pytest.approx(0.0523, abs=2e-4)
    assert design["bound"] <= design["found"]["objective"] * (1.0 + 1e-7)
    assert design["verdict"] == "optimal"


@pytest.mark.slow
def test_the_harmonics_that_a_crank_can_reach(engine, capsys):
    """``F = (B - TURNING + a_1) cos + i (B - TURNING) sin`` of order 1, ``a_n cos`` of others.

    With ``B - TURNING = -a_1 / 2`` half of the amplitude of order 1 is left, which turns.
    """
    angle = 2.0 * np.pi * np.arange(3600) / 3600
    c, s = np.cos(angle), np.sin(angle)
    root = np.sqrt(ROD**2 - CRANK**2 * s**2)
    bend = -(CRANK**2) * np.cos(2 * angle) / root - CRANK**4 * (s * c) ** 2 / root**3
    stroke = MOVING * (-CRANK * c + bend)
    first, second = (2.0 * np.mean(stroke * np.cos(n * angle)) for n in (1, 2))
    words = ["reduce", str(engine), "--balance", "force", "--links", "crank", "--json"]
    words += ["--speed", "3000rpm", "--budget", "20", "--points"]
    words += ["--region", "crank=box(-0.1:-0.02,-0.05:0.05,-0.02:0.02)", "--minimise"]
    assert main([*words, "1"]) == 0
    answer = json.loads(capsys.readouterr().out)
    (design,) = answer["designs"]
    (weight,) = design["weights"]
    assert answer["objective"] == "shaking of order 1"
    B = -weight["mass"] * weight["com"][0]
    assert B == pytest.approx(TURNING - 0.5 * first, rel=1e-3)
    # Two components of half the amplitude each.
    left = SPEED**2 * abs(first) / 2.0
    assert design["found"]["objective"] == pytest.approx(left, rel=1e-6)
    assert design["bound"] == pytest.approx(left, rel=1e-5)

    assert main([*words, "2"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["given"]["objective"] == pytest.approx(
        SPEED**2 * abs(second) / np.sqrt(2.0), rel=1e-6
    )
    assert answer["designs"][0]["found"]["objective"] == pytest.approx(
        answer["given"]["objective"], rel=1e-6
    )


@pytest.mark.parametrize(
    "minimise, words",
    [
        ("0", "from 1 to 100"),
        ("1,1", "different numbers"),
        ("1,x", "no orders of harmonics"),
        ("1", "one turn of a crank"),
    ],
)
def test_harmonics_that_there_are_not(minimise, words, engine, capsys):
    command = ["reduce", str(engine), "--links", "crank", "--budget", "1", "--minimise"]
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main([*command, minimise]))
    assert ended.value.code in (2, 3) and words in capsys.readouterr().err


def half_balls_and_caps(radius, budget):
    """Largest first moment, kg m, of steel in a ball about the shaft, and its mass, kg.

    A half-ball has ``ρ π R⁴ / 4``; a cap from the distance a on has ``ρ π (R² - a²)² / 4``.
    """
    mass = STEEL * 2.0 / 3.0 * np.pi * radius**3
    a = 0.0
    if mass > budget:
        height = brentq(
            lambda h: STEEL * np.pi * h**2 * (radius - h / 3.0) - budget, 0.0, radius
        )
        a, mass = radius - height, budget
    return STEEL * np.pi * (radius**2 - a**2) ** 2 / 4.0, mass


def test_wider_regions_and_the_least_of_the_crank(engine):
    """Regions by default reach half of the crank; the budget is that of 0.4 kg of steel."""
    angle = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)

    def rms(B):
        return float(np.sqrt(np.mean(forces(B, angle) ** 2)))

    best = minimize_scalar(rms, bounds=(0.0, 0.2), method="bounded", options={"xatol": 1e-12})
    design = balance.partial(engine, "crank", 0.4, balance="force", speed="3000rpm")
    assert design.least_anywhere == pytest.approx(best.fun, rel=1e-5)
    assert design.verdict == "optimal" and design.mass < 0.3
    radii = [wider.regions["crank"].size for wider in design.wider]
    assert radii == [0.05, 0.1, 0.2][: len(radii)] and len(radii) >= 2
    for wider, radius in zip(design.wider, radii, strict=True):
        B, mass = half_balls_and_caps(radius, 0.4)
        least = rms(min(B, best.x)) / rms(0.0)
        assert wider.share == pytest.approx(least, rel=1e-4)
        assert B > best.x or wider.mass == pytest.approx(mass, rel=1e-3)
    # The last one saves hardly more than the one before, or is the least that there is.
    assert design.wider[-1].share < design.wider[0].share - 0.02
