"""Files that a user names: read where they are files of a sensible size, refused at once where they are not."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import MOST_BYTES, check_readable, is_file, read_bytes, read_text, reason
from amorsim.motions.track import Track
from amorsim.runs.folder import check_free
from amorsim.scenario.programs.controller_files import load_controller
from amorsim.scenario.reading.read import is_model

LONG = "n" * 300


def test_a_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "file.txt"
    file.write_bytes(b"\xef\xbb\xbfone\r\ntwo\n")
    assert read_bytes(file) == file.read_bytes()
    assert read_text(file, encoding="utf-8-sig") == "one\ntwo\n"
    assert read_bytes(str(file), most=12) == file.read_bytes()
    with pytest.raises(OSError, match=r"it has 1\.2e-05 MB; expected 1\.1e-05 MB at most"):
        read_bytes(file, most=11)


def test_a_reason_is_without_the_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as found:
        check_readable(tmp_path / "none")
    assert reason(found.value) == "No such file or directory"
    assert reason(ValueError("embedded null byte")) == "embedded null byte"


def test_there_is_no_file_of_a_name_that_is_too_long(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert is_file(tmp_path / "file")
    assert not is_file(tmp_path)
    assert not is_file(tmp_path / LONG)
    assert not is_model(tmp_path / f"{LONG}.toml")
    with pytest.raises(am.RunError, match=r"cannot make this folder for the run \(File name too long\)"):
        check_free(tmp_path / LONG)


def odd_file(kind: str, folder: Path, suffix: str) -> Path:
    """A path that no map, track, scenario or program is at."""
    path = folder / f"odd{suffix}"
    if kind == "zero":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "sparse":
        with path.open("wb") as file:
            file.truncate(3_000_000_000)
    elif kind == "folder":
        path.mkdir()
    elif kind == "long":
        path = folder / (LONG + suffix)
    elif kind == "null":
        path = folder / f"a\0b{suffix}"
    return path


READERS: dict[str, Callable[[Path], object]] = {
    ".wld": am.load_map,
    ".png": am.load_map,
    ".odd": am.load_map,
    ".toml": am.load,
    ".csv": lambda path: Track(file=str(path)),
    ".py": lambda path: load_controller(path, "drive", {}),
}
WORDS = {
    "zero": "it is a device; expected a regular file",
    "pipe": "it is a pipe; expected a regular file",
    "sparse": "it has 3000 MB; expected [0-9]+ MB at most",
    "folder": "folder|directory",
    "long": "File name too long",
    "null": "null|no such file",
}


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="of Unix")
@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize("kind", WORDS)
def test_what_is_no_file_to_read_ends_in_a_message_at_once(kind: str, suffix: str, tmp_path: Path) -> None:
    path = odd_file(kind, tmp_path, suffix)
    begin = time.perf_counter()
    with pytest.raises(AmorsimError, match=WORDS[kind]):
        READERS[suffix](path)
    assert time.perf_counter() - begin < 2.0
    assert MOST_BYTES < 3_000_000_000
