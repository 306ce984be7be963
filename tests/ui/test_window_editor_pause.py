"""What is typed in the Editor is a step at each pause in typing, and its faults show, in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.test_window_editor import Editor

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture
def editor(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    am.open_document("demo").save(tmp_path / "mine.toml", copy=True)
    opened = Editor(browser, tmp_path, "mine.toml")
    yield opened
    opened.close()


def test_faults_of_the_text_show_at_their_lines_after_a_pause_in_typing(editor: Editor) -> None:
    page = editor.page
    module = "import('/amorsim/web/editor/code.js').then(({ PAUSE }) => PAUSE)"
    assert page.evaluate(module) <= 500  # [ms]: half of the second is left for the work
    steps = editor.see("state.steps")
    page.click("text=text")
    page.wait_for_selector(".beside .cm-content")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+End")
    page.keyboard.type("\n[[robots]]\nname = 5\n")
    page.wait_for_selector(".beside .code-fault-text")
    editor.until(f"state.steps > {steps}")
    page.click(".beside .main")
    editor.until("faults.length > 0")
    while editor.see("state.steps") > steps:
        editor.step(lambda: page.keyboard.press("Control+z"))
    editor.until("faults.length === 0")
    editor.until("state.is_saved")
