"""The YAML file beside a robot: what it may hold, and one clear line for all the rest."""

import os
import subprocess
import sys
from functools import partial

import numpy as np
import pytest

from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_unassembled
from tests.support.limited_process import run_limited
from tests.support.sidecar_text import PAIR, bench, written


@pytest.fixture
def write(tmp_path):
    """Write a robot and its YAML file to a folder of their own."""
    return partial(written, tmp_path)


# YAML, element, words of the problem, words of the remedy
BAD = {
    "not yaml": ("closed_loop: [", "", "not readable as YAML at line 1", "name:"),
    "bytes": (b"closed_loop: \xe9", "", "not readable as YAML", "name:"),
    "text": ("closed_loop", "line 1", "no mapping of keys", "name:"),
    "list": ("- closed_loop", "line 1", "no mapping of keys", "name:"),
    "comments": ("# closed_loop", "", "no keys", "name:"),
    "xml": ("<?xml version='1.0'?><closed_loop/>", "line 1", "no mapping", "name:"),
    "tag": (PAIR + "type: !!python/object/apply:os.system [exit]", "line 2", "the tag",
        "plain"),
    "own tag": (PAIR + "type: !x [3d]", "line 2", "tag '!x'", "plain names"),
    "anchor": ("closed_loop: &a [[tip_a, tip_b]]", "line 1", "anchor", "write the names out"),
    "alias": (PAIR + "type: *a", "line 2", "alias", "write the names out"),
    "mapping": (PAIR + "type: {a: 3d}", "line 2", "a mapping inside", "name:"),
    "depth": ("closed_loop: [[[[tip_a]]]]", "line 1", "lists too deep", "name:"),
    "documents": (PAIR + "---\ntype: [3d]", "line 3", "second document", "one document"),
    "twice": (PAIR + PAIR, "closed_loop (line 1)", "the key comes twice", "keep one"),
    "key": (PAIR + "colour: red", "colour (line 2)", "unknown key", "closed_loop, type"),
    "list as key": (PAIR + "? [a]\n: b", " (line 2)", "unknown key", "the keys are"),
    "pattern": (PAIR + "name_closedloop: ferme", "name_closedloop (line 2)", "old key", "pair"),
    "more types": (PAIR + "type: [3d, 3d]", "type (line 2)", "2 types for the 1 entries",
        "each"),
    "fewer types": (PAIR + "type: []", "type (line 2)", "0 types for the 1", "closed_loop"),
    "type": (PAIR + "type: [5d]", "type (line 2)", "unknown type '5d'", "choose from 3d, 6d"),
    "nested type": (PAIR + "type: [[3d]]", "type (line 2)", "unknown type", "3d, 6d"),
    "word": ("closed_loop: tip_a", "closed_loop (line 1)", "not a list", "brackets"),
    "flat": ("closed_loop: [tip_a, tip_b]", "closed_loop", "not a list of names", "[[first"),
    "single": ("closed_loop: [[tip_a]]", "closed_loop", "1 names at line 1", "pairs"),
    "triple": ("closed_loop:\n\n- [tip_a, tip_b, jb]", "closed_loop", "3 names at line 3",
        "pairs"),
    "no frame": ("closed_loop: [[tip_a, tip_c]]", "closed_loop", "'tip_c' does not exist",
        "tip_b"),
    "null": ("closed_loop: [[tip_a, ~]]", "closed_loop", "not a list of names", "first"),
    "itself": ("closed_loop: [[ja, ja]]", "closed_loop", "'ja' comes twice", "once"),
    "one body": ("closed_loop: [[tip_a, coupler]]",
        "closed_loop: loop 'tip_a/coupler' (line 1)",
        "one rigid body", "move apart"),
    "one frame": ("closed_loop: [[tip_a, ja]]", "closed_loop: loop 'tip_a/ja'",
        "one rigid body",
        "move apart"),
    "welded by type": ("closed_loop: [[crank, base]]\njoint_name: [j1]\njoint_type: [FIXED]",
        "closed_loop: loop 'crank/base'", "one rigid body", "move apart"),
    "pair twice": ("closed_loop: [[tip_a, tip_b], [jb, ja]]", "closed_loop (line 1)",
        "'jb' of 'jb/ja' is a frame of 'tip_a/tip_b' too", "frames of its own"),
    "frame of two pairs": ("closed_loop: [[tip_a, tip_b], [tip_b, crank]]", "closed_loop",
        "'tip_b' of 'tip_b/crank' is a frame of 'tip_a/tip_b' too", "frames of its own"),
    "no joint": (PAIR + "joint_name: [j9]\njoint_type: [FIXED]", "joint_name (line 2)",
        "'j9' does not exist", "'j1'"),
    "link as joint": (PAIR + "joint_name: [crank]\njoint_type: [FIXED]", "joint_name",
        "'crank' does not exist", "'j1'"),
    "joint twice": (PAIR + "joint_name: [j1, j1]\njoint_type: [FIXED, FIXED]", "joint_name",
        "'j1' comes twice", "once"),
    "joint type": (PAIR + "joint_name: [j1]\njoint_type: [UJOINT_XX]", "joint_type (line 3)",
        "unknown type 'UJOINT_XX'", "SPHERICAL, FIXED, UJOINT_XY"),
    "no joint type": (PAIR + "joint_name: [j1]", "joint_name (line 2)", "no joint_type",
        "add it"),
    "unequal joints": (PAIR + "joint_name: [j1, j2]\njoint_type: [FIXED]",
        "joint_type (line 3)",
        "1 types for the 2 entries of joint_name", "each"),
    "types alone": (PAIR + "joint_type: [FIXED]", "joint_type (line 2)", "1 types for the 0",
        "joint_name"),
    "input": (PAIR + "name_mot: [j1, j9]", "name_mot (line 2)", "'j9' does not exist", "'j1'"),
    "input twice": (PAIR + "name_mot: [j1, j1]", "name_mot", "'j1' comes twice", "once"),
    "fixed input": (PAIR + "name_mot: [ja]", "name_mot", "'ja' is fixed", "that move"),
    "welded input": (PAIR + "name_mot: [j1]\njoint_name: [j1]\njoint_type: [FIXED]", "name_mot",
        "'j1' is fixed", "that move"),
    "nested input": (PAIR + "name_mot: [[j1]]", "name_mot", "not a list of names", "[first"),
    "empty word": (PAIR + "rotule_name: ''", "rotule_name", "no part of a name", "list names"),
}  # fmt: skip


