"""Compiled kernels in one file: what it holds is used where it fits, and refused in words where it does not."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.kernels.cache_folder import cache_folder
from amorsim.runs.kernel_archive import misfit, pack_kernels, unpack_kernels
from tests.cli.conftest import Command, amorsim

__all__ = ["amorsim"]

_STEP = "import amorsim as am; am.Simulation(am.load('demo')).step()"


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An archive of what a step of the demo needs."""
    subprocess.run([sys.executable, "-c", _STEP], check=True)
    file = tmp_path_factory.mktemp("packed") / "kernels.zip"
    pack_kernels(file)
    return file


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for compiled kernels in which nothing is."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "elsewhere"))
    cache_folder.cache_clear()
    found = cache_folder()
    assert found is not None
    yield found
    cache_folder.cache_clear()


def _compiled(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.nb?")}


def _with_note(packed: Path, target: Path, **changes: str) -> Path:
    """A copy of an archive without kernels and with another note."""
    with zipfile.ZipFile(packed) as archive, zipfile.ZipFile(target, "w") as new:
        note = json.loads(archive.read("amorsim-kernels.json"))
        new.writestr("amorsim-kernels.json", json.dumps(note | changes))
    return target


def test_where_an_archive_was_taken_nothing_is_compiled(packed: Path, elsewhere: Path) -> None:
    (elsewhere / "of-before").write_text("")
    assert misfit(packed) == ""
    unpack_kernels(packed)
    before = _compiled(elsewhere)
    assert any(name.startswith("raycast/") for name in before)
    assert not (elsewhere / "of-before").exists()
    subprocess.run([sys.executable, "-c", _STEP], check=True)
    assert _compiled(elsewhere) == before


@pytest.mark.parametrize("key", ["kernels", "python", "system", "processor", "features"])
def test_an_archive_of_something_else_does_not_fit(packed: Path, tmp_path: Path, key: str) -> None:
    assert "it is of a" in misfit(_with_note(packed, tmp_path / "other.zip", **{key: "another"}))


def test_the_processor_may_be_named(packed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.CPU_NAME", "x86-64-v3")
    assert "processor" in misfit(packed)


def test_what_is_no_archive_is_refused(packed: Path, tmp_path: Path) -> None:
    whole = packed.read_bytes()
    contents = {"text.zip": b"no zip", "empty.zip": b"", "cut.zip": whole[: len(whole) // 2]}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(AmorsimError, match=f"{name}: not an archive of compiled kernels"):
            misfit(tmp_path / name)
    with pytest.raises(AmorsimError, match="cannot be read"):
        misfit(tmp_path)


@pytest.mark.parametrize("name", ["../outside.nbi", "/tmp/outside.nbi", "a/b/c.nbi", "a\\b.nbi"])
def test_an_archive_writes_only_into_its_folder(packed: Path, tmp_path: Path, elsewhere: Path, name: str) -> None:
    file = _with_note(packed, tmp_path / "bad.zip")
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(name, "")
    with pytest.raises(AmorsimError, match="it holds other files, too"):
        unpack_kernels(file)
    assert not list(elsewhere.iterdir())


def test_a_damaged_archive_leaves_what_was_compiled(packed: Path, tmp_path: Path, elsewhere: Path) -> None:
    content = bytearray(packed.read_bytes())
    content[len(content) // 2] ^= 0xFF
    (tmp_path / "damaged.zip").write_bytes(content)
    (elsewhere / "mark").write_text("")
    with pytest.raises(AmorsimError, match="it is damaged"):
        unpack_kernels(tmp_path / "damaged.zip")
    assert [path.name for path in elsewhere.iterdir()] == ["mark"]


@pytest.fixture
def _compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("amorsim.runs.warm.compile_kernels", lambda *_, more: None)


@pytest.mark.usefixtures("_compiles_nothing")
def test_the_command_writes_an_archive_and_takes_it(amorsim: Command, tmp_path: Path, elsewhere: Path) -> None:
    (elsewhere / "warm").write_text("")
    assert "wrote the compiled kernels to k.zip" in amorsim("compile", "--archive", "k.zip").out
    (elsewhere / "warm").unlink()
    assert amorsim("compile", "--archive", "k.zip").out == "took the compiled kernels from k.zip\n"
    assert [path.name for path in elsewhere.iterdir()] == ["warm"]
    _with_note(tmp_path / "k.zip", tmp_path / "other.zip", python="2.7")
    said = amorsim("compile", "--archive", "other.zip").out
    assert "other.zip does not fit and is written anew: it is of another version of Python" in said
    assert misfit(tmp_path / "other.zip") == ""
    assert amorsim("compile", "--archive", "k.zip", "--quiet").out == ""


@pytest.mark.usefixtures("elsewhere")
def test_a_place_that_cannot_be_written_is_found_before_compiling(
    amorsim: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("amorsim.runs.warm.compile_kernels", None)
    found = amorsim("compile", "--archive", tmp_path / "no" / "k.zip")
    assert found.status == 2
    assert "cannot be written" in found.err


def test_a_file_that_is_no_archive_is_not_replaced(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "notes.zip").write_text("mine")
    assert amorsim("compile", "--archive", "notes.zip").status == 2
    assert (tmp_path / "notes.zip").read_text() == "mine"
