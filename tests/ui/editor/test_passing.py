"""The temporary folders of Editors: they go with their process, and those of killed ones with the next Editor."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.ui.editor.storage.passing import PassingFolder
from tests.ui.windows import Server

HOLDING = """
import sys, tempfile
tempfile.tempdir = sys.argv[1]
from amorsim.ui.editor.storage.passing import PassingFolder
folder = PassingFolder()
print(folder.path, flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_one_that_is_removed_holds_nothing_any_more(place: Path) -> None:
    folder = PassingFolder()
    (folder.path / "files").mkdir()
    folder.remove()
    folder.remove()
    assert list(place.iterdir()) == []
    with pytest.raises(AmorsimError, match="is ending"):
        _ = folder.path


@pytest.mark.skipif(os.name == "nt", reason="processes cannot be looked up there: nothing is removed")
def test_folders_of_killed_processes_are_removed_and_no_others(place: Path) -> None:
    mine = PassingFolder()
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDING, str(place)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    theirs = Path(process.stdout.readline().strip())
    new = place / "amorsim-edit-new"  # of an earlier version, which did not say whose it is
    other = place / "amorsim-other"
    for folder in (new, other):
        folder.mkdir()
    PassingFolder().remove()
    assert {mine.path, theirs, new, other} == set(place.iterdir())
    process.kill()
    process.communicate()
    PassingFolder().remove()
    assert {mine.path, new, other} == set(place.iterdir())
    mine.remove()


@pytest.mark.long
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_an_editor_that_is_ended_leaves_no_folder(end: signal.Signals, place: Path) -> None:
    state = {"AMORSIM_STATE": str(place / "state"), "TMPDIR": str(place)}
    server = Server(place / "x", words=("edit", "demo"), env=state)
    assert list(place.glob("amorsim-edit-*"))
    server.process.send_signal(end)
    server.process.wait(10.0)
    server.close()
    assert list(place.glob("amorsim-*")) == []
