"""The general four-bar with rounded right angles in its file."""

from tests.support.laws import altered


def four_bar(tmp_path, right="1.5708"):
    """The general four-bar with the frames of its crank and rocker turned upright."""

    def turned(tree):
        for name, xyz, rpy, axis in [
            ("u1", "0 0 0", f"{right} 0 0", "0 1 0"),
            ("q2", "0.1 0 -0.3", f"-{right} 0 0", "0 0 1"),
            ("q4", "1.1 0 0", f"{right} 0 0", "0 1 0"),
        ]:
            joint = tree.find(f"joint[@name='{name}']")
            joint.find("origin").attrib |= {"xyz": xyz, "rpy": rpy}
            joint.find("axis").set("xyz", axis)
        tree.find("loop/predecessor/origin").set("rpy", f"{right} 0 0")
        tree.find("loop/successor/origin").set("xyz", "-0.2 0 -0.7")
        tree.find("loop/axis").set("xyz", "0 1 0")

    return altered("four_bar_general", tmp_path, turned)
