"""A lecturer's quarter of an hour in a real Chromium, from the gallery to the page for the students."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.ui.lecture import give_it
from tests.ui.test_window_editor import Editor

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


def test_a_lecturer_s_quarter_of_an_hour(browser: Any, tmp_path: Path) -> None:
    editor = Editor(browser, tmp_path)
    shown: list[str] = []
    try:
        page = give_it(editor, shown.append)
        away = editor.page.locator(".futures li").inner_text()
    finally:
        editor.close()
    assert shown == ["gallery", "drawn", "drift", "lecture"]
    assert "from 20.0 s" in away
    assert "untitled" in page.name
    assert page.stat().st_size < 3_000_000
    assert "<script" in page.read_text()
