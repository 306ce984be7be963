"""What killed processes leave is removed by the next one; what living ones use is not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.core.files import temporary_folders
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.temporary_folders import make_folder, own_name, remove_left, temporary_folder

pytestmark = pytest.mark.skipif(os.name == "nt", reason="processes cannot be looked up there: nothing is removed")

HOLDING = """
import sys
from pathlib import Path
from amorsim.core.files.temporary_folders import make_folder, own_name
place = Path(sys.argv[1])
print(make_folder(place), flush=True)
(place / own_name("room")).write_text("room")
print("ready", flush=True)
sys.stdin.read()
"""

WRITING = """
import os, signal, sys
from amorsim.core.files.atomic_files import replacing
with replacing(sys.argv[1]) as new:
    new.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_folders_and_files_of_a_killed_process_are_removed_and_no_others(tmp_path: Path) -> None:
    mine = make_folder(tmp_path)
    others = {mine, tmp_path / ".amorsim-abc", tmp_path / "amorsim-00000000-1-1-x", tmp_path / "notes"}
    for folder in others - {mine}:
        folder.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDING, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    theirs = Path(process.stdout.readline().strip())
    process.stdout.readline()
    assert len(set(tmp_path.iterdir()) - others) == 2
    remove_left(tmp_path)
    assert theirs.is_dir()  # it lives
    process.kill()
    process.communicate()
    remove_left(tmp_path)
    assert set(tmp_path.iterdir()) == others


def test_a_process_that_has_the_number_of_a_dead_one_does_not_keep_its_folders(tmp_path: Path) -> None:
    name = own_name("x")
    machine = name.removeprefix(".amorsim-").partition("-")[0]
    (tmp_path / name).mkdir()
    (tmp_path / f".amorsim-{machine}-{os.getpid()}-1-x").mkdir()  # begun at another time
    remove_left(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    machine = own_name("x").removeprefix(".amorsim-").partition("-")[0]
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").touch()
    (tmp_path / f".amorsim-{machine}-{os.getpid()}-1-x").symlink_to(tmp_path / "mine")
    remove_left(tmp_path)
    assert (tmp_path / "mine" / "file").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_the_next_write_takes_over_what_a_killed_one_left(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    subprocess.run([sys.executable, "-c", WRITING, str(file)], check=False)
    assert len(list(tmp_path.iterdir())) == 1
    write_text(file, "whole")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_temporary_folder_goes_and_comes_under_the_name_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(temporary_folders.tempfile, "tempdir", str(tmp_path))
    with temporary_folder("view") as folder:
        assert folder.parent == tmp_path
        assert folder.name.startswith("amorsim-view-")
        (folder / "file").touch()
    assert list(tmp_path.iterdir()) == []
