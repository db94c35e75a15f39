"""Files with chains of joints whose frames are turned one after the other."""

from tests.support.urdf_text import INERTIAL


def robot(*parts):
    """A robot from its parts."""
    return f'<robot name="r"><link name="l0"/>{"".join(parts)}</robot>'


def jointed(i, rpy, more="", kind="continuous", axis="0 0 1"):
    """A link, and the joint that carries it on the one before."""
    return (
        f'<link name="l{i}">{INERTIAL}</link><joint name="j{i}" type="{kind}">'
        f'<parent link="l{i - 1}"/><child link="l{i}"/>'
        f'<origin xyz="0.3 0.1 0" rpy="{rpy}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def written(tmp_path, text, name="robot"):
    """A file with a text."""
    path = tmp_path / f"{name}.urdf"
    path.write_text(text, encoding="utf-8")
    return path
