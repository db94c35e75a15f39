"""Commands on every linkage of the gallery and on files that were read wrong once."""

from __future__ import annotations

import shlex
from pathlib import Path

import kinematics
from tests.fuzz.sweep_words import STUDY
from tests.support.meeting_linkages import FLAT

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
FOLDERS = ("near_special", "digits", "dialects")
# Linkages of which each command takes seconds: of these, only the cheap ones run.
LARGE = (
    "delta",
    "stewart_6ups",
    "three_rsr",
    "three_rsr_rational",
    "four_bar_chain",
    "scissor_three_stage",
    "four_rrr_parallel",
    "eight_bar",
    "rusr",
    "three_four_bars_platform",
)
CHEAP = (
    "report {model}",
    "report {model} --balance force",
    "verify {model} --trajectories 1",
    "design {model}",
)
EVERY = (
    *CHEAP,
    "report {model} --explain --decoupled --pure-inertia",
    "verify {model} --trajectories 1 --balance force",
    "design {model} --balance force --minimise mass",
    "counterweights {model} --balance force --links {links}",
    "remedies {model} --only own_masses",
    "motion {model} --to {inputs}",
    "paths {model} --length 0.2",
)
# A least mass of this linkage leaves the centres of mass free to 1e-5, so that the last digit
# that is printed depends on rounding.
UNDETERMINED = {"design sarrus --balance force --minimise mass"}
# Commands that take no linkage, or options of their own.
OTHER = tuple(
    """
report three_rsr --motion u2=u3
report four_bar_kite --exact
report four_rrr --inputs a1,b1,c1 --balance force --motion c1=-a1-b1
verify four_rrr_prototype --motion b1=-2*a1 --motion c1=a1 --trajectories 1
verify four_bar_kite_balanced --speed 300rpm
verify four_bar_kite --trajectories 1 --against four_bar_kite_balanced
verify four_bar_kite_balanced --trajectories 1 --tolerance mass=2%,com=0.1mm
verify slider_pantograph --base free --base-mass 10 --base-inertia 1 --duration 0.1
report fuga_i --max-order 0
design fuga_i --max-order 0 --keep left_lower --keep right_lower
design four_bar_kite --minimise mass --bounds coupler=0.1:1
reduce four_bar_general --balance force --links crank,rocker --budget 1.5
reduce four_bar_general --balance force --links crank,rocker --pareto 3 --points
remedies four_bar_general --only own_masses,duplicates
remedies zero_reaction_arm --only slider_path
flex modes
flex modes --count 4 --beam length:1,EI:1,rhoA:1 --pin 0
flex modes --count 3 --beam length:1,EI:1,rhoA:1 --clamp 0 --tip 0.5,0.01
flex supports 3
flex supports 4
flex similar --arm length:0.1,EI:0.0045,rhoA:0.024,tip:0.01 --scale 0.5
flex simulate four_bar_general --flex coupler=EI:5,rhoA:1 --duration 0.01 --samples 3
motion five_bar --tool left_upper --along x,rz --to left_upper.x=0.01,left_upper.rz=0.02
motion near_special/rrr_platform_p120.urdf --tool plat --along ry,y --to plat.ry=-0.05
design near_special/de_fb_304.urdf --balance force --keep L1 --bounds L3=0.1:2 --bounds L4=0:1
report parallelogram.urdf
report kite.urdf
report kite.urdf --mode 2
verify kite.urdf --mode 2 --trajectories 1
report digits/two_yokes_1mm_irrational_relation.urdf --motion e1=e2
sweep run study.toml --out sweep.db --workers 1
sweep show sweep.db --count 5
discover run --topology slider-crank --starts 10 --out slider.db --workers 0
discover show slider.db --members 5 --tried 1
discover walk --topology slider-crank --start 2
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40" --moving 0.2,-0.1 --ratio -0.5
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40" --moving 0.4,0.4 --nonlinear
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40; -0.1,0.5,-70" --kind four-bar
springs four_bar_general --between base,crank --between base,rocker --gravity 0,-9.81,0
springs five_bar --between base,left_lower --gravity 0,-9.81,0
models
""".strip().splitlines()
)

# Some of all these, for each kind of answer that needs no kernels of sweeps.
SAMPLE = (
    "report four_bar_kite --balance force",
    "flex modes",
    "motion five_bar --to u1=0.05,u2=0.05",
)


def model_commands(model: str) -> list[str]:
    """Commands on a linkage of the gallery."""
    linkage = kinematics.load(model, bodies="all")
    links = ",".join(body.name for body in linkage.bodies[:2])
    inputs = ",".join(f"{name}=0.05" for name in linkage.inputs)
    templates = CHEAP if model in LARGE else EVERY
    return [text.format(model=model, links=links, inputs=inputs) for text in templates]


def file_commands() -> list[str]:
    """A report on every file."""
    files = [path for name in FOLDERS for path in sorted((DATA / name).glob("*.urdf"))]
    return [f"report {path.relative_to(DATA).as_posix()}" for path in files]


def all_commands() -> list[str]:
    """All of them, as in a shell and without the name of the program."""
    models = [
        command
        for model in sorted(kinematics.gallery())
        for command in model_commands(model)
        if command not in UNDETERMINED
    ]
    return models + file_commands() + list(OTHER)


def words_of(command: str) -> list[str]:
    """The words of a command, with the place of files that it names."""
    words = shlex.split(command)
    return [str(DATA / word) if word.startswith(FOLDERS) else word for word in words]


def prepare_folder(folder: Path) -> None:
    """Write the files that commands read from the folder in which they run."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    for name in ("parallelogram", "kite"):
        FLAT[name].write(folder, name)
