"""The documentation: each page shows what happens, and the site builds without a warning.

Pages run first, one test each, and leave their files for the site, which is built from them.
"""

from __future__ import annotations

import inspect
import logging
import re
import shlex
from importlib import import_module
from importlib.util import find_spec
from itertools import chain, combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from code_blocks import code_blocks, run_page
from generated_pages import EXAMPLES, command_parsers, option_examples

import balance
from balance.app.answers.html.linkage_drawing import linkage_drawing
from balance.app.cli.main import COMMANDS, command_parser
from tests.support.pictures import curves_agree

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("**/*.md"))
TEXTS = {path.relative_to(DOCS).as_posix(): path.read_text(encoding="utf-8") for path in PAGES}
# What a browser would load from elsewhere.
LOADED = re.compile(
    r'<(?:script|img|link rel="\w*(?:stylesheet|icon)")[^>]*(?:src|href)="(?:https?:)?//'
)
NEEDS_MKDOCS = pytest.mark.skipif(
    not all(map(find_spec, ("material", "mkdocstrings", "jupytext", "latex2mathml"))),
    reason="the extra docs is not installed",
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder in which pages run, and from which the site is built."""
    return tmp_path_factory.mktemp("docs")


@pytest.mark.docs
@pytest.mark.parametrize("page", [name for name, text in TEXTS.items() if code_blocks(text)])
def test_a_page_shows_what_happens(page, made):
    folder = made / page.removesuffix(".md")
    folder.mkdir(parents=True)
    run_page(TEXTS[page], folder, (DOCS / page).parent)


@pytest.mark.parametrize(
    "wrong",
    [
        "```sh\nbalance models\n```\n\n```text\nfour_bar_general\n```\n",
        "```sh\nbalance no_such_command\n```\n",
        "```sh\nbalance design four_bar_general\n```\n",
        "    balance report no_such_model\n",
        "```python\nprint(1.5)\n```\n\n```text\n1.6\n```\n",
        "```python\nprint(11)\n```\n\n```text\n12\n```\n",
        "```xml\n<robot>\n```\n",
        "```cobol\nSTOP RUN.\n```\n",
    ],
)
def test_a_wrong_page_is_found(wrong, tmp_path):
    with pytest.raises((AssertionError, SyntaxError)):
        run_page(wrong, tmp_path)


@pytest.mark.docs
@NEEDS_MKDOCS
def test_the_site_builds_without_a_warning_and_a_network(made, tmp_path, monkeypatch, caplog):
    """Strict: links, anchors, pages of the navigation, docstrings."""
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    monkeypatch.setenv("DOCS_FOLDER", str(made))
    monkeypatch.setenv("NO_MKDOCS_2_WARNING", "1")
    monkeypatch.chdir(ROOT)
    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(tmp_path), strict=True)
    build(config)
    told = [record for record in caplog.records if record.name.startswith("mkdocs")]
    assert not [record for record in told if record.levelno >= logging.WARNING]
    pages = {path: path.read_text(encoding="utf-8") for path in tmp_path.glob("**/*.html")}
    assert len(pages) > len(PAGES)
    assert not [path for path, text in pages.items() if LOADED.search(text)]
    assert "<math" in pages[tmp_path / "theory" / "momentum.html"]


@NEEDS_MKDOCS
def test_notebooks_hold_the_blocks_of_their_pages():
    import jupytext
    from notebooks import notebook

    for page, text in TEXTS.items():
        wanted = [block for block in code_blocks(text) if block.language != "text"]
        if not page.startswith(("tutorials/", "notebooks/")) or not wanted:
            continue
        cells = [
            cell["source"]
            for cell in jupytext.reads(notebook(text), "ipynb").cells
            if cell["cell_type"] == "code"
        ]
        assert len(cells) == len(wanted), page
        for cell, block in zip(cells, wanted, strict=True):
            lines = [line for line in cell.splitlines() if not line.startswith("%%")]
            assert lines == block.text.splitlines(), f"{page}, line {block.line}"


@pytest.mark.slow
def test_the_picture_of_the_readme_is_current(monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(str(DOCS))
    drawn = import_module("make_picture").picture()[0].decode()
    assert curves_agree(drawn, (DOCS / "shaking.svg").read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", [page for page in TEXTS if page.startswith("tutorials/")])
def test_a_tutorial_shows_its_machine(page):
    """As a drawing, which exists and has no ground of its own."""
    pictures = re.findall(r"!\[([^\]]+)\]\((machines/[\w.]+)\)", TEXTS[page])
    # The index has no machine, and the machine of the synthesis is drawn by its command.
    assert pictures or page in ("tutorials/index.md", "tutorials/synthesis.md")
    for _, path in pictures:
        drawing = ElementTree.parse(DOCS / "tutorials" / path).getroot()
        assert len(drawing) > 4 and not drawing.findall("{http://www.w3.org/2000/svg}rect")


def test_the_machines_of_the_tutorials_are_current(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    made = import_module("draw_machines")
    for page, name, model in made.MACHINES:
        kept = (DOCS / "tutorials" / "machines" / f"{name}.svg").read_text(encoding="utf-8")
        assert f"(machines/{name}.svg)" in TEXTS[f"tutorials/{page}.md"]
        drawn = made.machine(page, model)
        marks, numbers = (
            [re.split(r"-?\d+\.\d+", text) for text in (drawn, kept)],
            [np.array(re.findall(r"-?\d+\.\d+", text), float) for text in (drawn, kept)],
        )
        assert marks[0] == marks[1], name
        assert abs(numbers[0] - numbers[1]).max() < 0.11, name  # pixels, written to a tenth


def test_a_drawing_shows_all_links_and_joints_where_they_are():
    """Circles against the places of joints, turned and scaled: distances keep ratios."""

    linkage = balance.load("four_bar_general")
    drawing = linkage_drawing(linkage)
    circles = np.array(re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', drawing), float)
    places = np.array([joint.point for joint in linkage.joints])
    ratios = [
        np.linalg.norm(circles[i] - circles[j]) / np.linalg.norm(places[i] - places[j])
        for i, j in combinations(range(4), 2)
    ]
    assert len(circles) == 4 and np.ptp(ratios) < 0.01 * np.mean(ratios)
    assert drawing.count('stroke-width="4.5"') == len(linkage.bodies)
    assert all(f">{body.name}<" in drawing for body in linkage.bodies)


def test_the_gallery_page_draws_every_model():
    from generated_pages import gallery_pages

    pages = gallery_pages()
    names = {path.stem for path in (ROOT / "urdf_models").glob("*.urdf")}
    shown = set(re.findall(r'<img src="gallery/(\w+)\.svg"', pages["reference/gallery.md"]))
    assert shown == names == {Path(p).stem for p in pages if p.endswith(".svg")}
    assert "## How to add a model" in pages["reference/gallery.md"]
    for path in pages:
        if path.endswith(".svg"):
            sizes = ElementTree.fromstring(pages[path]).get("viewBox").split()[2:]
            links = re.sub("<g .*?</g>", "", pages[path])  # slides have axes of their own
            points = re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", links)
            assert np.all(np.array(points, float) >= 0.0), path
            assert np.all(np.array(points, float) <= np.array(sizes, float)), path


def test_the_index_of_tasks_names_every_verb_and_every_function():
    """A function once, those of the groups too; options of a command exist."""
    row = r"^\| [^|]+ \|([^|]*)\|([^|]*)\| (.+) \|$"
    rows = re.findall(row, TEXTS["tasks.md"], re.MULTILINE)
    rows = [row for row in rows if row[0] != " command "]
    verbs, parsers = set(), dict(command_parsers(command_parser(COMMANDS)))
    for command, _, page in rows:
        assert page.startswith("["), page
        for words in map(str.split, re.findall("`(.+?)`", command)):
            verbs.add(words[1])
            parser = parsers.get(" ".join(words[:3])) or parsers[" ".join(words[:2])]
            known = parser.format_help()
            assert all(word in known for word in words if word.startswith("--")), words
    assert verbs == {name.split()[1] for name in parsers if " " in name}
    shown = re.findall(r"`([\w.]+)`", " ".join(python for _, python, _ in rows))
    assert sorted(shown) == sorted(_public_functions())


def _public_functions():
    """Functions of `balance`, and of the modules that it shows, by the names of the index."""
    names = []
    for name in balance.__all__:
        value = getattr(balance, name)
        if inspect.isfunction(value):
            names.append(name)
        elif inspect.ismodule(value):
            inner = {key: getattr(value, key) for key in value.__all__}
            names += [
                f"{name}.{key}" for key, each in inner.items() if inspect.isfunction(each)
            ]
    return names


COMMAND_PARSERS = {
    name.removeprefix("balance "): parser
    for name, parser in command_parsers(command_parser(COMMANDS))
    if " " in name
}


@pytest.mark.parametrize("command", COMMAND_PARSERS)
def test_every_option_has_an_example_that_its_command_reads(command):
    """Each by itself, beside what the command needs; no word is left over."""
    parser = COMMAND_PARSERS[command]
    examples = {name: shlex.split(text) for name, _, text in option_examples(command, parser)}
    needed = [action for action in parser._actions if action.required]
    flags = [max(action.option_strings, key=len) for action in needed if action.option_strings]
    words = ["3" for action in needed if not action.option_strings]
    groups = parser._mutually_exclusive_groups
    required = [
        [max(action.option_strings, key=len) for action in group._group_actions]
        for group in groups
        if group.required
    ]
    for name, example in examples.items():
        more = [examples[flag] for flag in flags if flag != name]
        more += [examples[group[0]] for group in required if name not in group]
        read = parser.parse_args([*words, *example, *chain.from_iterable(more)])
        assert read is not None
    unknown = set(EXAMPLES.get(command, {})) - set(examples)
    assert not unknown


def test_examples_of_options_are_those_of_commands():
    assert set(EXAMPLES) - {"all"} <= set(COMMAND_PARSERS)
    known = {
        max(action.option_strings, key=len)
        for parser in COMMAND_PARSERS.values()
        for action in parser._actions
        if action.option_strings
    }
    assert set(EXAMPLES["all"]) <= known


@NEEDS_MKDOCS
def test_the_brackets_of_a_matrix_grow_with_it():
    """Each matrix and its brackets are a row of their own; brackets in the text stay small."""
    from formulas import with_formulas

    matrix = r"\begin{bmatrix} a & b \\\\ c & d \end{bmatrix}"
    html = with_formulas(rf'<div class="arithmatex">\[f(x) = {matrix} {matrix}\]</div>')
    math = ElementTree.fromstring(html)
    space = "{http://www.w3.org/1998/Math/MathML}"
    rows = [row for row in math.iter(f"{space}mrow") if row.find(f"{space}mtable") is not None]
    assert len(rows) == 2 and math.get("display") == "block"
    for row in rows:
        assert [part.tag.removeprefix(space) for part in row] == ["mo", "mtable", "mo"]
        assert [part.get("stretchy") for part in row] == ["true", None, "true"]
        assert [part.get("form") for part in row] == ["prefix", None, "postfix"]
    assert [mo.get("stretchy") for mo in math.iter(f"{space}mo")].count("false") == 2


def test_sentences_wrap_and_rows_do_not():
    from output_lines import with_wrapped_lines

    verdict = (
        "verdict       infeasible: in every balanced distribution some second moments add up"
    )
    row = "crank   1.3048     -0.05978, -0.14638, 0     166.2        67.78 and more of it here"
    block = (
        '<div class="language-text highlight"><pre><span></span><code>{}\n</code></pre></div>'
    )
    text = "\n".join((verdict, row, "short", "Shaking &lt;force" + 9 * " goes on"))
    html = with_wrapped_lines(block.format(text))
    marked = re.findall(r'<span class="sentence" style="--column: (\d+)ch">(.*?)</span>', html)
    lines = text.split("\n")
    assert [(int(column), line) for column, line in marked] == [(14, lines[0]), (0, lines[3])]
    unmarked = re.sub(r'<span class="sentence"[^>]*>(.*?)</span>', r"\1", html)
    assert unmarked == block.format(text)
    assert with_wrapped_lines("<p>verdict</p>") == "<p>verdict</p>"


def test_a_page_finds_the_files_beside_it(tmp_path):
    beside, folder = tmp_path / "docs", tmp_path / "run"
    for path in (beside, folder):
        path.mkdir()
    for name in ("load.csv", "other.csv"):
        (beside / name).write_text("time\n", encoding="utf-8")
    code = "from pathlib import Path\nprint(Path('load.csv').read_text(encoding='utf-8'))"
    text = f"[The load](load.csv).\n\n```python\n{code}\n```\n\n```text\ntime\n```\n"
    run_page(text, folder, beside)
    assert [path.name for path in folder.iterdir()] == ["load.csv"]
