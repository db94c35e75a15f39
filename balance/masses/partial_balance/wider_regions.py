"""What a budget leaves to shake in default regions of twice the radius, and in larger ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from balance.masses.counterweights.link_regions import default_region
from balance.masses.counterweights.regions import Region, ball_region
from balance.masses.counterweights.shaped.across_plane import is_at_rim
from balance.masses.partial_balance.least_shaking import CapsConflict
from balance.masses.partial_balance.partial_balance import PartialBalance, WiderRegions
from balance.masses.partial_balance.shaking_problem import ShakingOptions, build_problem

# Radii that are tried, over those by default.
FACTORS = (2.0, 4.0, 8.0)
# Part of the shaking in the file that the next radius must save.
WORTH_MORE_ROOM = 0.02
# Digits of radii, in millimetres, as they are printed.
DIGITS = 3
# Part of a budget from which it is used, and part of the shaking that is not worth a word.
USED, HARDLY_SHAKES = 0.99, 0.01
# Part of the shaking that matter saves, up to which it is told to be hardly worth its mass.
HARDLY_SAVED = 1e-3
# Part of the shaking by which the least is reached.
REACHED = 1e-3


def default_regions(design: PartialBalance) -> dict[str, Region]:
    """Return the regions of a design that are those by default, by name of the link."""
    space = design.space
    return {
        link: region
        for link, region in design.regions.items()
        if default_region(space, space.bodies.index(link)).text == region.text
    }


def reaches_least(design: PartialBalance) -> bool:
    """Whether a design shakes as little as any matter on its links lets it shake."""
    least = design.least_anywhere
    return least is not None and design.share <= least / design.given.objective + REACHED


def lacks_room(design: PartialBalance) -> bool:
    """Whether the room of the regions, not the budget, limits what is left to shake."""
    full = design.mass >= USED * design.budget
    # Of what saves hardly anything, the solver leaves open how much is best.
    determined = HARDLY_SHAKES <= design.share <= 1.0 - HARDLY_SAVED
    return bool(design.weights) and determined and not (full or reaches_least(design))


def links_at_rim(design: PartialBalance) -> list[str]:
    """List the links whose shapes would grow or move if their regions were larger."""
    # A sector whose radius is given does not grow with its region.
    if design.shape is None or "," in design.shape:
        return []
    space, regions = design.space, design.regions
    return [x.link for x in design.weights if is_at_rim(space, x, regions[x.link])]


def may_have_webs(design: PartialBalance) -> bool:
    """Whether shapes of the kind that was asked for may have webs."""
    return design.shape is not None and not design.shape.startswith("sector")


def try_wider_regions(
    design: PartialBalance, links: Sequence[str], options: ShakingOptions
) -> tuple[WiderRegions, ...]:
    """Solve the question of a design in larger regions, until more room saves little.

    In place of shapes with webs, which are not proved to be the best, matter of any shape is
    taken there.

    Args:
        design: a design.
        links: names of the links that may get matter.
        options: those of the design.

    Returns:
        What is left for each factor that was tried; none if regions do not limit the design, no
        region is that by default, or more room saves little.
    """
    limited = lacks_room(design) or (links_at_rim(design) and not reaches_least(design))
    given, wider = default_regions(design) if limited else {}, list[WiderRegions]()
    last, shape = design.share, None if may_have_webs(design) else options.shape
    for factor in FACTORS if given else ():
        balls = {x: _wider_ball(region, factor) for x, region in given.items()}
        regions = {**(options.regions or {}), **balls}
        asked = replace(options, regions=regions, motions=design.motions, shape=shape)
        problem = build_problem(design.space, links, asked)
        answer = problem.solve(design.budget)
        if isinstance(answer, CapsConflict):
            break
        share = answer.value / design.given.objective
        if last - share < WORTH_MORE_ROOM:
            break
        wider.append(WiderRegions(balls, share, float(problem.matter.masses @ answer.s)))
        last = share
    return tuple(wider)


def _wider_ball(ball: Region, factor: float) -> Region:
    """Make a ball about the same centre, of a radius with few digits in millimetres."""
    return ball_region(ball.centre, float(f"{1e3 * factor * ball.size:.{DIGITS}g}") / 1e3)
