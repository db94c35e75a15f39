"""One browser for all pages that a process tests, and pages of design spaces."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser without a network; tests that use it are skipped where there is none."""
    from tests.support.browser import started

    with started(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Design spaces and the addresses of their pages, by model."""
    from tests.support.design_space_pages import write_pages

    return write_pages(tmp_path_factory.mktemp)


@pytest.fixture(scope="module", params=("four_bar_antiparallelogram", "three_rsr"))
def model(request):
    """A linkage of `pages`."""
    return request.param
