"""Compiled kernel of the Taylor expansion of closed motions in the inputs.

Every quantity is a power series in the independent coordinates u, sorted by degree. The
radial derivative ``D = Σ u_i ∂/∂u_i`` multiplies degree k by k, so that the recursion along a
ray (see `kinematics.closure.series`) holds with polynomials for numbers and D for d/dt. The
fewest products are needed if links carry vectors instead of screws: the axes a_j of their
joints, and arms r_j from a point of the joint before a link to one of the joint after it:

    ω_j   = ω_parent + a_j Dq_j                   (j turns)
    D a_j = ω_parent × a_j
    D r_j = ω_parent × r_j + λ_j a_j Dq_j         (λ_j: pitch; revolute 0, prismatic 1)
    0     = Σ a_j Dq_j, Σ D r_j                   (each loop, A minus B; j turns in the first)

Of degree k, products of parts of lower degrees are known; the matrix of the unknown Dq is the
loop matrix S_0 of the screws, and its pseudo-inverse gives the response of Dq to each product.
All products of one degree are formed at once, each on a *lane* of its own: a column of the
arrays ``left_factors``, ``right_factors`` and ``product``, which have a row of ``stride`` lanes
for each monomial. Lengths are in chain units. (J. J. de Jong, PhD thesis, University of Twente,
Eq. 4.30, has the same derivatives with Kronecker products and without symmetry.)
"""

from __future__ import annotations

import numpy as np

from kinematics.closure.series import fill_loop_matrix
from kinematics.closure.taylor.layout import SECTION, SIZE, WORK, Layout, expansion_workspace
from kinematics.closure.taylor.monomials import multiply_polynomials
from kinematics.closure.taylor.vector_kernels import (
    fill_points,
    fill_starts,
    fill_turning,
    multiply_lanes,
    planar_responses,
    planar_vectors,
    spatial_responses,
    spatial_vectors,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    in_rows,
    load_vector,
    store_vector,
)
from kinematics.numerics.linalg.pseudo_inverse import pseudo_inverse


@kernel(inline=True, reference_counting=False)
def _fill_degree_1(columns, S, inverse, wide, rates):
    """Compute the joint rates of degree 1: ``Dq = C - S_0⁺ S_0 C`` with the columns C.

    Args:
        columns: in; rates of the independent joints (n, columns).
        S: in; the loop matrix (rows, n).
        inverse: in; the pseudo-inverse, transposed, flat.
        wide: length of its rows and of those of the rates, whole vectors.
        rates: out; the monomials of degree 1 are 1, 2, … (flat).
    """
    n = columns.shape[0]
    for w in range(columns.shape[1]):
        row = rates[(1 + w) * wide : (2 + w) * wide]
        for j in range(n):
            row[j] = columns[j, w]
        for x in range(0, wide, VECTOR_WIDTH):
            total = load_vector(row, x)
            for j in range(n):
                if columns[j, w] != 0.0:
                    for r in range(S.shape[0]):
                        factor = broadcast(-S[r, j] * columns[j, w])
                        total = total + factor * load_vector(inverse, r * wide + x)
            store_vector(row, x, total)


@kernel(inline=True, reference_counting=False)
def _divide_by_degree(degrees, rates, wide, n, positions):
    """Divide rates by their degree: ``Dq = k q`` for the part of degree k.

    Vectors are written beyond the end of their row; the next one is written later.

    Args:
        degrees: in; where the monomials of each degree begin (order + 2,).
        rates: in; coefficients of Dq, flat, rows of ``wide``.
        n: joints.
        positions: out; coefficients of q, flat, rows of n.
    """
    for k in range(degrees.size - 1):
        part = 1.0 / max(k, 1)
        for t in range(degrees[k], degrees[k + 1]):
            if t * n + wide <= positions.size:
                for x in range(0, wide, VECTOR_WIDTH):
                    scaled = load_vector(rates, t * wide + x) * broadcast(part)
                    store_vector(positions, t * n + x, scaled)
            else:
                for j in range(n):
                    positions[t * n + j] = rates[t * wide + j] * part


@kernel(inline=True, reference_counting=False)
def _fill_zeros(numbers):
    """Set all entries of a flat array to 0."""
    for i in range(numbers.size):
        numbers[i] = 0.0


