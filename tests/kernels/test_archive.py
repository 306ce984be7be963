"""Compiled kernels in one file: what it holds is used where it fits, and refused in words where it does not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numba
import pytest

from amorsim.kernels import archive as archives
from amorsim.kernels.archive import LEVEL, ArchiveError, misfit, pack_kernels, take_installed, unpack_kernels
from amorsim.kernels.cache_folder import cache_folder
from tests.cli.conftest import Command, amorsim

__all__ = ["amorsim"]

_STEP = "import amorsim as am; am.Simulation(am.load('demo')).step()"


def _here() -> Path:
    folder = cache_folder()
    assert folder is not None
    return folder


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An archive of what a step of the demo needs."""
    subprocess.run([sys.executable, "-c", _STEP], check=True)
    file = tmp_path_factory.mktemp("packed") / "kernels.zip"
    pack_kernels(_here(), file)
    return file


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
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


@pytest.mark.long
def test_where_an_archive_was_taken_nothing_is_compiled(packed: Path, elsewhere: Path) -> None:
    (elsewhere / "of-before").write_text("")
    assert misfit(_here(), packed) == ""
    unpack_kernels(_here(), packed)
    before = _compiled(elsewhere)
    assert any(name.startswith("raycast/") for name in before)
    assert not (elsewhere / "of-before").exists()
    subprocess.run([sys.executable, "-c", _STEP], check=True)
    assert _compiled(elsewhere) == before


@pytest.mark.parametrize("key", ["kernels", "python", "system", "processor", "features"])
def test_an_archive_of_something_else_does_not_fit(packed: Path, tmp_path: Path, key: str) -> None:
    assert "it is of a" in misfit(_here(), _with_note(packed, tmp_path / "other.zip", **{key: "another"}))


def test_the_processor_may_be_named(packed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.CPU_NAME", "haswell")
    assert "processor" in misfit(_here(), packed)


def test_what_is_no_archive_is_refused(packed: Path, tmp_path: Path) -> None:
    whole = packed.read_bytes()
    contents = {"text.zip": b"no zip", "empty.zip": b"", "cut.zip": whole[: len(whole) // 2]}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ArchiveError, match=f"{name}: not an archive of compiled kernels"):
            misfit(_here(), tmp_path / name)
    with pytest.raises(ArchiveError, match="cannot be read"):
        misfit(_here(), tmp_path)


@pytest.mark.parametrize("name", ["../outside.nbi", "/tmp/outside.nbi", "a/b/c.nbi", "a\\b.nbi"])
def test_an_archive_writes_only_into_its_folder(packed: Path, tmp_path: Path, elsewhere: Path, name: str) -> None:
    file = _with_note(packed, tmp_path / "bad.zip")
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(name, "")
    with pytest.raises(ArchiveError, match="it holds other files, too"):
        unpack_kernels(_here(), file)
    assert not list(elsewhere.iterdir())


def test_a_damaged_archive_leaves_what_was_compiled(packed: Path, tmp_path: Path, elsewhere: Path) -> None:
    content = bytearray(packed.read_bytes())
    content[len(content) // 2] ^= 0xFF
    (tmp_path / "damaged.zip").write_bytes(content)
    (elsewhere / "mark").write_text("")
    with pytest.raises(ArchiveError, match="it is damaged"):
        unpack_kernels(_here(), tmp_path / "damaged.zip")
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
    assert misfit(_here(), tmp_path / "other.zip") == ""
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


# --------------------------------------------------------------------------------- kernels that are installed


@pytest.fixture
def installed(packed: Path, elsewhere: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The file of an ``amorsim-kernels`` with kernels of this very processor, installed after the folder was made."""
    site = tmp_path / "site"
    (site / "amorsim_kernels").mkdir(parents=True)
    (site / "amorsim_kernels" / "__init__.py").write_text("")
    file = site / "amorsim_kernels" / "kernels.zip"
    file.write_bytes(packed.read_bytes())
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(archives, "is_of_level", lambda: False)
    before = numba.config.CPU_NAME, numba.config.CPU_FEATURES
    yield file
    archives._set_processor(*before)


def test_installed_kernels_are_taken_once(installed: Path, elsewhere: Path) -> None:
    take_installed(elsewhere)
    taken = _compiled(elsewhere)
    assert any(name.startswith("raycast/") for name in taken)
    next(elsewhere.rglob("*.nbi")).unlink()
    take_installed(elsewhere)
    assert len(_compiled(elsewhere)) == len(taken) - 1


def test_a_new_folder_begins_with_them(installed: Path, elsewhere: Path) -> None:
    cache_folder.cache_clear()
    assert _compiled(_here())


@pytest.mark.parametrize("key", ["kernels", "python", "system", "processor"])
def test_installed_kernels_of_something_else_are_ignored(
    installed: Path, packed: Path, elsewhere: Path, key: str
) -> None:
    _with_note(packed, installed, **{key: "another"})
    before = numba.config.CPU_NAME
    take_installed(elsewhere)
    assert not list(elsewhere.iterdir())
    assert before == numba.config.CPU_NAME


def test_a_damaged_file_of_them_is_ignored(installed: Path, elsewhere: Path) -> None:
    installed.write_bytes(installed.read_bytes()[:5000])
    take_installed(elsewhere)
    assert not list(elsewhere.iterdir())


@pytest.mark.skipif(not archives.is_of_level(), reason=f"a processor without {LEVEL}")
def test_with_kernels_of_the_level_numba_compiles_for_it(
    installed: Path, packed: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _with_note(packed, installed, processor=LEVEL, features="")
    monkeypatch.setattr(archives, "is_of_level", lambda: True)
    archives._set_processor(None, None)
    take_installed(elsewhere)
    assert (numba.config.CPU_NAME, numba.config.CPU_FEATURES) == (LEVEL, "")
    assert os.environ["NUMBA_CPU_NAME"] == LEVEL


def test_a_processor_that_the_user_names_stays(
    installed: Path, packed: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _with_note(packed, installed, processor=LEVEL, features="")
    monkeypatch.setattr(archives, "is_of_level", lambda: True)
    monkeypatch.setattr("numba.config.CPU_NAME", "haswell")
    take_installed(elsewhere)
    assert numba.config.CPU_NAME == "haswell"
    assert not list(elsewhere.iterdir())
