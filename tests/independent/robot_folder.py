"""Reports on a folder of robot files, and their mobility in maximal coordinates.

``python -m tests.independent.robot_folder FOLDER… [--json RESULTS]`` runs ``balance report`` on
each file as a user does, in a process of its own, and compares the mobility with that of a
second route; ``@LIST`` names a list of folders and files, one a line.

The second route has six velocities of each link and the rows of each joint for URDF and SDF,
read by the code below, and the rows of the equalities of MuJoCo for MJCF. Loops are closed by
another Newton method at poses beside that of the file, because the pose of the file may be
singular, or open: the least freedom at closed poses is the mobility. Refusals are listed with
their reasons; a crash, more than 20 s of processor time or more than
2 GB are failures.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

# Of processor time; another program may keep the machine busy.
SECONDS, TIMEOUT = 20.0, 120
MEGABYTES = 2000.0
RANK = 1e-9
CLOSED = 1e-11
# Directions along which the links of a joint may move against each other: turns, slides.
FREE = {
    "revolute": (1, 0),
    "continuous": (1, 0),
    "prismatic": (0, 1),
    "fixed": (0, 0),
    "floating": (3, 3),
    "free": (3, 3),
    "ball": (3, 0),
    "spherical": (3, 0),
    "planar": (1, 2),
}


def pose_of(words):
    numbers = [float(x) for x in words.split()] or [0.0] * 6
    H = np.eye(4)
    H[:3, :3] = Rotation.from_euler("xyz", numbers[3:6]).as_matrix()
    H[:3, 3] = numbers[:3]
    return H


def constraint_rows(kind, H, axis, before, after, columns):
    """Rows of the constraints of a joint on the velocities ``(ω, v)`` of its links, about 0."""
    locked, blocked = locked_directions(kind, H[:3, :3] @ axis)
    point = H[:3, 3]
    rows = [np.concatenate([d, np.zeros(3)]) for d in locked]
    # The velocity of the point is v + ω × p, and d·(ω × p) = ω·(p × d).
    rows += [np.concatenate([np.cross(point, d), d]) for d in blocked]
    return [spread(row, before, after, columns) for row in rows]


def locked_directions(kind, n):
    """Directions about which, and along which, the links of a joint do not move."""
    turns, slides = FREE[kind]
    across = np.linalg.svd(n[None])[2][1:]
    few = {0: np.eye(3), 1: across, 2: n[None], 3: np.empty((0, 3))}
    return few[turns], few[slides]


def gaps(kind, H, axis, closing):
    """How far a joint is open, in the order of its rows; ``closing`` is its frame after."""
    n = H[:3, :3] @ axis
    locked, blocked = locked_directions(kind, n)
    if FREE[kind][0] == 0:
        turn = Rotation.from_matrix(closing[:3, :3] @ H[:3, :3].T).as_rotvec()
    else:
        turn = np.cross(n, closing[:3, :3] @ axis)
    return [*(locked @ turn), *(blocked @ (closing[:3, 3] - H[:3, 3]))]


def spread(row, before, after, columns):
    out = np.zeros(columns)
    for link, sign in ((after, 1.0), (before, -1.0)):
        if link is not None:
            out[6 * link : 6 * link + 6] = sign * row
    return out


def rate_row(kind, H, axis, before, after, columns):
    """The row whose product with the velocities is the rate of a joint."""
    n, zero = H[:3, :3] @ axis, np.zeros(3)
    if kind == "prismatic":
        return spread(np.concatenate([np.cross(H[:3, 3], n), n]), before, after, columns)
    return spread(np.concatenate([n, zero]), before, after, columns)


def mobility_of(links, joints, mimics):
    """``6 links - rank`` of all rows; links are numbers, None is the ground.

    A joint is (name, kind, frame, axis in it, links before and after), and for a loop that is
    open at the pose of the file the frame on the link after.
    """
    columns = 6 * links

    def rows_and_gaps(moved):
        rows, rates, open_by = [], {}, []
        for name, kind, H, axis, before, after, *frame in joints:
            here = moved[before] @ H if before is not None else H
            closing = frame[0] if frame else H
            closing = moved[after] @ closing if after is not None else closing
            rows += constraint_rows(kind, here, axis, before, after, columns)
            open_by += gaps(kind, here, axis, closing)
            rates[name] = rate_row(kind, here, axis, before, after, columns)
        rows += [rates[j] - ratio * rates[source] for j, source, ratio in mimics]
        open_by += [0.0] * len(mimics)
        return np.reshape(rows, (-1, columns)), np.array(open_by)

    def step(moved, change):
        return [displacement(change[6 * k : 6 * k + 6]) @ moved[k] for k in range(links)]

    start = [np.eye(4) for _ in range(links)]
    if len(joints) <= links:
        return columns - rank_of(rows_and_gaps(start)[0])
    return least_freedom(rows_and_gaps, step, start, columns)


def displacement(twist):
    """The rotation by ω about the origin and the displacement by v."""
    H = np.eye(4)
    H[:3, :3] = Rotation.from_rotvec(twist[:3]).as_matrix()
    H[:3, 3] = twist[3:]
    return H


def rank_of(A):
    values = np.linalg.svd(A, compute_uv=False)
    return int(np.sum(values > RANK * values[0])) if values.size else 0


def least_freedom(rows_and_gaps, step, start, columns):
    """The least ``columns - rank`` at closed poses near the start, or at the start."""
    freedoms, random, begin = [], np.random.default_rng(1), start
    for _ in range(6):
        pose = close(rows_and_gaps, step, begin)
        if pose is not None:
            freedoms.append(columns - rank_of(rows_and_gaps(pose)[0]))
        # Beside that pose: along a direction that keeps loops closed to first order.
        pose = start if pose is None else pose
        _, values, Vt = np.linalg.svd(rows_and_gaps(pose)[0])
        null = Vt[np.sum(values > RANK * max(values, default=0.0)) :]
        begin = step(pose, 0.3 * random.standard_normal(len(null)) @ null)
    return min(freedoms, default=columns - rank_of(rows_and_gaps(start)[0]))


def close(rows_and_gaps, step, pose):
    """Close loops by Newton's method; None if they do not close."""
    for _ in range(40):
        rows, open_by = rows_and_gaps(pose)
        if not open_by.size or np.abs(open_by).max() < CLOSED:
            return pose
        change = -np.linalg.lstsq(rows, open_by, rcond=1e-6)[0]
        pose = step(pose, change / max(1.0, np.abs(change).max()))
    return None


