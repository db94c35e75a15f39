"""What the command line says of a file that it refuses."""

from __future__ import annotations

from pathlib import Path

from balance.app.cli.main import main


def said_of(path: Path, capsys: object, *options: str) -> str:
    """What the command prints for a file that it refuses, without the file."""
    assert main(["report", str(path), "--json", *options]) == 3
    streams = capsys.readouterr()
    assert streams.out == ""
    (line,) = streams.err.splitlines()
    assert line.isprintable() and len(line) < 2000
    start = f"balance: {path.parent}"
    assert line.startswith(start)
    return line.removeprefix(start)
