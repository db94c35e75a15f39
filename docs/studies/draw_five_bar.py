"""Compute the study of five-bars, print its best rows, and draw their masses.

``python docs/studies/draw_five_bar.py`` writes ``docs/studies/five_bar.svg`` in about a minute;
it needs the extra ``plot``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import balance
from balance.app.answers.html.plot_style import image, tidy

HERE = Path(__file__).resolve().parent
SHOWN = ("base", "left_lower.length", "left_upper.length", "added_mass", "inertia_u1")
BEST = 5


def best_rows(table):
    """List the numbers of the rows with the least balance mass, the least first."""
    mass = table["added_mass"]
    return [row for row in np.argsort(mass, kind="stable").tolist() if mass[row] > 0.0][:BEST]


def print_table(table, rows):
    """Print the best rows, and why the others have no answer."""
    print("| base m | lower m | upper m | balance mass kg | input inertia kg m² |")
    print("|---|---|---|---|---|")
    for row in rows:
        print("|", " | ".join(f"{table[name][row]:.4g}" for name in SHOWN), "|")
    for reason, count in table.reasons.items():
        print(f"{count:6d} {reason}")


def draw(table, best, figure):
    """Draw the balance mass by the lengths of the links, at the base of the best row."""
    base, lower, upper, mass, _ = (table[name] for name in SHOWN)
    at = base == base[best]
    missing, found = at & np.isnan(mass), at & ~np.isnan(mass)
    axes = figure.subplots()
    axes.scatter(
        lower[missing],
        upper[missing],
        s=14,
        marker="x",
        c="#bbbbbb",
        lw=0.8,
        label="does not fit, reach or transmit",
    )
    points = axes.scatter(
        lower[found], upper[found], s=42, marker="s", c=mass[found], cmap="viridis"
    )
    axes.plot(
        lower[best],
        upper[best],
        "o",
        ms=11,
        mfc="none",
        mec="#b8550a",
        mew=2.0,
        ls="",
        label=f"least: {mass[best]:.2f} kg",
    )
    figure.colorbar(points, ax=axes, label="balance mass, kg")
    axes.set(
        xlabel="lower link, m",
        ylabel="upper link, m",
        title=f"five-bars with motors {base[best]:.2g} m apart",
    )
    axes.legend(loc="lower left", fontsize=8)
    tidy(axes)


def main():
    """Compute, print and draw."""
    table = balance.studies.read_study(HERE / "five_bar_footprint.toml").run(workers=2)
    rows = best_rows(table)
    print_table(table, rows)
    picture = image((6.4, 4.2), "svg", lambda figure: draw(table, rows[0], figure))
    (HERE / "five_bar.svg").write_bytes(picture)


if __name__ == "__main__":
    main()
