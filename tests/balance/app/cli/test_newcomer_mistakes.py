"""Mistakes of newcomers: each is answered by one line with the element and the remedy.

What is wrong in the request has a second line, which leads to the help. None of them is
analysed as another machine without a notice.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from balance.app.cli.implausible_request import note_implausible_masses
from balance.app.cli.main import COMMANDS
from kinematics import from_dh, gallery
from tests.support.command_runs import asked

TABLES = {
    "semicolons.csv": "time;u1\n0;0\n1;1\n",
    "no_names.csv": "0,0\n1,1\n",
    "words.csv": "time,u1\n" + "a,b\n" * 8,
    "gons.csv": "time,u1 [gon]\n" + "0,1\n" * 8,
    "lengths.csv": "time,u1 [mm]\n" + "".join(f"{k},{k * k}\n" for k in range(9)),
    "degrees.csv": "time,u1\n" + "".join(f"{0.1 * k:.1f},{40 * k}\n" for k in range(9)),
    "still.csv": "time,u1\n" + "".join(f"{k},1\n" for k in range(9)),
    "back.csv": "time,u1\n" + "".join(f"{9 - k},{k * k}\n" for k in range(9)),
    "short.csv": "time,u1\n0,0\n1,1\n",
    "empty.urdf": "",
    "cut.urdf": "<robot",
    "no_links.urdf": "<robot name='r'/>",
    "notes.txt": "crank 0.2 m\n",
    "robot.step": "ISO-10303-21;\n",
    "tabs.csv": "time\tu1\n" + "".join(f"{k}\t{k * k}\n" for k in range(9)),
    "gap.csv": "time,u1\n0,0\n1,\n" + "".join(f"{k},1\n" for k in range(2, 9)),
    "capitals.csv": "Time,U1\n" + "".join(f"{k},{k * k}\n" for k in range(9)),
    "link.csv": "time,crank\n" + "".join(f"{k},{k * k}\n" for k in range(9)),
    "short_time.csv": "t,u1\n" + "".join(f"{k},{k * k}\n" for k in range(9)),
    "loads.csv": "time,FX,FY,MZ\n" + "0,1,1,1\n" * 20,
    "lengths_of_loads.csv": "time,fx [mm]\n" + "0,1\n" * 20,
    "motion.csv": "time,u1\n" + "".join(f"{0.1 * k:.1f},{0.01 * k * k}\n" for k in range(40)),
    "one_of_two.csv": "time,u1\n" + "".join(f"{k},{k * k}\n" for k in range(9)),
    "later.csv": "time,fx\n" + "".join(f"{7 + 0.1 * k:.1f},1\n" for k in range(40)),
    "list.toml": "[[\n",
    "tables.toml": 'model = "five_bar"\n[dimensions]\na = 1\n',
}

# Words, exit code, and what the first line says: the element, and the remedy.
MISTAKES = [
    ("report four_bar_genral", 3, "four_bar_genral.*a name such as 'four_bar_general'"),
    ("report none.urdf", 3, "none.urdf: no such file; check the path"),
    ("report .", 3, "not a file; give the path of a file"),
    ("report empty.urdf", 3, "empty.urdf: .*empty file"),
    ("report cut.urdf", 3, "cut.urdf: .*not well-formed XML"),
    ("report no_links.urdf", 3, "no_links.urdf: .*no <link>"),
    ("report", 2, "required: MODEL$"),
    ("verify five_bar --speed u1=200rpm --speed u2=200rpm", 2, "twice: .*--motion u2=u1"),
    ("verify five_bar --speed u1=200rpm,u2=-200rpm", 2, "one crank, .* --motion u2=-2.u1$"),
    (
        "counterweights slider_crank --region crank=cylinder(0,0,0,0,0,1mm,45mm,30mm)",
        2,
        "write cylinder.x,y,z,ax,ay,az,r,length.",
    ),
    ("reports four_bar_kite", 2, "'reports' .choose from 'new', 'report'.*mean 'report'"),
    ("verfy four_bar_kite", 2, "'verfy' .*did you mean 'verify'"),
    ("verify slider_crank --trajectoires 3", 2, "--trajectoires 3 .did you mean '--traj"),
    ("verify five_bar --base fere", 2, "'fere' .*did you mean 'free'"),
    ("report four_bar_kite --at u1", 2, "u1=0.3,u2=-10deg"),
    ("report four_bar_kite --at u1=30mm", 3, "'u1' is revolute: .*such as 30deg"),
    ("report slider_crank --at q4=3deg", 3, "'q4' is prismatic: .*such as 20mm"),
    ("report four_bar_kite --at u1=30kg", 2, "'kg' is a unit of mass: write angle or length"),
    ("report four_bar_kite --at u9=1", 3, "u9.*choose from u1"),
    ("report four_bar_kite --at u1=1e300", 3, "u1"),
    ("report four_bar_kite --motion u1", 3, "must hold one '='; the inputs are u1"),
    ("report four_bar_kite --motion u9=0", 3, "u9.*u1"),
    ("report four_bar_kite --inputs u2", 3, "u2: no such joint; choose from u1"),
    ("report four_bar_kite --ground wall", 3, "'wall': there is no such link; choose from"),
    ("report four_bar_kite --massless crnk", 3, "crnk.*crank"),
    ("report pantograph --inputs U1", 3, "U1: no such joint .did you mean 'u1'"),
    ("report pantograph --motion U1=0", 3, "'U1' is not an input .did you mean 'u1'"),
    ("paths pantograph --from U2=1", 3, "U2 is not an input .did you mean 'u2'"),
    ("quiet pantograph --to u1=1 --max-velocity U2=1", 2, "'U2' is no input .* 'u2'"),
    ("report four_bar_kite --loops none.yaml", 3, "loops here and in 'none.yaml'; remove"),
    ("report four_bar_kite --html page", 2, "'page' ends neither in .html nor in .htm"),
    ("report four_bar_kite --write-closed no/x.urdf", 3, "no/x.urdf: cannot be written.*give"),
    ("report four_bar_kite --max-order two", 2, "'two' is not an order from 0 to 50"),
    ("report four_bar_kite --balance static", 2, "'static' .choose from 'dynamic', 'force'"),
    ("verify slider_crank --csv none.csv", 3, "none.csv: cannot be read .No such file"),
    ("verify slider_crank --csv semicolons.csv", 3, "commas part them, no semicolons"),
    ("verify slider_crank --csv no_names.csv", 3, "line 1: the columns must be time, u1"),
    (
        "verify five_bar --csv one_of_two.csv",
        3,
        "must be time, u1, u2; u2 has none: one number in all rows is an input at rest",
    ),
    ("verify slider_crank --csv words.csv", 3, "sample 1: cannot be read as numbers"),
    ("verify slider_crank --csv gons.csv", 3, "column 'u1 .gon.': .*write angle.* in rad, deg"),
    ("verify slider_crank --csv lengths.csv", 3, "column 'u1': .*length; give one of angle"),
    ("verify slider_crank --csv degrees.csv", 3, "320 rad, 51 turns: .*'u1 .deg.'"),
    ("verify slider_crank --csv still.csv", 3, "nothing moves; give inputs that change"),
    ("verify slider_crank --csv back.csv", 3, "its times do not increase"),
    ("verify slider_crank --csv short.csv", 3, "holds 2 samples, not 6 to"),
    ("verify slider_crank --speed 300", 2, "'300' is not a speed: write 300rpm"),
    ("verify slider_crank --speed 300rmp", 2, "'300rmp' is not a speed: write 300rpm"),
    ("verify slider_crank --speed 1e300rpm", 3, "no speed of a crank; give one from"),
    ("verify five_bar --speed 300rpm", 3, "which is the crank. .*--motion u2=u1 --speed u1="),
    (
        "counterweights five_bar --links all --speed 300rpm",
        3,
        "the crank. .*--motion u2=u1 --speed u1=300rpm .the masses are then for this motion al",
    ),
    ("reduce five_bar --links all --budget 1 --speed 9hz", 3, "masses are then for this mot"),
    ("verify slider_crank --tolerance 2", 2, "'2' is not a number from 0 up to 1"),
    ("verify slider_crank --plot a.pdf", 2, "'a.pdf' ends neither in .png nor in .svg"),
    ("verify slider_crank --base free", 2, "give --base-mass and --base-inertia"),
    ("verify slider_crank --base-mass 2", 2, "only with --base free"),
    ("design four_bar_kite --density stele", 2, "'stele' is not a positive number.*steel"),
    ("counterweights delta --links upper1", 3, "'upper1': there is no such link; the bodies"),
    ("design four_bar_kite --density 7.85g", 2, "'g' is a unit of mass: write density in"),
    ("design four_bar_kite --density none --thickness 5mm", 3, "a thickness limits nothing"),
    ("design four_bar_kite --thickness 10kg", 2, "'kg' is a unit of mass: write length in m"),
    ("design four_bar_kite --keep crnak", 3, "'crnak': .*mean 'crank'.*the bodies are crank"),
    ("design four_bar_kite --bounds crank=2kg:1kg", 3, "'crank': .*give 0 ≤ least ≤ largest"),
    ("design four_bar_kite --bounds crank=1", 2, "not L=LO:HI, such as crank=0.5:2"),
    ("design four_bar_kite --minimise weight", 2, "'weight' .choose from 'mass', 'inertia'"),
    ("design four_bar_kite --add crank", 2, "unrecognized arguments: --add crank"),
    ("counterweights four_bar_kite", 2, "give --links: all, .* of crank, coupler, rocker"),
    ("reduce four_bar_kite --budget 1", 2, "give --links: all, .* of crank, coupler, rocker"),
    ("reduce four_bar_kite --shape disc=20mm --shape sector=20mm", 2, "twice: give one shape"),
    ("reduce four_bar_kite --shape disc=20mm/sector=20mm", 2, "one, such as disc=20mm$"),
    ("counterweights four_bar_kite --shape=disc=5mm --sha disc=5mm", 2, "one shape, .*5mm/8mm"),
    ("counterweights four_bar_kite --links krank", 3, "'krank': .*mean 'crank'.*bodies are"),
    ("counterweights four_bar_kite --links base", 3, "'base': is part of the ground"),
    ("counterweights four_bar_kite --links crank --region crank=sphere(0,0,0,1)", 2, "ball.x"),
    ("counterweights four_bar_kite --links crank --region crank=ball(0,0,0,-5m)", 2, "above"),
    ("counterweights four_bar_kite --links crank --region crank=ball(0,0,0,9deg)", 2, "ball.x"),
    ("reduce four_bar_kite --links crank", 2, "such as --budget 1.5 .kg., or --pareto 10"),
    ("reduce four_bar_kite --links crank --budget 1m", 2, "is a unit of length: write mass"),
    ("reduce four_bar_kite --links crank --budget=-1", 2, "a mass is not negative"),
    ("reduce four_bar_kite --links crank --budget 1e300", 2, "give at most 1e.09 kg"),
    ("reduce four_bar_kite --links crank --budget 1 --max-bearing u1", 2, "such as u1=20"),
    ("motion five_bar --to u1=10cm,u2=0", 3, "'u1' is revolute: .*such as 30deg"),
    ("motion five_bar --tool left_uper --along x", 3, "'left_uper': .*left_upper"),
    ("motion five_bar --tool left_upper", 2, "--tool and --along go together"),
    ("motion five_bar --path none.csv", 3, "none.csv: cannot be read"),
    ("flex simulate five_bar --flex coupler=EI:5", 2, "rhoA is missing: write LINK=EI"),
    ("paths five_bar --from u3=1", 3, "u3 is not an input; the inputs are u1, u2"),
    ("sweep run none.toml", 3, "none.toml: no such file .*give the path of a study"),
    ("sweep show none.db", 3, "none.db: no such file; give the file of a run"),
    ("discover run --topology slidercrank", 2, "'slidercrank' .did you mean 'slider-crank'"),
    ("springs four_bar_kite --between base,rokcer", 3, "rokcer.*did you mean 'rocker'"),
    ("remedies slider_crank --speed 300rpm", 2, "shafts hold at any .*verify FILE --speed"),
    ("remedies four_bar_kite --only passive_weel", 2, "did you mean 'passive_wheel'"),
    ("remedies four_bar_kite --only wheels", 2, "no remedy 'wheels': choose from own_masses"),
    ("formulas three_rsr", 3, "it has 2 loops: formulas of spatial linkages are of"),
    ('synthesize --positions "0,0"', 2, "is not x,y,deg: write"),
    ("report notes.txt", 3, "notes.txt: .*give a robot as URDF, SDF or MJCF"),
    ("report robot.step", 3, "robot.step: .*give a robot as URDF, SDF or MJCF"),
    ("report FOUR_BAR_KITE", 3, "FOUR_BAR_KITE.*a name such as 'four_bar_kite'"),
    ("report four_bar_kite.urdf", 3, "give the name of the model, four_bar_kite$"),
    ("report four_bar_kite -html page.html", 2, "-html .did you mean '--html'"),
    ("report --model four_bar_kite", 2, "write MODEL alone, without --model"),
    ("report four_bar_kite --at u1=0.3 u2=0.1", 2, "u2=0.1 .--at takes one word: commas"),
    ("report four_bar_kite --at 30deg", 2, "'30deg' is not u1=0.3,u2=-10deg"),
    ("report four_bar_kite --balance moment", 2, "'moment' .choose from 'dynamic', 'force'"),
    ("verify slider_crank --rpm 300", 2, "--rpm 300 .did you mean '--speed'"),
    ("verify slider_crank --speed u1=300 rpm", 2, "'u1=300' is not a speed: .*u1=300rpm"),
    ("verify slider_crank --csv tabs.csv", 3, "be time, u1; commas part them, no tabs"),
    ("verify slider_crank --csv gap.csv", 3, "sample 2: cannot be read as numbers"),
    ("verify slider_crank --csv capitals.csv", 3, "not Time .*'time'.*U1 .did you mean 'u1'"),
    ("verify slider_crank --csv link.csv", 3, "must be time, u1, not crank"),
    ("verify slider_crank --csv short_time.csv", 3, "must be time, u1, not t;"),
    ("verify slider_crank --gravity 9.81", 2, "not a vector such as 0,0,-9.81.*m/s²"),
    ("verify slider_crank --against none.urdf", 3, "none.urdf: no such file"),
    ("identify slider_crank", 2, "give --motion and --wrench, or --plan"),
    ("identify slider_crank --motion motion.csv --wrench loads.csv", 3, "not FX .*'fx'"),
    (
        "identify slider_crank --motion motion.csv --wrench lengths_of_loads.csv",
        3,
        "column 'fx .mm.': .*write force in N",
    ),
    ("identify slider_crank --motion later.csv --wrench motion.csv", 3, "u1, not fx;"),
    ("identify slider_crank --plan --duration 10m", 2, "unit of length: write time in s, ms"),
    ("design five_bar --bounds left_lower=1m:2", 2, "unit of length: write mass in kg"),
    ("design five_bar --keep left_lower,left_uper", 3, "'left_uper': .*mean 'left_upper'"),
    ("design five_bar --output x.urdf", 2, "--output x.urdf .did you mean '--out'"),
    ("counterweights five_bar --links left_lower left_upper", 2, "--links takes one word"),
    ("reduce five_bar --links all --budget 5%", 2, "'%' is no unit .*write mass in kg"),
    ("reduce five_bar --links all --budget 1 --material steel", 2, "mean '--density'"),
    ("springs five_bar --between base,left_lower --gravity -9.81", 2, "such as 0,0,-9.81"),
    ("springs five_bar --between base@0,0,0 left_lower@1,0,0", 2, "--between takes one word"),
    ("springs five_bar --between left_lower", 2, "no known form: write 'base,arm'"),
    ("flex simulate four_bar_general --flex coupler=rect(30,4),steel", 3, "4 m thick and 0.89"),
    ("flex simulate four_bar_general --flex coupler=rect(3kg,4mm),steel", 2, "write length"),
    ("flex simulate four_bar_general --flex coupler=rect(3,1),stel", 2, "materials are steel"),
    ("motion five_bar --to u9=1", 3, "u9.*u1, u2"),
    ("motion five_bar --path notes.txt", 3, "must be u1, u2, not crank 0.2 m"),
    ("paths five_bar --tool left_uper", 3, "'left_uper': .*did you mean 'left_upper'"),
    ("paths five_bar --tolerance 5", 2, "'5' is not below 1: write 5% or 0.05"),
    ("quiet five_bar", 2, "give the pose to reach by --to or --tool-to"),
    ("quiet five_bar --to u1=0.5 --duration 500kg", 2, "write time in s, ms, min"),
    ("quiet five_bar --to u1=0.5 --max-torque 20kg", 2, "write the number alone, in SI"),
    ("quiet five_bar --tool left_upper --tool-to u1=0.1", 3, "is an input: write --from or"),
    ("quiet five_bar --to x=0.1", 2, "a pose with x is one of a tool: name the link"),
    ("remedies five_bar --only own-masses", 2, "did you mean 'own_masses'"),
    ("sweep run list.toml", 3, "list.toml: no TOML: .*line 1, column 3.*correct the file"),
    ("sweep run tables.toml", 3, "no such table; the tables are model, parameters"),
    ("sweep run", 2, r"required: MODEL\|STUDY.toml"),
    ("sweep run four_bar_kite", 2, "nothing varies: give --vary, .*=90%:110%:10; now .* m"),
    ("sweep run four_bar_kite --vary length=1:2:3", 3, "--vary length: names no joint, loop"),
    ("sweep run four_bar_kite --vary crank=1:2:3", 3, "link 'crank' has the numbers length"),
    ("quiet five_bar --to u1=0.5 --csv a.csv", 2, "--csv a.csv .write --table FILE.csv"),
    ("sweep run four_bar_kite --links crank", 2, "--links crank .write --counterweights L1,L2"),
    ("sweep run four_bar_kite --vary coupler.length", 2, "is not PATH=RANGE, such as"),
    (
        "sweep run list.toml --vary a=1:2:3",
        2,
        "--vary goes with a model: list.toml has its",
    ),
    ("discover run --topology fourbar --starts 3", 2, "did you mean 'four-bar'"),
    ("synthesize --positions 0,0,0;1,0,9", 2, "by --fixed or --moving"),
    ("formulas five_bar --balance all", 2, "'all' .choose from 'dynamic', 'force'"),
    ("models four_bar", 2, "unrecognized arguments: four_bar"),
    ("new a.urdf --points A=0,0;B=A+1@90 --links a=A,B", 2, "'90' has no unit: write 90deg"),
    ("new a.urdf --points A=0,0;B=1,0 --links base=A;a=A,C", 2, "no point 'C'; there are 'A'"),
    ("new a.urdf --points A=0,0;B=9,0 --links a=A,B --base A", 2, "write base=A,B in --links"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder but for the tables, in which the command runs."""
    for name, text in TABLES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.table(12)
