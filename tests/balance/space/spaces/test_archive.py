"""Design spaces on disk: what is saved comes back, and nothing else is let in."""

from __future__ import annotations

import io
import json
import pickle
import zipfile
from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest

import balance
import kinematics
from balance.space.spaces.save import record_of
from kinematics.errors import FileError, LinkageError
from tests.support.covering import spread
from tests.support.figures import FIGURES
from tests.support.laws import coordinates, known

SHARED = (
    "balance planar bodies inputs idle orders poses settled kmax rank nullity serial_nullity "
    "length kept dropped notices labels"
).split()


@pytest.mark.parametrize("figure", spread(FIGURES, 3, 0), ids=str)
def test_a_saved_space_comes_back(figure, tmp_path):
    found = known(figure)
    balance.space.save_space(found, tmp_path / "space.npz")
    saved = balance.space.load_space(tmp_path / "space.npz")
    for name in SHARED:
        assert getattr(saved, name) == getattr(found, name), name
    for name in ("basis", "axes", "singular_values", "frames"):
        assert np.array_equal(getattr(saved, name), getattr(found, name)), name
    assert (saved.motion.relations if saved.motion else ()) == figure.motion
    file = kinematics.gallery()[figure.model]
    assert saved.source == str(file)
    assert saved.sha256 == sha256(file.read_bytes()).hexdigest()
    y = coordinates(found)
    for mine, its in zip(found.bodies_of(y), saved.bodies_of(y), strict=True):
        assert (mine.name, mine.mass, mine.element) == (its.name, its.mass, its.element)
    assert np.array_equal(saved.basis_in_link_frames(), found.basis_in_link_frames())
    arrays = (saved.basis, saved.axes, saved.frames, saved.singular_values)
    assert not any(array.flags.writeable for array in arrays)
    again = balance.design_space(
        kinematics.load(saved.source, inputs=saved.inputs),
        saved.motion,
        saved.balance,
        saved.orders[-1].order,
        spatial=not saved.planar,
    )
    assert saved.differences(record_of(again)) == ()


def test_what_differs_is_named():
    kite = record_of(balance.design_space(kinematics.load("four_bar_kite")))
    other = record_of(balance.design_space(kinematics.load("four_bar_antiparallelogram")))
    general = record_of(balance.design_space(kinematics.load("four_bar_general")))
    [line] = kite.differences(other)
    assert line.startswith("basis: the spaces are apart")
    lines = kite.differences(general)
    assert [line.partition(":")[0] for line in lines] == ["rank", "nullity", "kmax"]
    assert lines[0] == "rank: 7 here, 8 there"


def test_a_saved_file_is_whole_and_the_same_each_time(tmp_path, monkeypatch):
    found = known(FIGURES[0])
    path = tmp_path / "space.npz"
    balance.space.save_space(found, path)
    balance.space.save_space(found, tmp_path / "again")
    first = path.read_bytes()
    assert (tmp_path / "again").read_bytes() == first
    with monkeypatch.context() as patch, pytest.raises(FileError, match="No space left"):
        patch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left")))
        balance.space.save_space(known(FIGURES[2]), path)
    assert path.read_bytes() == first
    assert sorted(file.name for file in tmp_path.iterdir()) == ["again", "space.npz"]
    with open(path, "rb") as old:
        balance.space.save_space(known(FIGURES[2]), path)
        assert old.read() == first != path.read_bytes()
    header = json.loads(np.load(tmp_path / "again", allow_pickle=False)["header"].item())
    assert header["options"] == {
        "inputs": ["u1"],
        "motion": None,
        "balance": "dynamic",
        "max_order": 3,
        "spatial": False,
    }
    assert header["format"] == "balance.space/2" and header["directions"] == "deterministic"


FREE = """<robot name="free"><link name="ground"/>
<link name="plate"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="planar"><parent link="ground"/><child link="plate"/>
<axis xyz="0 0 1"/></joint></robot>"""


def test_a_space_of_dimension_zero(tmp_path):
    """A body that moves freely in the plane: nothing but no mass at all is balanced."""
    (tmp_path / "free.urdf").write_text(FREE, encoding="utf-8")
    found = balance.design_space(kinematics.load(tmp_path / "free.urdf"))
    assert (found.rank, found.nullity, found.basis.shape) == (4, 0, (4, 0))
    balance.space.save_space(found, tmp_path / "space.npz")
    saved = balance.space.load_space(tmp_path / "space.npz")
    assert saved.differences(record_of(found)) == ()
    assert saved.basis_in_link_frames().shape == (4, 0)
    assert [body.mass for body in saved.bodies_of([])] == [0.0]
    assert found.to_dict()["nullity"] == 0


