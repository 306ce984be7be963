"""A disk that is really full: a small one in memory, where the system allows to mount one."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.studies import make_study

RUN = """
mount -t tmpfs -o size="$1" tmpfs "$2" || exit 77
shift 2
"$@"
status=$?
cp -r disk kept
exit $status
"""


@pytest.mark.long
@pytest.mark.parametrize("size", ["400k", "700k"])
def test_a_run_that_fills_the_disk_ends_truthfully(tmp_path: Path, size: str) -> None:
    if shutil.which("unshare") is None:
        pytest.skip("there is no unshare to mount a disk with")
    study = make_study(tmp_path / "study")
    (tmp_path / "disk").mkdir()
    run = [sys.executable, "-m", "amorsim", "run", str(study), "--out", "disk/run", "-q"]
    command = ["unshare", "--map-root-user", "--mount", "sh", "-c", RUN, "sh", size, "disk", *run]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    if done.returncode in (1, 77) and "amorsim" not in done.stderr:
        pytest.skip(f"no disk can be mounted: {done.stderr}")
    assert done.returncode == 2, done.stderr
    assert "cannot be written (No space left on device)" in done.stderr
    folder = tmp_path / "kept" / "run"
    about = json.loads((folder / "run.json").read_text())
    assert about["status"] == "broken off"
    assert about["digests"] == {}
    assert "No space left on device" in about["problem"]
    tables = [path for path in folder.rglob("*.csv") if path.name != "events.csv"]
    ends = []
    for path in tables:
        text = path.read_text()
        assert text.endswith("\n"), path
        _, *lines = text.splitlines()
        ends.append(float(lines[-1].split(",")[0]) if lines else 0.0)
    assert about["steps_done"] == round(min(ends) / about["dt"])
    assert f"end early, the first of them at {min(ends):g} s" in done.stderr
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]