def read_xacro(path):
    """The root of an expanded xacro file; packages are those of the folders above it."""
    import xacro
    from xacrodoc import packages

    packages.look_in(path.resolve().parents[:3])
    return ET.fromstring(xacro.process_file(str(path.resolve())).toxml())


def read_urdf(root, fixed_base):
    joints = [x for x in root.findall("joint") if x.find("parent") is not None]
    children = {x.find("child").get("link"): x for x in joints}
    parents = {x.find("parent").get("link") for x in joints}
    (base,) = parents - set(children)
    places = {base: np.eye(4)}

    def place(link):
        if link not in places:
            joint = children[link]
            places[link] = place(joint.find("parent").get("link")) @ origin_of(joint)
        return places[link]

    number = {link: k for k, link in enumerate(children)} | {base: None}
    found, mimics = [], []
    for joint in joints:
        child = joint.find("child").get("link")
        axis = joint.find("axis")
        n = np.array(
            [float(x) for x in (axis.get("xyz") if axis is not None else "1 0 0").split()]
        )
        ends = number[joint.find("parent").get("link")], number[child]
        kind = joint.get("type")
        if fixed_base and kind == "floating" and ends[0] is None:
            kind = "fixed"
        found.append((joint.get("name"), kind, place(child), n, *ends))
        mimic = joint.find("mimic")
        if mimic is not None:
            ratio = float(mimic.get("multiplier", "1"))
            mimics.append((joint.get("name"), mimic.get("joint"), ratio))
    for joint in root.findall("gazebo/joint"):
        # As in SDF 1.5 and later: the pose is in the frame of the child, the axis in that pose.
        before, after = (joint.findtext(x).strip() for x in ("parent", "child"))
        H = place(after) @ pose_of(joint.findtext("pose") or "")
        n = np.array([float(x) for x in joint.findtext("axis/xyz", "0 0 1").split()])
        kind = joint.get("type")
        found.append((joint.get("name"), kind, H, n, number[before], number[after]))
    for plugin in root.findall("gazebo/plugin"):
        if "detachable" in plugin.get("filename", "").lower():
            before, after = (plugin.findtext(x).strip() for x in ("parent_link", "child_link"))
            n = np.array([0.0, 0.0, 1.0])
            found.append((after, "fixed", place(after), n, number[before], number[after]))
    for loop in root.findall("loop"):
        ends = [loop.find(x) for x in ("predecessor", "successor")]
        frames = [place(x.get("link")) @ origin_of(x) for x in ends]
        n = np.array([float(x) for x in loop.find("axis").get("xyz").split()])
        before, after = (number[x.get("link")] for x in ends)
        found.append(
            (loop.get("name"), loop.get("type"), frames[0], n, before, after, frames[1])
        )
    names = {x.get("name", "") for x in root}
    if {x.tag for x in root} & {"loop_joint", "coupling"} or any(
        "closing_" in x for x in names
    ):
        raise ValueError("loops in the words of another program")
    return mobility_of(len(children), found, mimics)


