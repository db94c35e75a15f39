"""Mobility to higher order: infinitesimal motion, singular poses, branches, dead centres.

Orders are confirmed by series in fractions, poses and openings by plane geometry.
"""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import least_squares

import kinematics
from balance import design_space
from balance.momentum import momentum_regressor
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import CoordinateError, MeetingModesError, MobilityError
from kinematics.model.spatial.inertia import displace_parameters
from tests.support.urdf_text import along, joint, link, loop, saved

Z = [0.0, 0.0, 1.0]
MASS = dict(mass=1.3, inertia=np.diag([0.1, 0.2, 0.3]), origin=along([0.2, 0.1, 0.0]))
# Bars of a platform: feet and heads, and the order at which its loops stop closing. Heads
# drop by u²/2l where they are moved by u, which a turn of the platform allows if 1/l is
# linear in x; the turn moves heads of unequal height, which undoes it at order 3.
LENGTHS, ACROSS = (1.0, 0.8, 0.5), (0.0, 0.25, 1.0)
STRUCTURES = {
    "lengths": ([(0, 0), (1, 0.3), (2, 0.5)], [(0, 1), (1, 1), (2, 1)], 2),
    "heights": (
        [(x, round(h - a, 9)) for x, h, a in zip(ACROSS, (0, 0.1, 0.3), LENGTHS, strict=True)],
        list(zip(ACROSS, (0, 0.1, 0.3), strict=True)),
        3,
    ),
    "one height": (
        [(x, -a) for x, a in zip(ACROSS, LENGTHS, strict=True)],
        [(x, 0) for x in ACROSS],
        4,
    ),
}
# Cranks of one length on one line, with one, two or three bars beside the first.
COLLINEAR = ([(0, 0), (1, 0), (2.5, 0), (3, 0)], [(0.5, 0), (1.5, 0), (3, 0), (3.5, 0)])


def platform(folder, feet, heads, turn=0.0, name="made"):
    """A planar platform on bars from ``feet`` to ``heads``, all turned by an angle."""
    feet, heads = (np.column_stack([x, np.zeros(len(x))]) for x in (feet, heads))
    c, s = np.cos(turn), np.sin(turn)
    swung = feet + (heads - feet) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    elements = [link("base"), link("top", **MASS)]
    for i, (foot, head) in enumerate(zip(feet, swung, strict=True)):
        elements.append(link(f"bar{i}", **MASS))
        elements.append(joint(f"a{i}", "continuous", "base", f"bar{i}", along(foot), Z))
        frames = along(head - foot), along(head - swung[0])
        if i == 0:
            elements.append(joint("b0", "continuous", "bar0", "top", frames[0], Z))
        else:
            elements.append(loop(f"b{i}", "revolute", (f"bar{i}", "top"), frames, Z))
    return saved(folder, *elements, name=name)


def notices(linkage, code):
    return [notice.message for notice in linkage.notices if notice.code == code]


def order_of_closure(feet, heads, highest=8):
    """The order at which no motion of a platform keeps the lengths of its bars.

    Its pose is ``(t, y(t), τ(t))``, with τ the tangent of half its angle; unknown
    coefficients of y and τ enter every order linearly, with the same three equations.
    """
    exact = [[tuple(Fraction(str(x)) for x in p) for p in side] for side in (feet, heads)]
    x, y, tau = ([Fraction(0)] * (highest + 1) for _ in range(3))
    x[1] = Fraction(1)

    def times(a, b):
        return [sum(a[i] * b[k - i] for i in range(k + 1)) for k in range(highest + 1)]

    def lengths(k):
        """Coefficient k of ``(1 + τ²)² (|head - foot|² - l²)`` of every bar."""
        found, one = [], [Fraction(1)] + [Fraction(0)] * highest
        plus = [a + b for a, b in zip(one, times(tau, tau), strict=True)]
        minus = [a - b for a, b in zip(one, times(tau, tau), strict=True)]
        for foot, head in zip(*exact, strict=True):
            p = [h - g for h, g in zip(head, exact[1][0], strict=True)]
            base = [g - f for g, f in zip(exact[1][0], foot, strict=True)]
            dx = [a + base[0] * o for a, o in zip(x, one, strict=True)]
            dy = [a + base[1] * o for a, o in zip(y, one, strict=True)]
            u = [
                a + p[0] * m - 2 * p[1] * s
                for a, m, s in zip(times(plus, dx), minus, tau, strict=True)
            ]
            v = [
                a + p[1] * m + 2 * p[0] * s
                for a, m, s in zip(times(plus, dy), minus, tau, strict=True)
            ]
            square = sum((h - f) ** 2 for h, f in zip(head, foot, strict=True))
            total = [a + b for a, b in zip(times(u, u), times(v, v), strict=True)]
            found.append((total[k] - square * times(plus, plus)[k]) / 2)
        return found

    for k in range(1, highest + 1):
        b = lengths(k)
        columns = []
        for series in (y, tau):
            series[k] = Fraction(1)
            columns.append([a - c for a, c in zip(lengths(k), b, strict=True)])
            series[k] = Fraction(0)
        solution = solved(columns, b)
        if solution is None:
            return k
        y[k], tau[k] = solution
    return None


