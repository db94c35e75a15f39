"""The least shaking of discs, blocks, cylinders and sectors: closed forms, and refusals."""

import json
import re

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import balance
from balance.app.cli.main import main
from balance.masses import ElasticFrame
from kinematics.errors import UsageError
from tests.independent.shapes_with_webs import shape_and_web
from tests.support.command_runs import asked

STEEL = 7850.0
NEEDED = 0.05  # kg m, what each arm needs on its other side
BALL, BOX = "ball(0,0,0,0.1)", "box(-0.1:0.1,-0.1:0.1,-0.02:0.02)"


def arm(name, place, mimic=""):
    """A link that turns about z, with 1 kg at x = 0.05 m."""
    return (
        f'<link name="{name}"><inertial><origin xyz="{NEEDED} 0 0"/><mass value="1"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
        f'<joint name="turn_{name}" type="continuous"><parent link="base"/>'
        f'<child link="{name}"/><origin xyz="{place} 0 0"/><axis xyz="0 0 1"/>{mimic}</joint>'
    )


@pytest.fixture
def one_arm(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="arm"><link name="base"/>{arm("a", 0)}</robot>')
    return path


@pytest.fixture
def two_arms(tmp_path):
    """The second arm turns against the first, so that the squares of their forces add up."""
    path = tmp_path / "arms.urdf"
    geared = '<mimic joint="turn_a" multiplier="-1"/>'
    arms = arm("a", 0) + arm("b", 1, geared)
    path.write_text(f'<robot name="arms"><link name="base"/>{arms}</robot>')
    return path


def first_moment(shape, region, mass, radius=0.1):
    """The largest first moment of a shape of some mass, with its web, in a region, kg m."""
    kind, size = shape.split("=")
    t = r = float(size)
    reach = np.sqrt(radius**2 - 0.25 * t * t) if region == BALL else radius
    if kind == "sector":
        half = mass / (STEEL * t * reach**2)
        return 2.0 / 3.0 * STEEL * t * reach**3 * np.sin(half)

    def with_web(size):
        """Mass and first moment with a radius, a half side, or half a length."""
        if kind == "cylinder":
            away = np.sqrt(radius**2 - size**2) - r
            return 2.0 * size * STEEL * np.array(shape_and_web(kind, r, away))
        return t * STEEL * np.array(shape_and_web(kind, size, reach - size))

    size = brentq(lambda size: with_web(size)[0] - mass, 1e-6, 0.9 * radius, xtol=1e-15)
    return with_web(size)[1]


SHAPES = [
    ("disc=0.02", BALL),
    ("disc=0.02", BOX),
    ("block=0.02", BOX),
    ("cylinder=0.03", BALL),
    ("sector=0.02", BALL),
]


@pytest.mark.parametrize("minimise", ["rms", "peak"])
@pytest.mark.parametrize(("shape", "region"), SHAPES)
def test_one_arm_gets_the_shape_at_its_far_side(shape, region, minimise, one_arm):
    """At constant speed the force is the square of the speed times what is left to balance."""
    budget = 0.3
    answer = balance.partial(
        one_arm,
        ["a"],
        budget,
        regions={"a": region},
        balance="force",
        speed="300rpm",
        minimise=minimise,
        shape=shape,
    )
    (weight,) = answer.weights
    assert weight.mass == pytest.approx(budget, rel=1e-9)
    left = NEEDED - first_moment(shape, region, budget)
    assert answer.share == pytest.approx(left / NEEDED, rel=1e-5)
    assert answer.shaking.force == pytest.approx((300 * np.pi / 30) ** 2 * left, rel=1e-5)
    assert answer.verdict == "optimal" and answer.bound <= answer.shaking.objective
    kind = shape.partition("=")[0]
    assert f"no {kind}s of" in answer.words and kind in weight.region.text
    assert answer.shape == f"{kind}={1e3 * float(shape.partition('=')[2]):g}mm"
    assert answer.least_objective < answer.shaking.objective


@pytest.mark.parametrize("shape", ["disc=0.02", "cylinder=0.03"])
def test_a_budget_is_shared_by_two_arms(shape, two_arms):
    """Both arms lack the same, but 0.5 kg are there: another solver shares them out.

    With webs that are given the shares are nearly the best ones, and never better.
    """
    budget, regions = 0.5, {"a": BALL, "b": "ball(0,0,0,0.07)"}

    def left(first):
        a = NEEDED - first_moment(shape, BALL, first)
        return np.hypot(a, NEEDED - first_moment(shape, BALL, budget - first, 0.07))

    best = minimize_scalar(left, bounds=(0.01, 0.49), method="bounded", options={"xatol": 1e-9})
    answer = balance.partial(
        two_arms,
        ["a", "b"],
        budget,
        regions=regions,
        balance="force",
        speed="300rpm",
        shape=shape,
    )
    given = np.hypot(NEEDED, NEEDED)
    masses = {weight.link: weight.mass for weight in answer.weights}
    assert sum(masses.values()) == pytest.approx(budget, rel=1e-6)
    assert answer.share == pytest.approx(left(masses["a"]) / given, rel=1e-6)
    assert best.fun / given * (1.0 - 1e-6) <= answer.share <= best.fun / given * (1.0 + 3e-3)
    assert answer.words.endswith("in the regions beside these webs do better")


def test_no_discs_beside_the_webs_do_better(two_arms):
    """Of discs at the rims, beside the webs that were found as given masses."""
    radii = {"a": 0.1, "b": 0.07}
    answer = balance.partial(
        two_arms,
        list(radii),
        0.8,
        regions={
            link: f"cylinder(0,0,0,0,0,1,{radius},0.02)" for link, radius in radii.items()
        },
        balance="force",
        speed="300rpm",
        shape="disc=0.02",
    )
    discs, webs, rests = {}, {}, {}
    for weight in answer.weights:
        discs[weight.link] = STEEL * weight.region.volume
        webs[weight.link] = weight.mass - discs[weight.link]
        moment = weight.mass * weight.com - discs[weight.link] * weight.region.centre
        rests[weight.link] = float(np.linalg.norm(moment))
    room = 0.8 - sum(webs.values())

    def left(first):
        parts = []
        for link, mass in (("a", first), ("b", room - first)):
            distance = radii[link] - np.sqrt(mass / (STEEL * np.pi * 0.02))
            parts.append(NEEDED - rests[link] - mass * distance)
        return np.hypot(*parts)

    best = minimize_scalar(left, bounds=(0.0, room), method="bounded", options={"xatol": 1e-10})
    assert min(webs.values()) > 0.05
    assert answer.share * np.hypot(NEEDED, NEEDED) == pytest.approx(best.fun, rel=1e-5)
    assert discs["a"] == pytest.approx(best.x, abs=1e-3 * room)


def test_of_several_sizes_the_best_is_taken(one_arm):
    """A thick disc of the same mass is smaller, and reaches further from the joint."""
    common = dict(regions={"a": BOX}, balance="force", speed=30.0)
    answer = balance.partial(one_arm, ["a"], 0.3, shape="disc=5mm/20mm/10mm", **common)
    thick = balance.partial(one_arm, ["a"], 0.3, shape="disc=20mm", **common)
    assert answer.share == pytest.approx(thick.share, rel=1e-6)
    assert "disc=5mm/20mm/10mm" in answer.words


@pytest.mark.parametrize("shape", ["disc=0.02", "sector=0.02"])
def test_with_mass_to_spare_the_lightest_that_balances_is_found(shape, one_arm):
    answer = balance.partial(
        one_arm, ["a"], 5.0, regions={"a": BALL}, balance="force", speed=30.0, shape=shape
    )
    assert answer.share < 1e-5
    needed = first_moment(shape, BALL, answer.mass)
    assert needed == pytest.approx(NEEDED, rel=1e-4)


def test_a_front_goes_down_and_its_file_has_the_shape(one_arm, tmp_path):
    front = balance.pareto(
        one_arm,
        ["a"],
        3,
        0.4,
        regions={"a": BALL},
        balance="force",
        speed=30.0,
        shape="disc=0.02",
    )
    shares = [design.share for design in front.designs]
    assert shares[0] == 1.0 and shares == sorted(shares, reverse=True)
    assert [round(design.mass, 9) for design in front.designs] == [0.0, 0.2, 0.4]
    text = front.to_urdf(tmp_path / "made.urdf").decode()
    assert "a_counterweight" in text
    assert front.designs[-1].weights[0].web is not None
    check = balance.verify(tmp_path / "made.urdf", balance="force", speed=30.0)
    assert check.force == pytest.approx(front.designs[-1].shaking.peak_force, rel=1e-9)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (dict(balance="dynamic"), "ask for force balance"),
        (dict(minimise="torque"), "moments of inertia"),
        (dict(max_torque={"turn_a": 5.0}), "moments of inertia"),
        (dict(frame=ElasticFrame(50.0, 4.0, 2e5, 100.0)), "moments of inertia"),
        (dict(thickness=0.01), "have their thickness"),
        (dict(move={"a": 0.5}), "for added matter"),
        (dict(density=None), "give a density"),
        (dict(shape="cone=0.02"), "no known form"),
    ],
)
def test_what_does_not_go_with_a_shape_is_said(words, reason, one_arm):
    options = dict(balance="force", speed=30.0, shape="disc=0.02") | words
    with pytest.raises(UsageError, match=reason):
        balance.partial(one_arm, ["a"], 0.3, **options)


