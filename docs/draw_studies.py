"""Draw the pictures of the studies of machines: linkages, masses, and what shakes.

``python docs/draw_studies.py [NAME…]`` writes ``docs/machines/NAME.svg``; it needs the extra
``plot``. A disc is as large as the mass of its body is, about the centre of mass.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import balance
import kinematics
from balance.app.answers.html.plot_style import image, tidy
from balance.motion.verification.verify_motions import verify_second
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics

FOLDER = Path(__file__).with_name("machines")
COLOURS = ("#b8550a", "#08264a")
# Room of a label, to the right and upwards, over the size of the linkage.
LABEL = np.array([0.24, 0.08])


@dataclass(frozen=True)
class Drawing:
    """One linkage as it is drawn.

    Attributes:
        title: of the drawing.
        linkage: at the pose that is drawn.
        plane: the two coordinates that are drawn, to the right and upwards.
        ghosts: displacements of the inputs, drawn faintly.
        density: of the discs, kg per square metre.
    """

    title: str
    linkage: kinematics.Linkage
    plane: tuple[int, int]
    ghosts: tuple[tuple[float, ...], ...]
    density: float


@dataclass(frozen=True)
class Loads:
    """Sizes of the shaking force and moment over time, N and N m."""

    name: str
    time: np.ndarray
    force: np.ndarray
    moment: np.ndarray


def compare(files, plane, ghosts, density, **motion):
    """Draw two files of one machine, and what shakes along one motion."""
    linkages = {name: kinematics.load(FOLDER / file) for name, file in files.items()}
    first, second = linkages.values()
    before = balance.verify(first, **motion)
    after = verify_second(before, second)
    drawings = [
        Drawing(name, linkage, plane, ghosts, density) for name, linkage in linkages.items()
    ]
    loads = [
        Loads(name, run.trajectory.time, run.sizes("force"), run.sizes("moment"))
        for name, run in zip(linkages, (before.runs[0], after.runs[0]), strict=True)
    ]
    return drawings, loads


def engine():
    """The engine without and with the weight of the book, in one revolution."""
    files = {"as it is": "engine.urdf", "with the book's weight": "engine_book.urdf"}
    ghosts = ((-0.5,), (-0.25,), (0.25,), (0.5,))
    return compare(files, (0, 1), ghosts, 3000.0, speed="240rpm")


def clavel_delta():
    """The Delta without weights and with those on arms and one rod, while it carries across."""
    linkage = kinematics.load(FOLDER / "clavel_delta.urdf")
    regions = {
        "arm1": "ball(-0.057,0,0.08216,0.02)",
        "arm2": "ball(0.0285,-0.049363,0.08216,0.02)",
        "arm3": "ball(0.0285,0.049363,0.08216,0.02)",
        "rod1a": "ball(0.09,0,0.12,0.02)",
    }
    answer = balance.counterweights(
        balance.design_space(linkage, None, "force"), list(regions), regions, density=None
    )
    s = np.linspace(0.0, 1.0, 121)
    across = 0.2 * (s**3 * (10 - 15 * s + 6 * s**2) - 0.5)
    table = Path(tempfile.mkdtemp()) / "pick.csv"
    rows = np.column_stack([0.3 * s, across, 0.025 * 64 * s**3 * (1 - s) ** 3])
    np.savetxt(table, rows, "%.12f", ",", header="time,x,z", comments="")
    motion = balance.motion.from_tool_csv(linkage, table, "plate")
    files = {"as printed": "clavel_delta.urdf", "four weights": written("balanced", answer)}
    ghosts = tuple(map(tuple, motion.u[[0, 120]]))
    return compare(files, (0, 2), ghosts, 500.0, motions=[motion])


def double_pendulum():
    """The arm as it was measured and with its weights, in a random motion."""
    files = {
        "as it was measured": "double_pendulum_measured.urdf",
        "with its weights": "double_pendulum_balanced.urdf",
    }
    ghosts = tuple((0.25 * k, 0.35 * k) for k in (-3, -2, -1, 1, 2, 3))
    return compare(files, (1, 2), ghosts, 500.0, trajectories=1, seed=3)


def forbal():
    """Forbal-2 without and with its rings, in a random motion."""
    files = {"without weights": "forbal2_bare.urdf", "with its rings": "forbal2.urdf"}
    ghosts = ((-0.3, -0.3), (-0.6, -0.6), (0.3, -0.3), (-0.3, 0.3))
    return compare(files, (0, 2), ghosts, 300.0, trajectories=1, seed=3)


def written(name, answer):
    """Write the masses of an answer beside nothing else, and return the path."""
    path = Path(tempfile.mkdtemp()) / f"{name}.urdf"
    path.write_bytes(answer.to_urdf())
    return path


def squeezer():
    """The press without weights, and with those for force and moment, in one revolution."""
    linkage = kinematics.load(FOLDER / "squeezer.urdf")
    discs = {"K1": 0.02, "K3": 0.03, "K5": 0.03, "K7": 0.03}
    answer = balance.partial(
        balance.design_space(linkage),
        list(discs),
        0.2,
        regions={link: f"cylinder(0,0,0,0,0,1,{r},0.01)" for link, r in discs.items()},
        density=7850.0,
        motions=balance.motion.one_turn(linkage, 200.0 * np.pi),
    )
    files = {"as it is": "squeezer.urdf", "four weights, 0.2 kg": written("less", answer)}
    ghosts = ((1.2,), (2.4,), (3.6,), (4.8,))
    return compare(files, (0, 1), ghosts, 600.0, speed="6000rpm")


def dual_v():
    """The 4-RRR without and with its counterweights, along a diagonal."""
    linkage = kinematics.load(FOLDER / "dual_v.urdf")
    links = [f"lower{leg}" for leg in (1, 2, 3, 4)]
    sides = zip(links, ((1, 1), (-1, 1), (-1, -1), (1, -1)), strict=True)
    answer = balance.counterweights(
        balance.design_space(linkage, "c1=-a1-b1", "force"),
        links,
        {link: f"ball({0.06 * x},{0.08 * y},0,0.04)" for link, (x, y) in sides},
        density=7850.0,
    )
    files = {"without weights": "dual_v.urdf", "with weights": written("balanced", answer)}
    time = np.linspace(0.0, 0.4, 81)
    way = 0.045 * 64.0 * (time / 0.4) ** 3 * (1.0 - time / 0.4) ** 3
    table = Path(tempfile.mkdtemp()) / "across.csv"
    rows = np.column_stack([time, way, way])
    np.savetxt(table, rows, "%.12f", ",", header="time,x,y", comments="")
    motion = balance.motion.from_tool_csv(linkage, table, "platform")
    return compare(
        files, (0, 1), tuple(map(tuple, motion.u[[20, 40]])), 500.0, motions=[motion]
    )


def quintic(time, swing):
    """Displacements, velocities and accelerations of the quintic law over a swing (N, w)."""
    duration = time[-1]
    s = (time / duration)[:, None]
    return (
        s**3 * (10 - 15 * s + 6 * s**2) * swing,
        30 * s**2 * (1 - s) ** 2 * swing / duration,
        60 * s * (1 - 3 * s + 2 * s**2) * swing / duration**2,
    )


def held_loads(name, linkage, time, motion, point):
    """Compute what shakes a base that is held, the moment about a point."""
    wrench = balance.motion.shaking(linkage, *motion)
    moment = wrench[:, :3] - np.cross(point, wrench[:, 3:])
    return Loads(
        name, time, *(np.linalg.norm(part, axis=1) for part in (wrench[:, 3:], moment))
    )


def ets7():
    """The space arm at both ends of its swing; the quintic law and the least moment."""
    linkage = kinematics.load(FOLDER / "ets7.urdf")
    swing = np.deg2rad([40.0, 50.0, -60.0, 0.0, 0.0, 0.0])
    end = dict(zip(linkage.inputs[:3], swing[:3].tolist(), strict=True))
    plan = balance.quiet_motion(
        linkage, {}, end, 60.0, minimise="moment", measure="peak", about=(0, 0, 0), velocity=0.1
    )
    time, *quiet = plan.samples(241)
    loads = [
        held_loads(name, linkage, time, motion, (0.0, 0.0, 0.0))
        for name, motion in (("quintic law", quintic(time, swing)), ("least moment", quiet))
    ]
    ghosts = tuple(tuple(part * -swing) for part in (0.25, 0.5, 0.75))
    drawings = [
        Drawing("start, from the side", linkage, (0, 2), (), 300.0),
        Drawing("end", kinematics.load(FOLDER / "ets7.urdf", at=end), (0, 2), ghosts, 300.0),
    ]
    return drawings, loads


def cassie_leg():
    """The leg without and with three weights, in one swing."""
    linkage = kinematics.load(FOLDER / "cassie_leg.urdf")
    balls = {"thigh": "0,0,0.15", "knee": "0.12,0,0.16", "crank": "0,0,0"}
    answer = balance.counterweights(
        balance.design_space(linkage, ["hip_roll=0", "hip_yaw=0"], "force"),
        list(balls),
        {link: f"ball({centre},0.1)" for link, centre in balls.items()},
        density=None,
    )
    s = np.linspace(0.0, 1.0, 161)
    hip, knee = 0.8 * s**3 * (10 - 15 * s + 6 * s**2), -0.6 * 64 * s**3 * (1 - s) ** 3
    table = Path(tempfile.mkdtemp()) / "swing.csv"
    rows = np.column_stack([0.4 * s, 0.0 * s, 0.0 * s, hip, knee, 0.0 * s])
    heads = "time," + ",".join(linkage.inputs)
    np.savetxt(table, rows, "%.14f", ",", header=heads, comments="")
    motion = balance.motion.from_csv(linkage, table)
    files = {"as it is": "cassie_leg.urdf", "three weights": written("balanced", answer)}
    return compare(
        files, (0, 2), tuple(map(tuple, motion.u[[60, 90, 160]])), 600.0, motions=[motion]
    )


def stewart():
    """The platform without and with a weight above it, while it rolls to both sides."""
    linkage = kinematics.load(FOLDER / "stewart.urdf")
    time = np.linspace(0.0, 2.0 * np.pi / 3.0, 121)
    rows = np.column_stack([time, np.pi / 12.0 * np.sin(3.0 * time)])
    table = Path(tempfile.mkdtemp()) / "roll.csv"
    np.savetxt(table, rows, "%.12f", ",", header="time,rx", comments="")
    centre = [-0.17, -0.595, 0.4]
    motion = balance.motion.from_tool_csv(linkage, table, "platform", centre)
    answer = balance.partial(
        balance.design_space(linkage, None, "force"),
        ["platform"],
        0.7,
        regions={"platform": "ball(-0.17,-0.595,0.7,0.05)"},
        motions=motion,
        density=None,
    )
    files = {"as printed": "stewart.urdf", "with a weight": written("rolling", answer)}
    ghosts = tuple(map(tuple, motion.u[[30, 90]]))
    return compare(files, (1, 2), ghosts, 100.0, motions=[motion])


def ur5e():
    """The arm at both ends of its motion; the quintic law and the best timing."""
    start = dict(zip(BENT, np.deg2rad([-90.0, 90.0, -90.0, -90.0]).tolist(), strict=True))
    linkage = kinematics.load(FOLDER / "ur5e.urdf", at=start)
    swing = np.deg2rad([90.0, -30.0, 40.0, -10.0, 0.0, 0.0])
    reached = dict(zip(linkage.inputs, swing.tolist(), strict=True))
    end = {name: start.get(name, 0.0) + reached[name] for name in linkage.inputs}
    plan = balance.quiet_timing(
        linkage, [0.0 * swing, swing], 0.9, measure="peak", acceleration=30.0
    )
    time, *best = plan.samples(181)
    loads = [
        held_loads(name, linkage, time, motion, plan.objective.point)
        for name, motion in (
            ("quintic law", quintic(time, swing)),
            ("best timing", best),
        )
    ]
    drawings = [
        Drawing("start, from the side", linkage, (0, 2), (), 400.0),
        Drawing(
            "end, a quarter turn on",
            kinematics.load(FOLDER / "ur5e.urdf", at=end),
            (1, 2),
            tuple(tuple(part * -swing) for part in (0.25, 0.5, 0.75)),
            400.0,
        ),
    ]
    return drawings, loads


def sewing_machine():
    """The needle drive without and with the three weights for the force, in one revolution."""
    discs = {"crank": (0.04, 0.02), "rocker": (0.03, 0.02), "link": (0.03, 0.01)}
    answer = balance.counterweights(
        balance.design_space(FOLDER / "sewing_machine.urdf", None, "force"),
        list(discs),
        {link: f"cylinder(0,0,0,0,0,1,{r},{h})" for link, (r, h) in discs.items()},
        density=19250.0,
    )
    files = {"as it is": "sewing_machine.urdf", "three weights": written("balanced", answer)}
    ghosts = ((1.2,), (2.4,), (3.6,), (4.8,))
    return compare(files, (0, 1), ghosts, 600.0, speed="1000rpm")


BENT = ("shoulder_lift", "elbow", "wrist_1_turn", "wrist_2_turn")
MACHINES = {
    "cassie_leg": cassie_leg,
    "clavel_delta": clavel_delta,
    "double_pendulum": double_pendulum,
    "dual_v": dual_v,
    "engine": engine,
    "ets7": ets7,
    "forbal": forbal,
    "sewing_machine": sewing_machine,
    "squeezer": squeezer,
    "stewart": stewart,
    "ur5e": ur5e,
}


def joints_of_links(linkage):
    """List the points of the joints of each moving link, that which carries it first."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    joints = {}
    for j, joint in enumerate(linkage.joints):
        for link in {welded.get(j, j), joint.parent}:
            joints.setdefault(link, []).append(joint.point)
    return {link: points for link, points in joints.items() if link >= 0}


