"""Path, searched places, arcs, histogram and velocities of a controller, in the window."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim
from tests.ui.windows import Server, Window

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

SCENARIOS = Path(amorsim.__file__).parent / "scenarios"
BUTTONS = ".panel.control [aria-label='what is drawn of what it intends'] button"


def serve(folder: Path, name: str, map_name: str) -> Server:
    for file in (f"{name}.toml", map_name):
        shutil.copy(SCENARIOS / file, folder)
    return Server(folder / f"{name}.toml")


@pytest.fixture(scope="module")
def navigating(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = serve(tmp_path_factory.mktemp("way"), "find-the-way", "office.wld")
    yield server
    server.close()


@pytest.fixture(scope="module")
def crossing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = serve(tmp_path_factory.mktemp("crossing"), "crossing", "square.wld")
    yield server
    server.close()


def switch_all_off(window: Window, labels: list[str]) -> None:
    """Each switch takes something away from the picture; with all off, nobody asks."""
    window.switch_off("what is drawn of what it intends", labels)
    key = window.see("stage.intended.key")
    window.do(do="step", steps=5)
    window.page.wait_for_timeout(500)
    assert window.see("stage.intended.key") == key


def test_a_path_with_what_was_searched_and_the_arcs_is_drawn(
    navigating: Server, browser: Any, open_window: Callable[[Server], Window]
) -> None:
    window = open_window(navigating)
    window.do(do="step", steps=30)
    window.until("stage.intended.found?.path?.length > 1 && stage.intended.found.arcs.length > 1")
    switch_all_off(window, ["path", "searched", "arcs"])


def test_velocities_are_drawn(crossing: Server, browser: Any, open_window: Callable[[Server], Window]) -> None:
    window = open_window(crossing)
    window.do(do="step", steps=30)
    window.until("stage.intended.found?.ways?.length > 1")
    switch_all_off(window, ["velocities"])
