"""Shapes that no workshop can be asked for: proofs that none balance, and refusals."""

import pytest

import balance
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.shaped.weight_shape import read_weight_shapes
from kinematics.errors import UsageError

STEEL = 7850.0
NEEDED = 0.05  # kg m, what the link of `turned_arm` needs on its other side


# Halves of a box 100 mm long behind the joint, from a height to 40 mm more: all of it, 20 mm
# thick, has the moment ``ρ 0.02 (2 half) 0.1² / 2``, which is what is needed at 31.8 mm.
@pytest.mark.parametrize(
    "half, low, verdict",
    [(0.030, -0.02, "infeasible"), (0.035, -0.02, "undecided"), (0.030, 0.01, "undecided")],
)
def test_shapes_that_are_not_found_are_excluded_where_no_plate_balances(
    half, low, verdict, turned_arm
):
    space = balance.design_space(turned_arm, balance="force")
    region = {"l1": f"box(-0.1:0,-{half}:{half},{low}:{low + 0.04})"}
    answer = balance.counterweights(space, ["l1"], region, shape="disc=0.02", relax=False)
    assert (STEEL * 0.02 * half * 0.1**2 < NEEDED) == (half == 0.030)
    assert answer.verdict == verdict and answer.z is None and not answer.weights
    excluded = verdict == "infeasible"
    assert (answer.check is not None and answer.check.accepted) == excluded
    assert ("No discs on l1 in these regions balance" in answer.sentence) == excluded
    thickness = "no plates" if excluded else "no discs"
    assert f"{thickness} of thickness 0.02 m" in answer.words


@pytest.mark.parametrize("factor, verdict", [(0.999, "infeasible"), (1.001, "feasible")])
def test_sectors_are_excluded_below_the_thickness_of_the_textbook(factor, verdict, turned_arm):
    """Half a disc of radius R has most moment: ``2/3 ρ t R³``."""
    space = balance.design_space(turned_arm, balance="force")
    thickness = factor * NEEDED / (2.0 / 3.0 * STEEL * 0.1**3)
    answer = balance.counterweights(
        space, ["l1"], {"all": "0.12"}, shape=f"sector={thickness},0.1", relax=False
    )
    assert answer.verdict == verdict


@pytest.mark.parametrize(
    "text, advice",
    [
        ("sector=12mm,disc=12mm", "sector=12mm"),
        ("disc=20mm/sector=20mm", "disc=20mm"),
        ("sector=1cm,0.1;disc=1cm", "sector=1cm,0.1"),
        ("disc=5mm/disc=8mm", "disc=5mm/8mm"),
        ("block=5mm, block=8mm", "block=5mm/8mm"),
        ("disc=0.02,disc=", "disc=0.02"),
    ],
)
def test_what_is_advised_for_several_shapes_is_one(text, advice):
    with pytest.raises(UsageError, match=f"give one, such as {advice}$"):
        read_weight_shapes(text)
    assert len({shape.kind for shape in read_weight_shapes(advice)}) == 1


def test_the_form_of_a_region_is_told_to_be_in_numbers():
    with pytest.raises(UsageError, match=r"write ball\(x,y,z,r\) in numbers, metres or with"):
        read_region("ball(x,y,z,r)")
