"""The command ``balance models``: the linkages that come with the package."""

from __future__ import annotations

import argparse

from balance.app.answers.answer import Answer, AnswerTable
from balance.app.cli.arguments import Parser, add_json_option
from balance.app.cli.exit_codes import DONE


def add_models(parser: Parser) -> None:
    """Add the options of the command ``models``."""
    add_json_option(parser, _run)


def _run(arguments: argparse.Namespace) -> Answer:
    """Describe every linkage of the gallery in one line."""
    from kinematics.loading.model_gallery import describe, gallery

    paths = gallery()
    models = {name: describe(path) for name, path in paths.items()}
    folder = next(iter(paths.values())).parent
    return Answer(
        DONE,
        lambda: {"schema": "balance.models/1", "models": models},
        lambda: [AnswerTable(list(models.items()))],
        remark=f"their files are in {folder}",
    )
