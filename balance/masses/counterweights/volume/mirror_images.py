"""Matter that is its own mirror image, where a linkage and its regions are.

The mirror image of matter that balances a planar linkage, in its plane, balances it too and
costs as much, and so does the mean of both: the least matter is its own mirror image. Only the
conditions that a mirror image keeps are left of those on the others, and sections of balls
replace rays in space (`ball_sections`). The same holds for matter that shakes least, where the
mirror image shakes as much: the size of a load is convex.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from balance.masses.counterweights.added_program import AddedProgram
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.dual_ascent import SECOND_ORDER
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES, block_diagonal, triangles
from balance.support.tolerances import MIRROR_IMAGE
from kinematics.numerics.array_types import Array


def halved_by_plane(
    program: AddedProgram, stocks: Mapping[int, Stock]
) -> tuple[AddedProgram, list[Stock]]:
    """Leave only the matter that is its own mirror image, if the least matter is.

    Args:
        program: the conditions.
        stocks: regions and densities by position of the body.

    Returns:
        The program with the conditions that a mirror image keeps, and the matter in equal
        halves; both as they are if a mirror image fulfils other conditions, or costs more.
    """
    unchanged = program, list(stocks.values())
    if program.taken.links or program.inertia[0].size:
        return unchanged
    mirrors = [_mirror_of(program.space, b, stock) for b, stock in stocks.items()]
    if any(mirror is None for mirror in mirrors):
        return unchanged
    images = np.array([_image_map(mirror) for mirror in mirrors if mirror is not None])
    rows, imaged = program.rows, program.rows @ images
    # Rows are orthonormal over all links: K tells which conditions the images fulfil.
    K = np.einsum("lri,lsi->rs", imaged, rows)
    kept = np.abs(imaged - np.einsum("rs,lsi->lri", K, rows)).max() <= MIRROR_IMAGE
    kept &= _same(K @ program.target, program.target)
    kept &= _same(np.einsum("li,lij->lj", program.cost, images), program.cost)
    if not kept:
        return unchanged
    values, V = np.linalg.eigh(0.5 * (K + K.T))
    even = V[:, values > 0.0]
    halved = program._replace(
        rows=np.einsum("rk,lrj->lkj", even, 0.5 * (rows + imaged)),
        target=even.T @ program.target,
        lift=program.lift @ even,
    )
    pairs = zip(stocks.values(), mirrors, strict=True)
    return halved, [stock._replace(mirror=mirror) for stock, mirror in pairs]


def halved_where_loads_are_even(
    space: DesignSpace, stocks: Mapping[int, Stock], loads: Sequence[Array]
) -> dict[int, Stock]:
    """Leave only the matter that is its own mirror image, if loads of images are as large.

    Of loads without second moments planes cut off the matter, which is such an image already.

    Args:
        space: a design space of the linkage.
        stocks: regions and densities by position of the body.
        loads: functions ``|A [s; 1]|`` of the matter s in the regions, matrices A (..., k, n).

    Returns:
        The matter in equal halves, or as it is.
    """
    mirrors = [_mirror_of(space, b, stock) for b, stock in stocks.items()]
    images = [_image_map(mirror) for mirror in mirrors if mirror is not None]
    second = np.arange(10 * len(stocks)) % 10 < SECOND_ORDER
    if len(images) < len(stocks) or not any(A[..., :-1][..., second].any() for A in loads):
        return dict(stocks)
    M = block_diagonal([*images, np.eye(1)])
    for A in loads:
        squares = A.mT @ A
        if not _same(M.T @ squares @ M, squares):
            return dict(stocks)
    pairs = zip(stocks.items(), mirrors, strict=True)
    return {b: stock._replace(mirror=mirror) for (b, stock), mirror in pairs}


def _mirror_of(space: DesignSpace, body: int, stock: Stock) -> Array | None:
    """Find the reflection (4, 4) about the plane of the linkage, in unit coordinates."""
    if stock.fan is not None:
        return None
    if stock.mirror is not None:
        return stock.mirror
    place = stock.region.place[:3, :3]
    to_plane = space.linkage.chain.frame.R[2] @ space.frames[body, :3, :3]
    mirror = np.eye(4)
    mirror[:3, :3] -= 2.0 * np.linalg.solve(place, np.outer(to_plane, to_plane @ place))
    return mirror if _maps_to_itself(stock.region, mirror[:3, :3]) else None


def _maps_to_itself(region: Region, L: Array) -> bool:
    """Whether a linear map of unit coordinates maps a region to itself."""
    if region.offsets.size:
        return bool(np.all(region.excess(region.vertices @ L.T) <= MIRROR_IMAGE))
    turned = np.abs(L @ L.T - np.eye(3)).max() <= MIRROR_IMAGE
    along = region.ellipsoidal or abs(abs(L[2, 2]) - 1.0) <= MIRROR_IMAGE
    return bool(turned and along and region.kind != "sector")


def _image_map(mirror: Array) -> Array:
    """Compute the map (10, 10) of `triangles` of moments to those of the mirror image."""
    basis = (TRIANGLES[4] @ np.eye(10)).T.reshape(-1, 4, 4)
    return triangles(mirror @ basis @ mirror.T).T


def _same(image: Array, given: Array) -> bool:
    """Whether a mirror image is the same, up to round-off."""
    largest = float(np.abs(given).max(initial=0.0))
    return bool(np.abs(image - given).max(initial=0.0) <= MIRROR_IMAGE * largest)
