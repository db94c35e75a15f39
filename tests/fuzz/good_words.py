"""Good words for every option of every command, and what commands need beside them."""

from __future__ import annotations

from collections.abc import Collection

# Lengths and masses of a pantograph.
MASSES = {
    "l2": 0.1,
    "l3": 0.1,
    "m1": 1,
    "m2": 1,
    "m3": 1,
    "m4": 1,
    "m5": 0.1,
    "m6": 0.5,
    "s3": 0.05,
    "s4": 0,
    "inertia_1": 0.1,
    "inertia_2": 0.1,
}
ARM = "length:0.1,EI:0.0045,rhoA:0.024,tip:0.01"
ARMS = (
    ARM,
    f"{ARM},radius:0.01,inertia:1e-6,hub:0.01",
    ARM.replace("0.01", "-1"),
    "length:0.1,EI:0.01,rhoA:0",
    "length:0,EI:1,rhoA:1",
    "tip:1",
    "",
)
BLOCK = "pitch:0.1,mass:0.02,length:0.12,breadth:0.02"
# A base that floats, for a short time.
BASE = ("--base", "free", "--base-mass", "3", "--base-inertia", "1", "--duration", "0.05")
# Points and links of a four-bar.
SKETCH = ("A=0,0; B=0,250mm; C=0.2,0.4; D=0.6,0", "crank=A,B; coupler=B,C; rocker=C,D")
# Words for a sketch, good and bad.
SKETCH_WORDS = {
    "new --points": (SKETCH[0], "A=0,0; B=A+1@B", "A=1,0;A=2,0", "A=0,0; B=A:1,A:2", "A=nan,0"),
    "new --links": (SKETCH[1], "a=A,B", "a=A", "base=A,D; a=A,B; a=C,D", "base=A", "a=A,Z"),
    "--sliders": ("block=C@0", "block=C@D", "block=C", "crank=C@0", "block=Z@1", "block=C@99"),
    "new --inputs": ("A", "A,B", "D", "x"),
    "--section": ("30mmx10mm", "d20mm", "crank=1x1", "0x1", "d", "x=d1", "1,1"),
    "new --density": ("steel", "crank=2700", "wood", "-1", "7.85g/cm3,1"),
    "--mass": ("crank=0.5", "rocker=200g", "1", "x=1", "crank=-1", "crank=1,crank=2"),
}
# Commands that take no model.
WITHOUT_MODEL = (
    "new",
    "models",
    "synthesize",
    "flex modes",
    "flex supports",
    "flex similar",
    "sweep show",
    "sweep export",
    "discover run",
    "discover show",
    "discover export",
    "discover walk",
)
# What commands below ``flex`` and ``sweep`` need beside an option, unless that is it.
# A short motion is quicker than random ones.
NEEDED: dict[str, tuple[tuple[str, ...], ...]] = {
    "counterweights": (("--links", "{link}"),),
    "reduce": (("--links", "{link}"), ("--budget", "0.1"), ("--csv", "{table}")),
    "new": (("{folder}/new.urdf",), ("--points", SKETCH[0]), ("--links", SKETCH[1])),
    "flex supports": (("3",),),
    "flex similar": (("--arm", ARM), ("--scale", "0.5")),
    "flex simulate": (
        ("--flex", "{link}=EI:5,rhoA:1"),
        ("--duration", "0.02"),
        ("--samples", "3"),
        ("--elements", "3"),
        ("--modes", "1"),
    ),
    "sweep run": (
        ("--vary", "{link}.length=0.9:1.1:2"),
        ("--workers", "1"),
        ("--out", "{folder}/a.db"),
    ),
    "sweep show": (("{results}",),),
    "sweep export": (("{results}",), ("--out", "{folder}/a.csv")),
    "discover run": (
        ("--topology", "slider-crank"),
        ("--starts", "3"),
        ("--workers", "0"),
        ("--out", "{folder}/a.db"),
    ),
    "discover show": (("{search}",), ("--members", "5"), ("--tried", "1")),
    "discover export": (("{search}",), ("--family", "1"), ("--out", "{folder}/a.urdf")),
    "discover walk": (("--topology", "slider-crank"), ("--start", "2")),
    "quiet": (("--to", "{first}=0.05"),),
    "identify": (("--motion", "{table}"), ("--wrench", "{loads}")),
    "springs": (("--between", "{tool}@0,0,0 {link}@0.1,0.2,0"), ("--gravity", "0.6,-1.3,0.4")),
}