@pytest.mark.parametrize(("words", "code", "said"), MISTAKES, ids=lambda word: str(word)[:60])
def test_mistakes_are_answered_in_one_line(words, code, said, folder):
    before = sorted(folder.iterdir())
    found, out, err = asked(shlex.split(words))
    lines = err.splitlines()
    assert (found, out) == (code, "") and len(lines) == (2 if code == 2 else 1), err
    assert re.search(said, lines[0]), lines[0]
    assert sorted(folder.iterdir()) == before


def test_there_are_sixty_and_some_of_every_command():
    assert len(MISTAKES) >= 60
    assert {words.split()[0] for words, *_ in MISTAKES} >= set(COMMANDS)


@pytest.mark.slow
def test_all_links_and_materials_have_a_word():
    """`all` and `steel` ask what the names of the links and 7850 ask."""
    words = ["counterweights", "five_bar", "--balance", "force", "--json", "--links"]
    links = "left_lower,left_upper,right_lower,right_upper"
    named = asked([*words, links, "--density", "7850"])
    assert asked([*words, "all", "--density", "steel"]) == named and named.code == 0
    one, other = (
        asked([*words, links, "--density", each, "--density", "left_lower=lead"])
        for each in ("aluminium", "2.7g/cm3")
    )
    assert one == other and one.code == 0


