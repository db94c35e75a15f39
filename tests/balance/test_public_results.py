"""One table of what public results can do, and one word for one thing in public functions."""

from __future__ import annotations

import inspect
import json
import re
from types import FunctionType

import pytest

import balance
from balance.support.result_files import WithPage, WithPicture
from kinematics.errors import UsageError
from tests.support.command_runs import asked
from tests.support.page_elements import without_breaks
from tests.support.source_files import FACES, public_names

DATA, FILE, PAGE, PICTURE = "to_dict", "to_urdf", "to_html", "plot"
ALL = {DATA, FILE, PAGE, PICTURE}

# What a result can do, as the command that gives it prints, writes and draws it.
RESULTS = {
    # Of spaces: no masses that a file could have, and a page with the moving linkage.
    "CertifiedSpace": {DATA, PAGE},
    "DesignSpace": {DATA, PAGE},
    "RequiredSpace": {DATA, PAGE},
    "Explanation": {DATA},
    "Formulas": {DATA, PAGE},
    "ModeAnswers": {DATA},
    "Decoupling": {DATA},
    "ExactRanks": {DATA},
    "PureInertia": {DATA},
    # Of masses.
    "Counterweights": ALL,
    "Design": ALL,
    "PartialBalance": ALL,
    "ParetoFront": ALL,
    "LeastViolation": {DATA, FILE},
    "MovableWeights": {DATA},
    "Identification": ALL,
    "ExcitingMotion": {DATA, PAGE, PICTURE},
    # Its remedies have the files, each its own: `AppliedRemedy`.
    "RemedyComparison": {DATA, PAGE, PICTURE},
    "AppliedRemedy": {DATA, FILE},
    "SpringBalance": {DATA, PAGE, PICTURE},
    # Of motions, which leave the file as it is.
    "Verification": {DATA, PAGE, PICTURE},
    "VerificationComparison": {DATA, PAGE, PICTURE},
    "FloatingBaseMotion": {DATA, PAGE, PICTURE},
    "FlexibleSimulation": {DATA, PAGE, PICTURE},
    "QuietMotion": {DATA, PAGE, PICTURE},
    "ReactionlessPaths": {DATA, PAGE, PICTURE},
    "ReactionlessPath": {DATA},
    "InertiaChart": {DATA, PAGE, PICTURE},
    "PathMoments": {DATA, PAGE, PICTURE},
    "ShakingTolerance": {DATA},
    "FreeMode": {DATA},
    "SupportedModes": {DATA, PICTURE},
    "SupportPoints": {DATA, PICTURE},
    # Of geometries.
    "SketchedLinkage": {DATA, FILE},
    "SweepTable": {DATA, PAGE, PICTURE},
    "Synthesis": ALL,
    "SynthesizedMechanism": {DATA, FILE},
}
# Parts of results and of requests, arrays with names, and checks: no command prints them alone.
PARTS = set(
    """
    Arm BalancingFamily Beam BodyInertia BuildableMasses Certainty CertificateCheck Clamp
    DesignCheck ElasticFrame EndBody Feasibility FewestRotors FloatingBase FourBarPlatform
    Freedom ManySpaces Meeting ModeAnswer MomentumMap MomentumTaylor MovableWeight Multipole
    PantographMasses ParallelepipedPlatform Payload PoseBalance Primitive PrincipalVectors Proof
    ReactionNullSpace Region RotorSet ScrewLine Section Similarity SpaceRecord StackedChains
    StackedFourBar Study Support Trajectory Transfer
    """.split()
)
# Words that stand for what another word stands for in the same arguments.
SYNONYMS = {
    "workers": ("jobs", "n_jobs", "processes", "cores"),
    "motions": ("trajectories_given", "moves", "followed"),
    "balance": ("kind_of_balance", "force_only", "objective_balance"),
    "crank": ("crank_joint", "driver"),
    "minimise": ("objective", "minimize"),
    "regions": ("region", "where_matter"),
    "density": ("rho", "material"),
}


def public(kind: type) -> dict[str, object]:
    """The public names of `balance` and its groups that are of a kind."""
    faces = [face for face in FACES if face.split(".")[0] == "balance"]
    return {
        name: value
        for face in faces
        for name, value in public_names(face).items()
        if isinstance(value, kind)
    }


def test_every_public_class_is_in_the_table():
    classes = public(type)
    assert classes.keys() == RESULTS.keys() | PARTS
    assert not RESULTS.keys() & PARTS


@pytest.mark.parametrize("name", sorted(RESULTS))
def test_a_result_does_what_its_command_does(name):
    cls = public(type)[name]
    assert {method for method in ALL if hasattr(cls, method)} == RESULTS[name]
    assert issubclass(cls, WithPage) == (PAGE in RESULTS[name])
    if name != "SweepTable":  # its picture takes columns
        assert issubclass(cls, WithPicture) == (PICTURE in RESULTS[name])


def test_results_of_functions_are_results():
    """What a public function returns is a number, an array, a linkage, or in the table."""
    plain = set("None bool bytes complex dict float int list str tuple".split())
    plain |= {"Array", "CounterweightPart", "Figure", "Linkage", "MassProperties"}
    for name, function in public(FunctionType).items():
        words = set(re.findall(r"[A-Za-z]+", str(function.__annotations__["return"])))
        assert words <= plain | RESULTS.keys() | PARTS, name