def needed(verb: str, given: Collection[str]) -> list[str]:
    """What a command needs beside the options that are given."""
    without = {*given, *["--scale"] * ("--against" in given)}
    without |= {"--csv"} if "--motion" in given or "--require" in given else set()
    without |= {"--topology"} if "--model" in given else set()
    without |= {"--to"} if {"--path", "--tool-to"} & set(given) else set()
    without |= {"--motion", "--wrench"} if "--plan" in given else set()
    return [word for words in NEEDED.get(verb, ()) if words[0] not in without for word in words]


# What every synthesis needs.
POSITIONS = ("--positions", "0.3,0.1,11; 0.1,0.4,-40")
# What a function needs.
GEARED = ("--kind", "geared-four-bar")
# What every plan of a motion needs.
PLAN = ("--plan", "--tries", "2")
BEAM = "length:1,EI:1,rhoA:1"
# Words that the five-bar linkage with masses takes, and what else its option needs.
GOOD: dict[str, list[str]] = {
    "--loops": ["{loops}"], "--bodies": ["all"], "--massless": ["{link}"],
    "--inputs": ["{inputs}"], "--motion": ["{first}=0"], "--balance": ["force"],
    "--at": ["{first}=0.05"],
    "--mode": ["1"], "--ground": ["base"],
    "--max-order": ["1"], "--html": ["{folder}/page.html"], "--certainty": ["verified"],
    "--require": ["force"], "--gravity": ["0,-9.81,0", "--require", "gravity"],
    "--trajectories": ["1"], "--seed": ["3"], "--csv": ["{table}"], "--path": ["{poses}"],
    "--tool-path": ["{tool}={path}"],
    "--speed": ["{first}=300rpm"], "--table": ["{folder}/table.csv"],
    "--tolerance": ["1e-6"], "--against": ["five_bar"], "--plot": ["{folder}/plot.svg"],
    "--minimise": ["mass"], "--keep": ["{link}"], "--bounds": ["{link}=0.1:2"],
    "--density": ["7850", "--thickness", "0.01"], "--thickness": ["0.01", "--density", "7850"],
    "reduce --minimise": ["peak"], "remedies --density": ["7850"],
    "--price-of-mass": ["0.02", "--minimise", "rotor"],
    "counterweights --massless": ["{tool}"], "reduce --massless": ["{tool}"],
    "--links": ["{link}"], "--region": ["{link}=ball(0,0,0,0.1)"],
    "--merge": ["--out", "{folder}/out.urdf"], "--budget": ["0.1"], "--move": ["{link}=30%"],
    "--shape": ["disc=0.02", "--density", "7850", "--balance", "force"],
    "--parts": ["{folder}/parts", "--density", "7850"],
    "--solids": ["--parts", "{folder}/parts"],
    "--weight-moment": ["0.2"], "--pareto": ["2"], "--max-bearing": ["{first}=1e9"],
    "--max-torque": ["{first}=1e9"], "--frame": ["9,1,1e4,10"],
    "--tip": ["0.5,1e-4", "--beam", BEAM, "--clamp", "0"],
    "--about": ["0.1,0.2,0"],
    "--flex": ["{link}=EI:5,rhoA:1"], "--drive": ["{first}=spin:1,0.1"], "--elements": ["4"],
    "--modes": ["2"], "--samples": ["5"], "--damping": ["1e-4"], "--count": ["3"],
    "flex simulate --duration": ["0.01"], "flex simulate --massless": ["{tool}"],
    "--beam": [BEAM], "--pin": ["0", "--beam", BEAM, "--pin", "1"],
    "--clamp": ["0", "--beam", BEAM], "--arm": [ARM], "--scale": ["0.5"],
    "flex similar --against": [ARM], "--spin": ["1,0.01,0.02"],
    "flex similar --plot": ["{folder}/plot.svg", "--spin", "1,0.01,0.02"],
    "--translator": [BLOCK, "--moment", "1e-3,0.001,0.002"],
    "--moment": ["1e-3,0.001,0.002", "--translator", BLOCK],
    "--both-hubs": ["--moment", "1e-3,0.001,0.002", "--translator", BLOCK],
    "new --points": [SKETCH[0]], "new --links": [SKETCH[1]], "new --inputs": ["A"],
    "new --sliders": ["block=C@0deg", "--links", "crank=A,B; coupler=B,C"],
    "--section": ["30mmx10mm"], "new --density": ["brass"], "--mass": ["crank=0.2"],
    "discover run --model": ["slider_crank"],
    "discover run --topology": ["four-bar"], "discover run --starts": ["4"],
    "discover run --seed": ["2"], "discover run --seconds": ["60"],
    "discover run --out": ["{folder}/b.db"], "discover run --workers": ["0"],
    "discover show --members": ["3"], "discover show --tried": ["2"],
    "discover walk --topology": ["four-bar"], "discover walk --start": ["1"],
    "discover walk --seed": ["2"],
    "discover export --family": ["1"], "discover export --out": ["{folder}/b.urdf"],
    "sweep run --out": ["{folder}/a.db"], "sweep run --workers": ["2"],
    "sweep run --dask": ["local"], "sweep show --sort": ["rank"],
    "sweep run --vary": ["{link}.length=0.9,1.1"], "sweep run --counterweights": ["{link}"],
    "sweep run --reduce": ["{link}", "--budget", "0.1"],
    "sweep run --budget": ["0.1", "--reduce", "{link}"], "sweep run --compute": ["distance"],
    "sweep run --set": ["run.chunk_rows=1"], "sweep run --best": ["max:rank={folder}/b.urdf"],
    "sweep run --write-study": ["{folder}/a.toml"],
    "sweep run --region": ["{link}=ball(0,0,0,0.1)", "--counterweights", "{link}"],
    "sweep export --added": ["none", "--row", "0", "--out", "{folder}/row.urdf"],
    "sweep show --descending": ["--sort", "rank"],
    "sweep show --plot": ["rank,closed", "--out", "{folder}/plot.svg"],
    "sweep show --out": ["{folder}/plot.svg", "--plot", "rank,closed"],
    "sweep show --count": ["3"], "sweep export --out": ["{folder}/b.parquet"],
    "sweep export --row": ["0", "--out", "{folder}/row.urdf"],
    "--out": ["{folder}/out.urdf"], "remedies --out": ["{folder}/remedies"],
    "--only": ["own_masses"], "--gear": ["2"], "--rotor-radius": ["0.1"], "--trade-off": ["2"],
    "remedies --workers": ["2"],
    "--write-closed": ["{folder}/closed.urdf"],
    "--tool": ["{tool}", "--along", "x"],
    "--along": ["x", "--tool", "{tool}"],
    "--point": ["0.1,0,-0.05", "--tool", "{tool}", "--along", "x"],
    "--order": ["2"], "--to": ["{first}=0.05"],
    "--from": ["{first}=0.05"], "--line": ["1", "--from", "{first}=0", "--from",
    "{first}=0.05"], "--length": ["0.2"], "--step": ["0.05"], "--base": ["free"],
    "--base-mass": ["2", "--base", "free"], "--which": ["1"],
    "--base-com": ["0.1,0,0", "--base", "free", "--base-mass", "2"],
    "--where": ["AB=BA"], "--solve": ["sx_{link}"], "formulas --seconds": ["60"],
    "--notation": ["latex"],
    "--attitude": ["--base", "free", "--base-mass", "2"],
    "paths --tolerance": ["0.9"], "--fan": ["3"],
    "--factors": ["{link}=0.5", "--moment-only"],
    "--through": ["{first}=0.05", "--change", "{link}", "--moment-only"],
    "--change": ["{link}", "--through", "{first}=0.05", "--moment-only"],
    "paths --tool": ["{tool}"], "paths --point": ["0.1,0,0", "--tool", "{tool}"],
    "--turn": ["0.05", "--base", "free", "--base-mass", "2", "--base-inertia", "1"],
    "paths --base-inertia": ["1", "--base", "free", "--base-mass", "2", "--turn", "0.05"],
    "paths --table": ["{folder}/path.csv"], "paths --about": ["0.1,0.2,0", "--moment-only"],
    "verify --base": ["free", *BASE[2:]], "verify --base-mass": ["2", *BASE],
    "--base-inertia": ["1,1,1", *BASE], "verify --base-com": ["0.1,0,0", *BASE],
    "--stiffness": ["1e3", "--base", "spring", *BASE[2:]], "--duration": ["0.1", *BASE[:6]],
    "--initial": ["vx=0.1", *BASE], "--torque": ["{first}=0.01", *BASE],
    "--payload": ["{link}@0.1,0,0=0.5"], "reduce --weights": ["2", "--require", "force"],
    "reduce --require": ["force"], "reduce --gravity": ["0,-9.81,0", "--require", "gravity"],
    "verify --gravity": ["0.1,-9.81,0"],
    "--between": ["{tool},{link}"], "--catalogue": ["10,0.1N/mm"],
    "--range": ["{first}=-0.1:0.1"], "springs --gravity": ["0.1,-9.81,0"],
    "quiet --from": ["{first}=0.02"], "quiet --duration": ["0.5"], "quiet --table": [
        "{folder}/quiet.csv"], "--shaking": ["both"], "--measure": ["peak"],
    "--natural-frequency": ["9"], "--max-velocity": ["20"],
    "--max-acceleration": ["{first}=90"], "--max-jerk": ["1e4"],
    "quiet --max-torque": ["1e3"], "quiet --gravity": ["0,-9.81,0"],
    "--front": ["2", "--straight"],
    "quiet --tool": ["{tool}"], "quiet --point": ["0.1,0,0", "--tool", "{tool}"],
    "--tool-from": ["x=0.005", "--tool", "{tool}"],
    "--tool-to": ["x=0.005", "--tool", "{tool}"],
    "--via": ["{first}=0.1"], "quiet --harmonics": ["3", "--cycle"],
    "identify --motion": ["{table}"], "--wrench": ["{loads}"], "--prior": ["0.1"],
    "identify --gravity": ["0,-9.81,0"], "identify --friction": ["--wrench", "{torques}"],
    "identify --rotors": ["--wrench", "{torques}"], "--cutoff": [
        "90", "--motion", "{dense}", "--wrench", "{many}"],
    "--plan": ["--tries", "3"], "--harmonics": ["3", *PLAN], "--tries": ["2", "--plan"],
    "identify --duration": ["2", *PLAN], "identify --seed": ["3", *PLAN],
    "identify --max-velocity": ["2", *PLAN],
    "identify --max-acceleration": ["{first}=20", *PLAN],
    "quiet --weight-moment": ["0.2", "--shaking", "both"],
    "--positions": ["0.3,0.1,11; 0.1,0.4,-40", "--moving", "0.2,-0.1"],
    "--kind": ["four-bar", *POSITIONS, "--fixed", "0.2,-0.1"],
    "--ratio": ["-0.5", *POSITIONS, "--moving", "0.2,-0.1"],
    "--nonlinear": [*POSITIONS, "--fixed", "0.2,-0.1"],
    "--timed": ["--positions", "0.3,0.1,10; 0.2,0.3,40; 0,0.4,75", "--kind", "geared-four-bar"],
    "--function": ["{function}", *GEARED],
    "synthesize --start": ["30,60", "--function", "{function}", *GEARED],
    "--base-length": ["400mm", "--function", "{function}", *GEARED],
    "--fixed": ["0.2,-0.1", *POSITIONS], "--moving": ["0.2,-0.1", *POSITIONS],
    "--masses": ["{masses}", *POSITIONS, "--moving", "0.2,-0.1"],
    "--window": ["0.1,2", *POSITIONS, "--nonlinear", "--fixed", "0.2,-0.1"],
    "synthesize --slot": ["{folder}/slot.csv", *POSITIONS, "--nonlinear", "--fixed",
                          "0.2,-0.1"],
    "synthesize --within": ["1", "--positions", "0,0,0; 0.1,0,10; 0.2,0.1,20; 0.3,0,40",
                            "--kind", "four-bar"],
    "synthesize --density": ["none", *POSITIONS, "--kind", "four-bar", "--moving", "0.2,-0.1"],
    "synthesize --thickness": ["8mm", *POSITIONS, "--kind", "four-bar", "--moving", "0.2,-0.1"],
    "synthesize --table": ["{folder}/table.csv", *POSITIONS, "--nonlinear", "--fixed",
                           "0.2,-0.1"],
    **{f"synthesize {name}": [*word, *POSITIONS, "--moving", "0.2,-0.1"] for name, word in {
        "--out": ["{folder}/out.urdf"], "--plot": ["{folder}/plot.svg"],
        "--html": ["{folder}/page.html"], "--json": [], "--overwrite": [],
    }.items()},
}  # fmt: skip
