"""Runs of ``balance motion``: its JSON, what it refuses, and tables that it reads."""

from __future__ import annotations

import json
from importlib.resources import files

import numpy as np
from jsonschema import Draft202012Validator

from balance.cli.main import main

SCHEMAS = files("balance").joinpath("schemas")
SCHEMA = json.loads(SCHEMAS.joinpath("motion.schema.json").read_text("utf-8"))


def run(capsys, *arguments):
    """Exit code and the JSON of one command, which keeps to its schema."""
    code = main(["motion", *arguments, "--json"])
    report = json.loads(capsys.readouterr().out)
    Draft202012Validator(SCHEMA).validate(report)
    return code, report


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
