"""Words for every option of every command: good ones, bad ones, and ones that nobody expects.

The options come from the parsers themselves, so that a new one without words is noticed.
"""

from __future__ import annotations

import argparse
import json
import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import kinematics
from balance.app.cli.main import COMMANDS, command_parser
from kinematics.errors import LinkageError
from tests.fuzz.good_words import ARMS, BLOCK, MASSES, SKETCH_WORDS

NUMBERS = (
    "0 1 -1 2 3 0.5 1e-3 -0.0 1e308 1e-308 1e400 -1e300 1e-13 nan inf -inf 0x10 1_0 ٣ ½ 7e7 "
    "12345"
).split()
ODD = (
    "",
    " ",
    "=",
    ",",
    "a=b=c",
    "ключ",
    "ghost",
    "l\u0000x",
    "\udcff",
    "x\ny",
    "🙂",
    "--",
    "*",
)
FILES = ("page", "out", "page.html", "a b.urdf", "ä.svg", "p.PNG", "no/such/folder/x.svg")


class Names(NamedTuple):
    """What a model has that options may name."""

    links: tuple[str, ...]
    joints: tuple[str, ...]
    inputs: tuple[str, ...]


class Place(NamedTuple):
    """Where words are made for: the names of a model, and a folder to write to."""

    names: Names
    folder: Path
    model: str


Maker = Callable[[random.Random, Place], list[str]]


@cache
def parsers() -> dict[str, argparse.ArgumentParser]:
    """The parser of every command; one below another goes by both words."""
    (verbs,) = command_parser(COMMANDS)._subparsers._group_actions
    found = {}
    for verb, parser in verbs.choices.items():
        kinds = parser._subparsers and parser._subparsers._group_actions[0].choices
        found |= {f"{verb} {k}": own for k, own in kinds.items()} if kinds else {verb: parser}
    return found


def options(parser: argparse.ArgumentParser) -> dict[str, argparse.Action]:
    """Every option of a command but ``--help``, by its longest name."""
    actions = (action for action in parser._actions if action.option_strings)
    named = {max(action.option_strings, key=len): action for action in actions}
    return {name: action for name, action in named.items() if name != "--help"}


@cache
def names_of(model: str) -> Names:
    """The names in a model; none if it cannot be read."""
    try:
        linkage = kinematics.load(model, bodies="all")
    except LinkageError:
        return Names((), (), ())
    links = tuple(body.name for body in linkage.bodies)
    return Names(links, tuple(joint.name for joint in linkage.joints), linkage.inputs)


def _one(rng: random.Random, known: tuple[str, ...], odd: float = 0.12) -> str:
    """A known name, or now and then a strange one."""
    return rng.choice(ODD) if rng.random() < odd or not known else rng.choice(known)


def _number(rng: random.Random, odd: float = 0.15) -> str:
    return rng.choice(NUMBERS) if rng.random() < odd else f"{rng.uniform(-0.4, 1.2):.4g}"


def _list(rng: random.Random, known: tuple[str, ...]) -> str:
    some = rng.sample(known, min(len(known), rng.choice((1, 1, 2, 3))))
    return ",".join(some) if some and rng.random() < 0.85 else _one(rng, known) + ","


def _relation(rng: random.Random, place: Place) -> str:
    a, b = _one(rng, place.names.inputs, 0.05), _one(rng, place.names.inputs, 0.05)
    kinds = "{a}={b} {a}=-{b} {a}=0 {a}={n}*{b} {a}={b}+{b} {a} {n}".split()
    return rng.choice(kinds).format(a=a, b=b, n=_number(rng))


def _requirement(rng: random.Random, place: Place) -> str:
    name = _one(rng, place.names.inputs, 0.05)
    kinds = (
        "force",
        "gravity",
        "force x,y",
        "moment about 0,0,{n}",
        "moment about com",
        "dynamic at {a}={n}",
        "dynamic along {b}",
        "dynamic along {a}={a}**2",
        "force;gravity",
        "dynamic up to order 1 about {a}={n}",
        "dynamic {n}",
        "moment along {a}",
        ";",
        "decoupled",
    )
    return rng.choice(kinds).format(a=name, b=_relation(rng, place), n=_number(rng))


