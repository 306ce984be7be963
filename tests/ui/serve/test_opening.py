"""The page that leads the browser to the window: who can read it, where it leads, when it goes."""

from __future__ import annotations

import stat
import tempfile
from pathlib import Path
from typing import Any

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.opening import OpeningPage
from tests.ui.windows import Server, Window, new_user


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


def test_only_the_user_can_read_it_and_it_goes_when_it_was_used(folder: Path) -> None:
    page = OpeningPage("http://127.0.0.1:80/?token=a&b")
    assert page.path.is_relative_to(folder)
    assert stat.S_IMODE(page.path.stat().st_mode) == 0o600
    assert stat.S_IMODE(page.path.parent.stat().st_mode) == 0o700
    assert "url=http://127.0.0.1:80/?token=a&amp;b" in page.path.read_text()
    page.remove()
    page.remove()
    assert list(folder.iterdir()) == []


def test_where_it_cannot_be_written_the_user_learns_what_to_do(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "nothing"))
    monkeypatch.setenv("HOME", str(folder / "nothing"))
    with pytest.raises(AmorsimError, match=r"the browser is not opened.*open the address by hand"):
        OpeningPage("http://127.0.0.1:80/?token=a")


@pytest.mark.long
def test_a_browser_gets_in_by_it_once(browser: Any, started: Server) -> None:
    page = OpeningPage(started.address)
    window = Window(new_user(browser).new_page()).open(page.path.as_uri())
    assert window.page.url == f"http://{started.address.split('/')[2]}/run/room"
    window.page.context.close()
    other = new_user(browser).new_page()
    other.goto(page.path.as_uri())
    other.get_by_text("each works once").wait_for()
    other.context.close()
