"""A file of arrays is read whole, or refused before it takes memory."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.runs import array_files
from amorsim.runs.array_files import read_arrays, sizes_of


def packed(path: Path, **parts: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in parts.items():
            file.writestr(f"{name}.npy", data)
    return path


def promising(shape: tuple[int, ...], dtype: str = "<f8") -> bytes:
    """The header of an array of this shape, and hardly a number."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": dtype, "fortran_order": False, "shape": shape})
    return stream.getvalue() + bytes(8)


def test_what_numpy_writes_is_read(tmp_path: Path) -> None:
    arrays = {
        "robot": np.array(["a", "rover"]),
        "replica": np.array([0, 0]),
        "particles": np.arange(12.0).reshape(2, 3, 2),
        "turned": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "is_lost": np.array([True, False]),
        "none": np.empty((2, 0)),
    }
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    found = read_arrays(tmp_path / "a.npz")
    assert set(found) == set(arrays) == set(sizes_of(tmp_path / "a.npz"))
    assert all(
        np.array_equal(found[name], array) and found[name].dtype == array.dtype for name, array in arrays.items()
    )


def test_a_file_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.savez_compressed(tmp_path / "a.npz", zeros=np.zeros(10_000))
    assert (tmp_path / "a.npz").stat().st_size < 1000
    monkeypatch.setattr(array_files, "LARGEST", 50_000)
    for read in (read_arrays, sizes_of):
        with pytest.raises(am.RunError, match=r"a\.npz: .*it unpacks to 1 arrays of 0\.080128 MB; expected"):
            read(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "data",
    [
        promising((10**10,)),
        promising((10**30, 10**30)),
        promising((-1,)),
        promising(()),
        promising((1,), "|O"),
        promising((1,), "<M8[s]"),
        promising((10**10,), "<U0"),
        b"",
        b"\x93NUMPY\x03\x00" + bytes(20),
        b"no array",
    ],
)
def test_a_header_that_promises_what_is_not_there_is_refused(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(am.RunError, match=r"a\.npz: cannot be read"):
        read_arrays(packed(tmp_path / "a.npz", one=data))


def test_arrays_of_different_rows_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", robot=np.array(["a"]), replica=np.array([0, 1]))
    with pytest.raises(am.RunError, match="different numbers of rows"):
        read_arrays(tmp_path / "a.npz")


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.npz").symlink_to("/dev/zero")
    (tmp_path / "b.npz").write_bytes(b"PK\x03\x04")
    for name in ("a.npz", "b.npz", "none.npz"):
        with pytest.raises(am.RunError, match="cannot be read"):
            read_arrays(tmp_path / name)


def test_a_directory_that_promises_more_than_the_file_holds_is_refused(tmp_path: Path) -> None:
    file = packed(tmp_path / "a.npz", a=promising((1,)))
    data = bytearray(file.read_bytes())
    entry = data.index(b"PK\x01\x02")
    data[entry + 20 : entry + 24] = (0x7FFFFFFF).to_bytes(4, "little")  # the compressed size
    file.write_bytes(data)
    for read in (read_arrays, sizes_of):
        with pytest.raises(am.RunError, match="its directory promises more than the file holds"):
            read(file)