def test_a_written_file_is_read_without_a_notice(tmp_path):
    """Coordinates of counterweights that are round-off are written as zeros."""
    path = str(tmp_path / "balanced.urdf")
    words = ["--balance", "force", "--links", "all", "--density", "steel", "--out", path]
    assert asked(["counterweights", "five_bar", *words]).code == 0
    done = asked(["report", path, "--balance", "force"])
    assert (done.code, done.err) == (0, "") and "Can it balance? Yes" in done.out


def test_other_signs_between_words_are_the_same():
    """A model and a topology with ``-`` for ``_``, or the other way."""
    same = [asked(["report", name, "--json"]) for name in ("four-bar-kite", "four_bar_kite")]
    assert same[0] == same[1] and same[0].code == 0


@pytest.mark.parametrize("number", ["90", "-90"])
def test_radians_of_more_than_a_turn_are_noticed(number):
    code, _, err = asked(["report", "four_bar_kite", "--at", f"u1={number}"])
    assert code == 0 and f"for degrees write u1={number}deg" in err
    assert "for degrees" not in asked(["report", "four_bar_kite", "--at", "u1=10deg"]).err


def _changed(folder, change):
    """The file of a four-bar, changed."""
    text = gallery()["four_bar_general"].read_text(encoding="utf-8")
    path = folder / "robot.urdf"
    path.write_text(change(text), encoding="utf-8")
    assert path.read_text(encoding="utf-8") != text
    return path