@pytest.mark.table
@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("explicit", [False, True])
def test_refused(write, case, explicit):
    yaml, element, problem, remedy = BAD[case]
    path = write(bench(), yaml)
    with pytest.raises(FileError) as caught:
        read_unassembled(path, path.with_suffix(".yaml") if explicit else None)
    error = caught.value
    assert str(error).splitlines() == [str(error)] and str(error).isprintable()
    assert error.file.endswith("robot.yaml") and error.element.startswith(element)
    assert problem in error.problem and remedy in error.remedy


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize(
    "data",
    [
        b"closed_loop: " + b"[" * 100_000,
        b"a: &a [x]\n" + b"".join(b"k%d: [*a, *a]\n" % i for i in range(5000)),
        b"closed_loop: [" + b"[tip_a, tip_b]," * 8000 + b"]",
        b"name_mot: [" + b"j1," * 40_000 + b"]",
        b"closed_loop: " + b"x" * 2**18,
        b"- " * 50_000,
        b"closed_loop: '\n" + b"\n" * 100_000,
    ],
)
def test_hostile_files_are_refused(write, data):
    path = write(bench(), data)
    code = (
        "import sys\n"
        "from kinematics.errors import FileError\n"
        "from kinematics.files.formats.robot_files import read_unassembled\n"
        "try:\n    read_unassembled(*sys.argv[1:])\n"
        "except FileError as error:\n    print(error)\n"
    )
    done = run_limited(code, str(path), str(path.with_suffix(".yaml")))
    (line,) = done.stdout.splitlines()
    assert "robot.yaml" in line and done.stderr == ""


@pytest.mark.slow
def test_no_byte_that_is_lost_does_more_than_refuse(write):
    """Truncated and damaged files raise nothing but the error that names them."""
    text = PAIR + "type: ['3d']\njoint_name: [j2]\njoint_type: [UJOINT_ZY]\nname_mot: ['j1']\n"
    data, rng = text.encode(), np.random.default_rng(1)
    damaged = [data[:n] for n in range(1, len(data), 3)]
    for _ in range(150):
        copy = bytearray(data)
        copy[rng.integers(len(copy))] = rng.choice(list(b"[]{}:,'\"-&*!|>%@\n\t \x00\xff#?a"))
        damaged.append(bytes(copy))
    for case in damaged:
        path = write(bench(), case)
        try:
            read_unassembled(path, path.with_suffix(".yaml"))
        except FileError as error:
            assert error.file.endswith("robot.yaml") and error.problem and error.remedy


def test_refusal_loads_nothing_heavy(write):
    path = write(bench(), PAIR + "colour: red")
    program = (
        "import sys\n"
        "from kinematics.errors import FileError\n"
        "from kinematics.files.formats.robot_files import read_robot\n"
        "from kinematics.files.urdf.loop_file import merge_loop_file\n"
        "try:\n    merge_loop_file(read_robot(sys.argv[1]).tree, sys.argv[1])\n"
        "except FileError as error:\n    print(error)\n"
        "print(sorted({'numpy', 'scipy', 'numba', 'yourdfpy', 'lxml'} & set(sys.modules)))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert "colour (line 2): unknown key" in run.stdout
    assert run.stdout.splitlines()[-1] == "[]"
