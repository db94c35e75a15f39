"""Options that name output files, checks of their paths, and the writing of all of them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from balance.app.cli.arguments import Parser
from balance.support.atomic_files import check_outputs, is_stream, write_all_atomic
from kinematics.errors import FileError, LinkageError, UsageError

if TYPE_CHECKING:
    from balance.app.answers.answer import Answer, Files


# Options of all commands that name output files.
OUTPUTS = {
    "write_closed": "--write-closed",
    "out": "--out",
    "plot": "--plot",
    "html": "--html",
    "table": "--table",
    "best": "--best",
    "write_study": "--write-study",
    "slot": "--slot",
    "parts": "--parts",
}
# End of the name of a table that is a workbook.
WORKBOOK = ".xlsx"
# What to write in place of the option of other commands that reads a table.
TABLE_NOT_CSV = {"--csv": "write --table FILE.csv"}
# Options that name models.
MODELS = ("model", "against")
# Options that name other input files.
INPUTS = (
    "loops",
    "csv",
    "tool_path",
    "path",
    "masses",
    "study",
    "results",
    "measured",
    "wrench",
)


def add_out_option(parser: Parser) -> None:
    """Add the option ``--out`` for the file of a linkage with new masses."""
    parser.group("output").add_argument(
        "--out", metavar="FILE.urdf", help="write the linkage with these masses"
    )


def add_page_option(parser: Parser, what: str) -> None:
    """Add the option ``--html``.

    Args:
        parser: the parser of a command.
        what: what the page shows, for the help: ``write a page …``.
    """
    parser.group("output").add_argument(
        "--html", type=page_path, metavar="FILE.html", help=f"write a page {what}"
    )


def add_picture_option(
    parser: Parser, purpose: str = "write a picture", kinds: str = ".png|.svg"
) -> None:
    """Add the option ``--plot``.

    Args:
        parser: the parser of a command.
        kinds: endings of the file, for the help.
    """
    parser.group("output").add_argument(
        "--plot", type=picture_path, metavar=f"FILE{kinds}", help=purpose
    )


def add_meshes_option(parser: Parser) -> None:
    """Add the option that leaves the shapes of the file out of a page."""
    parser.group("output").add_argument(
        "--no-meshes",
        action="store_true",
        help="leave the shapes of the file out of the page",
    )


def add_table_option(group: argparse._ActionsContainer, purpose: str) -> None:
    """Add the option ``--table``."""
    group.add_argument("--table", type=_table_path, metavar="FILE.csv|.xlsx", help=purpose)


def _table_path(text: str) -> str:
    """Check that a word names a table, a pipe or a device.

    Raises:
        ArgumentTypeError: it ends neither in .csv nor in .xlsx, and is no stream.
    """
    if not (text.lower().endswith((".csv", WORKBOOK)) or is_stream(text)):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .csv nor in .xlsx")
    return text


def picture_path(text: str) -> str:
    """Check that a word names a picture.

    Raises:
        ArgumentTypeError: it ends neither in .png nor in .svg.
    """
    if not text.lower().endswith((".png", ".svg")):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .png nor in .svg")
    return text


def page_path(text: str) -> str:
    """Check that a word names a page, a pipe or a device.

    Raises:
        ArgumentTypeError: it ends neither in .html nor in .htm, and is no stream.
    """
    if not (text.lower().endswith((".html", ".htm")) or is_stream(text)):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .html nor in .htm")
    return text


def kind_of(path: str | None) -> str:
    """Return the kind of a picture, ``png`` or ``svg``."""
    return (path or "png")[-3:].lower()


def _output_paths(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the paths of output files by the names of their options."""
    given = vars(arguments).items()
    return {name: path for name, path in given if name in OUTPUTS and isinstance(path, str)}


def result_files(arguments: argparse.Namespace, *results: Any, **page: object) -> Files:
    """Find what makes the page and the picture of results: that of their methods.

    Args:
        results: one, whose class names the functions, or several that are shown together.
        page: options of the page.
    """
    from balance.app.answers.result_files import maker_of

    kind, first = kind_of(getattr(arguments, "plot", None)), results[0]
    return {
        "html": lambda: maker_of(first.page_maker)(*results, **page),
        "plot": lambda: maker_of(first.picture_maker)(*results, kind=kind),
    }