@pytest.mark.parametrize("shape", ["disc=0.02", "block=0.02", "cylinder=0.02", "sector=0.02"])
@pytest.mark.parametrize(
    ("region", "wider"),
    [
        ("", "ball(0,0,0,0.0255)"),
        ("ball(0,0,0,0.1)", "ball(0,0,0,0.102)"),
        # The thickness of the box is that of the flat shapes, and bounds no lever.
        ("box(-0.1:0.1,-0.1:0.1,-0.01:0.01)", "box(-0.102:0.102,-0.102:0.102,-0.01:0.01)"),
    ],
)
def test_a_larger_region_leaves_less_where_a_shape_is_at_its_rim(
    region, wider, shape, one_arm, capsys
):
    """The region by default is a ball of half the distance 0.05 m of the centre of mass."""
    words = ["reduce", str(one_arm), "--links", "a", "--budget", "0.05", "--speed", "30rad/s"]
    words += ["--balance", "force"]
    shaped = ["--shape", shape]

    def run(text, *options):
        code = main([*words, *(["--region", f"a={text}"] if text else []), *options])
        out = capsys.readouterr().out
        assert code == 0
        return out

    def force_in(text, kind=shaped):
        return json.loads(run(text, *kind, "--json"))["designs"][0]["found"]["force"]

    lines = run(region, *shaped).splitlines()
    room = next(line for line in lines if line.startswith("room "))
    place = f"{region} of a;" if region else "ball(0,0,0,0.025) of a (the default);"
    assert room.split(maxsplit=1)[1].startswith(place)
    assert "a at the rim of the region: a larger one leaves less" in room
    if region:
        assert room.count("--region L=SHAPE gives room") == 1
    else:
        # Webs are not proved to be the best: in their place matter of any shape is tried.
        webs = not shape.startswith("sector")
        twice = force_in("50mm", [] if webs else shaped)
        saved = (force_in("") - twice) / (NEEDED * 30.0**2)
        more = "--region a=50mm leaves " if saved > 0.02 else "twice the radius saves less than"
        assert room.count(more) == 1 and (", of any shape" in room) == (webs and saved > 0.02)
        lead = lines[1].startswith("The default regions are too small: --region a=")
        assert lead == (saved > 0.02)
    assert force_in(wider) < force_in(region)


