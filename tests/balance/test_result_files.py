"""Python from end to end: load, design, write the file, verify, draw."""

import inspect
import json
import re

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers import result_files
from balance.support.result_files import Picture, WithPage, WithPicture
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import find

KITE = "four_bar_kite"


@pytest.fixture(scope="module")
def best():
    return balance.design(KITE, "mass", bounds={"coupler": (0.001, 1.0)})


def test_a_linkage_comes_from_its_name_its_file_and_its_text():
    """A text has no file beside it, and no other name."""
    path = find(KITE)
    named = balance.load(KITE)
    for given in (path, str(path), path.read_text("utf-8"), path.read_bytes()):
        linkage = balance.load(given)
        np.testing.assert_array_equal(linkage.frames, named.frames)
        assert linkage.inputs == named.inputs
    assert linkage.source == "<text>" and balance.load is kinematics.load
    with pytest.raises(kinematics.errors.FileError, match="<text>"):
        balance.load("<robot name='half'>")


def test_functions_take_a_name_a_linkage_or_a_space():
    linkage, space = balance.load(KITE), balance.design_space(KITE)
    masses = [balance.design(given).z for given in (KITE, linkage, space)]
    np.testing.assert_array_equal(masses[0], masses[1])
    np.testing.assert_array_equal(masses[0], masses[2])
    levels = {balance.certify(given).certainty.level for given in (KITE, linkage, space)}
    assert len(levels) == 1
    regressors = [
        balance.momentum.momentum_regressor(given, {"u1": 0.2})
        for given in (KITE, linkage, space)
    ]
    np.testing.assert_array_equal(regressors[0], regressors[2])
    assert balance.explain(KITE).transfers[0].words == balance.explain(space).transfers[0].words


def test_the_file_of_a_design_is_balanced(best, tmp_path):
    """Read again, its masses are in the space of the geometry, and those of the design."""
    path = tmp_path / "balanced.urdf"
    data = best.to_urdf(path)
    assert path.read_bytes() == data
    written = balance.design_space(path)
    assert written.can_balance.verdict == "as_given"
    np.testing.assert_allclose(
        [body.inertia for body in written.linkage.bodies], best.z, atol=1e-12
    )


def test_the_file_of_counterweights_has_the_added_mass(tmp_path):
    space = balance.design_space("four_bar_general", balance="force")
    weights = balance.counterweights(space, ["crank", "rocker"])
    for merge in (False, True):
        linkage = balance.load(weights.to_urdf(tmp_path / "heavier.urdf", merge=merge))
        total = sum(body.inertia[0] for body in linkage.bodies)
        assert total == pytest.approx(weights.given_mass + weights.added_mass, rel=1e-12)


def test_pages_are_returned_and_written(best, tmp_path):
    path = tmp_path / "page.html"
    page = best.to_html(path)
    assert path.read_text("utf-8") == page and page.startswith("<!DOCTYPE html>")
    assert best.space.can_balance.sentence in best.space.to_html()


def test_where_there_is_nothing_to_show_nothing_is_written(best, tmp_path):
    none = balance.design("four_bar_general")
    for write, name in (
        (none.to_urdf, "a.urdf"),
        (none.to_html, "a.html"),
        (none.plot, "a.png"),
    ):
        with pytest.raises(UsageError, match="infeasible"):
            write(tmp_path / name)
    with pytest.raises(UsageError, match="ends in .png or .svg"):
        best.plot(tmp_path / "picture.gif")
    assert not list(tmp_path.iterdir())


def test_files_are_echoed_in_one_line(best):
    """An interpreter shows no pages of characters; the contents stay bytes and text."""
    data, page, model = best.to_urdf(), best.to_html(), best.space.linkage.to_urdf()
    assert repr(data) == f"<{len(data)} bytes of a file; .decode() gives its text>"
    assert data.decode().startswith("<?xml")
    for text in (page, model):
        assert repr(text) == f"<text of a file, {len(text)} characters; print shows it>"
        assert str(text) == text and text.startswith("<")
    assert repr(Picture(b"\x89PNG")) == "<PNG picture, 4 bytes>"
    assert repr(Picture(b"<?xml")) == "<SVG picture, 5 bytes>"


