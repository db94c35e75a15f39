"""Requests to balance open linkages that are written link by link."""

from __future__ import annotations

import kinematics
from balance.masses.remedies.request import RemedyRequest
from kinematics.loading.model_gallery import as_linkage
from kinematics.model.document.element import Document


def rod(name, parent, place, mass, com, inertia, kind="continuous", axis="0 0 1", joint=""):
    """A link on a joint, with the inertia tensor about its centre on the diagonal."""
    entries = " ".join(f'i{a}{a}="{v!r}"' for a, v in zip("xyz", inertia, strict=True))
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>' * (kind == "prismatic")
    return (
        f'<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass!r}"/>'
        f'<inertia {entries} ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="{joint or f"j_{name}"}" type="{kind}"><origin xyz="{place}"/>'
        f'<parent link="{parent}"/><child link="{name}"/><axis xyz="{axis}"/>{limit}</joint>'
    )


def request_of(*parts, **options) -> RemedyRequest:
    text = f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>'
    linkage = kinematics.load(Document("r.urdf", text.encode()))
    return RemedyRequest(linkage, **options)


SLENDER = (0.0, 1.0 / 12.0, 1.0 / 12.0)
PENDULUM = (
    rod("a", "base", "0 0 0", 1.0, "0.5 0 0", SLENDER),
    rod("b", "a", "1 0 0", 1.0, "0.5 0 0", SLENDER),
)
# The second rod has its centre on its joint, the first balances it.
BALANCED_FORCE = (
    rod("a", "base", "0 0 0", 2.0, "-0.5 0 0", SLENDER),
    rod("b", "a", "1 0 0", 1.0, "0 0 0", SLENDER),
)


def request_of_model(name: str) -> RemedyRequest:
    """A request for a model of the gallery, or for the pendulum of "two rods"."""
    if name == "two rods":
        return request_of(*PENDULUM)
    return RemedyRequest(as_linkage(name))
