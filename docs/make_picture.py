"""Draw the picture of the README: a four-bar as drawn and balanced, and its shaking loads.

``python docs/make_picture.py`` writes ``docs/shaking.svg``; it needs the extra ``plot``. The
four-bar is one of the gallery; its masses are designed as by the command of the start page, and
both follow one motion. Force and moment come from `balance.verify`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import balance
from balance.app.answers.html.plot_style import image, tidy
from balance.motion.verification.verify_motions import verify_second
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics

MODEL = "four_bar_antiparallelogram"
DENSITY, THICKNESS = 7850.0, 0.02  # of the links: steel, 20 mm
LEAST = {"coupler": (0.5, 5.0)}  # kg
# Colours that can be read on white and on black: a viewer may follow no scheme.
COLOURS = {"as drawn": "#d06a10", "balanced": "#3a86c8"}
GREY = "#7c858d"
GHOSTS = (-0.5, -0.25, 0.25, 0.5)  # displacements of the crank, rad


def joints_of_bodies(linkage):
    """List the joints of each body: the one that carries it, and those that it carries."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    return [
        [
            joint
            for j, joint in enumerate(linkage.joints)
            if body.link in (welded.get(j, j), joint.parent)
        ]
        for body in linkage.bodies
    ]


def corners(linkage, u):
    """Compute link ends (bodies, 2, 3) and centres of mass (bodies, 3) at a crank angle u."""
    H = forward_kinematics(si_chain(linkage, spatial=True), joint_positions(linkage, [u])).H
    ends, centres = [], []
    for body, joints in zip(linkage.bodies, joints_of_bodies(linkage), strict=True):
        points = [joint.point for joint in joints[:2]]
        points.append(balance.bodies.mass_properties(body.inertia).com)
        *pair, centre = (H[body.link, :3, :3] @ p + H[body.link, :3, 3] for p in points)
        ends.append(pair)
        centres.append(centre)
    return np.array(ends), np.array(centres)


def draw_linkage(ax, name, linkage):
    """Draw the links at several poses, and the mass of each as a disc of steel in scale."""
    colour = COLOURS[name]
    for u in (*GHOSTS, 0.0):
        ends, centres = corners(linkage, u)
        strong = u == 0.0
        for pair in ends:
            ax.plot(
                *pair[:, :2].T,
                color=colour,
                lw=3.0 if strong else 1.0,
                alpha=1.0 if strong else 0.25,
                solid_capstyle="round",
            )
    for body, centre in zip(linkage.bodies, centres, strict=True):
        radius = np.sqrt(body.inertia[0] / (DENSITY * THICKNESS) / np.pi)
        ax.add_patch(_disc(centre, radius, colour))
        label = ax.annotate(
            f"{body.inertia[0]:.2g} kg",
            centre[:2],
            xytext=(7, -10),
            fontsize=8,
            color=GREY,
            textcoords="offset points",
        )
        label.set_in_layout(False)
    ax.plot(*ends.reshape(-1, 3)[:, :2].T, "o", ms=5, mfc=GREY, mec=GREY)
    ax.set(aspect="equal", xlim=(-0.2, 1.3), ylim=(-0.6, 0.75), title=name)
    ax.title.set_color(GREY)
    ax.axis("off")


def _disc(centre, radius, colour):
    from matplotlib.patches import Circle

    return Circle(centre[:2], radius, color=colour, alpha=0.6, lw=0, zorder=3)


def draw_loads(axes, runs):
    """Plot the size of the shaking force and moment over time."""
    for ax, part, unit in zip(axes, ("force", "moment"), ("N", "N m"), strict=True):
        for name, run in runs.items():
            ax.plot(run.trajectory.time, run.sizes(part), color=COLOURS[name], label=name)
        lowest = -0.04 * runs["as drawn"].peak(part)
        ax.set(ylabel=f"shaking {part}, {unit}", ylim=(lowest, None))
        tidy(ax)
        ax.grid(color=GREY, alpha=0.3, linewidth=0.6)
        ax.tick_params(colors=GREY)
        ax.yaxis.label.set_color(GREY)
        ax.spines[:].set_color(GREY)
    axes[0].legend(frameon=False, fontsize=8, labelcolor=GREY)
    axes[1].set_xlabel("time, s", color=GREY)


def picture():
    """Design, and compute the loads of both; return the picture and a line of text."""
    drawn = balance.load(MODEL)
    best = balance.design(drawn, "mass", bounds=LEAST, density=DENSITY, thickness=THICKNESS)
    linkages = {"as drawn": drawn, "balanced": balance.load(best.to_urdf())}
    first = balance.verify(drawn)
    second = verify_second(first, linkages["balanced"])
    shown = first.plotted
    runs = {"as drawn": first.runs[shown], "balanced": second.runs[shown]}

    def draw(figure):
        left, middle, right = figure.subfigures(1, 3, width_ratios=(1.0, 1.0, 1.15))
        for part, (name, linkage) in zip((left, middle), linkages.items(), strict=True):
            draw_linkage(part.subplots(), name, linkage)
        draw_loads(right.subplots(2, 1, sharex=True), runs)

    line = (
        f"peak force {first.force:.3g} N and {second.force:.2g} N, "
        f"peak moment {first.moment:.3g} N m and {second.moment:.2g} N m"
    )
    return image((9.0, 3.2), "svg", draw), line


def main():
    """Write the picture."""
    path = Path(__file__).with_name("shaking.svg")
    content, line = picture()
    path.write_bytes(content)
    print(f"{path.name}: {line}")


if __name__ == "__main__":
    main()
