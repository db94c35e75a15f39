"""Formulas between dollars become MathML, which browsers draw without a script."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

# What `pymdownx.arithmatex` writes for $…$ and $$…$$.
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
DISPLAY = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', re.DOTALL)


def with_formulas(html: str) -> str:
    """Replace the formulas of a page."""
    html = DISPLAY.sub(lambda found: _mathml(found[1], "block"), html)
    return INLINE.sub(lambda found: _mathml(found[1], "inline"), html)


def _mathml(formula: str, display: str) -> str:
    for entity, sign in (("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")):
        formula = formula.replace(entity, sign)
    return convert(formula.strip(), display=display)
