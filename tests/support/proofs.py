"""Proofs for tests, as they come out of a file, and as somebody might forge them."""

import json
from hashlib import sha256

from balance import certify
from tests.independent.checker import check
from tests.independent.checker_form import Rejected
from tests.support.urdf_text import INERTIAL, joint, link, pose_of

ARM = ([0, 0, 1], [0, 3, 4], [1, 0, 2])


def arm_text():
    """A serial arm of three skew axes."""
    frames = [
        pose_of(xyz, [0.0] * 3) for xyz in ([0, 0, 0.25], [0.5, -0.1, 0], [0.2, 0.4, 0.1])
    ]
    parts = [link("l0"), *(f'<link name="l{i}">{INERTIAL}</link>' for i in (1, 2, 3))]
    parts += [
        joint(f"j{i}", "continuous", f"l{i}", f"l{i + 1}", frame, axis)
        for i, (frame, axis) in enumerate(zip(frames, ARM, strict=True))
    ]
    return f'<robot name="arm">{"".join(parts)}</robot>'


def arm(folder, text=None):
    """A file with it, or with what is made of it."""
    path = folder / "arm.urdf"
    path.write_text(text or arm_text(), encoding="utf-8")
    return path


def proof_of(found):
    """The proof of a space as it is read from a file."""
    return json.loads(json.dumps(certify(found).certainty.proof.to_dict()))


def sealed(proof):
    """A proof with the digest that belongs to what is in it."""
    rest = {name: value for name, value in proof.items() if name != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return rest | {"sha256": sha256(text.encode()).hexdigest()}


def accepted(proof):
    """Whether the checker accepts a proof; it may raise nothing but `Rejected`."""
    try:
        check(json.loads(json.dumps(proof)))
    except Rejected:
        return False
    return True
