"""A browser for the tests that need one; elsewhere than on Debian with its `chromium` they skip and say why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.sessions import start as start  # a fixture
from tests.ui.windows import CHROMIUM, FLAGS, Server, Window, write_scenario


@pytest.fixture(scope="module")  # not longer: while Playwright runs, no other test can start a loop of its own
def browser() -> Iterator[Any]:
    pytest.importorskip("nicegui", reason="the extra 'ui' is not installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"there is no {CHROMIUM}: apt-get install chromium")
    with playwright.sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def served(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(write_scenario(tmp_path_factory.mktemp("room")))
    yield server
    server.close()


@pytest.fixture
def open_window(browser: Any) -> Iterator[Callable[[Server], Window]]:
    """Opens windows, each of a user of its own; at the end none may have met an error in its script."""
    opened: list[Window] = []

    def open_one(server: Server) -> Window:
        context = browser.new_context(viewport={"width": 1366, "height": 768}, accept_downloads=True)
        window = Window(context.new_page())
        opened.append(window)
        return window.open(server.address)

    yield open_one
    for window in opened:
        window.page.context.close()
    assert [problem for window in opened for problem in window.problems] == []


@pytest.fixture
def window(served: Server, open_window: Callable[[Server], Window]) -> Window:
    opened = open_window(served)
    opened.begin()
    return opened


@pytest.fixture
def project(served: Server) -> Path:
    return served.folder