@pytest.mark.slow
def test_pictures_are_those_of_the_path(best, tmp_path):
    """A design is drawn by its loads before and after; notebooks show what is returned."""
    for name, head in (("shaking.svg", b"<?xml"), ("shaking.png", b"\x89PNG")):
        picture = best.plot(tmp_path / name)
        assert isinstance(picture, Picture) and picture.startswith(head)
        assert (tmp_path / name).read_bytes() == picture
        assert (picture._repr_png_() is None) == (picture._repr_svg_() is not None)


@pytest.mark.parametrize(
    ("kind", "maker", "least"),
    [(WithPage, "page_maker", 9), (WithPicture, "picture_maker", 8)],
)
def test_every_result_with_a_page_or_a_picture_names_what_makes_it(kind, maker, least):
    """The function takes results of the class, and may take a kind of picture besides."""
    modules = (balance, balance.motion, balance.flexible)
    values = [getattr(module, name) for module in modules for name in module.__all__]
    classes = {value for value in values if isinstance(value, type) and issubclass(value, kind)}
    assert len(classes) >= least
    for cls in classes:
        function = result_files.maker_of(getattr(cls, maker))
        first, *others = inspect.signature(function).parameters.values()
        assert first.annotation in [base.__name__ for base in cls.__mro__], cls
        assert ("kind" in [other.name for other in others]) == (kind is WithPicture), cls


@pytest.fixture(scope="module")
def table():
    """A sweep with a drop of the rank, and geometries that do not close."""
    return balance.sweep(
        "four_bar_kite",
        {"coupler.length": "0.5:2.0:4", "rocker.length": [0.9, 5.0]},
        quantities=["rank", "singular_values"],
    )


@pytest.mark.lanes
def test_a_sweep_has_the_page_of_a_file_of_its_results(table, tmp_path):
    """The rows on the page of the table are those of the page of `balance sweep show`."""
    from balance.app.answers.html.sweep import sweep_page
    from balance.studies.runs.chunk_runs import run_chunks
    from balance.studies.runs.results_file import ResultsFile

    with ResultsFile.create(tmp_path / "sweep.db", table.job) as file:
        run_chunks(table.job, file, workers=0)
        shown = page_data(sweep_page(file))
    path = tmp_path / "sweep.html"
    page = table.to_html(path)
    assert path.read_text("utf-8") == page and str(tmp_path) not in page
    assert page_data(page) == shown


def page_data(page):
    """The object that a page of a sweep draws."""
    (text,) = re.findall(r'<script[^>]*id="sweep"[^>]*>(.*?)</script>', page, re.DOTALL)
    return json.loads(text)


@pytest.mark.lanes
def test_columns_of_a_sweep_are_plain_data(table):
    """None where a geometry has no answer, and nothing that JSON does not have."""
    data = json.loads(json.dumps(table.to_dict(), allow_nan=False))
    closed = np.array(data["columns"]["closed"], dtype=bool)
    assert closed.any() and not closed.all()
    assert [rank is None for rank in data["columns"]["rank"]] == [not each for each in closed]
    assert sum(data["reasons"].values()) == (~closed).sum()


@pytest.mark.slow
def test_pictures_of_a_sweep_name_their_columns(table, tmp_path):
    texts = {}
    for name, columns in (("a.svg", ()), ("b.svg", ("rank", "kept"))):
        texts[name] = table.plot(tmp_path / name, columns).decode()
    assert "<!-- coupler.length (m) -->" in texts["a.svg"]
    assert "<!-- rank -->" in texts["b.svg"]
    with pytest.raises(UsageError, match="no column 'ghost'; the columns are"):
        table.plot(columns=("rank", "ghost"))


def test_only_public_names_are_listed():
    assert dir(balance) == sorted(balance.__all__)


@pytest.mark.slow
def test_panels_of_two_sets_of_masses_say_which(tmp_path):
    space = balance.design_space("four_bar_general", balance="force")
    answers = {
        "with the designed masses": balance.design(space, "mass"),
        "with counterweights": balance.counterweights(space, ["crank", "rocker"]),
        "with the added matter": balance.partial(space, ["crank", "rocker"], 0.5),
    }
    for words, answer in answers.items():
        answer.plot(tmp_path / "a.svg")
        text = (tmp_path / "a.svg").read_text(encoding="utf-8")
        heads = ("with the masses given", words)
        assert [text.count(f"<!-- four_bar_general {head}") for head in heads] == [1, 1]
