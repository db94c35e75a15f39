"""Lines that a command printed: sentences wrap below their start, rows of tables do not."""

from __future__ import annotations

import re
from html import unescape

BLOCK = re.compile(
    r'(<div class="language-text highlight"><pre><span></span><code>)(.*?)(</code>)', re.DOTALL
)
# A label and its column, and a text without further columns.
SENTENCE = re.compile(r"(\s*(?:\S+(?: \S+)* {2,})?)(\S+(?: \S+)*)")
LONG = 60  # characters


def with_wrapped_lines(html: str) -> str:
    """Let the sentences in blocks of printed text wrap."""
    return BLOCK.sub(lambda found: found[1] + _wrapped(found[2]) + found[3], html)


def _wrapped(text: str) -> str:
    """Mark the lines of one block that are long sentences."""
    return "\n".join(map(_line, text.split("\n")))


def _line(line: str) -> str:
    """Mark a line with the column below which it goes on; leave a row of a table."""
    plain = unescape(line)
    sentence = SENTENCE.fullmatch(plain)
    if sentence is None or len(plain) <= LONG:
        return line
    return f'<span class="sentence" style="--column: {len(sentence[1])}ch">{line}</span>'
