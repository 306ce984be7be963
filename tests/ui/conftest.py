"""A browser for the tests that need one; elsewhere than on Debian with its `chromium` they skip and say why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.sessions import start as start  # a fixture
from tests.ui.views import views as views  # a fixture
from tests.ui.windows import CHROMIUM, FLAGS, Server, Window, new_user, write_scenario


@pytest.fixture(scope="module")  # not longer: while Playwright runs, no other test can start a loop of its own
def browser() -> Iterator[Any]:
    pytest.importorskip("starlette", reason="the extra 'ui' is not installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"there is no {CHROMIUM}: apt-get install chromium")
    with playwright.sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def started(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(write_scenario(tmp_path_factory.mktemp("room")))
    yield server
    server.close()


@pytest.fixture
def served(browser: Any, started: Server) -> Server:
    """A simulator for tests with a browser: the same one for all, which `begin` takes to its start."""
    return started


@pytest.fixture
def open_window(browser: Any) -> Iterator[Callable[[Server], Window]]:
    """Opens windows, each of a user of its own; at the end none may have met an error in its script."""
    opened: list[Window] = []

    def open_one(server: Server) -> Window:
        window = Window(new_user(browser).new_page())
        opened.append(window)
        return window.open(server.address)

    yield open_one
    for window in opened:
        window.page.context.close()
    assert [problem for window in opened for problem in window.problems] == []


@pytest.fixture(scope="module")
def usual_user(browser: Any) -> Any:
    return new_user(browser)


@pytest.fixture
def window(usual_user: Any, served: Server) -> Iterator[Window]:
    """A window at the start, of a browser that was here before: but for what it has fetched, it remembers nothing.

    A test lets go of the keys that it holds, for the next one's window is the same page.
    """
    usual_user.clear_cookies()
    pages = usual_user.pages
    window = Window(pages[0] if pages else usual_user.new_page()).open(served.address)
    window.begin()
    yield window
    window.leave()
    for page in usual_user.pages[1:]:
        page.close()
    assert window.problems == []


@pytest.fixture
def project(served: Server) -> Path:
    return served.folder
