"""One browser for all pages that a process tests."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser without a network; tests that use it are skipped where there is none."""
    from tests.support.browser import started

    with started(tmp_path_factory.mktemp("profile")) as driver:
        yield driver
