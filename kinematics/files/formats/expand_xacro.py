"""Expand xacro files with the packages xacro and xacrodoc, which finds packages without ROS.

Expressions of the file are evaluated, by the evaluator of xacro that knows a few functions of
Python only. This happens in a process of its own, of limited time and memory.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from kinematics.error_text import clean
from kinematics.files.urdf.xml_tree import MAX_BYTES, Refusal, build_tree, read_bytes
from kinematics.model.document.element import Element

EXPANDED = (
    "xacro_expanded",
    "the file was expanded with xacro; lines in messages are those of its expansion",
)
"""The remark on an expanded file."""

# Longest time of an expansion, seconds.
MAX_SECONDS = 60
_BY_HAND = "run xacro first (xacro robot.xacro > robot.urdf)"
_INSTALL = "pip install xacrodoc"


def expand_xacro(data: bytes, path: str | None) -> Element:
    """Expand a xacro file.

    Args:
        path: the file, from which others may be included; None for a stream.

    Returns:
        The root element of the expanded file.

    Raises:
        Refusal: the packages are missing, or the file cannot be expanded.
    """
    with TemporaryDirectory() as folder:
        result = Path(folder) / "result"
        if path is None:
            path = str(Path(folder) / "robot.xacro")
            Path(path).write_bytes(data)
        _run_worker(os.path.abspath(path), str(result), folder)
        if not result.is_file():
            raise Refusal("", "xacro ended without a result", _BY_HAND)
        word, _, text = read_bytes(str(result), MAX_BYTES).decode().partition("\n")
        text = text.replace(folder + os.sep, "")
    if word == "missing":
        problem = f"a xacro file, whose expansion needs {clean(text)}, which is not installed"
        raise Refusal("", problem, f"install it with '{_INSTALL}', or {_BY_HAND}")
    if word != "ok":
        raise Refusal("", f"xacro: {clean(' '.join(text.split()), 400)}", _remedy(text))
    return build_tree(text.encode())


def _remedy(text: str) -> str:
    """Choose the remedy of an error of xacro."""
    if "substitution argument" in text:
        return "give the <xacro:arg> a default, or run xacro first (xacro FILE NAME:=VALUE)"
    if "Package not found" in text or "No such file" in text:
        return f"put the files beside this one as its package has them, or {_BY_HAND}"
    if "unbound prefix" in text:
        return 'declare it: <robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
    return "correct the file"


def _run_worker(path: str, result: str, folder: str) -> None:
    """Run the expansion; its output goes nowhere.

    Raises:
        Refusal: it takes too long, or the process cannot be started.
    """
    worker = str(Path(__file__).with_name("xacro_worker.py"))
    try:
        subprocess.run(
            [sys.executable, "-P", worker, path, result],
            cwd=folder,
            timeout=MAX_SECONDS,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        problem = f"its expansion by xacro takes more than {MAX_SECONDS} s"
        raise Refusal("", problem, _BY_HAND) from None
    except OSError as error:
        raise Refusal("", f"xacro cannot be run ({error.strerror})", _BY_HAND) from None
