"""Commands beside report print what was read of a file in short form, and hide no danger."""

from types import SimpleNamespace

from balance.app.cli.short_notices import notices_by_file, shorten_notice
from kinematics.model.linkage import Notice
from tests.support.command_runs import asked

LISTED = "1.5708 in rpy of joint 'a: b; c' (line 3), 0.7854 in rpy of joint 'd' (line 4)"


def test_names_are_left_out_and_the_rest_stays():
    """Whatever stands in the names, and before and behind them."""
    notice = Notice("rounded_angles", f"robot.urdf: 2 look rounded: {LISTED}; or so", LISTED)
    short = "robot.urdf: 2 look rounded (balance report names them); or so"
    assert shorten_notice(notice).message == short
    of_two = notice._replace(message=f"left.urdf: {notice.message}: rank 3")
    assert shorten_notice(of_two).message == f"left.urdf: {short}: rank 3"


def test_notices_without_a_short_form_are_printed_whole():
    notice = Notice("no_loop", f"one: {LISTED}; two")
    assert shorten_notice(notice) == notice


def test_the_reading_of_angles_and_the_remedy_stay(tmp_path):
    """In a file, whose name stands before them."""
    text = (
        '<robot name="arm"><link name="base"/><link name="hand"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="base"/><child link="hand"/>'
        '<origin rpy="1.5708 0 0"/><axis xyz="0 0 1"/></joint></robot>'
    )
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    rest = "; write all 16 digits, or choose --as-written (angles='as_written')"
    whole = "1 angle looks rounded, read as multiples of π/12, the default"
    assert f"arm.urdf: {whole}: 1.5708 in rpy of joint 'j' (line 1){rest}" in (
        asked(["report", str(path)]).err
    )
    assert f"arm.urdf: {whole} (balance report names them){rest}" in (
        asked(["design", str(path)]).err
    )


def test_report_names_the_links_and_other_commands_count_them(tmp_path):
    """A chain of five links, of which the last has mass."""
    links = "".join(f'<link name="bare{k}"/>' for k in range(4))
    names = ["base", *(f"bare{k}" for k in range(4)), "hand"]
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="{names[k]}"/>'
        f'<child link="{names[k + 1]}"/><origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>'
        for k in range(5)
    )
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    hand = f'<link name="hand"><inertial><mass value="1"/>{inertia}</inertial></link>'
    path = tmp_path / "chain.urdf"
    path.write_text(f'<robot name="chain"><link name="base"/>{links}{hand}{joints}</robot>')
    whole = "massless: no mass, so no parameters: 4 links: bare0, bare1, bare2, bare3"
    assert whole in asked(["report", str(path)]).err
    told = asked(["design", str(path)]).err
    assert "bare3" not in told
    assert "massless: no mass, so no parameters: 4 links (balance report names them)" in told


def test_a_notice_on_both_linkages_is_told_once():
    both = notices_by_file(
        [SimpleNamespace(source=name, name=name, at=None) for name in ("a.urdf", "b.urdf")],
        [[Notice("x", "on both"), Notice("y", "a.urdf: its own")], [Notice("x", "on both")]],
    )
    assert [notice.message for notice in both] == ["both: on both", "a.urdf: its own"]
