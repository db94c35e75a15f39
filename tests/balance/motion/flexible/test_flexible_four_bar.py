"""The four-bar with a flexible coupler, and linkages of files of which links bend.

[M] J. P. Meijaard, V. van der Wijk, Mechanism and Machine Theory 172, 104784, 2022, Sec. 5.
"""

from functools import cache

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.flexible.build_beam import BeamOptions
from balance.motion.flexible.drives import constant_speed, moment_rise, spin_up
from balance.motion.flexible.flex_data import moment_about
from balance.motion.flexible.flex_links import parse_flex_link
from balance.motion.flexible.from_linkage import flexible_linkage
from balance.motion.flexible.simulate import simulate
from balance.motion.flexible.support_points import support_points
from balance.motion.verification.trajectory import drive
from kinematics.errors import LinkageError
from tests.support.covering import number_of_cases
from tests.support.flexible_cases import four_bar_text

# Where the pivot of the rocker is, with the crank from (0, 0) to (0, ½) and the coupler to
# (1, ½): the figure with the assembly is missing in the source.
OPEN, CROSSED = (1.5, -0.5), (0.5, 1.5)
# Length of the coupler over the distance of its hinges, its supports, and the modes kept.
CASES = {
    "ends": (1.0, "", 3),
    "nodes": (0.5 / support_points(2).hinge, ",supports:2", 4),
    "gyration": (3**0.5, f",length:{3**0.5!r}", 3),
    "four points": (0.5 / support_points(4).hinge, ",supports:4", 8),
}


def flexible(tmp_path, case, bending=1.0, options=None, profile=None, beside=OPEN):
    """The four-bar of a case; rigid without bending stiffness."""
    mass, supports, modes = CASES[case]
    path = tmp_path / "four_bar.urdf"
    path.write_text(four_bar_text(mass, beside), encoding="utf-8")
    link = parse_flex_link(f"coupler=EI:{bending or 1.0},rhoA:1{supports}")
    return flexible_linkage(
        kinematics.load(path),
        [link] if bending else [],
        {"u1": profile or (spin_up(1.0, 2.0), False)},
        options or BeamOptions(elements=12, modes=modes),
    )


@cache
def peaks(folder, case, geometric=True, beside=OPEN):
    """Peak force, peak moment about the centre of mass, and drift, over 10 units of time."""
    modes = CASES[case][2]
    options = BeamOptions(max(6, 3 * modes // 2), modes, geometric=geometric)
    found = flexible(folder, case, options=options, beside=beside)
    motion = simulate(found.mechanism, 10.0, 201, rtol=1e-6)
    moment = np.abs(moment_about(motion, found.centre)).max()
    return motion.peak_force, moment, motion.energy_drift


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("four_bar")


RIGID = [("ends", 0.17045), ("gyration", 0.0), ("nodes", 0.04412), ("four points", 0.13631)]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "moment"), RIGID[: number_of_cases(1, 4)])
def test_the_rigid_four_bar(case, moment, tmp_path):
    """-m2 (L²/12 - 1/4) θ̈2 with the coupler's angle θ2, and no force: [M] Sec. 5.

    The open assembly: crank (0, 0) to (0, ½), coupler to (1, ½), rocker to (3/2, -½).
    """
    found = flexible(tmp_path, case, bending=0.0)
    motion = simulate(found.mechanism, 10.0, 1001, rtol=1e-7)
    about = moment_about(motion, found.centre)
    assert motion.peak_force < 1e-8
    length = CASES[case][0]
    k = [part.name for part in found.mechanism.parts].index("coupler")
    angle = motion.positions[:, found.mechanism.slices[k]][:, 2]
    step = motion.times[1]
    bend = np.diff(angle, 2) / step**2
    law = -length * (length**2 / 12.0 - 0.25) * bend
    assert about[1:-1] == pytest.approx(law, abs=5e-5)
    assert np.abs(about).max() == pytest.approx(moment, rel=1e-4, abs=1e-8)


REDUCTIONS = {
    "nodes": ((8, 14), (2.5, 4)),
    "four points": ((150, 250), (1.5, 2.2)),
    "gyration": ((8, 13), (4.5, 10)),
}
BRANCHES = [(case, beside) for beside in (OPEN, CROSSED) for case in REDUCTIONS]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "beside"), BRANCHES[: number_of_cases(2, 6)])
def test_supports_of_the_coupler_reduce_its_shaking(case, beside, folder):
    """[M] Figs. 10 to 12 and 14: peaks with hinges at the ends over those of the supports.

    Open: 13.4 and 3.5, 237 and 1.8, 8.9 and 5.5; crossed: 11.8 and 3.2, 234 and 1.9, 12.0 and
    8.8.
    """
    force, moment = REDUCTIONS[case]
    worst, here = (peaks(folder, one, beside=beside) for one in ("ends", case))
    assert force[0] < worst[0] / here[0] < force[1]
    assert moment[0] < worst[1] / here[1] < moment[1]
    assert max(worst[2], here[2]) < 1e-6


@pytest.mark.slow
def test_axial_stiffness_of_bent_beams_doubles_the_force(folder):
    """Without it, the reference case comes out at about half."""
    assert 0.4 < peaks(folder, "ends", False)[0] / peaks(folder, "ends")[0] < 0.6


