"""Draw the machine of each tutorial.

``python docs/draw_machines.py`` writes ``docs/tutorials/machines/NAME.svg``: the linkage of a
file that the page shows or makes, or of a model of the gallery.
"""

from __future__ import annotations

import shlex
import sys
import tempfile
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE / "hooks"))

from code_blocks import code_blocks, command_lines  # noqa: E402

import balance  # noqa: E402
from balance.app.answers.html.linkage_drawing import linkage_drawing  # noqa: E402
from balance.app.cli.main import main as command  # noqa: E402

TUTORIALS = HERE / "tutorials"
# Page, name of the picture, and the file on that page or the model of the gallery.
MACHINES = (
    ("counterweights", "four_bar_general", "four_bar_general"),
    ("desk_lamp", "lamp", "lamp.urdf"),
    ("desk_lamp", "anglepoise", "anglepoise.urdf"),
    ("exoskeleton_leg", "leg", "leg.urdf"),
    ("flexible_coupler", "strip", "strip.urdf"),
    ("formulas", "shaper", "shaper.urdf"),
    ("four_bar_from_nothing", "four_bar", "four_bar.urdf"),
    ("parallel_robot", "robot", "robot.urdf"),
    ("pick_and_place", "scara", "scara.urdf"),
    ("space_arm", "arm", "arm.urdf"),
    ("special_geometries", "slider_crank", "slider_crank"),
    ("sweep_overnight", "four_bar_kite", "four_bar_kite"),
    ("which_masses", "five_bar", "five_bar"),
)


def machine(page: str, model: str) -> str:
    """Draw the linkage of a file that a page shows, or of a model of the gallery."""
    text = (TUTORIALS / f"{page}.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder, chdir(folder), redirect_stdout(StringIO()):
        for block in code_blocks(text):
            if block.title and not block.title.endswith((".yaml", ".toml")):
                Path(block.title).write_text(block.text, encoding="utf-8")
            for line in command_lines(block.text) if block.language == "sh" else ():
                if line.startswith("balance new "):
                    command(shlex.split(line)[1:])
        path = Path(folder) / model
        return linkage_drawing(balance.load(path if path.exists() else model))


def main() -> None:
    """Write the pictures."""
    folder = TUTORIALS / "machines"
    folder.mkdir(exist_ok=True)
    for page, name, model in MACHINES:
        (folder / f"{name}.svg").write_text(machine(page, model), encoding="utf-8")
        print(f"{page}: machines/{name}.svg")


if __name__ == "__main__":
    main()