def test_degrees_in_a_file_are_noticed(folder):
    """An rpy that makes sense in degrees alone."""
    path = _changed(folder, lambda text: text.replace('rpy="0 0 0"', 'rpy="0 0 90"', 1))
    err = asked(["report", str(path)]).err
    assert "0 0 90 in rpy of " in err and "multiply them by π/180" in err


def test_millimetres_in_a_file_are_noticed(folder):
    """A machine of a kilometre."""

    def thousand(match):
        numbers = " ".join(f"{1000.0 * float(word):g}" for word in match[1].split())
        return f'<origin xyz="{numbers}"'

    path = _changed(folder, lambda text: re.sub(r'<origin xyz="([^"]*)"', thousand, text))
    assert "its links are up to 1140 m apart" in asked(["report", str(path)]).err
    assert "apart" not in asked(["report", "four_bar_general"]).err


@pytest.mark.parametrize(
    ("masses", "inertias", "said"),
    [
        (1000, 1000, "its links weigh .* kg, more than a machine of .*multiply grams by 0.001"),
        (1, 1e6, "<inertia> is in kg m²; multiply kg mm² by 1e-6"),
        (1000, 1e9, "<inertia> is in kg m²; .*g mm² by 1e-9, and grams in <mass> by 0.001"),
    ],
)
def test_grams_and_square_millimetres_in_a_file_are_noticed(masses, inertias, said, folder):
    """A file in which all masses, or all moments of inertia, have another unit."""
    text = gallery()["slider_crank"].read_text(encoding="utf-8")
    for name, factor in (("value", masses), ("i[xyz]{2}", inertias)):
        text = re.sub(
            rf'({name})="([^"]*)"', lambda m, f=factor: f'{m[1]}="{f * float(m[2]):g}"', text
        )
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    code, _, err = asked(["report", str(path)])
    assert code == 0 and re.search(said, err), err
    assert "multiply" not in asked(["report", "slider_crank"]).err


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        ("reduce four_bar_general --require force --links crank,rocker --budget ", "200"),
        ("design four_bar_antiparallelogram --minimise mass --bounds coupler=", "200:500"),
    ],
)
def test_grams_in_a_request_are_noticed(words, heavy):
    """The ratio in the notice, against masses as summed from the file."""
    err = asked(shlex.split(words + heavy)).err
    text = gallery()[words.split()[1]].read_text(encoding="utf-8")
    mass = sum(float(value) for value in re.findall(r'<mass value="([^"]*)"', text))
    said = re.search(
        r"=?200 is in kg, ([\d.]+) times the ([\d.]+) kg .*did you mean 200g\?", err
    )
    assert said and float(said[1]) == pytest.approx(200 / mass, rel=0.06)
    assert float(said[2]) == pytest.approx(mass, rel=0.006)
    assert "did you mean" not in asked(shlex.split(words + heavy.replace("00", ""))).err


