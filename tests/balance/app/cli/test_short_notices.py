"""Commands beside report print what was read of a file in short form, and hide no danger."""

import pytest

from balance.app.cli.short_notices import short_notice
from kinematics.model.linkage import Notice
from tests.support.command_runs import asked

ROUNDED = (
    "3 angles look rounded, read as multiples of π/12, the default: 1.5708 in rpy of joint 'a' "
    "(line 3), 0.7854 in rpy of joint 'b' (line 4); write all 16 digits, or choose "
    "--as-written (angles='as_written')"
)


def test_long_lists_of_names_are_left_to_report():
    names = Notice("massless", "no mass, so no parameters: a, b, c, d, e")
    short = "no mass, so no parameters: 5 links (balance report names them)"
    assert short_notice(names).message == short
    of_two = names._replace(message=f"left.urdf: {names.message}")
    assert short_notice(of_two).message == f"left.urdf: {short}"
    few = names._replace(message="no mass, so no parameters: a, b, c")
    assert short_notice(few) == few


def test_the_reading_of_angles_and_the_remedy_stay():
    assert short_notice(Notice("rounded_angles", ROUNDED)).message == (
        "3 angles look rounded, read as multiples of π/12, the default (balance report names "
        "them); write all 16 digits, or choose --as-written (angles='as_written')"
    )


@pytest.mark.parametrize(
    "code", ["no_loop", "large_machine", "degrees", "wide_inertia", "unphysical", "corrected"]
)
def test_notices_of_danger_are_printed_whole(code):
    notice = Notice(code, f"one: {', '.join('abcdefgh')}; {ROUNDED}")
    assert short_notice(notice) == notice


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
    assert "bare0, bare1, bare2, bare3" in asked(["report", str(path)]).err
    told = asked(["design", str(path)]).err
    assert "bare3" not in told
    assert "massless: no mass, so no parameters: 4 links (balance report names them)" in told