def _bounds(rng: random.Random, place: Place) -> str:
    low, high = (rng.choice(("", _number(rng))) for _ in range(2))
    sign = ":" if rng.random() < 0.95 else "-"
    return f"{_one(rng, place.names.links, 0.05)}={low}{sign}{high}"


def _density(rng: random.Random, place: Place) -> str:
    name = f"{_one(rng, place.names.links, 0.05)}=" if rng.random() < 0.5 else ""
    return f"{name}{_number(rng)}"


def _region(rng: random.Random, place: Place) -> str:
    """A region of a link, good or bad."""
    kinds = (
        "ball({0},{1},{2},{3})",
        "box({0}:{1},{2}:{3},{4}:{5})",
        "ellipsoid({0},{1},0,{3},1,1)",
        "cylinder(0,0,0,{0},{1},1,{2},{3})",
        "collision",
        "mesh(part.stl,{0})",
        "cube(1)",
        "",
    )
    numbers = [_number(rng, 0.05) for _ in range(6)]
    return f"{_one(rng, place.names.links, 0.05)}={rng.choice(kinds).format(*numbers)}"


def _spring(rng: random.Random, place: Place) -> str:
    """A spring between two links, good or bad."""
    first, second = (_one(rng, ("base", *place.names.links), 0.05) for _ in range(2))
    kinds = (
        "{a},{b}",
        "{a}@0,0,{0} {b}@{1},{2},0",
        "{a}@0:{0},0,0 {b}",
        "{a}@{0},0,0 {b}@0,{1},0 k={2}",
        "{a}@{0},0,0 {b}@0,{1},0 L0=0.05",
        "{a}@{0},0,0 {b}@0,{1},0 L0=-0.1:{2} k=10:500",
        "{a}@0,0 {b}",
        "{a} {b} k=",
        "{a}@0:1,0,0 {b}@0:1,0,0",
        "",
    )
    numbers = [_number(rng, 0.05) for _ in range(3)]
    return rng.choice(kinds).format(*numbers, a=first, b=second)


def _payload(rng: random.Random, place: Place) -> str:
    """A payload, good or bad."""
    kinds = ("{a}={0}", "{a}@{0},{1},0={2}", "{a}=0:{0}", "{a}={0}:{1}", "{a}", "{a}@1,2=3", "")
    numbers = [_number(rng, 0.05) for _ in range(3)]
    name = _one(rng, ("base", *place.names.links), 0.05)
    return rng.choice(kinds).format(*numbers, a=name)


def _target(rng: random.Random, place: Place) -> str:
    inputs = place.names.inputs
    if rng.random() < 0.5:
        return ",".join(_number(rng, 0.05) for _ in inputs or "x")
    some = rng.sample(inputs, rng.randint(1, len(inputs))) if inputs else ["u"]
    return ",".join(f"{name}={_number(rng, 0.05)}" for name in some)


def _speed(rng: random.Random, place: Place) -> str:
    unit = rng.choice(("rpm", "rpm", "rad/s", "deg/s", "hz", "Hz", "1/s", "rev/s", "", "m/s"))
    crank = f"{_one(rng, place.names.inputs, 0.05)}=" if rng.random() < 0.5 else ""
    return f"{crank}{_number(rng)}{unit}"


def _pose(rng: random.Random, place: Place) -> str:
    """Coordinates of some inputs, mostly near the pose of the file."""
    some = rng.sample(place.names.inputs, min(len(place.names.inputs), rng.choice((1, 1, 2))))
    if not some or rng.random() < 0.05:
        return _one(rng, place.names.joints)
    near = f"{rng.uniform(-0.1, 0.1):.3g}"
    return ",".join(f"{name}={rng.choice((near, _number(rng, 0.05)))}" for name in some)


