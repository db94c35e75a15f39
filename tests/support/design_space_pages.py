"""Pages of design spaces in a browser: what they draw, and how their sliders are moved."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

import kinematics
from balance import design_space
from balance.app.answers.data import Report
from balance.app.answers.html.report import report_page
from balance.space.interpretation.explain import explain
from kinematics.model.spatial.screws import hat
from tests.support.browser import Select, one, settle

FOUR_BAR, PARALLEL = "four_bar_antiparallelogram", "three_rsr"
READ = "return stage.drawn(arguments[0])"
SET = (
    "const input = document.querySelectorAll('#sliders input')[arguments[0]];"
    "input.value = arguments[1]; input.dispatchEvent(new Event('input'))"
)


def written(folder, space):
    """The address of the page of a design space."""
    path = folder / "page.html"
    path.write_text(report_page(Report(space, explain(space))), encoding="utf-8")
    return path.as_uri()


def write_pages(make_folder):
    """Write pages of design spaces, each into a new folder; spaces and addresses by model."""
    pages = {}
    for model, motion in ((FOUR_BAR, None), (PARALLEL, "u2=u3")):
        space = design_space(kinematics.load(model), motion)
        pages[model] = space, written(make_folder("pages"), space)
    return pages


def opened(browser, address):
    """The page at its start: loaded, or put back there if it is loaded already."""
    if browser.current_url != address:
        browser.get_log("browser")
        browser.get(address)
    else:
        reset = one(browser, ".reset")
        if reset.is_enabled():
            reset.click()
        Select(one(browser, "#choice")).select_by_index(0)
    settle(browser)


def drawn(browser, name):
    """Vertices of a trace (n, 3); rows of nan separate lines."""
    points = [p or [np.nan] * 3 for p in browser.execute_script(READ, name)]
    return np.array(points, dtype=float).reshape(-1, 3)


def slide(browser, number, value):
    """Put a slider to a value, in degrees or metres, and wait for the drawing."""
    browser.execute_script(SET, number, value)
    settle(browser)


def links(linkage, q):
    """Displacements of all links at joint positions q, as products of exponentials."""
    H = []
    for joint, value in zip(linkage.joints, q, strict=True):
        before = H[joint.parent] if joint.parent >= 0 else np.eye(4)
        H.append(before @ expm(value * hat(joint.screw)))
    return H