def test_grams_are_not_meant_for_links_without_masses():
    linkage = from_dh([[0, 0.4, 0, 0], [0, 0, 0.5, 0]])
    assert note_implausible_masses(linkage, [("--budget ", 200.0)]) == ()


def _five_bar():
    """A symmetric five-bar of 0.2 m, as text."""
    bars = {"crank": (0.05, 0.15, 1.3e-4), "rod": (0.1, 0.12, 4e-4)}
    links = "".join(
        f'<link name="{name}{side}"><inertial><origin xyz="{x} 0 0"/><mass value="{m}"/>'
        f'<inertia ixx="1e-6" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for side in "12"
        for name, (x, m, i) in bars.items()
    )
    joints = "".join(
        f'<joint name="m{side}" type="continuous"><parent link="base"/>'
        f'<child link="crank{side}"/><origin xyz="{place} 0 0" rpy="0 0 {angle}"/>'
        f'<axis xyz="0 0 1"/></joint><joint name="e{side}" type="continuous">'
        f'<parent link="crank{side}"/><child link="rod{side}"/>'
        f'<origin xyz="0.1 0 0" rpy="0 0 {turn}"/><axis xyz="0 0 1"/></joint>'
        for side, place, angle, turn in (("1", -0.06, 2.0944, -1.2), ("2", 0.06, 1.0472, 1.2))
    )
    ends = "".join(
        f'<{end} link="rod{side}"><origin xyz="0.2 0 0"/></{end}>'
        for end, side in (("predecessor", "1"), ("successor", "2"))
    )
    loop = f'<loop name="tip" type="revolute">{ends}<axis xyz="0 0 1"/></loop>'
    return f'<robot name="five"><link name="base"/>{links}{joints}{loop}</robot>'


@pytest.mark.slow
def test_regions_of_a_kilometre_name_no_negative_mass(folder):
    """Millimetres without their unit: a notice, and no change of the request that is none."""
    (folder / "five.urdf").write_text(_five_bar(), encoding="utf-8")
    far = "box(-80:-20,-30:30,-10:10)"
    regions = [word for k in "12" for word in ("--region", f"crank{k}={far}")]
    words = ["five.urdf", "--balance", "force", "--links", "crank1,crank2", *regions]
    code, out, err = asked(["counterweights", *words])
    assert code == 1 and "regions are in metres" in err
    assert not re.search(r"\(-[\d.e+]+ kg", out), out


def test_the_files_of_the_gallery_are_found():
    """To change a copy of one."""
    folder = asked(["models"]).err.splitlines()[-1].removeprefix("their files are in ")
    assert {path.parent for path in gallery().values()} == {Path(folder)}
