"""Options and files that the commands below ``balance flex`` share."""

from __future__ import annotations

import argparse

from balance.cli.arguments import picture_path

__all__ = ["add_output", "kind_of", "write_file"]


def add_output(parser: argparse.ArgumentParser) -> None:
    """Add the options of commands that read no model."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--plot", type=picture_path, metavar="FILE", help="write a picture")
    parser.set_defaults(force=False)


def kind_of(path: str) -> str:
    """Return the kind of a picture, ``png`` or ``svg``."""
    return path[-3:].lower()


def write_file(path: str, content: bytes) -> None:
    """Write a file whole or not at all.

    Args:
        path: where to.
        content: its bytes.
    """
    from balance.atomic_files import write_all_atomic

    write_all_atomic([(path, content)])
