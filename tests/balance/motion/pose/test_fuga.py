"""Fuga I: upper arms in closed form, the balanced pose, and the motions of Figs. 3.8 and 3.9.

[J] J. J. de Jong, PhD thesis, University of Twente, sections 3.3 and 3.4, table 3.2. The table
puts the lower arms at 140 mm and 90°, which contradicts its upper arms, 69 mm and 150°.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from balance import design, design_space
from balance.bodies import mass_properties
from balance.motion import shaking
from balance.motion.pose.body_family import planar_balancing_body
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.shaking_wrench import inertia_loads, mass_parameters
from balance.pose import balance_pose, momentum_map, momentum_matrix, reaction_null_space
from kinematics.closure.joint_positions import input_chain
from tests.support.fuga import (
    ACCELERATION,
    LENGTH,
    LOWER,
    LOWER_MASS,
    PATHS,
    PIVOTS,
    TIME,
    UPPER,
    UPPER_MASS,
    Masses,
    angles,
    driven,
    fuga,
    travel,
)

PRINTED_UPPER, PRINTED_MOMENT = (0.069, 150.0), 1.46e-3
# End point on the base line, and 1 mm beyond it as seen from the elbows.
ON_LINE, BEYOND = 0.0, -1e-3
# Centres of mass of the lower arms: printed; asked for by the printed upper arms; across.
PRINT, ASKED, STRAIGHT = (0.140, 90.0), (0.10274, 88.84), (0.104, 90.0)
NO_UPPER = Masses(STRAIGHT, PRINTED_UPPER, PRINTED_MOMENT)


@cache
def upper_arm(lower, x):
    """Distance (mm), angle (degrees) and moment of inertia (g m²) of the solved left arm."""
    linkage = fuga(x, NO_UPPER._replace(lower=lower))
    found = balance_pose(linkage)
    assert found.residual < 1e-12 and set(found.families) == {"left_upper", "right_upper"}
    names = [body.name for body in linkage.bodies]
    body = mass_properties(found.z[names.index("left_upper")])
    other = mass_properties(found.z[names.index("right_upper")])
    assert np.abs(body.com * [1, -1, 1] - other.com).max() < 1e-12  # mirror images
    c = body.com[:2] - PIVOTS[0]
    turn = np.degrees(np.arctan2(c[1], c[0]) - angles([x, 0.0])[0][0]) % 360.0
    return np.linalg.norm(c) * 1e3, turn, body.inertia[2, 2] * 1e3


@cache
def balanced(lower=STRAIGHT, x=BEYOND):
    """Masses with which the linkage is balanced with the end point at (x, 0)."""
    distance, turn, moment = upper_arm(lower, x)
    return Masses(lower, (distance * 1e-3, turn), moment * 1e-3)


def test_the_closed_form_is_that_of_the_plane():
    """[J] Eqs. 3.59 and 3.60, written out for this linkage, against the spatial form."""
    linkage = fuga(BEYOND, NO_UPPER)
    rest = [np.delete(np.arange(4), k) for k in (0, 2)]
    z = mass_parameters(linkage)
    for column, k in ((0, 0), (1, 2)):
        others = z.copy()
        others[np.delete(np.arange(4), rest[column])] = 0.0
        h = -momentum_matrix(linkage, [0.0, 0.0], others)[[2, 3, 4], column]
        pivot = PIVOTS[column]
        c, g = planar_balancing_body(pivot, 1.0, h, UPPER_MASS)
        assert linkage.bodies[k].name.endswith("upper")
        found = mass_properties(balance_pose(linkage).z[k])
        assert np.abs(found.com[:2] - c).max() < 1e-12
        assert abs(found.inertia[2, 2] - g) < 1e-12 * PRINTED_MOMENT * 1e6


@pytest.mark.parametrize(
    ("lower", "x", "expected"),
    [
        # The printed lower arms ask for upper arms of 76.6 mm at 142.1°.
        (PRINT, ON_LINE, (76.588, 142.125, 5.657)),
        (PRINT, BEYOND, (76.588, 142.125, 5.767)),
        # Lower arms across: force balance everywhere, 69.8 mm at 150.0°.
        (STRAIGHT, ON_LINE, (69.820, 149.982, 1.479)),
        (STRAIGHT, BEYOND, (69.820, 149.982, 1.554)),
        # At 88.84° mirror images are balanced in the pose with 70.3 mm at 150.5° only.
        (ASKED, ON_LINE, (70.322, 150.506, 1.170)),
        (ASKED, BEYOND, (70.336, 150.498, 1.242)),
    ],
)
def test_upper_arms_of_the_closed_forms(lower, x, expected):
    assert np.abs(np.subtract(upper_arm(lower, x), expected)).max() < 6e-4


def test_the_printed_upper_arms_ask_for_102_74_mm_at_88_84_degrees():
    """Force balance of an arm: ``m1 c1 = -m2 l1 (1 - c2 / l2)``, complex numbers along it."""
    wanted = UPPER_MASS * PRINTED_UPPER[0] * np.exp(1j * np.radians(PRINTED_UPPER[1]))
    lower = LOWER * (1.0 + wanted / (LOWER_MASS * UPPER))
    assert abs(abs(lower) - ASKED[0]) < 1e-5
    assert abs(np.degrees(np.angle(lower)) - ASKED[1]) < 5e-3


@pytest.mark.parametrize(("x", "moment"), [(ON_LINE, 1.389), (BEYOND, 1.461)])
def test_moment_of_inertia_that_leaves_no_moment(x, moment):
    """With 102.74 mm at 88.84° and 69.0 mm at 150.0°: 1.389 on the line, 1.461 beyond it.

    The moment about the middle of the base then vanishes for both inputs. The force does not:
    mirror images of arms are balanced everywhere at 90° alone ([J] Eq. 3.61).
    """
    without = fuga(x, Masses(ASKED, PRINTED_UPPER, 0.0))
    needed = -momentum_matrix(without, [0.0, 0.0])[2]
    assert np.abs(needed * 1e3 - moment).max() < 1e-3
    linkage = fuga(x, Masses(ASKED, PRINTED_UPPER, float(needed[0])))
    assert reaction_null_space(linkage, [0.0, 0.0], "moment").dimension == 2
    whole = reaction_null_space(linkage, [0.0, 0.0])
    assert whole.dimension == 0
    assert 1e-3 < whole.singular_values[0] / whole.scale < 1e-1


@pytest.mark.slow
@pytest.mark.lanes
def test_two_rates_are_free_in_the_balanced_pose_and_one_elsewhere():
    """[J] Fig. 3.6: with the forces balanced, every pose has one direction without reaction."""
    linkage = fuga(BEYOND, balanced())
    assert reaction_null_space(linkage, [0.0, 0.0]).dimension == 2
    around = np.linspace(-0.25, 0.26, 24)  # not the pose itself
    found = momentum_map(linkage, {"u1": around, "u3": around})
    assert found.reached.all() and (found.dimension == 1).all()
    # On the line of symmetry the way along it is quiet: u3 = -u1.
    for u in (-0.2, 0.1):
        quiet = reaction_null_space(linkage, [u, -u]).basis[:, 0]
        assert abs(quiet.sum()) < 1e-9


def test_the_convex_problem_agrees():
    """Lower arms kept: at the masses that it finds, the closed form has the same upper arms."""
    linkage = fuga(BEYOND, NO_UPPER)
    space = design_space(linkage, max_order=0)
    best = design(space, keep=["left_lower", "right_lower"], one_pose=True)
    assert best.verdict == "feasible" and best.residuals.accepted
    masses = {body.name: body.mass for body in best.bodies if body.name.endswith("upper")}
    closed = balance_pose(linkage, masses)
    for name in masses:
        k = space.bodies.index(name)
        there, here = mass_properties(best.z[k]), mass_properties(closed.z[k])
        assert np.abs(there.com - here.com).max() < 1e-10
        assert abs(there.inertia[2, 2] - here.inertia[2, 2]) < 1e-10


def test_the_profile_of_the_motions():
    """[J] section 3.4 and Fig. 3.8: 200 mm in 0.4 s, at most 1 m/s and 5 m/s²."""
    t, s, v, a = travel()
    assert (t[-1], s[-1] - s[0], v.max(), np.abs(a).max()) == (TIME, LENGTH, 1.0, ACCELERATION)
    assert np.abs(np.diff(s) - (v[1:] + v[:-1]) / 2 * np.diff(t)).max() < 1e-12


@cache
def measured(masses, path):
    """Peak-to-peak: moment, forces; drive torque and force (x, y) of base joint u1."""
    linkage = fuga(BEYOND, masses)
    q, ud, udd = driven(path, BEYOND)
    found = shaking(linkage, q, ud, udd)
    chain = input_chain(linkage)
    loads = inertia_loads(chain, mass_parameters(linkage), q / chain.units, ud, udd)
    joints = joint_reactions(chain, loads)
    names, L = [joint.name for joint in linkage.joints], chain.frame.length
    bearing = L * joints.joints[:, names.index("u1"), 3:5]
    return (
        np.ptp(found[:, 2]),
        np.ptp(found[:, 3:5], axis=0).max(),
        L**2 * np.abs(joints.motors).max(),
        np.ptp(bearing, axis=0),
    )


@pytest.mark.parametrize(("path", "moment"), [(1, 0.0), (2, 0.013), (3, 0.81)])
def test_shaking_of_the_balanced_masses(path, moment):
    """[J] Fig. 3.9, peak to peak: measured 0.06, 0.04, 0.80 N m; force none, measured 0.26 N.

    Path 2 is the straight line here, not the reactionless path beside it.
    """
    found = measured(balanced(), path)
    assert abs(found[0] - moment) < 0.005
    assert found[1] < 1e-10
    assert path != 1 or found[0] < 1e-9


def test_the_printed_masses_would_shake_more():
    """The measured 0.80 N m of the diagonal belongs to the corrected masses, not to 140 mm."""
    printed = Masses(PRINT, PRINTED_UPPER, PRINTED_MOMENT)
    assert abs(measured(printed, 3)[0] - 1.06) < 0.01
    assert measured(printed, 2)[0] > 0.2 and measured(printed, 1)[1] > 0.9


def test_forces_of_the_base_joints_and_torques():
    """[J] estimates 5.93, 4.51, 2.58 N: near ours in the other order; motors of 7.4 N m."""
    sizes = {path: measured(balanced(), path) for path in PATHS}
    found = [float(np.linalg.norm(sizes[path][3])) for path in PATHS]
    assert np.abs(np.subtract(found, [2.589, 4.192, 4.954])).max() < 2e-3
    assert 0.8 < max(one[2] for one in sizes.values()) < 0.95


def test_a_switch_of_acceleration_does_not_shake_in_the_balanced_pose():
    """[J] Fig. 3.9, the arrows."""
    linkage = fuga(BEYOND, balanced())
    q, ud, udd = (x[20] for x in driven(3, BEYOND, 41))
    assert np.abs(q).max() < 1e-12
    there = [shaking(linkage, q, ud, sign * udd) for sign in (1.0, -1.0)]
    assert np.abs(there[0] - there[1]).max() < 1e-10
