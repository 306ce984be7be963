"""Reading the files of arrays that a run's recorder ``arrays`` writes; one that is damaged takes no memory."""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from pathlib import Path

import numpy as np

from amorsim.array_types import AnyArray
from amorsim.core.errors import RunError
from amorsim.core.files.reading import check_readable, reason

__all__ = ["LARGEST", "read_arrays", "sizes_of"]

LARGEST = 1 << 30  # [bytes] that the arrays of a file may have together
_MOST_ARRAYS = 10_000
_KINDS = "biufU"  # of dtypes
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_BROKEN = (OSError, ValueError, EOFError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error)


def read_arrays(path: Path) -> dict[str, AnyArray]:
    """The arrays of a file by name, of numbers, flags and texts; the first axis is the row.

    Raises
    ------
    RunError
        If the file cannot be read, or its arrays would take more than `LARGEST` bytes: before they take them.
    """
    try:
        with _opened(path) as file:
            found = {name: _array(file.read(part), name) for name, part in _parts(file, path).items()}
            if len({array.shape[:1] for array in found.values()}) > 1:
                raise ValueError("its arrays have different numbers of rows")
            return found
    except _BROKEN as error:
        raise _unreadable(path, error) from None


def sizes_of(path: Path) -> dict[str, int]:
    """The arrays of a file by name, with their sizes [bytes]; raises as `read_arrays`."""
    try:
        with _opened(path) as file:
            return {name: part.file_size for name, part in _parts(file, path).items()}
    except _BROKEN as error:
        raise _unreadable(path, error) from None


def _opened(path: Path) -> zipfile.ZipFile:
    check_readable(path, LARGEST)
    return zipfile.ZipFile(path)


def _parts(file: zipfile.ZipFile, path: Path) -> dict[str, zipfile.ZipInfo]:
    parts = file.infolist()
    if sum(part.compress_size for part in parts) > path.stat().st_size:
        raise ValueError("its directory promises more than the file holds")
    size = sum(part.file_size for part in parts)
    if size > LARGEST or len(parts) > _MOST_ARRAYS:
        raise ValueError(
            f"it unpacks to {len(parts)} arrays of {size / 1e6:.6g} MB; expected at most {_MOST_ARRAYS} of "
            f"{LARGEST / 1e6:.6g} MB"
        )
    return {part.filename.removesuffix(".npy"): part for part in parts}


def _array(data: bytes, name: str) -> AnyArray:
    """An array from the bytes of its file; the header may promise more than there is."""
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    if version not in _HEADERS:
        raise ValueError(f"{name}: is in version {version} of NumPy's format")
    shape, _, dtype = _HEADERS[version](stream)
    size = math.prod(shape) * dtype.itemsize
    if not shape or min(shape) < 0 or dtype.kind not in _KINDS or size != len(data) - stream.tell():
        raise ValueError(f"{name}: its header does not fit its content, or is not of an array with rows")
    stream.seek(0)
    found: AnyArray = np.lib.format.read_array(stream, allow_pickle=False)
    return found


def _unreadable(path: Path, error: Exception) -> RunError:
    return RunError(f"{path}: cannot be read ({reason(error)})")
