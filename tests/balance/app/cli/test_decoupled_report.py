"""``balance report --decoupled`` and ``--pure-inertia``: data, text, page, exit codes."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from jsonschema import validate

from balance import design_space
from balance.app.answers.data import schema
from balance.app.cli.main import main
from balance.masses import pure_inertia
from balance.space import decoupling

MODEL = "two_rrr_bisector"


def report(capsys, *words):
    """Exit code and the JSON that was printed, which fits the schema."""
    code = main(["report", *words, "--json"])
    data = json.loads(capsys.readouterr().out)
    validate(data, schema())
    return code, data


@pytest.mark.parametrize(
    ("model", "order", "exact"),
    [(MODEL, 2, True), ("slider_pantograph", 0, False), ("four_bar_general", None, False)],
)
def test_decoupled_says_order_and_exact(model, order, exact, capsys):
    code, data = report(capsys, model, "--decoupled")
    found = data["decoupled"]
    assert code == 0 and data["pure_inertia"] is None
    assert (found["order"], found["exact"]) == (order, exact)
    answer = decoupling(design_space(model))
    assert found["rank"] == answer.rank and found["nullity"] == answer.nullity
    assert np.shape(found["basis"]) == (data["parameters"], answer.nullity)
    assert found["certainty"] in ("proved", "verified")


def test_pure_inertia_says_what_moves_and_what_stays(capsys):
    code, data = report(capsys, MODEL, "--pure-inertia")
    found = data["pure_inertia"]
    assert code == 0 and data["decoupled"] is None
    assert found["complete"] and found["balanced"] and not found["left"]
    assert found["inertias"]["platform"] == pytest.approx(-2.025)
    _, data = report(capsys, "slider_crank", "--pure-inertia")
    assert "prismatic" in " ".join(item["words"] for item in data["pure_inertia"]["left"])


def test_the_text_has_both(capsys):
    assert main(["report", MODEL, "--decoupled", "--pure-inertia"]) == 0
    text = capsys.readouterr().out
    assert "yes: balanced, and the inertia on the base is constant" in text
    assert re.search(r"platform +-2\.025 kg m²", text)
    for words in pure_inertia(design_space(MODEL)).condition_words:
        assert words in text


def test_the_page_has_both_and_the_masses_of_the_lines(capsys, tmp_path):
    page = tmp_path / "page.html"
    words = ["report", "four_bar_kite_balanced", "--decoupled", "--pure-inertia"]
    assert main([*words, "--html", str(page)]) == 0
    text = page.read_text("utf-8")
    assert "<h2>Decoupled from a moving base</h2>" in text and "<h2>Pure inertias</h2>" in text
    drawing = json.loads(re.search(r'id="scene">(.*?)</script>', text, re.S)[1])
    P = np.array(drawing["pure"])
    assert np.abs(P[:, 3]).max() < 1e-13
    assert np.einsum("bii->b", P[:, :2, :2]) == pytest.approx([0.192, 0.192, -0.192])
    assert main(["report", "four_bar_kite_balanced", "--html", str(page)]) == 0
    assert "<h2>Pure inertias</h2>" not in page.read_text("utf-8")


@pytest.mark.parametrize(
    "words",
    [
        ["five_bar", "--balance", "force", "--decoupled"],
        ["five_bar", "--balance", "force", "--pure-inertia"],
        ["bennett", "--pure-inertia"],
    ],
)
def test_questions_that_do_not_fit_are_refused(words, capsys):
    assert main(["report", *words, "--json"]) == 2
    assert capsys.readouterr().out == ""


def test_nobody_else_pays_for_them():
    code = (
        "import sys; from balance.app.cli.main import main; main(['report', 'four_bar_kite']); "
        "print([n for n in sys.modules if 'decoupled' in n or 'dynamic_equiv' in n])"
    )
    found = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=os.environ | {"BALANCE_COMPILE": "never"},
    )
    assert found.returncode == 0 and found.stdout.splitlines()[-1] == "[]"
