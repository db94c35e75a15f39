"""Linkages built from Denavit-Hartenberg rows, beside products of matrices written out."""

import numpy as np
import pytest
from scipy.linalg import expm

import kinematics
from kinematics import from_dh
from kinematics.errors import FileError
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.loading import model_gallery as models
from kinematics.model.spatial.screws import hat

# Published by the maker: θ, d, a, α of the UR5.
UR5 = np.array(
    [
        [0, 0.089159, 0, np.pi / 2],
        [0, 0, -0.425, 0],
        [0, 0, -0.39225, 0],
        [0, 0.10915, 0, np.pi / 2],
        [0, 0.09465, 0, -np.pi / 2],
        [0, 0.0823, 0, 0],
    ]
)


def standard(theta, d, a, alpha):
    """Frame i in frame i-1, entry by entry, as textbooks print it."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    )


def modified(theta, d, a, alpha):
    """The same in the convention of Craig (his equation 3.6)."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [
            [c, -s, 0, a],
            [s * ca, c * ca, -sa, -sa * d],
            [s * sa, c * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


MATRICES = {"standard": standard, "modified": modified}


def frames(rows, convention, q=None, kinds=None):
    """Poses of frames 0 … n, with joints at positions q."""
    poses = [np.eye(4)]
    for i, row in enumerate(rows):
        theta, d, a, alpha = row
        if q is not None:
            theta, d = (theta + q[i], d) if kinds[i] == "revolute" else (theta, d + q[i])
        poses.append(poses[-1] @ MATRICES[convention](theta, d, a, alpha))
    return poses


def random_rows(seed):
    rng = np.random.default_rng(seed)
    kinds = [str(kind) for kind in rng.permutation(["revolute"] * 4 + ["prismatic"] * 2)]
    return rng.uniform(-1.5, 1.5, (6, 4)), kinds, rng.uniform(-1.0, 1.0, 6)


def moved(linkage, q):
    """Displacement of the last link, by exponentials of the joint screws."""
    H = np.eye(4)
    for joint, position in zip(linkage.joints, q, strict=True):
        H = H @ expm(position * hat(joint.screw))
    return H


@pytest.mark.parametrize("convention", MATRICES)
@pytest.mark.parametrize("seed", range(4))
def test_the_last_frame_moves_by_the_product_of_the_rows(convention, seed):
    rows, kinds, q = random_rows(seed)
    linkage = from_dh(rows, convention, kinds)
    last = "tool" if convention == "standard" else "link6"
    found = moved(linkage, q) @ linkage.places[last].pose
    expected = frames(rows, convention, q, kinds)[-1]
    assert np.abs(found - expected).max() <= 1e-13
    assert [joint.kind for joint in linkage.joints] == kinds
    assert linkage.inputs == tuple(f"q{i}" for i in range(1, 7))


@pytest.mark.parametrize("convention", MATRICES)
def test_links_have_the_frames_that_are_promised(convention):
    rows, kinds, _ = random_rows(9)
    linkage, poses = from_dh(rows, convention, kinds), frames(rows, convention)
    before = int(convention == "standard")
    for i in range(1, 7):
        found = linkage.places[f"link{i}"].pose
        assert np.abs(found - poses[i - before]).max() <= 1e-14


@pytest.mark.parametrize("seed", range(3))
def test_both_conventions_describe_one_arm(seed):
    """Row i has θ and d of joint i; a and α come after it, or before the next."""
    rows, kinds, _ = random_rows(20 + seed)
    shifted = rows.copy()
    shifted[1:, 2:], shifted[0, 2:] = rows[:-1, 2:], 0.0
    pairs = zip(
        from_dh(rows, kinds=kinds).joints,
        from_dh(shifted, "modified", kinds).joints,
        strict=True,
    )
    assert max(np.abs(a.screw - b.screw).max() for a, b in pairs) <= 1e-14


@pytest.mark.parametrize("convention", MATRICES)
def test_masses_are_in_the_frames_of_the_rows(convention):
    """Point masses, carried into the inertial frame by the products."""
    rows, kinds, _ = random_rows(5)
    rng = np.random.default_rng(1)
    places, bodies = {}, {}
    for i, pose in enumerate(frames(rows, convention)[1:], 1):
        x = rng.standard_normal((5, 3))
        com, arms = x.mean(axis=0), x - x.mean(axis=0)
        tensor = np.sum(arms**2) * np.eye(3) - arms.T @ arms
        bodies[f"link{i}"] = (5.0, com, tensor)
        places[f"link{i}"] = x @ pose[:3, :3].T + pose[:3, 3]
    for body in from_dh(rows, convention, kinds, bodies).bodies:
        x = places[body.name]
        E = np.sum(x**2) * np.eye(3) - x.T @ x
        expected = [5.0, *x.sum(axis=0), *np.diag(E), E[0, 1], E[0, 2], E[1, 2]]
        assert np.abs(body.inertia - expected).max() <= 1e-13 * np.abs(expected).max()


def invariants(screws):
    """Angle, distance and reciprocal product of consecutive axes, up to their signs."""
    found = []
    for s, t in zip(screws, screws[1:], strict=False):
        cosine, moment = abs(s[:3] @ t[:3]), abs(s[:3] @ t[3:] + s[3:] @ t[:3])
        across = np.cross(s[:3], t[:3])
        if np.linalg.norm(across) < 1e-6:
            moment = np.linalg.norm(np.cross(s[:3], s[3:] * np.sign(s[:3] @ t[:3]) - t[3:]))
        found.append((cosine, moment))
    return np.array(found)


def test_the_published_rows_of_a_robot_are_those_of_its_file():
    path = models.robots().get("ur5")
    if path is None:
        pytest.skip("needs example-robot-data")
    file, rows = kinematics.load(path), from_dh(UR5)
    ours, theirs = (invariants([j.screw for j in each.joints]) for each in (rows, file))
    assert np.abs(ours - theirs).max() <= 1e-9


def test_right_angles_are_exact():
    """In exact arithmetic axes are coordinate axes, and no number is replaced by another."""
    rows = UR5 + [[np.pi / 2, 0, 0, 0]] * 6
    geometry = exact_geometry(from_dh(rows))
    assert {abs(x) for screw in geometry.screws for x in screw[:3]} == {0, 1}
    assert all("is taken as" in notice.message for notice in geometry.notices)
    arm = from_dh([[0, 0, 1, np.pi], [np.pi / 2, 0, 1, -np.pi], [0, 0, 1, 0]])
    assert arm.planar


def test_angles_that_look_rounded_are_read_as_in_a_file():
    rounded = [[0, 0.1, 0, 1.5708], [0, 0.2, 0.3, 0]]
    exact = from_dh([[0, 0.1, 0, np.pi / 2], [0, 0.2, 0.3, 0]])
    nominal, written = from_dh(rounded), from_dh(rounded, angles="as_written")
    assert [notice.code for notice in nominal.notices] == ["rounded_angles"]
    assert "alpha of joint 'q1'" in nominal.notices[0].message
    assert np.array_equal(nominal.joints[1].screw, exact.joints[1].screw)
    assert 1e-6 < np.abs(written.joints[1].screw - exact.joints[1].screw).max() < 1e-5


REFUSED = {
    "width": ([[0, 0, 0]], {}, "rows are 1 by 3, not n by 4"),
    "ragged": ([[0, 0, 0, 0], [0]], {}, "not numbers of one length"),
    "empty": ([], {}, "rows are 0, not n by 4"),
    "flat": ([0, 0, 0, 0], {}, "rows are 4, not n by 4"),
    "nan": ([[0, np.nan, 0, 0]], {}, "row 1: d = nan is not a finite number"),
    "infinite": ([[0, 0, 0, 0], [np.inf, 0, 0, 0]], {}, "row 2: theta = inf"),
    "convention": ([[0, 0, 0, 0]], {"convention": "craig"}, "convention 'craig'; choose from"),
    "angles": ([[0, 0, 0, 0]], {"angles": "deg"}, "unknown angles 'deg'"),
    "kind": ([[0, 0, 0, 0]], {"kinds": "helical"}, "joint 'q1': unknown kind 'helical'"),
    "kinds": ([[0, 0, 0, 0]], {"kinds": ["revolute"] * 2}, "2 kinds for 1 rows"),
    "names": ([[0, 0, 0, 0]], {"names": "q"}, "does not name 1 joints"),
    "same name": ([[0, 0, 1, 0]] * 2, {"names": ["a", "a"]}, "name 'a' is taken"),
    "fixed name": ([[0, 0, 1, 0]], {"names": ["tool_fixed"]}, "'tool_fixed' is taken"),
    "body": (
        [[0, 0, 0, 0]],
        {"bodies": {"arm": (1, (0, 0, 0), np.eye(3))}},
        "body 'arm': there is no such link; .*'base', 'link1'",
    ),
    "mass": (
        [[0, 0, 0, 0]],
        {"bodies": {"link1": ("x", (0, 0, 0), np.eye(3))}},
        "body 'link1': mass = 'x' is not one finite number",
    ),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_rows_that_are_no_arm_are_refused_with_the_reason(fault):
    rows, more, message = REFUSED[fault]
    with pytest.raises(FileError, match=message) as error:
        from_dh(rows, **more)
    assert "\n" not in str(error.value) and error.value.remedy