def solved(columns, b):
    """Numbers (y, τ) with ``y c₀ + τ c₁ = -b``, exactly, or None; c₀, c₁ independent."""
    (p, q), rows = columns, range(len(b))
    for i in rows:
        for j in rows:
            if det := p[i] * q[j] - p[j] * q[i]:
                y = (-b[i] * q[j] + b[j] * q[i]) / det
                t = (-p[i] * b[j] + p[j] * b[i]) / det
                fits = all(y * p[k] + t * q[k] == -b[k] for k in rows)
                return (y, t) if fits else None
    raise AssertionError("columns are dependent")


@pytest.mark.parametrize("name", STRUCTURES)
def test_a_structure_is_refused_with_the_order_at_which_it_stops_closing(name, tmp_path):
    feet, heads, order = STRUCTURES[name]
    assert order_of_closure(feet, heads) == order
    with pytest.raises(MobilityError, match=f"not mobile at order {order};") as caught:
        kinematics.load(platform(tmp_path, feet, heads))
    error = caught.value
    assert error.order == order
    assert set(error.joints) == {"a0", "a1", "a2", "b0", "b1", "b2"}
    assert "moves only infinitesimally" in str(error) and "made.urdf" in str(error)


def test_three_equal_bars_move():
    """Overconstrained, and its conditions vanish with all bars at any angle."""
    feet, heads = [(0, 0), (1, 0), (2, 0.3)], [(0.2, 1), (1.2, 1), (2.2, 1.3)]
    assert order_of_closure(feet, heads) is None


def test_the_design_space_of_three_equal_bars(tmp_path):
    path = platform(tmp_path, [(0, 0), (1, 0), (2, 0.3)], [(0.2, 1), (1.2, 1), (2.2, 1.3)])
    linkage = kinematics.load(path)
    assert linkage.mobility == 1 and linkage.planar and not linkage.notices
    found = design_space(linkage)
    # Momentum ``[ξ, p]`` of three bars that turn alike and a platform that only translates,
    # in a frame at each foot: p = Σ mc of the bars + m_top r, ξ = Σ Ezz + feet × p.
    assert (found.rank, found.nullity) == (5, 11) and found.settled
    for angle in (-1.0, 0.7):
        q = joint_positions(linkage, [angle])
        assert np.abs(q) == pytest.approx(np.full(6, abs(angle)), abs=1e-12)
        X = momentum_regressor(linkage, [angle]).reshape(-1, found.basis.shape[0])
        assert np.abs(X @ found.basis).max() < 1e-12


@pytest.mark.parametrize("bars", [3, 4])
def test_a_singular_pose_with_one_branch_is_left(bars, tmp_path):
    """Three coupled cranks in line: the third rules out the antiparallelogram."""
    feet, heads = (points[:bars] for points in COLLINEAR)
    linkage = kinematics.load(platform(tmp_path, feet, heads))
    (text,) = notices(linkage, "left_singular_pose")
    assert "2 degrees of freedom there at first order, 1 elsewhere" in text
    moved = {name: float(x) for name, x in re.findall(r"(\w+)=(-?[\d.]+)", text)}
    assert moved.pop("b0") == pytest.approx(-moved["a0"], abs=1e-3)
    assert set(moved) == {f"a{i}" for i in range(bars)} and linkage.mobility == 1
    assert len(set(moved.values())) == 1 and abs(moved["a0"]) > 0.2
    regular = kinematics.load(platform(tmp_path, feet, heads, turn=0.9, name="other"))
    assert not notices(regular, "left_singular_pose")
    found, given = (design_space(each) for each in (linkage, regular))
    assert [o.rank for o in found.orders] == [o.rank for o in given.orders]
    assert_same_bodies(linkage, regular)