def test_one_word_stands_for_one_thing():
    wrong = [
        f"{name}({taken}): say {word}"
        for name, function in public(FunctionType).items()
        for taken in inspect.signature(function).parameters
        for word, others in SYNONYMS.items()
        if taken in others
    ]
    assert not wrong


def test_functions_of_a_linkage_take_a_path_or_a_name():
    """The first argument; a space where it has requirements of its own is one."""
    wrong = []
    for name, function in public(FunctionType).items():
        first = next(iter(inspect.signature(function).parameters.values()), None)
        if first is None or first.name not in ("linkage", "space", "model"):
            continue
        if "LinkageLike" not in str(first.annotation):
            wrong.append(name)
    # Requirements make their space; `load` is what reads paths and names.
    assert set(wrong) <= {"least_violation", "load"}


@pytest.mark.parametrize("name", ["counterweights", "design", "pareto", "partial", "verify"])
def test_jobs_take_the_same_words(name):
    """Balance and motion; the speed of a crank where loads along motions count."""
    taken = inspect.signature(getattr(balance, name)).parameters
    assert {"motion", "balance"} <= taken.keys()
    if name != "design":
        assert {"motions", "speed", "crank"} <= taken.keys()


def test_a_space_is_for_the_balance_that_is_asked():
    """Of a linkage it is made; another one is refused, and so is a motion beside it."""
    space = balance.design_space("four_bar_kite", balance="force")
    for job in (balance.design, lambda *a, **k: balance.partial(*a, ["crank"], 0.1, **k)):
        with pytest.raises(UsageError, match="is for force balance: leave out balance"):
            job(space, balance="dynamic")
        with pytest.raises(UsageError, match="has its motion"):
            job(space, motion="free")
    assert balance.design("four_bar_kite", balance="force").space.balance == "force"
    with pytest.raises(UsageError, match="either a speed or motions"):
        turn = balance.motion.rest_to_rest("four_bar_kite", [[0.0], [0.1]])
        balance.partial("four_bar_kite", ["crank"], 0.1, speed=1.0, motions=turn)
    with pytest.raises(UsageError, match="crank u1 has no speed"):
        balance.partial("four_bar_kite", ["crank"], 0.1, crank="u1")


@pytest.mark.slow
def test_the_speed_of_a_crank_is_its_turn():
    """The loads of the same motion, whether it is a word or a trajectory."""
    model, links = "four_bar_general", ["crank", "rocker"]
    turn = balance.motion.one_turn(model, "120rpm")
    pairs = [
        balance.partial(model, links, 0.5, balance="force", **motion)
        for motion in ({"speed": "120rpm"}, {"motions": turn})
    ]
    assert pairs[0].given == pairs[1].given
    assert pairs[0].shaking.objective == pytest.approx(pairs[1].shaking.objective, rel=1e-9)
    slow, fast = (
        balance.pareto(model, links, 2, 0.5, speed=speed).designs[0].given.force
        for speed in (1.0, 2.0)
    )
    assert fast == pytest.approx(4.0 * slow, rel=1e-9)
    weights = balance.counterweights(model, links, balance="force", speed="120rpm")
    assert weights.along.before.crank.rpm == pytest.approx(120.0)


@pytest.mark.slow
def test_a_comparison_is_that_of_the_command(tmp_path):
    """The data, the sentence and the page of ``--against``; twice the masses shake twice."""
    model = balance.load("four_bar_general")
    masses = [body.inertia for body in model.bodies]
    double = balance.verify(model, [2.0 * z for z in masses], speed="60rpm", crank="u1")
    pair = balance.motion.verify_against(double, "four_bar_general")
    assert pair.after.force == pytest.approx(2.0 * pair.before.force, rel=1e-9)
    page = without_breaks(pair.to_html())
    assert "100 % more" in pair.sentence and pair.sentence in page
    assert pair.plot(tmp_path / "pair.svg").startswith(b"<?xml")
    options = {"seed": 3, "trajectories": 2, "balance": "force"}
    same = balance.motion.verify_against(model, model.source, **options)
    words = ["four_bar_general", "--against", "four_bar_general", "--balance", "force"]
    code, out, _ = asked(["verify", *words, "--seed", "3", "--trajectories", "2", "--json"])
    assert code == 1 and json.loads(out) == json.loads(json.dumps(same.to_dict()))
    assert balance.motion.verify_against(double, pair.before).before is pair.before
    with pytest.raises(UsageError, match="leave out the options"):
        balance.motion.verify_against(double, model, speed=1.0)


@pytest.mark.slow
def test_files_of_fronts_and_mechanisms_are_those_of_their_best(tmp_path):
    front = balance.pareto("four_bar_general", ["crank"], 2, 0.3, speed=2.0)
    path = tmp_path / "best.urdf"
    assert front.to_urdf(path) == front.designs[-1].to_urdf() == path.read_bytes()
    modes = balance.flexible.supported_modes(
        balance.flexible.Beam(1.0, 10.0, 1.0), [balance.flexible.Clamp(0.0)]
    )
    for result in (modes, balance.flexible.support_points(3)):
        assert result.plot(tmp_path / "picture.png").startswith(b"\x89PNG")
        assert result.to_dict()["schema"] == "balance.flex/1"