def test_a_place_that_cannot_be_written_to(tmp_path):
    found = known(FIGURES[0])
    for path in (tmp_path, tmp_path / "none" / "space.npz"):
        with pytest.raises(FileError, match="cannot be written") as caught:
            balance.space.save_space(found, path)
        assert str(path) in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_linkage_without_a_file_has_no_hash():
    found = replace(known(FIGURES[0]), source="made\0up")
    assert record_of(found).sha256 is None


def packed(folder, **changes):
    """A saved space whose header or arrays were changed; None leaves an entry out."""
    path = folder / "space.npz"
    balance.space.save_space(known(FIGURES[12]), path)
    with np.load(path) as archive:
        entries = dict(archive)
    header = json.loads(entries["header"].item())
    for name, value in changes.items():
        if name in ("basis", "axes", "frames", "singular_values", "motion", "extra"):
            entries[name] = value(entries.get(name)) if callable(value) else value
        elif name in header["options"]:
            header["options"][name] = value
        else:
            header[name] = value
    entries["header"] = np.array(json.dumps({k: v for k, v in header.items() if v != "none"}))
    np.savez(path, **{k: v for k, v in entries.items() if v is not None})
    return path


DAMAGE = [
    {"bodies": "lower1"}, {"bodies": ["lower1"]}, {"bodies": "none"}, {"orders": []},
    {"orders": [[0, 35, 35], [2, 35, 35]]}, {"orders": [[0, 35.0, 35]]}, {"settled": 1},
    {"serial_nullity": 36},
    {"orders": [[0, 34, 35]]}, {"kept": "1"}, {"notices": [["a"]]}, {"balance": "static"},
    {"spatial": False}, {"motion": None}, {"sha256": 5}, {"source": None}, {"inputs": ["u1"]},
    {"basis": lambda a: a[:, :-1]}, {"basis": lambda a: a.astype(np.float32)},
    {"basis": lambda a: np.where(a > a.max() / 2, np.nan, a)}, {"basis": None},
    {"frames": lambda a: a[:-1]}, {"axes": np.eye(4)}, {"singular_values": None},
    {"singular_values": lambda a: a[:-1]}, {"singular_values": lambda a: np.append(a, 1e-9)},
    {"motion": None, "extra": np.zeros(2)}, {"extra": np.zeros(2)}, {"format": "none"},
    {"basis": lambda a: a.astype(object)},
]  # fmt: skip


@pytest.mark.parametrize("changes", DAMAGE, ids="-".join)
def test_a_damaged_space_is_refused_in_one_line(changes, tmp_path):
    assert balance.space.load_space(packed(tmp_path)).rank == 35
    refused(packed(tmp_path, **changes), "not a saved design space, or damaged")


def refused(path, problem):
    with pytest.raises(FileError) as caught:
        balance.space.load_space(path)
    assert isinstance(caught.value, LinkageError) and caught.value.__cause__ is None
    message = str(caught.value)
    assert len(message.splitlines()) == 1 and problem in message
    assert "give a file that save_space wrote" in message


def test_another_format_is_named(tmp_path):
    refused(packed(tmp_path, format="balance.space/9"), "its format is 'balance.space/9'")


def test_a_cut_or_foreign_file_is_refused(tmp_path):
    whole = packed(tmp_path).read_bytes()
    path = tmp_path / "other.npz"
    for length in (0, 1, 4, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        refused(path, "damaged")
    flipped = bytearray(whole)
    flipped[len(whole) // 3] ^= 255
    path.write_bytes(flipped)
    refused(path, "damaged")
    np.save(tmp_path / "one.npy", np.zeros(3))
    refused(tmp_path / "one.npy", "damaged")
    refused(tmp_path / "missing.npz", "cannot be read (No such file")
    refused(tmp_path, "cannot be read")
    refused(tmp_path / "a\nb.npz", "cannot be read")


class Trap:
    """Unpickling this would raise something that no reader expects."""

    def __reduce__(self):
        return (exec, ("raise SystemExit('unpickled')",))


def test_nothing_is_unpickled(tmp_path):
    path = tmp_path / "trap.npz"
    np.savez(path, header=np.array(Trap(), dtype=object))
    refused(path, "damaged")
    path.write_bytes(pickle.dumps(Trap()))
    refused(path, "damaged")


def test_a_file_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    path = packed(tmp_path)
    monkeypatch.setattr("balance.space.spaces.save.LARGEST_FILE", 1000)
    refused(path, "damaged")
    with zipfile.ZipFile(path, "w") as archive:
        buffer = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            buffer, {"descr": "<f8", "fortran_order": False, "shape": (2**60,)}
        )
        archive.writestr("header.npy", buffer.getvalue())
    refused(path, "damaged")
