"""HTML page and picture of counterweights."""

from __future__ import annotations

from balance.app.answers.html.added_matter import added_matter_page
from balance.app.answers.html.render import facts_list
from balance.app.answers.html.verification import verification_picture
from balance.app.answers.text.counterweights import (
    counterweights_facts,
)
from balance.masses.counterweights.counterweights import with_loads
from balance.masses.counterweights.counterweights_result import Counterweights


def counterweights_page(counterweights: Counterweights) -> str:
    """Render counterweights as one HTML file.

    The page begins with the sentence of the answer. It shows the linkage in 3D, with a slider
    for each degree of freedom of the motion, the regions as outlines and the weights inside
    them; the loads along motions before and after on common axes; and a table of the weights
    in grams and millimetres. Without motions in the answer, they are those of
    `balance.verify`. The element ``report`` contains `Counterweights.to_dict` as JSON.

    Returns:
        The text of the file.

    Raises:
        LinkageError: the loads cannot be computed; see `balance.verify`.
    """
    computed = _with_loads(counterweights)
    assert computed.along is not None and computed.z is not None
    return added_matter_page(
        computed.space,
        computed.z,
        computed.regions,
        computed.weights,
        computed.along,
        summary=computed.sentence,
        report=computed.to_dict(),
        facts=facts_list(counterweights_facts(computed)),
    )


def counterweights_picture(counterweights: Counterweights, kind: str = "png") -> bytes:
    """Draw the loads along motions without and with counterweights."""
    along = _with_loads(counterweights).along
    assert along is not None
    masses = "with the masses given", "with counterweights"
    return verification_picture(*along.pair, kind=kind, masses=masses)


def _with_loads(counterweights: Counterweights) -> Counterweights:
    """Return counterweights with their loads along motions."""
    return counterweights if counterweights.along else with_loads(counterweights)
