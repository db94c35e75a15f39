"""The whole numbers that reports give of linkages: ranks, nullities and levels of certainty."""

import tempfile
from pathlib import Path

import kinematics
from balance import certify, design_space
from tests.support.urdf_text import INERTIAL

MODELS = (
    "four_bar_general",
    "four_bar_antiparallelogram",
    "four_bar_parallelogram",
    "five_bar",
    "slider_crank",
    "rusr",
    "four_bar_spherical",
    "hprs",
    "pantograph",
    "bennett",
    "six_bar_watt",
    "two_rrr",
    "three_rsr",
    "sarrus",
)
# A parallelogram that is open at the pose of the file: exact arithmetic does not apply, and
# there is a parallel part.
OPEN = f"""<robot name="open"><link name="base"/><link name="crank">{INERTIAL}</link>
<link name="coupler">{INERTIAL}</link><link name="rocker">{INERTIAL}</link>
<joint name="u" type="continuous" independent="true"><parent link="base"/>
  <child link="crank"/><axis xyz="0 0 1"/></joint>
<joint name="a" type="continuous"><origin xyz="0 1 0"/><parent link="crank"/>
  <child link="coupler"/><axis xyz="0 0 1"/></joint>
<joint name="b" type="continuous"><origin xyz="2 0 0"/><parent link="base"/>
  <child link="rocker"/><axis xyz="0 0 1"/></joint>
<loop name="c" type="revolute"><axis xyz="0 0 1"/>
  <predecessor link="coupler"><origin xyz="2 0 0"/></predecessor>
  <successor link="rocker"><origin xyz="0.6 0.8 0"/></successor></loop></robot>"""


def answers():
    """The whole numbers of reports, and their levels of certainty, by model."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "open.urdf")
        path.write_text(OPEN, encoding="utf-8")
        for model in (*MODELS, path):
            space = design_space(kinematics.load(model))
            certainty = certify(space).certainty
            found[Path(model).stem] = [
                [order.rank for order in space.orders],
                space.rank,
                space.nullity,
                space.serial_nullity,
                space.kmax,
                space.poses,
                certainty.level,
                certainty.poses,
            ]
            if model != path:
                # Positions that Newton's method finds differ by the last digit, so that exact
                # arithmetic bounds the ranks of another linkage.
                found[Path(model).stem] += [certainty.rank, certainty.nullity]
    return found
