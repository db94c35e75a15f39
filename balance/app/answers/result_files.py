"""Pages and pictures of results, for their methods ``to_html`` and ``plot``."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

from kinematics.errors import UsageError


def make_result_file(result: Any, kind: str, **options: Any) -> bytes:
    """Make a page or a picture of a result, by the function that its class names.

    Args:
        kind: ``"html"``, ``"png"`` or ``"svg"``.
        options: of the picture: the columns of a sweep.

    Raises:
        UsageError: the result has none: there is no design.
    """
    shown = result.designs[-1] if hasattr(result, "designs") else result
    if getattr(shown, "z", shown) is None:
        raise UsageError(f"{shown.space.linkage.name}: nothing to show: {shown.words}")
    if kind == "html":
        page: str = maker_of(result.page_maker)(result)
        return page.encode()
    picture: bytes = maker_of(result.picture_maker)(result, kind=kind, **options)
    return picture


def maker_of(name: str) -> Any:
    """Import the function that makes a page or a picture: ``module:function``."""
    return resolve_name(f"balance.app.answers.html.{name}")
