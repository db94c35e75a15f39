"""Names that look like HTML, and a design space in which links and joints have them."""

from __future__ import annotations

from xml.sax.saxutils import escape

import kinematics
from balance import design_space
from tests.support.urdf_text import FOUR_BAR

HOSTILE = "</script><script>alert(1)</script><b>{{script}}&amp;\"'"


def hostile(tmp_path):
    """A design space whose linkage, links and joints have names that look like HTML."""
    text = FOUR_BAR.replace('<mimic joint="j1" multiplier="1" offset="0"/>', "")
    for name in ("four_bar", "coupler", "j1"):
        text = text.replace(f'"{name}"', f'"{escape(name + HOSTILE, {chr(34): "&quot;"})}"')
    path = tmp_path / "hostile.urdf"
    path.write_text(text, encoding="utf-8")
    return design_space(kinematics.load(path))
