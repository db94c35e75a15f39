"""Studies of machines from books and papers: their figures by circles that cross.

Points and vectors of the plane are complex numbers. Derivatives along a closed motion are those
of its Fourier series.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from tests.support.source_files import ROOT

MACHINES = ROOT / "docs" / "machines"
SAMPLES = 720


def rate(values, period=2.0 * np.pi):
    """Derivative of an even number of samples of one period, the first one not repeated."""
    orders = 2.0j * np.pi * np.fft.fftfreq(len(values), period / len(values))
    orders[len(values) // 2] = 0.0  # this order has no sign
    return np.fft.ifft(orders * np.fft.fft(values))


def meeting_point(a, r, b, s, side):
    """Point at the distance r from a and s from b, to one side of the way from a to b."""
    along = (r**2 - s**2 + abs(b - a) ** 2) / (2.0 * abs(b - a))
    return a + (along + side * 1j * np.sqrt(r**2 - along**2)) * (b - a) / abs(b - a)


class Moving:
    """Bodies along a motion: mass, moment of inertia, centres and directions (samples,)."""

    def __init__(self, bodies, period):
        self.bodies, self.period = bodies, period

    def rate(self, values):
        return rate(values, self.period)

    def force(self):
        """Rate of the linear momentum."""
        return self.rate(self.rate(sum(m * centre for m, _, centre, _ in self.bodies)))

    def moment(self, point=0.0):
        """Rate of the angular momentum about a point."""
        total = 0.0
        for m, inertia, centre, direction in self.bodies:
            turn = self.rate(direction) / direction
            total = total + m * np.conj(centre - point) * self.rate(centre) + inertia * turn
        return self.rate(total.imag).real

    def energy(self):
        """Kinetic energy."""
        return 0.5 * sum(
            m * abs(self.rate(centre)) ** 2 + inertia * abs(self.rate(direction)) ** 2
            for m, inertia, centre, direction in self.bodies
        )


def rms(values):
    return np.sqrt(np.mean(abs(values) ** 2))


# --- Andrews' squeezing mechanism ----------------------------------------------------------

# Hairer and Wanner, section VII.7: masses, moments of inertia, centres in the book's frames.
SQUEEZER = {
    "K1": (0.04325, 2.194e-6, 0.00092),
    "K2": (0.00365, 4.410e-7, -0.0115),
    "K3": (0.02373, 5.255e-6, 0.01043 - 0.01874j),
    "K5": (0.07050, 1.169e-5, 0.02308 + 0.00916j),
    "K4": (0.00706, 5.667e-7, -0.00579j),
    "K7": (0.05498, 1.912e-5, -0.00449 - 0.01228j),
    "K6": (0.00706, 5.667e-7, 0.00579),
}
A, B = -0.06934 - 0.00227j, -0.03635 + 0.03273j
START = -0.0617138900142764496358948458001
TURN = 200.0 * np.pi
STEP = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)


def squeezer_frames(crank):
    """Origin and direction of each link at the angles of the crank."""
    pin = 0.007 * np.exp(1j * crank)
    P = meeting_point(pin, 0.028, B, 0.035, 1)
    E = meeting_point(A, 0.04, P, 0.02, 1)
    H = meeting_point(A, 0.04, P, 0.02, -1)
    return {
        "K1": (0.0 * pin, pin / 0.007),
        "K2": (pin, (pin - P) / 0.028),
        "K3": (B, (P - B) / -0.035j),
        "K5": (A, (E - A) / 0.04),
        "K4": (E, (P - E) / -0.02j),
        "K7": (A, (H - A) / -0.04j),
        "K6": (H, (P - H) / 0.02),
    }


def squeezer(weights=()):
    """The press in one revolution, with weights (link, mass, centre in its frame)."""
    frames = squeezer_frames(START + STEP)
    bodies = [(link, *values) for link, values in SQUEEZER.items()]
    bodies += [(link, m, 0.0, centre) for link, m, centre in weights]
    moving = []
    for link, m, inertia, centre in bodies:
        origin, direction = frames[link]
        moving.append((m, inertia, origin + centre * direction, direction))
    return Moving(moving, 2.0 * np.pi / TURN)


def test_the_file_of_the_squeezer_is_the_table_of_the_book():
    linkage = kinematics.load(MACHINES / "squeezer.urdf")
    frames = squeezer_frames(np.array([START]))
    for body, (link, (m, inertia, centre)) in zip(
        linkage.bodies, SQUEEZER.items(), strict=True
    ):
        known = balance.bodies.mass_properties(body.inertia)
        (place,) = frames[link][0] + centre * frames[link][1]
        assert known.mass == pytest.approx(m, rel=1e-12)
        assert known.com[:2] == pytest.approx([place.real, place.imag], abs=1e-12)
        assert known.inertia[2, 2] == pytest.approx(inertia, rel=1e-9)


def test_the_squeezer_starts_as_the_books_print():
    """The torque of the example accelerates the crank by 14222.44 rad/s² from rest."""
    (inertia, *_) = 2.0 * squeezer().energy() / TURN**2
    assert 0.033 / inertia == pytest.approx(14222.4439199541, rel=1e-7)


def test_the_rows_of_the_squeezer():
    """Force, moment and torque without weights, and what the best on the crank leaves."""
    press = squeezer()
    force, point = press.force(), -0.02966 + 0.003249j
    assert abs(force).max() == pytest.approx(119.0, rel=5e-3)
    assert rms(force) == pytest.approx(81.57, rel=1e-4)
    assert abs(press.moment(point)).max() == pytest.approx(1.33, rel=5e-3)
    assert rms(press.moment(point)) == pytest.approx(0.7734, rel=5e-4)
    torque = press.rate(press.energy()).real / TURN
    assert abs(torque).max() == pytest.approx(0.3667, rel=1e-3)
    # A first moment w on the crank adds -w ω² exp(iβ): a Fourier coefficient of the force.
    best = np.mean(force * np.exp(-1j * (START + STEP)))
    left = np.sqrt(rms(force) ** 2 - abs(best) ** 2)
    assert left == pytest.approx(48.47, rel=1e-3)
    weight = 0.01027 * np.hypot(0.01515, 0.00568)
    assert abs(best) / TURN**2 == pytest.approx(weight, rel=1e-3)


def test_four_weights_take_the_force_of_the_squeezer():
    """Those of the page, whose digits leave a little; without one of them much is left."""
    weights = [
        ("K1", 0.0028685, -0.01912),
        ("K3", 0.025756, -0.00961 + 0.024858j),
        ("K5", 0.086822, -0.021052 - 0.007438j),
        ("K7", 0.035183, 0.007017 + 0.024893j),
    ]
    before = rms(squeezer().force())
    assert rms(squeezer(weights).force()) < 3e-4 * before
    for k in range(4):
        assert rms(squeezer(weights[:k] + weights[k + 1 :]).force()) > 0.1 * before


@pytest.mark.slow
def test_the_squeezer_shakes_as_its_circles_say():
    """At every sample, by Pinocchio and our series; and the drive torque."""
    check = balance.verify(MACHINES / "squeezer.urdf", speed="6000rpm")
    (run,) = check.runs
    assert run.trajectory.u[:SAMPLES, 0] == pytest.approx(STEP, abs=1e-9)
    force = squeezer().force()
    ours = run.shaking[:SAMPLES, 3] + 1j * run.shaking[:SAMPLES, 4]
    assert ours == pytest.approx(force, abs=1e-6 * 119.0)
    assert check.drive_peaks["crank"] == pytest.approx(0.3667, rel=1e-3)


# --- the needle drive of a sewing machine --------------------------------------------------

# Lengths in print: O2A, AB, O4B, BC, O4C, CD, and O4 from O2; masses and frames of ours.
O2A, AB, O4B, BC, O4C, CD = 0.016, 0.0357, 0.0224, 0.016, 0.0274, 0.0381
O4, PRINTED_POSE, STITCHES = -0.0142 + 0.0381j, 0.75 * np.pi, 1000.0 * 2.0 * np.pi / 60.0
ARM = np.arccos((O4B**2 + O4C**2 - BC**2) / (2.0 * O4B * O4C))
BAR, NEEDLE_BAR = 7850.0 * 0.008 * 0.004, 7850.0 * np.pi * 0.0035**2 * 0.13
MIDDLE = -0.001059 + 0.01341j


def needle_pins(crank):
    """Points A, B, C and D at the angles of the crank; D is on the line of the needle."""
    A = O2A * np.exp(1j * crank)
    B = meeting_point(A, AB, O4, O4B, -1)
    C = O4 + O4C * np.exp(-1j * ARM) * (B - O4) / O4B
    return A, B, C, 1j * (C.imag - np.sqrt(CD**2 - C.real**2))


def needle_drive(weights=()):
    """The drive in one revolution: bars between pins, and weights (link, mass, centre)."""
    A, B, C, D = needle_pins(PRINTED_POSE + STEP)
    ends = {
        "crank": (0.0 * A, A),
        "coupler": (A, B),
        "rocker": (O4 + 0.0 * B, B),
        "link": (C, D),
    }
    bodies = [(NEEDLE_BAR, 0.0, D, 1.0 + 0.0 * D)]
    for start, end in (*ends.values(), (O4 + 0.0 * C, C)):
        length = abs(end[0] - start[0])
        mass, direction = BAR * length, (end - start) / length
        inertia = mass * (length**2 + 0.008**2) / 12.0
        bodies.append((mass, inertia, (start + end) / 2.0, direction))
    for link, mass, centre in weights:
        start, end = ends[link]
        direction = (end - start) / abs(end - start)
        bodies.append((mass, 0.0, start + centre * direction, direction))
    return Moving(bodies, 2.0 * np.pi / STITCHES)


def test_the_needle_drive_is_where_the_notes_print_it():
    """e = 2.694 cm, angles 14.29, 48.94, 92.23, 62.65 and 15.43 degrees, s = 1.12 cm."""
    A, B, C, D = (point[0] for point in needle_pins(np.array([PRINTED_POSE])))

    def angle(at, first, second):
        return np.degrees(abs(np.angle((first - at) / (second - at))))

    assert abs(A - O4) == pytest.approx(0.02694, abs=6e-6)
    printed = (
        (angle(O4, 0.0, A), 14.29),
        (angle(B, O4, A), 48.94),
        (angle(O4, A, B), 92.23),
        (angle(O4, O4 - 1j, C), 62.65),
        (angle(C, C - 1j, D), 15.43),
        (np.degrees(ARM), 35.73),
    )
    for ours, theirs in printed:
        assert ours == pytest.approx(theirs, abs=0.011)
    assert -D.imag == pytest.approx(0.0112, abs=5e-5)
    assert np.ptp(needle_pins(STEP)[3].imag) == pytest.approx(0.0288, abs=5e-5)
    linkage = kinematics.load(MACHINES / "sewing_machine.urdf")
    places = {joint.name: complex(*joint.point[:2]) for joint in linkage.joints}
    for name, point in (("A", A), ("C", C)):
        assert abs(places[name] - point) < 1e-12
    assert sum(body.inertia[0] for body in linkage.bodies) == pytest.approx(
        sum(body[0] for body in needle_drive().bodies), rel=1e-5
    )


def test_the_rows_of_the_needle_drive():
    """Force, moment and torque; what the best weight on the crank and shafts leave."""
    drive = needle_drive()
    force = drive.force()
    assert abs(force).max() == pytest.approx(29.6, rel=2e-3)
    assert rms(force) == pytest.approx(12.78, rel=5e-4)
    assert abs(drive.moment(MIDDLE)).max() == pytest.approx(0.114, rel=5e-3)
    torque = drive.rate(drive.energy()).real / STITCHES
    assert abs(torque).max() == pytest.approx(0.4494, rel=1e-3)
    orders = np.fft.fft(force) / SAMPLES
    left = np.sqrt(rms(force) ** 2 - abs(orders[1]) ** 2)
    assert left / rms(force) == pytest.approx(0.896, abs=5e-4)
    first, second = (abs(orders[k]) + abs(orders[-k]) for k in (1, 2))
    assert (first, second) == pytest.approx((10.3, 13.2), rel=5e-3)
    second_taken = orders.copy()
    second_taken[[2, -2]] = 0.0
    rest = rms(SAMPLES * np.fft.ifft(second_taken))
    assert rest / rms(force) == pytest.approx(0.68, abs=5e-4)
    for taken, share, peak in ((1, 0.821, 20.26), (2, 0.369, 11.43)):
        for k in (taken, -taken):
            orders[k] = 0.0
        rest = SAMPLES * np.fft.ifft(orders)
        assert rms(rest) / rms(force) == pytest.approx(share, abs=6e-4)
        assert abs(rest).max() == pytest.approx(peak, rel=5e-3)


def test_the_needle_rests_at_its_lower_end():
    """A slider-crank with its stroke and link pulls 2.5 times as much once as twice a turn."""
    needle = needle_pins(STEP)[3].imag
    stroke = np.ptp(needle)
    assert np.mean(needle < needle.min() + 0.1 * stroke) == pytest.approx(0.48, abs=0.005)
    across = 0.5 * stroke * np.sin(STEP)
    slider = 0.5 * stroke * np.cos(STEP) + np.sqrt(CD**2 - across**2)
    orders = abs(np.fft.fft(rate(rate(slider))))
    assert orders[1] / orders[2] == pytest.approx(2.5, abs=0.06)


def test_three_weights_take_the_force_of_the_needle_drive():
    """Those of the page, whose digits leave a little; moment and torque are their price."""
    weights = [
        ("crank", 0.0026246, -0.039586),
        ("rocker", 0.15492, -0.01894 + 0.012864j),
        ("link", 0.072274, -0.023226),
    ]
    drive, before = needle_drive(weights), rms(needle_drive().force())
    assert rms(drive.force()) < 3e-4 * before
    # Of points: those of the page have an extent, and 3.35 and 1.94 N m.
    assert abs(drive.moment(MIDDLE)).max() == pytest.approx(2.997, rel=5e-3)
    torque = drive.rate(drive.energy()).real / STITCHES
    assert abs(torque).max() == pytest.approx(1.741, rel=5e-3)
    without = [
        rms(needle_drive(weights[:k] + weights[k + 1 :]).force()) / before for k in range(3)
    ]
    assert without[0] == pytest.approx(0.089, abs=1e-3) and min(without[1:]) > 0.5


@pytest.mark.slow
def test_the_needle_drive_shakes_as_its_circles_say():
    """At every sample, by Pinocchio and our series; and the drive torque."""
    check = balance.verify(MACHINES / "sewing_machine.urdf", speed="1000rpm")
    (run,) = check.runs
    assert run.trajectory.u[:SAMPLES, 0] == pytest.approx(STEP, abs=1e-9)
    ours = run.shaking[:SAMPLES, 3] + 1j * run.shaking[:SAMPLES, 4]
    assert ours == pytest.approx(needle_drive().force(), abs=1e-5 * 29.6)
    moment = run.shaking[:SAMPLES, 2]
    assert moment == pytest.approx(needle_drive().moment(), abs=1e-4 * 0.114)
    assert check.drive_peaks["O2"] == pytest.approx(0.4494, rel=1e-3)


# --- DUAL-V --------------------------------------------------------------------------------

LENGTH = 0.25
LOWER, UPPER, PLATFORM = (2700.0 * x for x in (0.25 * 3e-2 * 15e-3, 0.25 * 2e-2 * 1e-2, 7e-5))
# Pivots and the side to which each leg bends; joints of the platform.
LEGS = (
    (0.3 - 0.05j, 1, -0.05j),
    (-0.3 - 0.05j, -1, -0.05j),
    (-0.3 + 0.05j, 1, 0.05j),
    (0.3 + 0.05j, -1, 0.05j),
)
WEIGHT, BEHIND, WEIGHT_INERTIA = 0.96525, np.hypot(0.069751, 0.093002), 3.8357e-4
TIME = np.linspace(0.0, 0.4, 800, endpoint=False)


def dual_v(way, weight):
    """The 4-RRR along a way of its platform, which does not turn."""
    bodies = [(PLATFORM, 0.0, way, np.ones_like(way))]
    for pivot, side, joint in LEGS:
        tip = way + joint
        elbow = meeting_point(pivot, LENGTH, tip, LENGTH, side)
        lower, upper = (elbow - pivot) / LENGTH, (tip - elbow) / LENGTH
        for m, width, middle, along in (
            (LOWER, 0.03, pivot + 0.5 * LENGTH * lower, lower),
            (UPPER, 0.02, elbow + 0.5 * LENGTH * upper, upper),
        ):
            bodies.append((m, m * (LENGTH**2 + width**2) / 12.0, middle, along))
        bodies.append((weight, weight / WEIGHT * WEIGHT_INERTIA, pivot - BEHIND * lower, lower))
    return Moving(bodies, 0.4)


def there_and_back(end):
    s = TIME / 0.4
    return end * 64.0 * s**3 * (1.0 - s) ** 3


def test_the_weights_of_the_dual_v_by_hand():
    moment = LENGTH * (LOWER / 2.0 + 1.5 * UPPER + PLATFORM / 2.0)
    assert moment == pytest.approx(0.1122, rel=1e-3)
    assert WEIGHT * BEHIND == pytest.approx(moment, rel=1e-4)
    assert 4.0 * WEIGHT == pytest.approx(3.861, rel=1e-4)


@pytest.mark.parametrize(
    ("end", "push"), [(0.06, (6.33, 9.58)), (0.06j, (7.58, 12.64)), (0.045 + 0.045j, None)]
)
def test_the_dual_v_along_its_lines_and_a_diagonal(end, push):
    """No force with the weights; a moment on the diagonal alone; the push of the motors."""
    way = there_and_back(end)
    bare, balanced = (dual_v(way, weight) for weight in (0.0, WEIGHT))
    assert abs(balanced.force()).max() < 1e-4 * abs(bare.force()).max()
    moments = [abs(each.moment()).max() for each in (bare, balanced)]
    if push is None:
        assert moments == pytest.approx([0.338, 0.514], rel=3e-3)
        return
    assert max(moments) < 1e-8
    speed = rate(way / end * 0.06, 0.4).real
    moving = abs(speed) > 1e-2
    for each, most in zip((bare, balanced), push, strict=True):
        force = each.rate(each.energy()).real[moving] / speed[moving]
        assert abs(force).max() == pytest.approx(most, rel=5e-3)


def test_the_file_of_the_dual_v_has_its_bars():
    linkage = kinematics.load(MACHINES / "dual_v.urdf")
    masses = {body.name: body.inertia[0] for body in linkage.bodies}
    assert sum(masses.values()) == pytest.approx(4.0 * (LOWER + UPPER) + PLATFORM, rel=1e-3)
    known = dual_v(np.array([0j, 0j]), 0.0)
    places = sum(m * centre[0] for m, _, centre, _ in known.bodies)
    ours = sum(body.inertia[1:3] for body in linkage.bodies)
    assert ours == pytest.approx([places.real, places.imag], abs=1e-6)
