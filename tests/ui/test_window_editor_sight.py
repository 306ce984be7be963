"""What is seen in the Editor stays in sight while it is drawn in, in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.test_window_editor import Editor
from tests.ui.windows import add_thing, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture
def editor(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    opened = Editor(browser, tmp_path)
    yield opened
    opened.close()


def test_the_view_stays_while_things_are_drawn_and_shows_all_of_another_world(editor: Editor) -> None:
    page = editor.page
    left, low, right, high = editor.see("stage.camera.bounds()")
    assert left < 0.0 < 8.0 < right  # room for the tutorial's first room
    assert low < 0.0 < 6.0 < high

    def view() -> list[float]:
        """Where things are on the page: faults below the drawing may take room from it."""
        return [*editor.see("stage.camera.toScreen(0, 0)"), editor.see("stage.camera.scale")]

    inspector = page.locator(".inspector")
    expect(inspector).to_contain_text("nothing is here yet: press R")
    before = view()
    add_thing(page, "pioneer2dx")
    editor.step(lambda: editor.click(2.0, 2.0))
    assert view() == pytest.approx(before)
    page.keyboard.press("Escape")
    expect(inspector).to_contain_text("nothing is selected")
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(8.0, 6.0))
    assert view() == pytest.approx(before)
    page.keyboard.press("w")
    editor.look_near(-6.0, -4.0, scale=40.0)  # out of the world as it was
    before = view()
    editor.click(-6.0, -4.0)
    editor.step(lambda: editor.click(-3.0, -4.0))
    assert view() == pytest.approx(before)
    editor.step(lambda: page.keyboard.press("Control+z"))
    assert view() == pytest.approx(before)

    page.select_option("select[aria-label='file and world']", "world")
    page.select_option("dialog select", "generate maze")
    editor.step(lambda: page.click("dialog .main"))
    editor.until("state.walls_fixed && stage.still.extent[2] > stage.still.extent[0]")
    x0, y0, x1, y1 = editor.see("stage.still.extent")
    left, low, right, high = editor.see("stage.camera.bounds()")
    assert left < x0 < x1 < right
    assert low < y0 < y1 < high
