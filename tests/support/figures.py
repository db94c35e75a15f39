"""The table of known results: rank by order and size of the design space of each linkage.

Some come from J. J. de Jong, PhD thesis, University of Twente (four-bar linkages, HPRS,
3-RSR), the 4-RRR and 2-RRR from the IFToMM paper of 2011 on shaking-force balance; the
others are ours. All of them come out of finite poses as well; see ``reference.py``.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """One row of the table.

    Attributes:
        model: name of a file of the gallery, without suffix.
        ranks: rank of all balance conditions up to order 0, 1, 2 …, until it stays.
        serial: dimension of the part of the design space that the opened linkage has.
        parallel: dimension of the part that only loop closure opens.
        motion: relations between the inputs; none for the whole workspace.
        balance: ``"dynamic"``, or ``"force"`` for the linear momentum alone.
        spatial: False counts the planar parameters ``[m, mcx, mcy, Ezz]`` only.
        parameters: how many inertial parameters there are.
        reach: of the random poses of the reference route, in radians or scaled lengths.
            Long chains of conditions show only far from the reference pose.
        radius: of the circle on which the reference route takes its derivatives.
        samples: points on that circle; more where it passes near a singularity.
        kept: lower bound of the smallest singular value that the product keeps.
    """

    model: str
    ranks: tuple[int, ...]
    serial: int
    parallel: int
    parameters: int
    motion: tuple[str, ...] = ()
    balance: str = "dynamic"
    spatial: bool = False
    reach: float = 0.3
    radius: float = 0.08
    samples: int = 32
    kept: float = 1e-6

    @property
    def kmax(self) -> int:
        """The last order that adds a condition."""
        return len(self.ranks) - 1

    @property
    def nullity(self) -> int:
        """Dimension of the design space."""
        return self.parameters - self.ranks[-1]

    def __str__(self) -> str:
        """A name for test reports."""
        marks = [self.balance] if self.balance != "dynamic" else []
        marks += ["spatial"] if self.spatial else []
        return "-".join([self.model, *marks, *self.motion])


FIGURES = (
    Figure("four_bar_general", (3, 6, 7, 8), 4, 0, 12),
    Figure("four_bar_general", (5, 10, 11, 12), 17, 1, 30, spatial=True),
    Figure("four_bar_kite", (3, 6, 7), 4, 1, 12),
    Figure("four_bar_antiparallelogram", (3, 6, 7), 4, 1, 12),
    Figure("four_bar_parallelogram", (3, 4, 5), 4, 3, 12),
    Figure("slider_crank", (3, 6), 5, 1, 12),
    Figure("five_bar", (6, 11), 5, 0, 16),
    Figure("five_bar", (4, 6), 5, 1, 12, balance="force"),
    Figure("four_rrr", (6, 12), 12, 3, 27, balance="force"),
    Figure("hprs", (23, 24), 16, 0, 40, spatial=True),
    Figure("bennett", (6, 10, 13), 16, 1, 30, spatial=True),
    Figure("three_rsr", (15, 39, 43), 27, 0, 70, spatial=True),
    Figure("three_rsr", (11, 28, 33, 34, 35), 33, 2, 70, motion=("u2=u3",), spatial=True),
    Figure("bennett_rational", (6, 10, 13), 16, 1, 30, spatial=True),
    Figure("three_rsr_rational", (16, 41, 43), 27, 0, 70, spatial=True),
    Figure(
        "three_rsr_rational", (11, 28, 33, 34, 35), 33, 2, 70, motion=("u2=u3",), spatial=True
    ),
    Figure(
        "six_bar_watt", (3, 6, 9, *range(10, 14)), 7, 0, 20,
        reach=0.6, radius=0.2, samples=64,
    ),
    Figure(
        "six_bar_stephenson", (3, 6, 9, *range(10, 14)), 7, 0, 20,
        reach=0.6, radius=0.2, samples=64,
    ),
    Figure(
        "eight_bar", (3, 6, 9, *range(12, 19)), 10, 0, 28, reach=0.6, radius=0.3, samples=64
    ),
    # Sixteen orders: the last condition is 9.5e-7 of the first.
    Figure(
        "four_bar_chain", (3, 6, 9, 12, 15, *range(18, 29)), 16, 0, 44,
        reach=0.6, radius=0.2, samples=256, kept=1e-7,
    ),
    Figure("three_rrr", (9, 19), 9, 0, 28),
    Figure("pantograph", (6, 7, 8), 5, 3, 16),
    Figure("scissor_three_stage", (3, 6), 11, 11, 28),
    Figure("fuga_i", (6, 11), 5, 0, 16),
    Figure("fuga_i", (4, 6), 5, 1, 12, balance="force"),
    Figure("rusr", (6, 12, 15, 18), 12, 0, 30, spatial=True),
    Figure("four_bar_spherical", (6, 11, 14, 15), 15, 0, 30, spatial=True),
    Figure("sarrus", (6, 12, 16, 18), 29, 3, 50, spatial=True),
    Figure("goldberg_five_bar", (6, 12, 15, 18, 20), 19, 1, 40, spatial=True),
    Figure("delta", (18, 46, 49), 27, 24, 100, spatial=True),
    Figure("stewart_6ups", (36, 82), 48, 0, 130, spatial=True, reach=0.1, radius=0.03),
    Figure("four_rrr_pair", (4, 8), 12, 7, 27, motion=("c1=-a1-b1",), balance="force"),
    Figure("four_rrr_parallel", (4, 6), 12, 9, 27, motion=("c1=-a1-b1",), balance="force"),
    Figure("four_rrr_in_line", (6, 12), 12, 3, 27, balance="force"),
    Figure("four_rrr_symmetric", (6, 12), 12, 3, 27, balance="force"),
    Figure("four_rrr_prototype", (4, 6), 12, 9, 27, motion=("c1=-a1-b1",), balance="force"),
    Figure("four_rrr_side_by_side", (4, 6), 12, 9, 27, motion=("c1=-a1-b1",), balance="force"),
    Figure("two_rrr", (6,), 6, 3, 15, balance="force"),
    Figure("double_pendulum_counter_rotary", (6, 10), 4, 2, 16),
    Figure("double_pendulum_duplicates", (6, 13, 14), 8, 10, 32),
    Figure("four_bar_added_antiparallelogram", (3, 6, 7, 8, 9), 7, 4, 20),
    Figure("four_bar_added_slider_crank", (3, 6, 7), 8, 5, 20),
    Figure("principal_vector_linkage", (9, 10), 2, 0, 12),
    Figure("principal_vector_linkage", (3, 6), 2, 4, 12, motion=("u1=-u3", "u2=-u3")),
    Figure("principal_vector_linkage_slider", (3, 6), 4, 2, 12),
    Figure("three_four_bars_platform", (9, 18, 21), 12, 3, 36),
    Figure("zero_reaction_arm", (9, 12, 15), 12, 9, 36),
    Figure("zero_reaction_arm", (6, 11, 14), 12, 10, 36, motion=("u3=-12*u1-4*u2",)),
    Figure("two_rrr_bisector", (6, 15, 16), 10, 6, 32, reach=0.2),
    Figure("slider_pantograph", (3, 5), 2, 1, 8),
    Figure("pantograph_reaction_wheel", (9, 11), 1, 0, 12),
    Figure("pantograph_reaction_wheel", (6, 7), 1, 1, 9, balance="force"),
)  # fmt: skip

# Balanced masses for the geometry of another model, whose figures are theirs as well.
DESIGNS = {
    "four_bar_antiparallelogram_balanced": "four_bar_antiparallelogram",
    "four_bar_kite_balanced": "four_bar_kite",
}

# Rows, as words, for which the masses of the file are balanced.
BALANCED = {
    "double_pendulum_counter_rotary",
    "double_pendulum_duplicates",
    "four_bar_added_antiparallelogram",
    "four_bar_added_slider_crank",
    "principal_vector_linkage-u1=-u3-u2=-u3",
    "principal_vector_linkage_slider",
    "slider_pantograph",
    "three_four_bars_platform",
    "three_rsr-spatial-u2=u3",
    "two_rrr_bisector",
    "zero_reaction_arm-u3=-12*u1-4*u2",
}
