"""Help of the commands: its length, its examples, and where usage errors lead."""

from __future__ import annotations

import shlex
from shutil import copyfile

import pytest

from balance.app.cli.arguments import GROUPS
from balance.app.cli.main import COMMANDS, command_parser
from kinematics import gallery
from tests.fuzz.request_words import parsers
from tests.support.command_runs import asked

# Lines of a help page that fits on a screen, of 80 columns.
MOST_LINES = 40
ON_ONE_PAGE = ("design", "counterweights", "reduce")


def help_of(verb, monkeypatch):
    """The help of a command in 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = asked([*verb.split(), "--help"])
    assert (code, err) == (0, "")
    return out


def examples_of(text):
    """The commands at the end of a help page."""
    commands = text.split("examples:\n")[1].replace("\\\n", " ").splitlines()
    return [shlex.split(command) for command in commands]


@pytest.mark.parametrize("verb", ON_ONE_PAGE)
def test_help_fits_on_a_page(verb, monkeypatch):
    text = help_of(verb, monkeypatch)
    assert len(text.splitlines()) <= MOST_LINES
    assert len(examples_of(text)) == 3


@pytest.mark.parametrize("verb", ["counterweights", "reduce"])
def test_help_says_where_matter_may_be_without_a_region(verb, monkeypatch):
    (line,) = (x for x in help_of(verb, monkeypatch).splitlines() if "--region L=" in x)
    assert line.endswith("(half L's length)")


def test_help_of_paths_fits_on_a_page(monkeypatch):
    """It has no examples."""
    assert len(help_of("paths", monkeypatch).splitlines()) <= MOST_LINES


@pytest.mark.parametrize("verb", [*ON_ONE_PAGE, "verify", "report"])
def test_groups_of_the_help(verb, monkeypatch):
    """Every option stands in a group, the model first and the output last."""
    lines = help_of(verb, monkeypatch).splitlines()
    titles = [line[:-1] for line in lines if line.endswith(":") and not line.startswith(" ")]
    places = [GROUPS.index(title) for title in titles[:-1]]
    assert titles[-1] == "examples" and places == sorted(places)
    assert titles[0] == "model" and titles[-2] == "output"


@pytest.mark.parametrize("verb", ["design", "counterweights", "reduce"])
def test_verbs_have_only_their_options(verb):
    """What one of the three asks for is no option of the others."""
    own = {
        "design": {"--keep", "--bounds", "--anywhere"},
        "counterweights": {"--links", "--region", "--merge", "--price-of-mass"},
        "reduce": {"--links", "--region", "--merge", "--budget", "--pareto"},
    }
    known = {name for action in parsers()[verb]._actions for name in action.option_strings}
    others = set().union(*own.values()) - own[verb]
    assert own[verb] <= known and not others & known


@pytest.mark.slow
@pytest.mark.parametrize("verb", [*ON_ONE_PAGE, "verify", "report"])
def test_examples_of_the_help(verb, monkeypatch, tmp_path):
    """The parser takes them all; the last one of a verb for masses writes a file."""
    commands = examples_of(help_of(verb, monkeypatch))
    for command in commands:
        command_parser([verb]).parse_args(command[1:])
    if verb in ON_ONE_PAGE:
        monkeypatch.chdir(tmp_path)
        model = "four_bar_kite" if verb == "design" else "four_bar_general"
        copyfile(gallery()[model], "robot.urdf")
        code, out, err = asked(commands[-1][1:])
        assert code == 0 and out, err
        name = commands[-1][commands[-1].index("--out") + 1]
        assert (tmp_path / name).is_file()


def test_balance_alone_prints_the_jobs():
    """Each with an example that its parser takes."""
    code, out, err = asked([])
    assert (code, err) == (0, "")
    for name, command in COMMANDS.items():
        assert f"{name} " in out and command.summary in out and command.example in out
        program, verb, *words = shlex.split(command.example)
        assert (program, verb) == ("balance", name)
        command_parser([name]).parse_args([verb, *words])
    assert max(map(len, out.splitlines())) <= 96


@pytest.mark.parametrize(
    ("words", "where"),
    [
        (["design"], "balance design"),
        (["design", "five_bar", "--links", "x"], "balance design"),
        (["flex", "supports", "x"], "balance flex supports"),
        (["nonsense"], "balance"),
        (["reduce", "five_bar", "--links", "left_lower"], "balance reduce"),
        (
            ["design", "x.urdf", "--out", "a.urdf", "--html", "a.urdf.html", "--bounds", "a"],
            "balance design",
        ),
    ],
)
def test_usage_errors_are_two_lines(words, where):
    """What is wrong, and where to look."""
    code, out, err = asked(words)
    wrong, look = err.splitlines()
    assert (code, out) == (2, "") and wrong.startswith(f"{where}: error: ")
    assert look == f"{where} --help lists what there is"


@pytest.mark.parametrize(
    ("words", "old"),
    [
        (["design", "five_bar", "--add", "left_lower"], "--add"),
        (["design", "five_bar", "--partial"], "--partial"),
        (["design", "five_bar", "--force"], "--force"),
        (["design", "five_bar", "--minimize", "mass"], "--minimize"),
        (
            ["reduce", "five_bar", "--links", "left_lower", "--trajectory", "a.csv"],
            "--trajectory",
        ),
    ],
)
def test_old_words_are_gone(words, old):
    code, _, err = asked(words)
    assert code == 2 and f"unrecognized arguments: {old}" in err