def assert_same_bodies(linkage, other):
    """Parameters and joints of two poses of a linkage agree in the frames of its links."""
    frames = [{b.name: b.frame for b in each.bodies} for each in (linkage, other)]
    for one, two in zip(linkage.bodies, other.bodies, strict=True):
        z = [displace_parameters(b.inertia, np.linalg.inv(b.frame)) for b in (one, two)]
        if one.name != "top":  # its frame turns with the bars of the file
            assert z[0] == pytest.approx(z[1], abs=1e-12)
    lengths = []
    for each, places in zip((linkage, other), frames, strict=True):
        points = {j.name: j.point for j in each.joints}
        lengths.append([np.linalg.norm(points[f"b{i}"] - points[f"a{i}"]) for i in range(3)])
        assert points["b0"] == pytest.approx(places["top"][:3, 3], abs=1e-12)
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-12)


def test_a_bifurcation_is_refused_and_lists_the_modes(tmp_path):
    """Parallelogram and antiparallelogram meet: at a0 = t the cranks turn t, or about 3 t."""
    feet, heads = (points[:2] for points in COLLINEAR)
    with pytest.raises(MeetingModesError, match="2 modes of motion meet there") as caught:
        kinematics.load(platform(tmp_path, feet, heads))
    assert set(caught.value.joints) == {"a0", "b0", "a1", "b1"}
    nullities = []
    for mode in caught.value.modes:
        path = swung(tmp_path, mode.positions, f"pose{mode.number}")
        found = design_space(kinematics.load(path))
        nullities.append(found.nullity)
        assert design_space(mode.linkage).nullity == found.nullity
        part = f"mode {mode.number}: mobility 1, at a0={mode.positions['a0']:.3g}, "
        assert part in str(caught.value)
    assert nullities == [7, 5]


@pytest.mark.table(1)
@pytest.mark.parametrize("arms", [["base"], ["top"], ["base", "top", "bar0"]])
def test_a_bifurcation_counts_the_freedoms_of_the_linkage(arms, tmp_path):
    """Arms on links of the loop add a freedom each, here and elsewhere."""
    feet, heads = (points[:2] for points in COLLINEAR)
    path = platform(tmp_path, feet, heads)
    more = []
    for name in arms:
        more += [link(f"arm_{name}", **MASS)]
        more += [joint(f"j_{name}", "continuous", name, f"arm_{name}", along([0, 0, 0]), Z)]
    path.write_text(path.read_text().replace("</robot>", "".join(more) + "</robot>"))
    with pytest.raises(MeetingModesError) as caught:
        kinematics.load(path)
    mobility = [(mode.mobility, mode.linkage.mobility) for mode in caught.value.modes]
    assert mobility == [(1 + len(arms),) * 2] * 2