def _table(rng: random.Random, place: Place) -> str:
    """The path of a table of motions, good or bad."""
    path = place.folder / rng.choice(("motion.csv", "bewegung ä.csv"))
    if rng.random() < 0.1:
        return str(place.folder / "none.csv")
    inputs, rows = list(place.names.inputs) or ["u"], []
    head = ["time", *inputs] if rng.random() < 0.7 else inputs
    step = rng.choice((0.01, 0.01, 0.1, 0.0))
    for k in range(rng.choice((0, 1, 5, 12, 12))):
        values = [f"{0.2 * (k / 12) ** 2:.6g}" for _ in inputs]
        rows.append([f"{k * step:.6g}", *values][-len(head) :])
    if rows and rng.random() < 0.2:
        rng.choice(rows)[-1] = rng.choice((*NUMBERS, *ODD[:4]))
    lines = [",".join(row) for row in (head, *rows)]
    path.write_text("\n".join(lines), encoding="utf-8", errors="replace")
    return str(path)


def _loads(rng: random.Random, place: Place) -> str:
    """The path of a table of measured loads, good or bad."""
    path = place.folder / "loads.csv"
    if rng.random() < 0.1:
        return str(place.folder / "none.csv")
    known = ("fx", "fy", "fz", "mx", "my", "mz", *place.names.inputs)
    names = ["time", *rng.sample(known, rng.randint(1, len(known)))]
    if rng.random() < 0.1:
        names[-1] = _one(rng, ("ghost", "fx [Nm]", "fx", ""))
    step = rng.choice((0.002, 0.002, 0.002, 0.0, 1.0))
    rows = [
        [f"{k * step:.6g}", *(f"{rng.gauss(0.0, 1.0):.4f}" for _ in names[1:])]
        for k in range(rng.choice((0, 5, 40, 40, 40)))
    ]
    if rows and rng.random() < 0.15:
        rng.choice(rows)[-1] = rng.choice((*NUMBERS, *ODD[:4]))
    text = "\n".join(",".join(row) for row in (names, *rows))
    path.write_text(text, encoding="utf-8", errors="replace")
    return str(path)


def _tool_path(rng: random.Random, place: Place) -> str:
    """A link, now and then with a point, and a table of its path."""
    names = place.names._replace(inputs=rng.choice((("x",), ("x", "y"), ("rz",))))
    link = f"{_one(rng, place.names.links)}{rng.choice(('', '@0,0,0', '@0', '@'))}"
    return f"{link}={_table(rng, place._replace(names=names))}"


def _out(rng: random.Random, place: Place, *more: str) -> str:
    name = rng.choice((*FILES, *more, *more, ""))
    return str(place.folder / name) if name else rng.choice(("", str(place.folder)))


def _model(rng: random.Random, place: Place) -> str:
    others = ("five_bar", "hprs", "slider_crank")
    return place.model if rng.random() < 0.5 else _one(rng, others)


def _values(rng: random.Random, names: tuple[str, ...]) -> str:
    """Values of some of these names."""
    some = rng.sample(names, min(len(names), rng.choice((1, 1, 2)))) or ["u"]
    return ",".join(f"{name}={_number(rng, 0.05)}" for name in some)


def _directions(rng: random.Random, place: Place) -> str:
    return _list(rng, ("x", "y", "z", "rx", "ry", "rz"))


def _positions(rng: random.Random, place: Place) -> str:
    """Positions of a tool, mostly two."""
    rows = [
        ",".join([_number(rng, 0.02), _number(rng, 0.02), f"{rng.uniform(-90, 90):.4g}"])
        for _ in range(rng.choice((1, 2, 2, 2, 2, 3)))
    ]
    return "; ".join(rows) if rng.random() < 0.95 else rng.choice(ODD)


def _masses(rng: random.Random, place: Place) -> str:
    """The path of a file of masses, good or bad."""
    path = place.folder / "masses.json"
    if rng.random() < 0.1:
        return str(place.folder / "none.json")
    found = dict(MASSES)
    if rng.random() < 0.3:
        found[rng.choice((*MASSES, "s1", "ghost"))] = rng.choice(
            (-1, 0, 1e300, "x", None, True)
        )
    path.write_text(json.dumps(found) if rng.random() < 0.95 else "{", encoding="utf-8")
    return str(path)


