"""Compiled kernels are kept, and never used with other sources than their own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from amorsim.kernels import cache_folder
from amorsim.kernels.compile import inlined, kernel, part


def _add(x: float, y: float) -> float:
    return x + y


@pytest.mark.parametrize("decorate", [kernel, part, inlined])
def test_a_kernel_computes_what_its_function_does(decorate: object) -> None:
    assert decorate(_add)(1.5, 2.0) == 3.5  # type: ignore[operator]


def test_division_by_zero_is_as_numpys() -> None:
    assert kernel(lambda x, y: x / y)(1.0, 0.0) == float("inf")


def test_numbas_own_cache_folder_is_left_alone() -> None:
    before = numba.config.CACHE_DIR
    kernel(_add)
    assert before == numba.config.CACHE_DIR


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for compiled kernels of this test's own."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    cache_folder.cache_folder.cache_clear()
    yield tmp_path
    cache_folder.cache_folder.cache_clear()


def test_the_folder_changes_with_the_sources(fresh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = cache_folder.cache_folder()
    sources = fresh / "sources"
    sources.mkdir()
    (sources / "one.py").write_text("a = 1\n")
    monkeypatch.setattr(cache_folder, "_SOURCES", sources)
    cache_folder.cache_folder.cache_clear()
    other = cache_folder.cache_folder()
    (sources / "one.py").write_text("a = 2\n")
    cache_folder.cache_folder.cache_clear()
    assert len({before, other, cache_folder.cache_folder()}) == 3


def test_a_new_folder_is_cold_until_it_is_marked(fresh: Path) -> None:
    assert cache_folder.is_cold()
    cache_folder.mark_warm()
    assert not cache_folder.is_cold()


def test_folders_of_other_sources_are_removed_after_a_week(fresh: Path) -> None:
    old, young = fresh / "amorsim" / "kernels-old", fresh / "amorsim" / "kernels-young"
    for folder in (old, young):
        folder.mkdir(parents=True)
    os.utime(old, (0, 0))
    cache_folder.cache_folder()
    assert not old.exists()
    assert young.exists()


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users to tell apart")
def test_a_folder_that_others_can_write_is_not_used(fresh: Path) -> None:
    (fresh / "amorsim").mkdir()
    (fresh / "amorsim").chmod(0o777)
    found = cache_folder.cache_folder()
    assert found is not None
    assert fresh not in found.parents


def test_importing_amorsim_starts_no_process_and_compiles_nothing(tmp_path: Path) -> None:
    program = (
        "import gc, subprocess\n"
        "def started(*_, **__): raise AssertionError('a process was started')\n"
        "subprocess.Popen.__init__ = started\n"
        "before = gc.isenabled(), gc.get_freeze_count()\n"
        "import amorsim as am\n"
        "am.Simulation, am.Map, am.run\n"
        "assert (gc.isenabled(), gc.get_freeze_count()) == before\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", program], env=environment, check=True)
    assert not list(tmp_path.rglob("*.nb?"))
