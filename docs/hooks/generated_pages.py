"""Pages that are made from the code: the command line, JSON, exit codes, the Python API."""

from __future__ import annotations

import argparse
import inspect
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import balance
import kinematics
from balance.app.answers.html.linkage_drawing import linkage_drawing
from balance.app.cli import exit_codes
from balance.app.cli.main import COMMANDS, command_parser

ROOT = Path(__file__).parents[2]
Field = tuple[str, str]
COPIES = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
GALLERY = ROOT / "urdf_models"
EXAMPLES = tomllib.loads((ROOT / "docs" / "option_examples.toml").read_text(encoding="utf-8"))


def copied_pages() -> dict[str, str]:
    """Read the pages that live beside the code, by path on the site."""
    texts = {path: (ROOT / name).read_text(encoding="utf-8") for name, path in COPIES.items()}
    return {path: text.replace("](docs/", "](") for path, text in texts.items()}


def gallery_pages() -> dict[str, str]:
    """Make the page of the gallery, with a drawing of each of its linkages."""
    text = (GALLERY / "README.md").read_text(encoding="utf-8")
    drawings = {
        path.stem: linkage_drawing(kinematics.load(path), (240, 180), names=False)
        for path in sorted(GALLERY.glob("*.urdf"))
    }
    figures = "\n".join(
        f'<figure><img src="gallery/{name}.svg" alt="Drawing of {name}" width="240" '
        f'height="180" loading="lazy"><figcaption><code>{name}</code></figcaption></figure>'
        for name in drawings
    )
    intro, head, rest = text.partition("\n*Rank by order*")
    page = f'{intro}\n<div class="gallery">\n{figures}\n</div>\n{head}{rest}'
    return {
        "reference/gallery.md": page,
        **{f"reference/gallery/{name}.svg": drawing for name, drawing in drawings.items()},
    }


def command_pages() -> dict[str, str]:
    """Print the help of every command, from its parser."""
    page = "# Help of the commands\n\nWhat `balance COMMAND --help` prints, and an example of "
    page += "each option; they are explained under [Command line](../command_line.md).\n"
    for name, parser in command_parsers(command_parser(COMMANDS)):
        page += f"\n## {name}\n\n```text\n{parser.format_help()}```\n"
        if " " not in name:
            continue
        rows = [
            f"| `{_cell(option)}` | {_cell(words)} | `{_cell(example)}` |\n"
            for option, words, example in option_examples(name.removeprefix("balance "), parser)
        ]
        if rows:
            page += f"\n| option | what it does | example |\n|---|---|---|\n{''.join(rows)}"
    return {"reference/command_help.md": page}


def option_examples(
    command: str, parser: argparse.ArgumentParser
) -> Iterator[tuple[str, str, str]]:
    """List the options of a command: the option, its help, and an example.

    Args:
        command: its name without the first word, such as ``flex modes``.
        parser: its parser.

    Raises:
        KeyError: ``docs/option_examples.toml`` has no word for an option.
    """
    words = {**EXAMPLES["all"], **EXAMPLES.get(command, {})}
    for action in parser._actions:
        if not action.option_strings or action.help == argparse.SUPPRESS:
            continue
        name = max(action.option_strings, key=len)
        text = (action.help or "").replace("%%", "%")
        yield name, text, name if action.nargs == 0 else f"{name} {_quoted(words[name])}"


def _quoted(word: str) -> str:
    """Quote a word that a shell would take apart."""
    return f'"{word}"' if re.search(r"[^\w.,:=@/%+*-]", word) else word


def command_parsers(
    parser: argparse.ArgumentParser,
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """List a parser and the parsers of its commands, by their full names."""
    yield parser.prog, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for verb in dict.fromkeys(action.choices.values()):
                yield from command_parsers(verb)


def exit_code_page() -> dict[str, str]:
    """Make a table of the exit codes from the sentence that `balance --help` ends with."""
    words = re.sub(r" \([^)]*\)", "", exit_codes.EXPLANATION)
    rows = re.findall(r"(\d+) ([^,.]+)", words)
    table = "".join(f"| {code} | {text.strip()} |\n" for code, text in rows)
    page = "# Exit codes\n\n| code | meaning |\n|---|---|\n" + table
    page += "\nA negative verdict is an answer: not balanced, no design, a pose that is not "
    page += "reached. With codes 2 and 3 one line on standard error names the element and the "
    page += "remedy, and `--json` prints nothing. `BALANCE_DEBUG=1` prints the traceback of a "
    page += "defect.\n"
    return {"reference/exit_codes.md": page}


def json_pages() -> dict[str, str]:
    """Describe the objects that `--json` prints, from their schemas."""
    page = "# JSON\n\n`--json` prints one object on standard output. Each has a schema, and "
    page += (
        "its field `schema` names the schema and its version, which changes when the meaning "
    )
    page += (
        "of a field changes. The schemas come with the package, in `balance/app/schemas/`.\n"
    )
    files = {}
    for path in sorted((ROOT / "balance" / "app" / "schemas").glob("*.json")):
        text = path.read_text(encoding="utf-8")
        files[f"reference/{path.name}"] = text
        page += _schema_section(path.name, json.loads(text))
    return {"reference/json.md": page, **files}


def _schema_section(name: str, schema: dict) -> str:
    """Describe one schema: its title, and a table of its fields."""
    section = f"\n## {schema['title']}\n\n{schema['description']} [Schema]({name}).\n"
    fields = dict(_fields(schema, schema, "", ()))
    rows = "".join(f"| `{key}` | {_cell(text)} |\n" for key, text in fields.items())
    return section + (f"\n| field | meaning |\n|---|---|\n{rows}" if rows else "")


def _fields(part: dict, schema: dict, path: str, seen: tuple[str, ...]) -> Iterator[Field]:
    """List the fields below a part of a schema that are described, with their paths."""
    reference = part.get("$ref", "")
    if reference.startswith("#/$defs/") and reference not in seen:
        found = schema["$defs"][reference.removeprefix("#/$defs/")]
        yield from _fields(found, schema, path, (*seen, reference))
    for key, value in part.get("properties", {}).items():
        if isinstance(value, bool):
            continue
        inner = f"{path}.{key}" if path else key
        if "description" in value:
            yield inner, value["description"]
        yield from _fields(value, schema, inner, seen)
    if isinstance(part.get("items"), dict):
        yield from _fields(part["items"], schema, f"{path}[]", seen)
    for choice in ("oneOf", "anyOf", "allOf"):
        for value in part.get(choice, ()):
            yield from _fields(value, schema, path, seen)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def api_pages() -> dict[str, str]:
    """List the public names of both packages, a page for each module that shows them."""
    faces = [getattr(balance, name) for name in balance.__all__]
    modules = [kinematics, balance, *filter(inspect.ismodule, faces)]
    return {
        f"reference/api/{module.__name__.replace('.', '_')}.md": _api_page(module)
        for module in modules
    }


def _api_page(module: ModuleType) -> str:
    """Title, first line of the docstring, and the public names."""
    values = {name: getattr(module, name) for name in module.__all__}
    names = [name for name, value in values.items() if not inspect.ismodule(value)]
    page = f"# {module.__name__}\n\n{(module.__doc__ or '').splitlines()[0]}\n\n"
    page += f"`from {module.__name__} import {', '.join(names)}`\n"
    members = (f"{values[name].__module__}.{name}" for name in names)
    return page + "".join(f"\n::: {member}\n" for member in members)
