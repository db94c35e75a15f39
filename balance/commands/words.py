"""Words of the command line that several commands read alike."""

from __future__ import annotations

import argparse
from collections.abc import Callable

__all__ = ["picture_path", "whole_number"]


def whole_number(lowest: int, highest: int, what: str = "a number") -> Callable[[str], int]:
    """What reads a whole number between two others, these included.

    It raises ArgumentTypeError for any other word.
    """

    def read(text: str) -> int:
        digits = text.isascii() and text.isdigit() and len(text) <= 18
        number = int(text) if digits else lowest - 1
        if not lowest <= number <= highest:
            raise argparse.ArgumentTypeError(
                f"'{text}' is not {what} from {lowest} to {highest}"
            )
        return number

    return read


def picture_path(text: str) -> str:
    """A word that names a picture.

    Raises:
        ArgumentTypeError: by its end it is none.
    """
    if not text.lower().endswith((".png", ".svg")):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .png nor in .svg")
    return text