def swung(folder, angle, name):
    """The collinear parallelogram, with the angles of its tree joints in the file."""
    (foot, other), (head, _) = (points[:2] for points in COLLINEAR)

    def placed(d, turn):
        H = along([*d, 0.0])
        H[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        return H

    return saved(
        folder,
        link("base"),
        *(link(each, **MASS) for each in ("bar0", "top", "bar1")),
        joint("a0", "continuous", "base", "bar0", placed(foot, angle["a0"]), Z),
        joint("b0", "continuous", "bar0", "top", placed(head, angle["b0"]), Z),
        joint("a1", "continuous", "base", "bar1", placed(other, angle["a1"]), Z),
        loop("b1", "revolute", ("bar1", "top"), (along([0.5, 0, 0]), along([1, 0, 0])), Z),
        name=name,
    )


def test_loops_apart_are_looked_at_apart(tmp_path):
    """A flat parallelogram carried by an arm: the arm is not at fault."""
    parts = [link("base"), link("arm", **MASS), *(link(f"l{i}", **MASS) for i in range(3))]
    parts += [
        joint("shoulder", "continuous", "base", "arm", along([0, 0, 0]), Z),
        joint("a", "continuous", "arm", "l0", along([0.3, 0, 0]), Z),
        joint("b", "continuous", "l0", "l1", along([0.5, 0, 0]), Z),
        joint("d", "continuous", "arm", "l2", along([1.3, 0, 0]), Z),
        loop("c", "revolute", ("l1", "l2"), (along([1, 0, 0]), along([0.5, 0, 0])), Z),
    ]
    with pytest.raises(MeetingModesError, match="2 modes of motion") as caught:
        kinematics.load(saved(tmp_path, *parts))
    assert set(caught.value.joints) == {"a", "b", "c", "d"}


@pytest.mark.parametrize("turn", [0.002, -0.01, 0.03, 0.05])
def test_a_pose_near_a_singular_one_is_left(turn, tmp_path):
    """There round-off is amplified order by order, so ranks would be wrong."""
    feet, heads = (points[:2] for points in COLLINEAR)
    try:
        linkage = kinematics.load(platform(tmp_path, feet, heads, turn))
    except MobilityError as error:
        assert abs(turn) < 0.003 and "2 modes of motion" in str(error)
        return
    (text,) = notices(linkage, "left_singular_pose")
    assert "nearly singular" in text
    a0 = float(re.search(r"a0=(-?[\d.]+)", text)[1])
    assert a0 * turn > 0 and abs(a0) > 0.2  # away from the singular pose, not across it
    assert design_space(linkage).nullity == 7


@pytest.mark.table(1)
@pytest.mark.parametrize("turn", [1e-3, 1e-6, 1e-9])
def test_a_pose_that_cannot_be_told_from_a_singular_one_is_refused(turn, tmp_path):
    feet, heads = (points[:2] for points in COLLINEAR)
    with pytest.raises(MobilityError, match="2 modes of motion meet there"):
        kinematics.load(platform(tmp_path, feet, heads, turn))


@pytest.mark.slow
def test_loops_far_from_closing_are_a_structure_at_order_two(tmp_path):
    """Two freedoms at first order, none at second: the least opening grows as the square."""
    feet, heads = [(0, 0), (1, 0), (2.5, 0)], [(0.4, 0), (1.5, 0), (2.2, 0)]
    with pytest.raises(MobilityError, match="2 degrees of freedom .* not mobile at order 2"):
        kinematics.load(platform(tmp_path, feet, heads))
    least = [opening(feet, heads, h) for h in (0.1, 0.05)]
    assert np.log2(least[0] / least[1]) == pytest.approx(2.0, abs=0.1)


def opening(feet, heads, distance):
    """Least error of bar lengths of a platform at a distance in its two freedoms (y, φ)."""
    feet, heads = np.array(feet, float), np.array(heads, float)
    length = np.linalg.norm(heads - feet, axis=1)

    def errors(x):
        R = np.array([[np.cos(x[2]), -np.sin(x[2])], [np.sin(x[2]), np.cos(x[2])]])
        now = heads[0] + x[:2] + (heads - heads[0]) @ R.T
        apart = np.linalg.norm(now - feet, axis=1) - length
        return [*apart, 10 * (np.hypot(x[1], x[2]) - distance)]

    starts = [distance * np.array([0, np.cos(a), np.sin(a)]) for a in np.arange(0, 6.3, 0.2)]
    return min(np.linalg.norm(least_squares(errors, s, xtol=1e-15).fun[:3]) for s in starts)


def at_dead_centre(folder, digits, mark=""):
    """A four-bar with crank 1 and coupler 3 in line, ground 4 and rocker 2.5."""
    x = (16 + 16 - 2.5**2) / 8
    C = np.array([x, np.sqrt(16 - x * x), 0.0])
    B, C, D = np.round(C / 4, digits), np.round(C, digits), np.array([4.0, 0, 0])
    return saved(
        folder,
        link("base"),
        *(link(name, **MASS) for name in ("crank", "coupler", "rocker")),
        joint("a", "continuous", "base", "crank", along([0, 0, 0]), Z),
        joint("b", "continuous", "crank", "coupler", along(B), Z),
        joint("d", "continuous", "base", "rocker", along(D), Z, marks=mark),
        loop("c", "revolute", ("coupler", "rocker"), (along(C - B), along(C - D)), Z),
    )


@pytest.mark.parametrize("digits", [16, 6])
@pytest.mark.parametrize("by_file", [True, False])
def test_the_rocker_cannot_drive_a_four_bar_from_its_dead_centre(digits, by_file, tmp_path):
    path = at_dead_centre(tmp_path, digits, 'independent="true"' if by_file else "")
    with pytest.raises(CoordinateError, match="a dead centre") as caught:
        kinematics.load(path, inputs=None if by_file else ["d"])
    assert caught.value.names == ("d",) and caught.value.valid[0] == "a"
    assert "d" not in caught.value.valid and "choose from a" in str(caught.value)
    assert kinematics.load(path, inputs=["a"]).mobility == 1
