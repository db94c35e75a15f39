"""Expand a xacro file in a process of its own, which has no other part of this project.

It is run with the path of the file and that of the result, whose first line is ``ok``, or a
word that names the failure, followed by the text of the URDF file or of the message.
"""

from __future__ import annotations

import sys
from pathlib import Path
from xml.etree import ElementTree

# Largest amount of memory, bytes.
MAX_MEMORY = 2**31
# Longest text of a message.
MAX_MESSAGE = 1000


def expand_file(path: str, result: str) -> None:
    """Expand a file, and write the text or the message.

    Args:
        result: the file to write.
    """
    try:
        _limit_memory()
        text = _expand(path)
    except ModuleNotFoundError as error:
        text = f"missing\n{error.name}"
    except Exception as error:  # Expressions of the file may raise anything.
        text = f"failed\n{error}"[:MAX_MESSAGE]
        cause = getattr(error, "exc", None) or error
        if isinstance(cause, RecursionError | MemoryError):
            text = "failed\nits macros or properties expand without end"
    Path(result).write_text(text, encoding="utf-8")


def _limit_memory() -> None:
    """Limit the memory of this process, where the operating system can."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))


def _expand(path: str) -> str:
    """Expand a file; packages are searched above it, beside those it is in, and by ROS."""
    import xacro
    from xacrodoc import packages

    above = _packages_above(Path(path).resolve())
    for folder in reversed(above.values()):
        packages.look_in([str(folder.parent)])
    packages.update_package_cache(above)
    return "ok\n" + xacro.process_file(path).toprettyxml(indent="  ")


def _packages_above(path: Path) -> dict[str, Path]:
    """Find the packages that a file is in, by name, the innermost first.

    A package without a readable ``package.xml`` has the name of its folder. ``walk_up_from`` of
    xacrodoc takes the first folder with a ``manifest.xml`` for any package whatever.
    """
    packages: dict[str, Path] = {}
    for folder in path.parents:
        name = ""
        if (folder / "package.xml").is_file():
            try:
                name = ElementTree.parse(folder / "package.xml").findtext("name") or ""
            except (ElementTree.ParseError, OSError):
                name = folder.name
        elif (folder / "manifest.xml").is_file():
            name = folder.name
        if name.strip():
            packages.setdefault(name.strip(), folder)
    return packages


if __name__ == "__main__":
    expand_file(*sys.argv[1:])