def describe_written(
    arguments: argparse.Namespace,
    designed: bool,
    *,
    without: Sequence[str] = (),
    inside: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """Say which files are written.

    Args:
        designed: whether there is a design; without one, no file is written.
        without: options whose files are not written.
        inside: names of the files in the folders that options give.
    """
    given = _output_paths(arguments)
    names = [name for name in OUTPUTS if name in given and name not in without]
    folders = {name: _paths_inside(given[name], (inside or {}).get(name, ())) for name in names}
    paths = ", ".join(folders[name] or given[name] for name in names)
    if not paths:
        return ""
    return f"written: {paths}" if designed else f"not written, for there is no design: {paths}"


def _paths_inside(folder: str, names: Sequence[str]) -> str:
    """List the paths of files in a folder: of many the first, and how many there are."""
    from kinematics.wording import MAX_NAMES, first_names

    paths = first_names([os.path.join(folder, name) for name in names])
    return f"{paths} ({len(names)} files in {folder})" if len(names) > MAX_NAMES else paths


def join_remarks(*remarks: str) -> str:
    """Join remarks to the text of one, a line each; empty ones are left out."""
    return "\n".join(filter(None, remarks))


def check_files(arguments: argparse.Namespace) -> None:
    """Refuse to write where a command reads, or one file twice; see `check_outputs`.

    Raises:
        UsageError: an output is an input, or two outputs are one file.
        PackageError: there is nothing here that writes a workbook.
    """
    if _is_workbook(getattr(arguments, "table", None)):
        from balance.support.workbook import require_openpyxl

        require_openpyxl()
    outputs = {OUTPUTS[name]: path for name, path in _output_paths(arguments).items()}
    if outputs:
        check_outputs(outputs, _input_paths(arguments), arguments.overwrite)


def _input_paths(arguments: argparse.Namespace) -> list[str]:
    """List the paths of the files that a command reads."""
    from kinematics.files.urdf.loop_file import loop_file_of
    from kinematics.loading.model_gallery import find

    given = vars(arguments)
    paths = [path for name in INPUTS for path in _texts(given.get(name))]
    models = [path for name in MODELS for path in _texts(given.get(name))]
    for model in (*models, *getattr(arguments, "others", ())):
        # Reading the model raises the error later.
        with suppress(LinkageError, OSError, ValueError):
            path = str(find(model)) if model else ""
            paths += [path, *filter(None, [loop_file_of(path)])] if path else []
    return paths


def _is_workbook(path: str | None) -> bool:
    """Whether the path of a table is one of a workbook."""
    return path is not None and path.lower().endswith(WORKBOOK)


def _texts(value: object) -> list[str]:
    """List the texts of an option that takes one or several."""
    values = value if isinstance(value, list) else [value]
    return [text for text in values if isinstance(text, str)]


def write_outputs(arguments: argparse.Namespace, answer: Answer) -> None:
    """Write the files of the options that an answer can make, all of them or none.

    Args:
        answer: what makes the files.

    Raises:
        LinkageError: a file cannot be written, or a library is missing.
        UsageError: a file of a folder would replace one that is read.
    """
    paths = _output_paths(arguments)
    makers = answer.files() if paths else {}
    files: dict[str, bytes] = {}
    folder = ""
    for name in filter(makers.__contains__, paths):
        path, content = paths[name], makers[name]()
        if isinstance(content, Mapping):
            folder = path
            inside = {key: os.path.join(folder, key) for key in content}
            outputs = {f"{OUTPUTS[name]} ({key})": file for key, file in inside.items()}
            check_outputs(outputs, _input_paths(arguments), arguments.overwrite)
            files |= {inside[key]: data for key, data in content.items()}
        else:
            data = content.encode() if isinstance(content, str) else content
            if name == "table" and _is_workbook(path):
                from balance.support.workbook import workbook_of

                data = workbook_of(data)
            files[path] = data
    made = bool(folder) and not os.path.isdir(folder)
    if made:
        _make_folder(folder)
    try:
        write_all_atomic(files.items())
    except BaseException:
        if made:
            os.rmdir(folder)
        raise


def check_file_folders(arguments: argparse.Namespace) -> None:
    """Refuse output files whose folder does not exist, before any work.

    Raises:
        FileError: there is no such folder.
    """
    from kinematics.error_text import clean

    for name, path in _output_paths(arguments).items():
        if not os.path.isdir(os.path.dirname(os.path.abspath(path))):
            problem = f"{OUTPUTS[name]}: its folder does not exist"
            raise FileError(clean(path, 1000), "", problem, "create it, or give another file")


def check_folder(folder: str, option: str = "--out") -> None:
    """Refuse a folder for output that cannot be made, before any work.

    Args:
        folder: its path.
        option: the option that names it.

    Raises:
        UsageError: it is a file, or the folder around it does not exist.
    """
    from kinematics.error_text import clean

    if os.path.exists(folder) and not os.path.isdir(folder):
        raise UsageError(f"{clean(folder, 1000)}: {option} is a file: give a folder")
    around = os.path.dirname(os.path.abspath(folder))
    if not os.path.isdir(around):
        raise UsageError(f"{clean(around, 1000)}: no such folder: make it before {option}")


def _make_folder(folder: str) -> None:
    """Make a folder.

    Raises:
        FileError: it cannot be made.
    """
    from kinematics.error_text import clean

    try:
        os.mkdir(folder)
    except OSError as error:
        raise FileError(
            clean(folder, 1000),
            "",
            f"cannot be made ({error.strerror})",
            "give a folder inside one that can be written to",
        ) from None