@pytest.mark.slow
def test_rigid_links_shake_as_verify_says(tmp_path):
    """EI × 1e6 on the linkage of one file: the base reaction that `balance.verify` finds along
    the same motion, from Pinocchio, to 1e-4 of its peak.
    """
    path = tmp_path / "own.urdf"
    text = four_bar_text(1.0).replace('mass value="5.0"', 'mass value="2.0"')
    path.write_text(text, encoding="utf-8")
    linkage, profile = kinematics.load(path), spin_up(1.0, 0.4)
    found = flexible_linkage(
        linkage,
        [parse_flex_link("coupler=EI:1e6,rhoA:1")],
        {"u1": (profile, False)},
        BeamOptions(elements=4, modes=1, damping=2e-5),
    )
    motion = simulate(found.mechanism, 0.1, 11, rtol=1e-12, method="DOP853")
    columns = np.array([profile(t) for t in motion.times]).T[:, :, None]
    along = drive(linkage, motion.times, *columns)
    (run,) = balance.verify(linkage, motions=[along]).runs
    rigid = -run.shaking
    assert np.abs(rigid[:, 3:5]).max() > 0.5
    for ours, theirs in ((motion.force, rigid[:, 3:5]), (motion.moment, rigid[:, 2])):
        assert np.abs(ours - theirs)[1:].max() < 1e-4 * np.abs(theirs).max()


def test_energy_is_kept_and_damping_takes_it(tmp_path):
    """The balance of energy, work and losses closes with damping too, and less bends then."""
    force, bent = (moment_rise(0.05, 0.1), True), []
    for damping in (0.0, 0.05):
        options = BeamOptions(elements=6, modes=2, damping=damping)
        found = flexible(tmp_path, "ends", options=options, profile=force)
        motion = simulate(found.mechanism, 1.0, 51, rtol=1e-7, method="DOP853")
        assert motion.energy_drift < 1e-6
        bent.append(np.ptp(motion.force[25:], axis=0).max())
    assert bent[1] < 0.9 * bent[0]


@pytest.mark.slow
def test_both_integrators_and_all_modes_agree(tmp_path):
    """Refinement: more modes and elements, and the implicit method, change little."""
    found = []
    for elements, modes, method in ((4, 4, "DOP853"), (8, 6, "DOP853"), (4, None, "Radau")):
        options = BeamOptions(elements=elements, modes=modes)
        one = flexible(tmp_path, "ends", options=options)
        found.append(simulate(one.mechanism, 0.8, 81, rtol=1e-6, method=method))
    for other in found[1:]:
        assert np.abs(other.force - found[0].force).max() < 5e-3 * found[0].peak_force


def test_a_simulation_without_end_is_given_up(tmp_path, monkeypatch):
    """The line says where, and what to change."""
    monkeypatch.setattr("balance.motion.flexible.simulate.MOST_EVALUATIONS", 40)
    found = flexible(tmp_path, "ends", options=BeamOptions(elements=4, modes=2))
    with pytest.raises(LinkageError, match=r"slow at 0.* s: .* give a shorter duration"):
        simulate(found.mechanism, 5.0, 11)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("coupler=EI:1", "rhoA is missing"),
        ("coupler=EI:-1,rhoA:1", "not a positive number"),
        ("coupler", "write LINK="),
        ("coupler=rect(0.1,0.2)", "name a material"),
        ("coupler=rect(0.1,0.2),wood", "'wood' is not known"),
        ("coupler=EI:1,rhoA:1,supports:3", "supports are 2, 4, 6"),
        ("coupler=EI:1,rhoA:1,supports:2,length:3", "leave it out"),
    ],
)
def test_wrong_words_for_links_are_refused(text, message):
    with pytest.raises(LinkageError, match=message):
        parse_flex_link(text)


def test_sections_of_materials():
    link = parse_flex_link("rod=rect(0.01,0.002),steel,timoshenko,length:0.4")
    assert link.bending == pytest.approx(210e9 * 0.01 * 0.002**3 / 12)
    assert link.line_mass == pytest.approx(7850 * 0.01 * 0.002)
    assert np.isfinite([link.axial, link.shear]).all() and link.rotary > 0.0
    assert link.length == 0.4
    assert not np.isfinite(parse_flex_link("rod=rect(0.01,0.002),steel").axial)


@pytest.mark.parametrize(
    ("model", "link", "drive", "message"),
    [
        ("four_bar_kite", "nobody", "u1", "'nobody'"),
        ("three_rsr", "lower1", "u1", "not planar"),
        ("five_bar", "{first}", "nothing", "'nothing' is not a joint"),
        ("slider_crank", "{last}", None, "cannot bend"),
    ],
)
def test_links_that_cannot_bend_are_refused(model, link, drive, message):
    linkage = kinematics.load(model)
    names = [body.name for body in linkage.bodies]
    name = link.format(first=names[0], last=names[-1])
    drives = {drive or linkage.inputs[0]: (constant_speed(1.0), False)}
    with pytest.raises(LinkageError, match=message):
        flexible_linkage(linkage, [parse_flex_link(f"{name}=EI:1,rhoA:1")], drives)
