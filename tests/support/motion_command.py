"""Runs of ``balance motion``: its JSON, what it refuses, and tables that it reads."""

from __future__ import annotations

import numpy as np

from balance.app.cli.main import main
from tests.support.json_answers import json_answer


def run(capsys, *arguments):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "motion", *arguments)


def refused(capsys, code, *arguments):
    """What is said of a command that ends with this code: nothing is printed."""
    assert main(["motion", *arguments, "--json"]) == code
    streams = capsys.readouterr()
    assert streams.out == ""
    if code == 3:
        assert streams.err.count("\n") == 1 and streams.err.startswith("balance: ")
    return streams.err


def named(report, values):
    """Positions of the report by the names of the joints."""
    names = [joint["name"] for joint in report["joints"]]
    return dict(zip(names, values, strict=True))


def table(path, names, rows):
    lines = [",".join(names), *(",".join(map(repr, row)) for row in np.asarray(rows).tolist())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)