def test_the_page_has_the_size_that_is_printed(one_arm, tmp_path, capsys):
    page = tmp_path / "page.html"
    words = ["reduce", str(one_arm), "--links", "a", "--budget", "0.3", "--speed", "30rad/s"]
    words += ["--region", f"a={BALL}"]
    words += ["--balance=force", "--shape=disc=20mm", "--about=0.1,0,0", "--html", str(page)]
    assert main(words) == 0
    printed = re.search(r"^a fills (.* disc .*)$", capsys.readouterr().out, re.MULTILINE)
    sizes = (1e3 * float(size) for size in re.findall(r"([\d.]+) m\b", printed[1]))
    radius, thickness, width, length = sizes
    size = f"disc of radius {radius:g} mm, {thickness:g} mm thick"
    web = f"a web {width:g} mm wide, {length:g} mm long"
    text = page.read_text("utf-8")
    assert f">all of a {size}, and {web}</td>" in text
    assert "the moment about\n(0.1, 0, 0) m;" in text and "middle of the mechanism" not in text
    area, _ = shape_and_web("disc", 1e-3 * radius, 1e-3 * length)
    assert STEEL * area * 0.02 == pytest.approx(0.3, rel=1e-3) and width == radius


@pytest.mark.slow
def test_webs_settle_where_they_are_most_of_the_mass():
    """A disc of 6 mm on a bar of 0.6 m; other rounding took 30 to 50 steps."""
    regions = {"crank": "632mm", "rocker": "1460mm"}
    best = balance.partial(
        "four_bar_general",
        "crank,rocker",
        0.6,
        regions=regions,
        balance="force",
        shape="disc=20mm",
    )
    (weight,) = best.weights
    assert weight.web is not None and not weight.floats
    _, wide, _ = 2.0 * np.linalg.norm(weight.web.place[:3, :3], axis=0)
    assert wide == pytest.approx(np.linalg.norm(weight.region.place[:3, 0]), rel=1e-9)
    assert best.share > best.least_objective / best.given.objective


def test_the_page_says_which_region_does_more(one_arm, tmp_path, capsys):
    page = tmp_path / "page.html"
    words = ["reduce", str(one_arm), "--links", "a", "--budget", "0.3", "--speed", "30rad/s"]
    assert main([*words, "--balance=force", "--html", str(page)]) == 0
    lead, room = capsys.readouterr().out.splitlines()[:2]
    assert room.startswith("The default regions are too small: --region a=")
    assert f"{lead} {room}" in " ".join(page.read_text("utf-8").split())


