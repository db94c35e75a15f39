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
# Commands that print figures of an optimum, many of them flat.
OPTIMA = tuple(
    """
design four_bar_antiparallelogram --minimise mass --bounds coupler=0.5:5 --density steel
design four_bar_kite --minimise change --thickness 0.02
design six_bar_watt --balance force --minimise change
design fuga_i --require "force; dynamic at u1=0" --minimise change
design four_bar_general --balance force --minimise inertia
design four_bar_parallelogram --balance force --minimise inertia
design six_bar_stephenson --balance force --minimise inertia
design four_bar_antiparallelogram --minimise inertia
design four_bar_antiparallelogram --minimise rotor
design bennett --balance force --minimise rotor
design bennett_rational --balance force --minimise inertia
design rusr --balance force --minimise inertia
design two_rrr --balance force --minimise inertia
design fuga_i --balance force --minimise inertia
counterweights scissor_three_stage --balance force --links all
counterweights scissor_three_stage --balance force --links all --minimise rotor
counterweights scissor_three_stage --balance force --links all --points
counterweights four_bar_antiparallelogram --balance force --links all --points
counterweights six_bar_stephenson --balance force --links all --points
counterweights five_bar --balance force --links left_lower,right_lower
counterweights five_bar --balance force --links all --shape disc=30mm
counterweights four_bar_general --balance force --links crank,rocker --speed 300rpm
counterweights four_bar_general --balance force --links crank,rocker --minimise inertia
counterweights four_bar_general --balance force --links crank,rocker --minimise rotor
counterweights four_bar_general --balance force --links crank,rocker --move crank=30%
counterweights four_bar_general --balance force --links crank,rocker --thickness 10mm
counterweights four_bar_general --balance force --links crank,rocker --shape sector=15mm/20mm
counterweights four_bar_general --require gravity --gravity 0,-9.81,0 --links crank,rocker
reduce four_bar_general --balance force --links crank,rocker --budget 5
reduce four_bar_general --balance force --links crank,rocker --budget 0.5 --minimise peak
reduce four_bar_general --balance force --links crank,rocker --budget 0.6 --shape disc=20mm
reduce four_bar_general --balance force --links crank,rocker --pareto 3 --speed 300rpm
reduce four_bar_general --links crank,rocker --budget 1 --speed 300rpm --minimise torque
reduce four_bar_general --links crank,rocker --budget 1 --speed 300rpm --minimise bearing
reduce four_bar_general --links crank,rocker --budget 1 --speed 300rpm --minimise 1,2
reduce four_bar_general --links crank,rocker --budget 1 --speed 300rpm --frame 50,5,1e5,100
reduce four_bar_general --links crank,rocker --budget 1 --speed 300rpm --max-torque u1=100
reduce four_bar_general --links crank,rocker --budget 3 --require "force; dynamic" --weights 2,1
reduce delta --balance force --links arm1,arm2,arm3 --budget 4kg
reduce five_bar --links all --budget 2 --points
reduce five_bar --balance force --links all --budget 9
reduce slider_crank --balance force --links crank --budget 1 --speed 300rpm --density lead
reduce zero_reaction_arm --links link1,link2 --budget 1 --points
remedies four_bar_general --only separate_rotors,counter_rotary_masses
remedies four_bar_general --only passive_wheel,moving_mass,free_joint,partial --density steel
remedies slider_crank --only balance_shafts,force_masses,pantograph,harmonic_springs
remedies double_pendulum_duplicates --only own_masses,force_masses
quiet five_bar --to u1=0.5,u2=-0.3 --duration 0.5 --measure peak
quiet five_bar --to u1=0.5,u2=-0.3 --duration 0.5 --straight --max-velocity 2 --front 3
quiet five_bar --to u1=0.5,u2=-0.3 --via u1=0.3 --duration 1
quiet five_bar --to u1=0.5,u2=-0.3 --cycle --harmonics 5 --natural-frequency 2.5
quiet four_bar_general --to u1=0.5 --straight --max-torque 20
quiet two_rrr --to a1=0.2,b1=0.1 --duration 1
paths five_bar --moment-only --factors left_lower=0.5,2 --length 0.2
paths three_rrr --moment-only --length 0.2 --fan 3
springs five_bar --between base,left_lower --between base,right_lower --gravity 0,-9.81,0
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40; -0.1,0.5,-70" --kind slider-crank
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40; -0.1,0.5,10" --kind stack
synthesize --positions "0.3,0.1,11; 0.1,0.4,-40" --fixed 0,0
identify four_bar_general --plan --duration 2 --tries 10
verify four_bar_general --speed 300rpm
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
        command for model in sorted(kinematics.gallery()) for command in model_commands(model)
    ]
    return models + file_commands() + list(OTHER) + list(OPTIMA)


def words_of(command: str) -> list[str]:
    """The words of a command, with the place of files that it names."""
    words = shlex.split(command)
    return [str(DATA / word) if word.startswith(FOLDERS) else word for word in words]


def prepare_folder(folder: Path) -> None:
    """Write the files that commands read from the folder in which they run."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    for name in ("parallelogram", "kite"):
        FLAT[name].write(folder, name)
