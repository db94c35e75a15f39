"""The plainest remedy: counter-masses on the links that are there."""

from __future__ import annotations

from collections.abc import Iterator

from balance.remedies.applied import AppliedRemedy
from balance.remedies.judge import judge
from balance.remedies.request import RemedyRequest
from balance.remedies.variant import Variant

__all__ = ["apply_own_masses"]


def apply_own_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by matter on its own links alone.

    Args:
        request: the request.

    Yields:
        One result.
    """
    words = f"matter on {', '.join(request.links)}"
    yield judge(request, Variant("own_masses", words, request.base, request.links))
