"""Runs of ``balance verify``: its JSON, a balanced linkage and one that shakes."""

from __future__ import annotations

from tests.support.json_answers import json_answer

FEW = ["--trajectories", "1"]
BALANCED, SHAKING = "four_bar_kite_balanced", "four_bar_general"


def run(capsys, *arguments):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "verify", *arguments)