def draw_linkage(ax, drawing, colour):
    """Draw the links at several poses, and the masses."""
    linkage, plane = drawing.linkage, list(drawing.plane)
    still = (0.0,) * len(linkage.inputs)
    chain = si_chain(linkage, spatial=True)

    def line(ends, **style):
        ax.plot(*np.array(ends).T, color=colour, solid_capstyle="round", **style)

    for u in (*drawing.ghosts, still):
        H = forward_kinematics(chain, joint_positions(linkage, list(u))).H
        for link, points in joints_of_links(linkage).items():
            placed = [(H[link, :3, :3] @ p + H[link, :3, 3])[plane] for p in points]
            for joint in placed[1:]:
                style = {"lw": 2.6} if u == still else {"lw": 0.9, "alpha": 0.2}
                line((placed[0], joint), **style)
            if u == still:
                ax.plot(*np.array(placed).T, "o", ms=4, mfc="white", mec="#1b1e22")
    draw_masses(ax, drawing, colour)
    ax.set(aspect="equal", title=drawing.title)
    ax.margins(0.12)
    ax.axis("off")


def draw_masses(ax, drawing, colour):
    """Draw a disc for each body, the heaviest first, and its mass where there is room."""
    from matplotlib.patches import Circle

    linkage, plane = drawing.linkage, list(drawing.plane)
    carried, labels = joints_of_links(linkage), []
    span = np.ptp([joint.point[plane] for joint in linkage.joints], axis=0).max()
    for body in sorted(linkage.bodies, key=lambda body: -round(body.inertia[0], 9)):
        mass = body.inertia[0]
        centre = balance.bodies.mass_properties(body.inertia).com[plane]
        ax.plot(
            *np.array((carried[body.link][0][plane], centre)).T, color=colour, lw=1.0, ls=":"
        )
        radius = np.sqrt(mass / drawing.density / np.pi)
        ax.add_patch(Circle(centre, radius, color=colour, alpha=0.45, lw=0, zorder=3))
        apart = abs(centre - np.array(labels).reshape(-1, 2)) > span * LABEL
        if not apart.any(axis=1).all():
            continue
        labels.append(centre)
        text = f"{1e3 * mass:.3g} g" if mass < 0.1 else f"{mass:.3g} kg"
        ax.annotate(
            text,
            centre,
            xytext=(0, 7),
            fontsize=7,
            color=colour,
            textcoords="offset points",
            ha="center",
        )


def draw_loads(axes, loads):
    """Plot the size of the shaking force and moment over time."""
    for ax, part, unit in zip(axes, ("force", "moment"), ("N", "N m"), strict=True):
        for load, colour in zip(loads, COLOURS, strict=True):
            ax.plot(load.time, getattr(load, part), color=colour, label=load.name)
        ax.set(ylabel=f"shaking {part}, {unit}", ylim=(0.0, None))
        tidy(ax)
    axes[0].legend(frameon=False, fontsize=8)
    axes[1].set_xlabel("time, s")


def picture(name):
    """Compute the picture of a machine."""
    drawings, loads = MACHINES[name]()

    def draw(figure):
        *parts, right = figure.subfigures(1, 3, width_ratios=(1.0, 1.0, 1.15))
        for part, drawing, colour in zip(parts, drawings, COLOURS, strict=True):
            draw_linkage(part.subplots(), drawing, colour)
        draw_loads(right.subplots(2, 1, sharex=True), loads)

    return image((9.0, 3.0), "svg", draw)


def main():
    """Write the pictures that are named, or all."""
    for name in sys.argv[1:] or MACHINES:
        (FOLDER / f"{name}.svg").write_bytes(picture(name))


if __name__ == "__main__":
    main()
