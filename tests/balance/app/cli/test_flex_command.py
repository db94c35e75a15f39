"""The command ``balance flex``: JSON by its schema, files that are written, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer
from tests.support.page_elements import Elements, without_breaks

ARM = "length:0.1,EI:0.0045,rhoA:0.024,tip:0.01,radius:0.01,hub:0.01,inertia:1e-7"
FAST = ["--duration", "0.2", "--samples", "5", "--elements", "4", "--modes", "1"]


def run(capsys, *words):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "flex", *words)


@pytest.mark.slow
def test_modes_and_supports(capsys, tmp_path):
    picture = tmp_path / "modes.svg"
    code, found = run(capsys, "modes", "--count", "3", "--plot", str(picture))
    assert code == 0 and len(found["modes"]) == 3 and picture.stat().st_size > 1000
    beam = ["modes", "--beam", "length:1,EI:1,rhoA:1", "--count", "2"]
    code, found = run(capsys, *beam, "--pin", "0", "--pin", "1", "--plot", str(picture))
    assert found["frequencies"] == pytest.approx([1.5707963, 6.2831853], rel=1e-6)
    code, found = run(capsys, *beam, "--pin", "0.1*0.5+0.3*0.5", "--clamp", "1")
    assert code == 0 and found["frequencies"][0] > 1.0
    code, found = run(capsys, "supports", "4", "--plot", str(tmp_path / "supports.png"))
    assert found["hinge"] == pytest.approx(0.255872813, abs=5e-10)


@pytest.mark.slow
def test_similar_arms(capsys, tmp_path):
    code, found = run(capsys, "similar", "--arm", ARM, "--scale", "0.5")
    assert code == 0 and found["similar"] and found["motion"] is None
    picture = tmp_path / "shaking.png"
    words = ["--spin", "10,0.02,0.03", "--plot", str(picture)]
    code, found = run(capsys, "similar", "--arm", ARM, "--against", ARM, *words)
    assert found["motion"]["peak_force"] < 1e-8 and picture.stat().st_size > 1000
    assert main(["flex", "similar", "--arm", ARM, "--scale", "0.5"]) == 0
    assert "similar" in capsys.readouterr().out


BLOCK = "pitch:0.1,mass:0.02,length:0.12,breadth:0.02"


@pytest.mark.slow
def test_translators(capsys, tmp_path):
    """Equal translators on both sides are in perfect balance; the answer is drawn and told."""
    picture = tmp_path / "shaking.svg"
    words = ["similar", "--arm", ARM, "--against", ARM, "--translator", BLOCK]
    words += ["--moment", "0.1,0.002,0.004", "--both-hubs", "--plot", str(picture)]
    code, found = run(capsys, *words)
    one = found["translator"]
    assert code == 0 and found["motion"] is None and picture.stat().st_size > 1000
    assert one["blocks"][0] == one["blocks"][1] and one["both_hubs"]
    assert one["displacement"][1] > 1e-6 and one["alone"]["peak_force"] > 1e-4
    assert one["pair"]["peak_force"] < 1e-8 < 1e-2 * one["pair"]["peak_moment"]
    assert main(["flex", *words]) == 0
    assert "half of it on each hub" in capsys.readouterr().out


def test_modes_are_enough_for_the_supports(capsys, caplog):
    """A warning of fewer than twice the supports: the first modes do not shake the mount."""
    for more, told in (([], False), (["--modes", "6"], True), (["--modes", "8"], False)):
        words = ["simulate", "four_bar_kite", "--flex", "coupler=EI:50,rhoA:1,supports:4"]
        assert main(["flex", *words, "--duration", "0.01", "--samples", "2", *more]) == 0
        assert ("few_modes" in caplog.text) == told
        assert f", {more[1] if more else 10} modes" in capsys.readouterr().out
        caplog.clear()


def test_a_wrong_word_leads_to_the_help_of_its_command(capsys):
    assert main(["flex", "modes", "--no-such"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "balance flex modes: error: unrecognized arguments: --no-such",
        "balance flex modes --help lists what there is",
    ]


@pytest.mark.slow
def test_a_linkage_of_the_gallery(capsys, tmp_path):
    page, picture = tmp_path / "page.html", tmp_path / "shaking.svg"
    words = ["simulate", "four_bar_kite", "--flex", "coupler=rect(0.02,0.02),steel", *FAST]
    code, found = run(capsys, *words, "--html", str(page), "--plot", str(picture))
    assert code == 0 and found["energy_drift"] < 1e-5
    assert found["beams"][0]["link"] == "coupler" and len(found["times"]) == 5
    text = page.read_text("utf-8")
    assert '"schema": "balance.flex/1"' in text and 'id="bend"' in text
    elements = Elements(text)
    # The controls of the other pages: a bar with sliders and Play.
    names = {value for _, name, value in elements.attributes if name == "id"}
    assert {"controls", "time", "now", "scale", "play"} <= names
    frames = elements.data("frames")
    (x0, x1), (y0, y1) = frames["box"]
    for beam in (*frames["straight"][0], *frames["bent"][0]):
        assert all(x0 < x < x1 and y0 < y < y1 for x, y in beam)
    # The first drawing shows the bending, and not more than a tenth of the linkage.
    apart = np.subtract(frames["bent"], frames["straight"])
    shown = 10 ** frames["exponent"] * np.abs(apart).max() / (x1 - x0)
    assert 0.01 < shown < 0.1
    # The beam of the coupler is as long as its joints are apart, and bends less than is seen.
    lengths = [np.hypot(*np.subtract(line[-1], line[0])) for line in frames["straight"][0]]
    assert max(lengths) == pytest.approx(found["beams"][0]["length"], rel=1e-3)
    deflection = f"{1e3 * found['beams'][0]['peak_deflection']:.3g} mm"
    assert deflection in without_breaks(elements.text.partition("Motion")[0])
    assert "https://" not in text.partition("<script>")[0]
    assert (
        main(["flex", *words, "--damping", "1e-6", "--linear", "--drive", "u1=moment:0.1,0.1"])
        == 0
    )
    assert "shaking force" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["modes", "--pin", "0"], 2, "--pin, --clamp and --tip need --beam"),
        (["modes", "--beam", "length:1,EI:-1,rhoA:1"], 2, "bending -1 is not positive"),
        (["modes", "--beam", "length:1,EI:1"], 2, "rhoA: is missing"),
        (["modes", "--beam", "length:1,EI:1,rhoA:1", "--pin", "2"], 3, "not on the beam"),
        (["supports", "0"], 2, "from 1 to 40"),
        (["similar", "--arm", ARM, "--scale", "0"], 2, "not a positive number"),
        (["similar", "--arm", ARM, "--scale", "1e308"], 3, "choose one from 1e-06 to 1e+06"),
        (["similar", "--arm", ARM, "--scale", "1e-308"], 3, "choose one from 1e-06 to 1e+06"),
        (["similar", "--arm", ARM, "--scale", "1", "--plot", "x.png"], 2, "add --spin"),
        (["similar", "--arm", ARM, "--scale", "1", "--translator", BLOCK], 2, "go together"),
        (["similar", "--arm", ARM, "--scale", "1", "--both-hubs"], 2, "needs --translator"),
        (["similar", "--arm", ARM, "--scale", "1", "--translator", "pitch:1"], 2, "missing"),
        (["simulate", "no_such", "--flex", "a=EI:1,rhoA:1"], 3, "no such file"),
        (["simulate", "five_bar", "--flex", "nobody=EI:1,rhoA:1"], 3, "'nobody'"),
        (["simulate", "five_bar", "--flex", "x=EI:-1,rhoA:1"], 2, "not a positive number"),
        (["simulate", "three_rrr", "--flex", "platform=EI:1,rhoA:1"], 3, "not on a line"),
        (["simulate", "three_rsr", "--flex", "lower1=EI:1,rhoA:1"], 3, "not planar"),
        (["simulate", "five_bar", "--flex", "x=EI:1,rhoA:1", "--spatial"], 2, "unrecognized"),
        (["simulate", "five_bar", "--flex", "x=EI:1,rhoA:1", "--drive", "u"], 2, "not JOINT"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(words, code, message, capsys):
    assert main(["flex", *words, "--json"]) == code
    printed = capsys.readouterr()
    assert printed.out == "" and message in printed.err.splitlines()[0]
