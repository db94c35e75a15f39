"""Formulas between dollars become MathML, which browsers draw without a script."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

# What `pymdownx.arithmatex` writes for $…$ and $$…$$.
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
DISPLAY = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', re.DOTALL)
# A matrix, with the signs around it.
BRACKETS = re.compile(r"<mo>([^<]+)</mo>(<mtable>(?:(?!<mtable).)*?</mtable>)<mo>([^<]+)</mo>")


def with_formulas(html: str) -> str:
    """Replace the formulas of a page."""
    html = DISPLAY.sub(lambda found: _mathml(found[1], "block"), html)
    return INLINE.sub(lambda found: _mathml(found[1], "inline"), html)


def _mathml(formula: str, display: str) -> str:
    for entity, sign in (("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")):
        formula = formula.replace(entity, sign)
    return BRACKETS.sub(_tall, convert(formula.strip(), display=display))


def _tall(found: re.Match[str]) -> str:
    """Make the brackets of a matrix as tall as it is, whatever stands beside it."""
    fence = '<mo stretchy="true" fence="true" form="{}">{}</mo>'
    first, last = fence.format("prefix", found[1]), fence.format("postfix", found[3])
    return f"<mrow>{first}{found[2]}{last}</mrow>"
