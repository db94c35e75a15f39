"""Pages, pictures and table of partial balance."""

from __future__ import annotations

from typing import Any

import numpy as np

from balance.app.answers.html.added_matter import added_matter_page
from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.render import facts_list, rows_table
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.html.verification import verification_picture
from balance.app.answers.text.partial_balance import (
    front_facts,
    front_rows,
    part_word,
    room_sentence,
)
from balance.masses.partial_balance.partial_balance import ParetoFront, PartialBalance
from balance.motion.verification.before_after import BeforeAfter, compare_masses
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

# Most inputs with a line of their own; of more, those with the largest values.
MOST_LINES = 6
# Height of the axes over the largest value.
HEADROOM = 1.1


def front_page(front: ParetoFront) -> str:
    """Render designs that let a linkage shake least as one HTML file.

    It shows the last design as `counterweights_page` does, and the others in a table. Peaks
    stand below the sentence if that has root mean squares, for the curves show peaks. The
    element ``report`` contains `ParetoFront.to_dict` as JSON.

    Returns:
        The text of the file.

    Raises:
        LinkageError: the loads cannot be computed; see `balance.verify`.
    """
    best = front.designs[-1]
    assert best.z is not None
    loads, summary = loads_of(best), f"{best.sentence} {room_sentence(best)}".rstrip()
    if front.minimise != "peak":
        summary += f" Peaks of the curves: {loads.words[0].lower()}{loads.words[1:]}."
    return added_matter_page(
        best.space,
        best.z,
        best.regions,
        best.weights,
        loads,
        summary=summary,
        report=front.to_dict(),
        facts=facts_list(front_facts(front)),
        front=front_section(front),
        nothing="none",
        how=part_word(best),
    )


def loads_of(design: PartialBalance) -> BeforeAfter:
    """Compute the loads along the motions of a design, before and after its matter is added.

    Raises:
        LinkageError: see `balance.verify`.
    """
    assert design.z is not None
    return compare_masses(
        design.space.linkage,
        design.z,
        motions=design.motions,
        balance=design.space.balance,
        about=design.point,
    )


def partial_balance_page(balance: PartialBalance) -> str:
    """Render one design that lets a linkage shake least; see `front_page`."""
    return front_page(balance.front)


def partial_balance_picture(balance: PartialBalance, kind: str = "png") -> bytes:
    """Draw the loads along motions before and after."""
    masses = "with the masses given", "with the added matter"
    return verification_picture(*loads_of(balance).pair, kind=kind, masses=masses)


def front_picture(front: ParetoFront, kind: str = "png") -> bytes:
    """Draw a front as an image.

    The panels on the left show the root mean square of the shaking force, the shaking moment
    and, with an elastic frame, the vibration. Those on the right show the inertia and the peak
    drive torque of each input, relative to those of the file.
    """
    shown = [design for design in front.designs if design.shaking is not None]
    mass = np.array([design.mass for design in shown])
    shaking_panels = [
        ("shaking force (N, rms)", "force"),
        ("shaking moment (N m, rms)", "moment"),
    ]
    if front.frame is not None:
        shaking_panels.append(("vibration of the frame (m, rms)", "vibration"))
    input_panels = [
        ("inertia felt, of that in the file", "inertia"),
        ("peak torque, of that in the file", "torque"),
    ]

    def draw(figure: Any) -> None:
        axes = figure.subplots(len(shaking_panels), 2, sharex=True, squeeze=False)
        for ax, (title, name) in zip(axes[:, 0], shaking_panels, strict=True):
            ax.plot(
                mass,
                [getattr(design.shaking, name) for design in shown],
                "o-",
                ms=3,
                color=COLOURS[0],
            )
            _label(ax, title)
        for ax, (title, name) in zip(axes[:, 1], input_panels, strict=False):
            _draw_inputs(ax, mass, shown, name)
            _label(ax, title)
        for ax in axes[len(input_panels) :, 1]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("added mass (kg)")
        axes[0, 0].set_title(front.designs[0].space.linkage.name, loc="left")

    return image((9.0, 2.8 * len(shaking_panels)), kind, draw)


def front_section(front: ParetoFront) -> str:
    """Render the table of several designs; nothing for a single one."""
    if len(front.designs) == 1:
        return ""
    return (
        '<section>\n<h2>What each kilogram buys</h2>\n<p class="note">Root mean squares of '
        "shaking force and moment. The page shows the last one.</p>\n"
        f'<div class="scroll">\n{rows_table(front_rows(front), range(6))}\n</div>\n</section>'
    )


def _label(ax: Any, title: str) -> None:
    """Give axes a title, a grid and a scale from zero."""
    tidy(ax)
    ax.set_ylabel(title)
    ax.set_ylim(0.0, HEADROOM * ax.dataLim.y1 or None)


def _draw_inputs(ax: Any, mass: Array, shown: list[PartialBalance], name: str) -> None:
    """Draw a line for each input, relative to the value of the file."""
    given = getattr(shown[0].given, name)
    lines = {}
    for key, before in given.items():
        if before > 0.0:
            lines[key] = [getattr(design.shaking, name)[key] / before for design in shown]
    names = list(lines)
    ranks = rank_least_first([-max(line) for line in lines.values()])
    largest = [names[k] for k in ranks[:MOST_LINES]]
    for key, colour in zip(largest, COLOURS * MOST_LINES, strict=False):
        ax.plot(mass, lines[key], "o-", ms=3, color=colour, label=key)
    ax.legend(fontsize=8, frameon=False)
