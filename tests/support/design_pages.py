"""Designs of linkages of the gallery, and their pages."""

from __future__ import annotations

from functools import cache

import kinematics
from balance import design_space
from balance.app.answers.html.design import design_page
from balance.masses.designs.best_design import design

FOUR_BAR = "four_bar_antiparallelogram"


@cache
def case(model, motion):
    """A design and the text of its page."""
    found = design(design_space(kinematics.load(model), motion))
    return found, design_page(found)