def _bends(rng: random.Random) -> str:
    """How a link bends, good or bad."""
    return rng.choice(
        (
            "EI:5,rhoA:1",
            "EI:0.1,rhoA:0.1",
            "EI:50,rhoA:1,supports:2",
            "EI:1,rhoA:1,length:3",
            "rect(0.02,0.01),aluminium",
            "EI:-1,rhoA:1",
            "EI:nan,rhoA:1",
            "EI:1",
            "rect(1)",
            "",
            "EI:1,rhoA:1,supports:3",
            "rect(0.1,0.1),wood",
            "EI:1,rhoA:0",
            "EI:9,rhoA:1,length:0.1",
        )
    )


def _drive(rng: random.Random) -> str:
    """The motion or moment of an input, good or bad."""
    return rng.choice(
        (
            "spin:1,0.1",
            "speed:1",
            "moment:0.1,0.1",
            "spin:1",
            "spin:1,0",
            "turn",
            "speed:nan",
            "moment:1,-1",
        )
    )


def _of(*known: str) -> Maker:
    return lambda rng, place: [_one(rng, known, 0.05)]


# Words after each option. A flag has none.
WORDS: dict[str, Maker] = {
    "--loops": lambda rng, place: [_table(rng, place)],
    "--bodies": _of("given", "all"),
    "--ground": lambda rng, place: [rng.choice((*place.names.links, "world", "nowhere"))],
    "--massless": lambda rng, place: [_list(rng, place.names.links)],
    "--inputs": lambda rng, place: [_list(rng, rng.choice(place.names[1:]))],
    "--at": lambda rng, place: [_pose(rng, place)],
    "--mode": _of("1", "1", "2", "0", "99", "x"),
    "--motion": lambda rng, place: [_relation(rng, place)],
    "--balance": _of("dynamic", "force", "force"),
    "--max-order": _of("0", "1", "2", "3", "5", "-1", "51", "x"),
    "--html": lambda rng, place: [_out(rng, place, "page.html")],
    "--write-closed": lambda rng, place: [_out(rng, place, "closed.urdf")],
    "--require": lambda rng, place: [_requirement(rng, place)],
    "--gravity": _of("0,0,-9.81", "0,-1,0", "1,2,3", "0,0,0", "1,2", "nan,0,0"),
    "--certainty": _of("proved", "verified"),
    "--trajectories": _of("1", "1", "1", "2", "0", "10001"),
    "--seed": _of("0", "7", "123456", "-1", "99999999999999999999"),
    "--tool-path": lambda rng, place: [_tool_path(rng, place)],
    "--csv": lambda rng, place: [_table(rng, place)],
    "--speed": lambda rng, place: [_speed(rng, place)],
    "--table": lambda rng, place: [_out(rng, place, "motion.csv")],
    "--path": lambda rng, place: [_table(rng, place)],
    "--tolerance": _of(
        "0",
        "1e-9",
        "1e-3",
        "0.999",
        "1",
        "nan",
        "-1",
        "1e-400",
        "mass=2%",
        "mass=0.01,com=1mm",
        "length=0.1mm",
        "mass=2",
        "ghost=1",
        "com=0",
    ),
    "--against": lambda rng, place: [_model(rng, place)],
    "--plot": lambda rng, place: [_out(rng, place, "a.svg", "a.png")],
    "--minimise": _of(
        "mass", "inertia", "rotor", "change", "rms", "peak", "torque", "bearing", "1,2"
    ),
    "--keep": lambda rng, place: [_one(rng, place.names.links, 0.05)],
    "--bounds": lambda rng, place: [_bounds(rng, place)],
    "--density": lambda rng, place: [_density(rng, place)],
    **dict.fromkeys(
        "--thickness --price-of-mass --budget --gear --rotor-radius --base-mass --scale "
        "--weight-moment".split(),
        lambda rng, place: [_number(rng)],
    ),
    "--links": lambda rng, place: [_list(rng, place.names.links)],
    "--region": lambda rng, place: [_region(rng, place)],
    "--move": lambda rng, place: [_one(rng, place.names.links) + rng.choice(["", "=3%", "=x"])],
    "--shape": _of("disc=5mm/8mm", "block=1cm", "sector=1cm,0.1", "cylinder=1cm", "disc=0"),
    "--parts": lambda rng, place: [_out(rng, place, "parts")],
    "--only": _of("own_masses", "partial", "own_masses,partial", "wheel"),
    "--trade-off": _of("2", "3", "1", "0", "x"),
    "--pareto": _of("2", "3", "1", "0", "x"),
    "--max-bearing": lambda rng, place: [f"{_one(rng, place.names.joints)}={_number(rng)}"],
    "--max-torque": lambda rng, place: [f"{_one(rng, place.names.inputs)}={_number(rng)}"],
    "--frame": _of("9,1,1e4,10", "1,2,3", "1,1,0,0", "2,1,1e3,0"),
    "--out": lambda rng, place: [_out(rng, place, "out.urdf")],
    "--tool": lambda rng, place: [_one(rng, place.names.links, 0.05)],
    "--along": lambda rng, place: [_directions(rng, place)],
    **dict.fromkeys(
        ("--point", "--about", "--base-com", "springs --gravity", "quiet --gravity"),
        lambda rng, place: [",".join(_number(rng, 0.05) for _ in range(3))],
    ),
    "--order": _of("1", "2", "3", "5", "0", "99"),
    **{name: _of(*words) for name, words in SKETCH_WORDS.items()},
    "--positions": lambda rng, place: [_positions(rng, place)],
    "--kind": _of("pantograph", "four-bar", "stack"),
    "--ratio": lambda rng, place: [f"-{_number(rng)}"],
    "--fixed": lambda rng, place: [f"{_number(rng)},{_number(rng)}"],
    "--moving": lambda rng, place: [f"{_number(rng)},{_number(rng)}"],
    "--masses": lambda rng, place: [_masses(rng, place)],
    "--within": _of("1", "1mm", "1deg", "-1", "x"),
    **dict.fromkeys(("--function", "--base-length", "synthesize --start"), _of("1", "3,6")),
    "--slot": _of("slot.csv", "slot.dxf", "slot.txt", "slot.svg"),
    "--window": _of("-1,1", "-1,1,-1,1", "1,0", "x"),
    **dict.fromkeys(("--to", "--through"), lambda rng, place: [_target(rng, place)]),
    **dict.fromkeys(
        ("--from", "--via", "paths --to", "quiet --to"), lambda r, p: [_pose(r, p)]
    ),
    "--fan": _of("3", "1", "0", "x"),
    "paths --tolerance": _of("5%", "0.2", "0", "1", "x"),
    "--factors": _of("crank=0.5", "left_lower=0.5,2", "crank=0", "crank"),
    "--change": _of("crank", "left_lower,left_upper", "x"),
    "--turn": _of("0.1", "3deg", "0.1,0,0", "0,0,0.1", "1,2", "x"),
    "--line": _of("1", "2", "0", "x"),
    "--length": _of("0.1", "0.3", "0", "-1", "nan"),
    "--step": _of("0.01", "0.05", "0", "1e-9"),
    "--base": _of("fixed", "free", "spring", "loose"),
    "--tip": lambda rng, place: [",".join(_number(rng) for _ in range(rng.randint(1, 4)))],
    "--where": _of("AB=CD", "AB=2*BC", "AB=AB", "AB", "XY=ZZ", "l_crank=0.5*AB", "="),
    "--solve": lambda rng, place: [
        f"{rng.choice(('s', 'sx', 'J', 'q'))}_{link}" for link in [_one(rng, place.names.links)]
    ],
    "formulas --seconds": _of("60", "20", "1", "0", "nan", "x"),
    "--notation": _of("text", "latex", "python", "sympy"),
    "--which": _of("1", "2", "0", "99"),
    "--base-inertia": _of(
        "1", "0.5", "1,1,1", "1,1,1,0.1,0,-0.1", "1,1,1,2,0,0", "1,1,3", "1,2", "-1", "x"
    ),
    "--stiffness": _of("1e3", "1e3Nm/rad", "50N/m", "5N/mm", "1e40"),
    "--initial": lambda rng, place: [_values(rng, ("wx", "wz", "vy", *place.names.inputs))],
    "--torque": lambda rng, place: [_values(rng, place.names.inputs)],
    "--duration": _of("0.1", "0.02", "0", "nan", "1e9"),
    "--payload": lambda rng, place: [_payload(rng, place)],
    "--weights": _of("1", "2,1", "0", "1,x", "-1"),
    "verify --gravity": _of("0,-9.81,0", "0.1,-9.81,0", "0,0,0", "1,2", "x"),
    "--between": lambda rng, place: [_spring(rng, place)],
    "--catalogue": _of("100,200", "0.1N/mm", "0", "-1", "x", "", "9:90:9@0:0.1:0.05"),
    "--range": lambda rng, place: [f"{_one(rng, place.names.inputs)}={_number(rng)}:1"],
    "identify --motion": lambda rng, place: [_table(rng, place)],
    "--wrench": lambda rng, place: [_loads(rng, place)],
    "--cutoff": _of("9", "5", "1e-3", "200", "0", "-1", "x"),
    "--prior": _of("0.3", "1e-3", "10", "0", "-1", "nan"),
    "identify --gravity": _of("0,0,-9.81", "0,0,0", "1,2", "x"),
    "--harmonics": _of("2", "3", "1", "51", "x"),
    "--tries": _of("1", "2", "2", "0", "x"),
    "quiet --duration": _of("1", "0.3", "1e-6", "1e6", "0", "x"),
    "--shaking": _of("force", "moment", "both"),
    "--measure": _of("rms", "peak"),
    "--natural-frequency": _of("5", "12.5", "0", "nan"),
    "--front": _of("2", "1", "x"),
    "--tool-from": _of("x=0.01", "z=0.01,rx=0.1", "rz=2deg", "x=1deg", "w=1", "x=9"),
    "--tool-to": _of("x=0.01", "y=-0.01", "rz=2deg", "x=1deg", "w=1", "x=9", "x"),
    **{
        f"--max-{kind}": lambda rng, place: [
            f"{rng.choice(('', _one(rng, place.names.inputs) + '='))}{_number(rng)}"
        ]
        for kind in ("velocity", "acceleration", "jerk")
    },
    "flex simulate --duration": _of("0.05", "0.01", "0", "nan"),
    "--flex": lambda rng, place: [f"{_one(rng, place.names.links, 0.05)}={_bends(rng)}"],
    "--drive": lambda rng, place: [f"{_one(rng, place.names.inputs, 0.05)}={_drive(rng)}"],
    "--elements": _of("2", "4", "0", "401", "x"),
    "--modes": _of("1", "2", "3", "0", "401"),
    "--samples": _of("2", "5", "1", "1e9"),
    "--damping": _of("1e-4", "0", "-1", "nan"),
    "--count": _of("1", "3", "12", "0", "501", "x"),
    "--beam": _of(
        "length:1,EI:1,rhoA:1",
        "length:1,EI:2,rhoA:0",
        "length:1,EI:1",
        "rhoA:inf",
        "length:1,EI:1,rhoA:1,GA:9,rhoI:0.1",
        "EI:1,EI:2",
    ),
    "--pin": _of("0", "1", "0.5", "2", "nan", "0.1*0.5+0.3*0.5", "0.1+0.3", "*", "+"),
    "--clamp": _of("0", "1", "-1", "inf", "x"),
    "--arm": _of(*ARMS),
    "flex similar --against": _of(*ARMS),
    "--spin": _of("1,0.01,0.02", "1", "0,1", "1,0", "a,b", "1,0.01,nan"),
    "--translator": _of(BLOCK, f"{BLOCK},hubmass:0.001", "pitch:1", BLOCK.replace("0.02", "0")),
    "--moment": _of("1e-3,0.001,0.002", "1", "0,0", "x,1"),
}