def origin_of(item):
    origin = item.find("origin")
    if origin is None:
        return np.eye(4)
    return pose_of(f"{origin.get('xyz', '0 0 0')} {origin.get('rpy', '0 0 0')}")


def read_sdf(path):
    root = ET.parse(path).getroot()
    models = [*root.findall("model"), *root.findall("world/model")]
    model = next((x for x in models if x.find("joint") is not None), models[0])
    if model.find("model") is not None or model.find("include") is not None:
        raise ValueError("nested models")
    links = [x.get("name") for x in model.findall("link")]
    elements = {x.get("name"): x for x in model.findall("joint")}
    elements |= {x.get("name"): x for x in model if x.tag in ("link", "frame")}
    world = pose_of("")

    def place(name):
        return world if name == "__model__" else place_of(elements[name])

    def place_of(item):
        pose = item.find("pose")
        base = None if pose is None else pose.get("relative_to")
        if base is None and item.tag == "joint":
            base = item.find("child").text.strip()
        if base is None and item.tag == "frame":
            base = item.get("attached_to")
        H = pose_of((pose.text or "") if pose is not None else "")
        return (place(base) if base else world) @ H

    number = {link: k for k, link in enumerate(links)}
    found, mimics, fixed = [], [], False
    for joint in model.findall("joint"):
        kind = joint.get("type")
        parent, child = (joint.find(x).text.strip() for x in ("parent", "child"))
        axis, n = joint.find("axis"), np.array([0.0, 0.0, 1.0])
        H = place_of(joint)
        if axis is not None and axis.find("xyz") is not None:
            n = np.array([float(x) for x in axis.find("xyz").text.split()])
            frame = axis.find("xyz").get("expressed_in")
            old = axis.find("use_parent_model_frame")
            if old is not None and old.text.strip() in ("1", "true"):
                frame = "__model__"
            if frame:
                n = H[:3, :3].T @ place(frame)[:3, :3] @ n
            mimic = axis.find("mimic")
            if mimic is not None:
                ratio = float(mimic.findtext("multiplier"))
                mimics.append((joint.get("name"), mimic.get("joint"), ratio))
        fixed = fixed or "world" in (parent, child)
        found.append((joint.get("name"), kind, H, n, number.get(parent), number.get(child)))
    mobility = mobility_of(len(links), found, mimics)
    return mobility if fixed else mobility - 6


def read_included(path, folder):
    """The root of an MJCF file, each ``<include>`` replaced by what its file contains."""
    root = ET.fromstring(path.read_bytes().strip())
    for parent in list(root.iter()):
        for place, child in reversed(list(enumerate(parent))):
            if child.tag == "include":
                parent.remove(child)
                for item in reversed(read_included(folder / child.get("file"), folder)):
                    parent.insert(place, item)
    return root


def read_mjcf(path, fixed_base):
    import mujoco

    root = read_included(path, path.parent)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in ("geom", "mesh", "material", "texture", "skin", "hfield", "sensor",
                             "contact", "actuator", "keyframe", "camera", "light", "custom",
                             "flex", "tuple", "tendon", "plugin", "deformable", "asset",
                             "option", "size", "statistic", "visual"):  # fmt: skip
                parent.remove(child)
    for body in root.iter("body"):
        inertial = body.find("inertial")
        if inertial is None:
            ET.SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
    bounds = {"boundmass": "1e-3", "boundinertia": "1e-6", "balanceinertia": "true"}
    ET.SubElement(root, "compiler", bounds)
    if fixed_base:
        free = {("freejoint", None), ("joint", "free")}
        bodies = [(x, y) for x in root.findall("worldbody/body") for y in x]
        body, joint = next((x, y) for x, y in bodies if (y.tag, y.get("type")) in free)
        body.remove(joint)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    data = mujoco.MjData(model)

    def rows_and_gaps(qpos):
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        J = np.zeros((len(rows), model.nv))
        if mujoco.mj_isSparse(model) or data.efc_J.size != J.size:
            mujoco.mju_sparse2dense(
                J, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind
            )
        else:
            J = np.reshape(data.efc_J, J.shape)
        return J[rows], data.efc_pos[rows].copy()

    def step(qpos, change):
        qpos = qpos.copy()
        mujoco.mj_integratePos(model, qpos, change, 1.0)
        return qpos

    return int(least_freedom(rows_and_gaps, step, model.qpos0.copy(), model.nv))


