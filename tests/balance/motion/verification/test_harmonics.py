"""Harmonics of the shaking of a crank, beside those of known loads and of a book."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.motion.verification.harmonics import harmonic_peaks


def test_harmonics_of_known_loads():
    """A force on a line, one that rotates in a plane askew, and a mean that is none."""
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    plane = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 2)))[0].T
    load = 3.0 * np.cos(angle)[:, None] * plane[0] + 7.0
    load = load + 4.0 * (np.column_stack([np.cos(2 * angle), np.sin(2 * angle)]) @ plane)
    ellipse = np.column_stack([5.0 * np.cos(3 * angle + 1.0), 2.0 * np.sin(3 * angle + 1.0)])
    sizes = harmonic_peaks(load + ellipse @ plane, 4)
    np.testing.assert_allclose(sizes, [3.0, 4.0, 5.0, 0.0], atol=1e-9)


def test_a_piston_shakes_as_its_series_says(tmp_path):
    """A piston alone, on a massless rod: m r ω² cos θ + (r / l) m r ω² cos 2θ + …

    With ``s = r cos θ + √(l² - r² sin² θ)``, whose even coefficients are those of the
    elliptic integrals of textbooks, here by a rule of 4096 points.
    """
    r, rod, mass, speed = 0.05, 0.2, 0.4, 100.0
    path = tmp_path / "piston.urdf"
    path.write_text(
        f"""<robot name="piston"><link name="block"/><link name="crank"/><link name="rod"/>
        <link name="piston"><inertial><mass value="{mass}"/>
          <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="shaft" type="continuous" independent="true"><parent link="block"/>
          <child link="crank"/><axis xyz="0 0 1"/></joint>
        <joint name="pin" type="continuous"><parent link="crank"/><child link="rod"/>
          <origin xyz="0 {r} 0"/><axis xyz="0 0 1"/></joint>
        <joint name="cylinder" type="prismatic"><parent link="block"/><child link="piston"/>
          <origin xyz="{np.sqrt(rod**2 - r**2)} 0 0"/><axis xyz="1 0 0"/></joint>
        <loop name="wrist" type="revolute">
          <predecessor link="rod"><origin xyz="{np.sqrt(rod**2 - r**2)} {-r} 0"/></predecessor>
          <successor link="piston"/><axis xyz="0 0 1"/></loop></robot>""",
        encoding="utf-8",
    )
    check = balance.verify(str(path), speed=speed)
    angle = 2.0 * np.pi * np.arange(4096) / 4096
    place = r * np.cos(angle) + np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    series = [2.0 * np.mean(place * np.cos(n * angle)) for n in range(1, 5)]
    wanted = mass * speed**2 * np.abs([n**2 * a for n, a in enumerate(series, start=1)])
    sizes = check.harmonics(4)
    assert sizes is not None
    np.testing.assert_allclose(sizes["force"], wanted, rtol=1e-9, atol=1e-9 * wanted[0])
    assert sizes["force"][0] == pytest.approx(mass * r * speed**2)
    assert sizes["force"][2] == 0.0
    assert check.to_dict()["speed"]["harmonics"] == sizes
    assert balance.verify(str(path)).harmonics(4) is None
