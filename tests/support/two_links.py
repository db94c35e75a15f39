"""Two links in a plane whose moment vanishes: how the first one turns, in closed form."""

import numpy as np
from scipy.integrate import quad

LENGTHS, MASSES = (0.5, 0.4), (3.0, 2.0)


def turned(start, end, first=1.0, second=1.0):
    """How far the first joint turns while the second goes from start to end."""
    (l1, l2), (m1, m2) = LENGTHS, MASSES
    c1, c2 = l1 / 2, l2 / 2
    I1, I2 = first * m1 * l1**2 / 12, second * m2 * l2**2 / 12

    def slope(q2):
        coupling = I2 + m2 * (c2**2 + l1 * c2 * np.cos(q2))
        whole = I1 + I2 + m1 * c1**2 + m2 * (l1**2 + c2**2 + 2 * l1 * c2 * np.cos(q2))
        return -coupling / whole

    return quad(slope, start, end, epsabs=1e-13)[0]


def tip(q1, q2):
    """The end of the second link in the plane."""
    angles = np.array([q1, q1 + q2])
    return np.array(LENGTHS) @ np.column_stack([np.cos(angles), np.sin(angles)])
