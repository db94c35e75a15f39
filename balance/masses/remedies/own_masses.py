"""The plainest remedy: counter-masses on the links that are there."""

from __future__ import annotations

from collections.abc import Iterator

from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.judge import judge
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant


def apply_own_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by matter on its own links alone.

    Yields:
        One result.
    """
    words = f"matter on {', '.join(request.links)}"
    yield judge(request, Variant("own_masses", words, request.base, request.links))