def test_a_region_that_bounds_nothing_is_told_without_its_rim(one_arm, capsys):
    """A sector of a given radius is no larger in a larger region."""
    words = ["reduce", str(one_arm), "--links", "a", "--budget", "0.05", "--speed", "30rad/s"]
    words += ["--balance", "force", "--shape", "sector=20mm,50mm", "--region", f"a={BALL}"]
    assert main(words) == 0
    (room,) = (x for x in capsys.readouterr().out.splitlines() if x.startswith("room "))
    assert room.split(maxsplit=1)[1] == f"{BALL} of a"
    enough = [*words[:5], "5", *words[6:-4], "--shape", "disc=20mm", *words[-2:]]
    assert main(enough) == 0
    out = capsys.readouterr().out
    assert "at the rim of the region: a larger one takes less" in out


def test_the_command_prints_and_refuses_as_counterweights_does(one_arm, capsys):
    words = ["reduce", str(one_arm), "--links", "a", "--budget", "0.3", "--speed", "30rad/s"]
    shaped = [*words, "--shape", "disc=20mm"]
    assert main([*shaped, "--balance", "force"]) == 0
    text = capsys.readouterr().out
    assert "a fills 100 % of a disc of radius" in text
    assert "shape " in text and "any shape leaves" in text
    assert main([*shaped, "--balance", "force", "--json"]) == 0
    (design,) = json.loads(capsys.readouterr().out)["designs"]
    assert design["shape"] == "disc=20mm" and design["least_objective"] > 0.0
    for more, reason in (
        ([], "--balance force"),
        (["--balance", "force", "--max-torque", "turn_a=5"], "leave out --max-torque"),
        (["--balance", "force", "--thickness", "5mm"], "leave out --thickness"),
        (["--balance", "force", "--points"], "leave out --points"),
        (["--balance", "force", "--density", "none"], "leave out --density none"),
        (["--balance", "force", "--move", "a"], "leave out --move"),
    ):
        assert main([*shaped, *more]) == 2
        refused = capsys.readouterr()
        assert not refused.out and reason in refused.err.splitlines()[0]


def test_a_budget_below_what_the_solver_tells_is_not_limited_by_room(one_arm, capsys):
    """Of 1e-9 kg that save nothing the solver uses any part, though more would save more."""
    words = ["reduce", str(one_arm), "--links", "a", "--balance", "force", "--budget", "1e-9"]
    for shape in ([], ["--shape", "disc=0.01"]):
        assert main([*words, *shape]) == 0
        assert "more kilograms do no better" not in capsys.readouterr().out


def test_a_sector_that_no_workshop_cuts_names_shapes_that_it_does():
    """A sector of the mass ρ t φ R²/2 that is said to be of 60° has that mass.

    What it costs is the distance of the centre, from the integral of the sector: as sampled.
    """
    words = [
        "reduce",
        "slider_crank",
        "--links",
        "crank",
        "--budget",
        "0.5",
        "--speed",
        "300rpm",
    ]
    words += ["--balance", "force", "--shape"]
    said = asked([*words, "sector=20mm"]).out
    (radius,) = re.findall(r"with 60°, --shape sector=20mm,(\d+)mm", said)
    assert "is too narrow to cut: take --shape disc=20mm" in said
    assert said.splitlines()[0].endswith("The sector on 'crank' is too narrow to cut.")
    # Crank and rod of this model are equally long: at half a turn they may fold.
    assert re.search("^note .*passes near a singularity", said, re.MULTILINE)
    typo = asked([*words, "disc=15mm/"])
    assert (typo.code, typo.out) == (2, "") and "shape 'disc=15mm/': '' is not" in typo.err
    mass = 7850 * 0.02 * np.pi / 6.0 * (1e-3 * float(radius)) ** 2
    assert abs(mass - 0.5) <= 0.02
    assert "too narrow" not in asked([*words, f"sector=20mm,{radius}mm"]).out
    far, near = map(float, re.findall(r"has ([\d.]+) times the unbalance", said))
    (turn,) = re.findall(r"a sector of ([\d.]+)° on 'crank'", said)
    wide = float(radius) * (60.0 / float(turn)) ** 0.5

    def distance(angle, reach):
        r, a = np.meshgrid(np.linspace(0.0, reach, 2001), np.linspace(-angle, angle, 201) / 2)
        return float((r * r * np.cos(np.radians(a))).sum() / r.sum())

    narrow = distance(float(turn), wide)
    assert near == pytest.approx(distance(60.0, float(radius)) / narrow, rel=0.05)
    disc = wide * (float(turn) / 360.0) ** 0.5
    assert far == pytest.approx((wide - disc) / narrow, rel=0.05) and far > 1.0 > near
