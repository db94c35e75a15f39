"""Runs of ``balance verify``: its JSON, a balanced linkage and one that shakes."""

from __future__ import annotations

import json
from importlib.resources import files

from jsonschema import Draft202012Validator

from balance.cli.main import main

FEW = ["--trajectories", "1"]
BALANCED, SHAKING = "four_bar_kite_balanced", "four_bar_general"
SCHEMAS = files("balance").joinpath("schemas")
SCHEMA = json.loads(SCHEMAS.joinpath("verify.schema.json").read_text("utf-8"))


def run(capsys, *arguments):
    """Exit code and the JSON of one command, which keeps to its schema."""
    code = main(["verify", *arguments, "--json"])
    report = json.loads(capsys.readouterr().out)
    Draft202012Validator(SCHEMA).validate(report)
    return code, report