def _polynomials_kernel(dim):
    """Make the kernel for screws of ``dim`` components: 6 in space, 3 in a plane."""
    space = 3 if dim == 6 else 2

    @kernel(reference_counting=False)
    def expand(whole, screws, positions, workspace):
        """Compute the coefficients of the joint positions, degree by degree.

        Args:
            whole: in; integers, in the sections of `kinematics.closure.taylor.layout`.
            screws: in; joint screws (n, 6 or 3).
            positions: out; coefficients of the joint positions (monomials, n).
            workspace: as from `expansion_workspace`.

        Returns:
            The condition number of the equations.
        """
        sizes = whole[whole[SECTION.sizes] : whole[SECTION.sizes + 1]]
        parent = whole[whole[SECTION.parent] : whole[SECTION.parent + 1]]
        ends = in_rows(whole[whole[SECTION.ends] : whole[SECTION.ends + 1]], 2)
        dependent = whole[whole[SECTION.dependent] : whole[SECTION.dependent + 1]]
        equations = whole[whole[SECTION.equations] : whole[SECTION.equations + 1]]
        joints = in_rows(whole[whole[SECTION.joints] : whole[SECTION.joints + 1]], 3)
        arms = in_rows(whole[whole[SECTION.arms] : whole[SECTION.arms + 1]], 3)
        axes = in_rows(whole[whole[SECTION.axes] : whole[SECTION.axes + 1]], 5)
        terms = in_rows(whole[whole[SECTION.terms] : whole[SECTION.terms + 1]], 3)
        cuts = whole[whole[SECTION.cuts] : whole[SECTION.cuts + 1]]
        degrees = whole[whole[SECTION.degrees] : whole[SECTION.degrees + 1]]
        places = in_rows(whole[whole[SECTION.places] : whole[SECTION.places + 1]], 2)
        pairs = in_rows(whole[whole[SECTION.pairs] : whole[SECTION.pairs + 1]], 2)
        n, width, lanes = sizes[SIZE.joints], sizes[SIZE.width], sizes[SIZE.lanes]
        stride, wide, order = sizes[SIZE.stride], sizes[SIZE.wide], degrees.size - 2

        at = whole[whole[SECTION.work] : whole[SECTION.work + 1]]
        left_factors = workspace[at[WORK.left_factors] : at[WORK.left_factors + 1]]
        right_factors = workspace[at[WORK.right_factors] : at[WORK.right_factors + 1]]
        product = workspace[at[WORK.product] : at[WORK.product + 1]]
        rates = workspace[at[WORK.rates] : at[WORK.rates + 1]]
        effect = workspace[at[WORK.effect] : at[WORK.effect + 1]]
        response = workspace[at[WORK.response] : at[WORK.response + 1]]
        inverse = workspace[at[WORK.inverse] : at[WORK.inverse + 1]]
        reflected = workspace[at[WORK.reflected] : at[WORK.reflected + 1]]
        turning = workspace[at[WORK.turning] : at[WORK.turning + 1]]
        turned = workspace[at[WORK.turned] : at[WORK.turned + 1]]
        S = in_rows(workspace[at[WORK.matrix] : at[WORK.matrix + 1]], n)
        points = in_rows(workspace[at[WORK.points] : at[WORK.points + 1]], space)
        starts = in_rows(workspace[at[WORK.starts] : at[WORK.starts + 1]], space)
        omega = in_rows(workspace[at[WORK.omega] : at[WORK.omega + 1]], 3)
        pitch = workspace[at[WORK.pitch] : at[WORK.pitch + 1]]
        scratch = workspace[at[WORK.scratch] : at[WORK.scratch + 1]]
        columns = in_rows(workspace[at[WORK.columns] : at[WORK.columns + 1]], width)
        mimics = in_rows(workspace[at[WORK.mimics] : at[WORK.mimics + 1]], n)
        # Of the other sections, what is read is written, or always the same.
        _fill_zeros(workspace[at[WORK.response] : at[WORK.matrix + 1]])

        fill_loop_matrix(parent, screws, ends, mimics, S)
        condition = pseudo_inverse(S, equations, dependent, inverse, reflected, scratch)
        fill_points(parent, screws, cuts, points, pitch)
        fill_starts(dim, arms, axes, screws, points, starts)
        if dim == 6:
            spatial_responses(inverse, wide, axes, terms, points, pitch, response)
        else:
            planar_responses(inverse, wide, axes, terms, response)
            fill_turning(parent, screws, arms, axes, starts, stride, turning, turned)
            multiply_lanes(0, lanes, n, wide, response, stride, turning, effect)
        if order > 0:
            _fill_degree_1(columns, S, inverse, wide, rates)
        for k in range(1, order + 1):
            begin, end = degrees[k], degrees[k + 1]
            if k > 1:
                # The last degree needs no turned axes: those lanes come after the loops'.
                count = lanes if k == order else stride
                multiply_polynomials(
                    begin,
                    end,
                    count,
                    stride,
                    places,
                    pairs,
                    left_factors,
                    right_factors,
                    product,
                )
                multiply_lanes(begin, end, lanes, stride, product, wide, response, rates)
            if k < order and dim == 6:
                spatial_vectors(
                    k,
                    begin,
                    end,
                    stride,
                    joints,
                    arms,
                    axes,
                    screws,
                    starts,
                    pitch,
                    in_rows(rates, wide),
                    omega,
                    product,
                    left_factors,
                    right_factors,
                )
            elif k < order:
                if k > 1:
                    multiply_lanes(
                        begin, end, lanes, stride, product, stride, effect, left_factors
                    )
                else:
                    multiply_lanes(begin, end, n, wide, rates, stride, turning, left_factors)
                planar_vectors(
                    k,
                    begin,
                    end,
                    stride,
                    arms,
                    axes,
                    turned,
                    starts,
                    product,
                    left_factors,
                    right_factors,
                )
        _divide_by_degree(degrees, rates, wide, n, positions.reshape(-1))
        return condition

    return expand


_spatial, _planar = _polynomials_kernel(6), _polynomials_kernel(3)


def polynomials(screws: Array, which: Layout) -> tuple[Array, float]:
    """Expand the joint positions of the closed motion in a chain's coordinates.

    Args:
        screws: unit screws of the chain's joints (n, 6 or 3), in its units.
        which: all other data, from `packed_layout`.

    Returns:
        Coefficients of the positions, in the units of the chain (M, n), and the condition
        number of the equations that are solved, infinite if they determine no motion.
    """
    whole, _, shape, spare = which
    try:
        workspace = spare.pop()
    except IndexError:
        workspace = expansion_workspace(which)
    positions = np.empty(shape)
    expand = _spatial if screws.shape[1] == 6 else _planar
    condition: float = expand(whole, screws, positions, workspace)
    spare.append(workspace)
    return positions, condition
