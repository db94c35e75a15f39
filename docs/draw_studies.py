"""Draw the pictures of the studies of machines: linkages, masses, and what shakes.

``python docs/draw_studies.py [NAME…]`` writes ``docs/machines/NAME.svg``; it needs the extra
``plot``. A disc is as large as the mass of its body is, about the centre of mass.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import balance
import kinematics
from balance.app.answers.html.plot_style import image, tidy
from balance.motion.verification.to_pinocchio import verify_second
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics

FOLDER = Path(__file__).with_name("machines")
COLOURS = ("#b8550a", "#08264a")


@dataclass(frozen=True)
class Machine:
    """What a picture shows.

    Attributes:
        files: two files of one machine, by what they are called.
        plane: the two coordinates that are drawn, to the right and upwards.
        ghosts: displacements of the inputs, drawn faintly.
        density: of the discs, kg per square metre.
        at: the pose that is drawn, positions of inputs.
        motion: arguments of `balance.verify`.
    """

    files: dict[str, str]
    plane: tuple[int, int]
    ghosts: tuple[tuple[float, ...], ...]
    density: float
    at: dict[str, float] = field(default_factory=dict)
    motion: dict[str, object] = field(default_factory=dict)


MACHINES = {
    "engine": Machine(
        {"as it is": "engine.urdf", "with the book's weight": "engine_book.urdf"},
        (0, 1),
        ((-0.5,), (-0.25,), (0.25,), (0.5,)),
        3000.0,
        motion={"speed": "240rpm"},
    ),
    "forbal": Machine(
        {"without weights": "forbal2_bare.urdf", "with its rings": "forbal2.urdf"},
        (0, 2),
        ((-0.3, -0.3), (-0.6, -0.6), (0.3, -0.3), (-0.3, 0.3)),
        300.0,
        motion={"trajectories": 1, "seed": 3},
    ),
}


def joints_of_links(linkage):
    """List the joints of each moving link: the one that carries it, and those that it carries."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    joints = {}
    for j, joint in enumerate(linkage.joints):
        for link in {welded.get(j, j), joint.parent}:
            joints.setdefault(link, []).append(joint.point)
    return {link: points for link, points in joints.items() if link >= 0}


def draw_linkage(ax, title, linkage, machine, colour):
    """Draw the links at several poses, and a disc for the mass of each body."""
    from matplotlib.patches import Circle

    plane = list(machine.plane)
    still = (0.0,) * len(linkage.inputs)
    chain = si_chain(linkage, spatial=True)

    def line(ends, **style):
        ax.plot(*np.array(ends).T, color=colour, solid_capstyle="round", **style)

    for u in (*machine.ghosts, still):
        H = forward_kinematics(chain, joint_positions(linkage, list(u))).H
        for link, points in joints_of_links(linkage).items():
            placed = [(H[link, :3, :3] @ p + H[link, :3, 3])[plane] for p in points]
            for joint in placed[1:]:
                style = {"lw": 2.6} if u == still else {"lw": 0.9, "alpha": 0.2}
                line((placed[0], joint), **style)
            if u == still:
                ax.plot(*np.array(placed).T, "o", ms=4, mfc="white", mec="#1b1e22")
    carried = joints_of_links(linkage)
    for body in linkage.bodies:
        mass = body.inertia[0]
        centre = balance.bodies.mass_properties(body.inertia).com[plane]
        line((carried[body.link][0][plane], centre), lw=1.0, ls=":")
        radius = np.sqrt(mass / machine.density / np.pi)
        ax.add_patch(Circle(centre, radius, color=colour, alpha=0.45, lw=0, zorder=3))
        ax.annotate(
            f"{mass:.3g} kg",
            centre,
            xytext=(0, 7),
            fontsize=7,
            color=colour,
            textcoords="offset points",
            ha="center",
        )
    ax.set(aspect="equal", title=title)
    ax.margins(0.12)
    ax.axis("off")


def draw_loads(axes, runs):
    """Plot the size of the shaking force and moment over time."""
    for ax, part, unit in zip(axes, ("force", "moment"), ("N", "N m"), strict=True):
        for (name, run), colour in zip(runs.items(), COLOURS, strict=True):
            ax.plot(run.trajectory.time, run.sizes(part), color=colour, label=name)
        ax.set(ylabel=f"shaking {part}, {unit}", ylim=(0.0, None))
        tidy(ax)
    axes[0].legend(frameon=False, fontsize=8)
    axes[1].set_xlabel("time, s")


def picture(machine):
    """Compute the loads of both files of a machine; return the picture."""
    linkages = {
        name: kinematics.load(FOLDER / file, at=machine.at or None)
        for name, file in machine.files.items()
    }
    first, second = linkages.values()
    before = balance.verify(first, **machine.motion)
    after = verify_second(before, second, **machine.motion)
    runs = dict(zip(linkages, (before.runs[0], after.runs[0]), strict=True))

    def draw(figure):
        *parts, right = figure.subfigures(1, 3, width_ratios=(1.0, 1.0, 1.15))
        for part, (name, linkage), colour in zip(
            parts, linkages.items(), COLOURS, strict=True
        ):
            draw_linkage(part.subplots(), name, linkage, machine, colour)
        draw_loads(right.subplots(2, 1, sharex=True), runs)

    return image((9.0, 3.0), "svg", draw)


def main():
    """Write the pictures that are named, or all."""
    for name in sys.argv[1:] or MACHINES:
        (FOLDER / f"{name}.svg").write_bytes(picture(MACHINES[name]))


if __name__ == "__main__":
    main()
