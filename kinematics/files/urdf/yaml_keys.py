"""Parse a small YAML file to keys with text or lists.

Only the event parser of PyYAML runs; no objects are constructed. Aliases, tags, nested mappings
and deep lists are rejected: loop files do not need them, and an attacker could use them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from kinematics.error_text import clean
from kinematics.files.urdf.xml_tree import Refusal

if TYPE_CHECKING:
    from yaml.events import Event


# Deepest nesting of lists.
MAX_DEPTH = 3

_NULLS = ("", "~", "null", "Null", "NULL")
_EXAMPLE = "write keys with lists, such as name: [first, second]"


class YamlItem(NamedTuple):
    """A text or a list, and the line where it begins."""

    line: int
    text: str | None
    parts: list[YamlItem]


class YamlMapping:
    """The keys of a YAML file; every error names the key and its line."""

    def __init__(
        self, data: bytes, accepted: Collection[str], retired: Mapping[str, str]
    ) -> None:
        """Read the bytes of a file.

        Args:
            accepted: keys that may come, each at most once.
            retired: rejected keys of old files, and the remedy for each.

        Raises:
            Refusal: the file is not YAML, or not a mapping from accepted keys to text and
                lists.
        """
        self.items: dict[str, YamlItem] = {}
        top = _parse_document(data)
        for key, value in zip(top.parts[::2], top.parts[1::2], strict=True):
            name = key.text or ""
            if name in self.items:
                raise self.wrong(name, "the key comes twice", "keep one of them")
            self.items[name] = value._replace(line=key.line)
            if name in retired:
                raise self.wrong(name, "this old key is not supported", retired[name])
            if name not in accepted:
                raise self.wrong(name, "unknown key", f"the keys are {', '.join(accepted)}")

    def wrong(self, key: str, problem: str, remedy: str) -> Refusal:
        """Compose the refusal of the value of a key.

        Args:
            problem: what is wrong with its value.
        """
        return Refusal(f"{clean(key)} (line {self.items[key].line})", problem, remedy)

    def text(self, key: str) -> str | None:
        """Read the text of a key, None if it is absent or holds a list."""
        return self.items[key].text if key in self.items else None

    def entries(self, key: str) -> list[YamlItem]:
        """Read the entries of the list of a key; none if the key is absent."""
        if self.text(key) is not None:
            raise self.wrong(key, "not a list", f"put it in brackets: {key}: [ … ]")
        return self.items[key].parts if key in self.items else []

    def names(self, key: str, item: YamlItem | None = None) -> list[str]:
        """Read a list of different names.

        Args:
            item: an entry of the key that is a list; the list of the key by default.

        Raises:
            Refusal: it is not a list of names, or a name occurs twice.
        """
        parts = item.parts if item else self.entries(key)
        names = [part.text or "" for part in parts]
        if not all(names) or (item and item.text is not None):
            form = "[[first, second]]" if item else "[first, second]"
            raise self.wrong(key, "not a list of names", f"write it as in {key}: {form}")
        (name, count), *_ = Counter(names).most_common(1) or [("", 0)]
        if count > 1:
            raise self.wrong(key, f"'{clean(name)}' comes twice", "name each once")
        return names

    def kinds(self, key: str, owner: str, accepted: Collection[str]) -> list[str]:
        """Read a type for each entry of another key.

        Args:
            key: the key, with one type for all entries or a list of types.
            accepted: types to choose from; case does not matter.

        Raises:
            Refusal: the number of types is another one, or a type is unknown.
        """
        count, common = len(self.entries(owner)), self.text(key)
        if common is not None:
            words = [common] * count
        else:
            words = [part.text or "" for part in self.entries(key)]
        if len(words) != count:
            problem = f"{len(words)} types for the {count} entries of {owner}"
            raise self.wrong(key, problem, f"give a type for each entry of {owner}")
        exact = {name.lower(): name for name in accepted}
        for word in words:
            if word.lower() not in exact:
                remedy = f"choose from {', '.join(accepted)}"
                raise self.wrong(key, f"unknown type '{clean(word)}'", remedy)
        return [exact[word.lower()] for word in words]


def _parse_document(data: bytes) -> YamlItem:
    """Parse the mapping of a YAML document to a list of keys and values in turn.

    Scalars stay text, so that a joint may have the name ``on`` or ``1``.
    An empty value, or a null, is an empty list.
    """
    import yaml

    try:
        top = _collect_items(yaml.parse(data, Loader=yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        problem = f"not readable as YAML{where} ({clean(str(reason))})"
        raise Refusal("", problem, _EXAMPLE) from None
    if not top:
        raise Refusal("", "no keys", _EXAMPLE)
    return top[0]


def _collect_items(events: Iterable[Event]) -> list[YamlItem]:
    """Collect the top value of the only document, if there is one."""
    stack = [YamlItem(0, None, [])]
    for event in events:
        line = event.start_mark.line + 1
        kind = type(event).__name__.removesuffix("Event")
        if kind in ("Alias", "Scalar", "SequenceStart", "MappingStart"):
            _check_event(event, kind, len(stack) - 1, f"line {line}")
            if stack[0].parts:
                raise Refusal(f"line {line}", "a second document", "keep one document")
        if kind == "Scalar":
            null = event.style is None and event.value in _NULLS
            stack[-1].parts.append(YamlItem(line, None if null else event.value, []))
        elif kind in ("MappingStart", "SequenceStart"):
            stack.append(YamlItem(line, None, []))
        elif kind in ("MappingEnd", "SequenceEnd"):
            done = stack.pop()
            stack[-1].parts.append(done)
    return stack[0].parts


def _check_event(event: Event, kind: str, depth: int, where: str) -> None:
    """Check for a mapping at the top, text and lists in it, no aliases and no tags."""
    if getattr(event, "anchor", None) is not None:
        raise Refusal(where, "an anchor or an alias", "write the names out")
    if getattr(event, "tag", None) is not None:
        raise Refusal(where, f"the tag '{clean(event.tag)}'", "write plain names")
    if (kind == "MappingStart") != (depth == 0):
        raise Refusal(where, "a mapping inside" if depth else "no mapping of keys", _EXAMPLE)
    if depth > MAX_DEPTH:
        raise Refusal(where, "lists too deep", _EXAMPLE)
