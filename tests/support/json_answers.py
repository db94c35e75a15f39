"""Answers of commands as JSON, which keep to their schemas."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files

from jsonschema import Draft202012Validator

from balance.app.cli.main import main


@cache
def read_schema(name):
    """Read the schema of what a command prints."""
    path = files("balance").joinpath("app", "schemas", f"{name}.schema.json")
    return json.loads(path.read_text("utf-8"))


def json_answer(capsys, verb, *words, schema=""):
    """Run a command; return its exit code and its JSON, which keeps to its schema."""
    code = main([verb, *words, "--json"])
    answer = json.loads(capsys.readouterr().out)
    Draft202012Validator(read_schema(schema or verb)).validate(answer)
    return code, answer
