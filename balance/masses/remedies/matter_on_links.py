"""The plainest remedies: matter on the links that are there, to balance or within a budget."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.partial.budgets import partial
from balance.masses.partial.motion_loads import input_inertia
from balance.masses.remedies.applied import AppliedRemedy, with_cost
from balance.masses.remedies.judge import judge
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document


def apply_own_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by matter on its own links alone.

    Yields:
        One result.
    """
    words = f"matter on {', '.join(request.links)}"
    yield judge(request, Variant("own_masses", words, request.base, request.links))


def apply_partial(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Add the matter within a budget that lets a linkage shake least; see `balance.partial`.

    The residual is the root mean square of the shaking over that of the file.

    Yields:
        One result.
    """
    budget = request.given_mass if request.budget is None else request.budget
    words = f"at most {budget:.4g} kg on {', '.join(request.links)}"
    design = partial(
        request.space, request.links, budget, regions=request.regions, density=request.density
    )
    blank = AppliedRemedy("partial", words, "undecided", design.words)
    if design.found is None or design.verdict != "optimal":
        yield blank
        return
    residual = (
        design.found.objective / design.given.objective if design.given.objective else 0.0
    )
    urdf = with_counterweights(design) if design.weights else request.base.data
    felt = input_inertia(
        load(
            Document(request.base.name, urdf),
            None,
            request.linkage.inputs,
            angles=request.angles,
        )
    )
    done = replace(blank, verdict="partial", residual=residual, urdf=urdf)
    yield with_cost(request, done, design.mass, felt)