def other_mobility(path, fixed_base):
    """Mobility by the other route, or the reason why it has none."""
    try:
        if path.suffix == ".xacro":
            return read_urdf(read_xacro(path), fixed_base), ""
        root = ET.fromstring(path.read_bytes().strip())
        if root.tag == "robot":
            return read_urdf(root, fixed_base), ""
        if root.tag == "sdf":
            return read_sdf(path), ""
        return read_mjcf(path, fixed_base), ""
    except Exception as error:  # files of others: any of them may break a reader
        return None, f"{type(error).__name__}: {error}"[:200]


def run(words):
    """Run a command: exit code, seconds of processor time, megabytes, output, errors.

    A command that takes more processor time than ``TIMEOUT`` is killed by a signal, whatever
    else the machine does.
    """
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        child = subprocess.Popen(words, stdout=out, stderr=err)
        resource.prlimit(child.pid, resource.RLIMIT_CPU, (TIMEOUT, TIMEOUT + 5))
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        took = usage.ru_utime + usage.ru_stime
        return child.returncode, took, usage.ru_maxrss / 1024, out.read(), err.read()


def report(path):
    """Report on a file, and compare its mobility; a record."""
    command = [sys.executable, "-m", "balance", "report", str(path), "--json"]
    fixed = False
    code, took, size, out, err = run(command)
    if code == 3 and "--fix-base" in err + out:
        fixed = True
        code, took, size, out, err = run([*command, "--fix-base"])
    record = {
        "file": str(path),
        "code": code,
        "seconds": round(took, 1),
        "megabytes": round(size),
        "fixed_base": fixed,
    }
    if code in (0, 1, 4):
        answer = json.loads(out)
        answer = min(answer.get("modes", [answer]), key=lambda mode: mode["mobility"]) | answer
        record |= {k: answer.get(k) for k in ("mobility", "rank", "certainty")}
        record["codes"] = sorted({notice["code"] for notice in answer.get("warnings", [])})
        record["doubts"] = answer.get("doubts", [])
        record["other"], record["why"] = other_mobility(path, fixed)
    else:
        record["reason"] = (err or out).strip().splitlines()[-1][:400] if err + out else ""
    record["verdict"] = judge(record)
    return record


def judge(record):
    """One word: right, wrong, unsure, refused, unread, slow, large or crashed."""
    if record["code"] not in (0, 1, 2, 3, 4, -signal.SIGXCPU):
        return "crashed"
    if record["seconds"] > SECONDS:
        return "slow"
    if record["megabytes"] > MEGABYTES:
        return "large"
    if record["code"] in (2, 3):
        return "refused"
    if record["other"] is None:
        return "unread"
    if record["mobility"] == record["other"]:
        return "right"
    return "unsure" if record["code"] == 4 else "differs"


def robot_files(folders):
    """Files that describe robots: those that are named, and those in folders, sorted."""
    files = [path for path in folders if path.is_file()]
    for folder in folders:
        files += sorted(
            path
            for path in folder.rglob("*")
            if path.name.lower().endswith((".urdf", ".sdf", ".urdf.xacro"))
            or (path.suffix == ".xml" and "<mujoco" in path.read_text(errors="replace"))
        )
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__, fromfile_prefix_chars="@")
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    counts = {}
    for path in robot_files(arguments.folders):
        record = report(path)
        counts[record["verdict"]] = counts.get(record["verdict"], 0) + 1
        words = record.get("reason") or record.get("why") or ""
        cost = f"{record['seconds']}s {record['megabytes']}MB"
        mobilities = record.get("mobility"), record.get("other")
        print(record["verdict"], record["code"], *mobilities, cost, path, words, flush=True)
        if arguments.json:
            with arguments.json.open("a") as file:
                print(json.dumps(record), file=file)
    print(counts)
    bad = sum(counts.get(word, 0) for word in ("crashed", "slow", "large", "differs"))
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
