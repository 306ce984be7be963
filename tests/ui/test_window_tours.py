"""Help in the windows: the tours of the Simulator and the Editor, and manuals of components, in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.ui.test_window_editor import Editor
from tests.ui.windows import Window, axe_violations, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


def take(page: Any) -> list[str]:
    """Take the tour that is offered with the keys; what it told."""
    page.keyboard.press("?")
    page.get_by_role("button", name="a tour of this page").click()
    tour, told = page.locator(".tour"), []
    assert axe_violations(page) == []
    while tour.count():
        told.append(tour.locator("p").inner_text())
        box, mark = tour.bounding_box(), page.locator(".tour-mark").bounding_box()
        size = page.viewport_size
        assert 0 <= box["x"] <= size["width"] - box["width"]
        assert 0 <= box["y"] <= size["height"] - box["height"]
        assert mark["width"] > 20
        tour.get_by_role("button", name="done" if "done" in tour.inner_text() else "next").click()
    return told


def test_the_simulator_shows_itself(window: Window) -> None:
    told = take(window.page)
    assert len(told) == 9
    assert told[0].startswith("The world as it is")
    # Escape ends it, and its keys are not the window's.
    window.page.keyboard.press("?")
    window.page.get_by_role("button", name="a tour of this page").click()
    window.page.keyboard.press("ArrowRight")
    expect(window.page.locator(".tour")).to_contain_text("What the robot knows")
    window.page.keyboard.press("Escape")
    expect(window.page.locator(".tour")).to_have_count(0)
    assert window.see("newest.tick") == 0


def test_the_editor_shows_itself(browser: Any, tmp_path: Path) -> None:
    editor = Editor(browser, tmp_path, "demo")
    try:
        assert len(take(editor.page)) == 8
    finally:
        editor.close()


def test_a_question_mark_opens_the_manual_of_a_component(browser: Any, tmp_path: Path) -> None:
    editor = Editor(browser, tmp_path, "demo")
    page = editor.page
    try:
        page.get_by_role("button", name="rover").first.click()
        editor.unfold("robots.0.controller")
        page.get_by_role("button", name="what wander is, and what its fields are").click()
        manual = page.get_by_role("dialog", name="controller wander")
        expect(manual).to_contain_text("Roams for ever: straight on while the way is free")
        expect(manual.get_by_role("rowheader", name="turn_rate_deg")).to_be_visible()
        assert axe_violations(page) == []
        page.keyboard.press("Escape")
        expect(manual).to_have_count(0)
    finally:
        editor.close()


@pytest.mark.long
def test_parts_of_a_running_robot_have_their_manuals(window: Window) -> None:
    page = window.page
    page.get_by_role("button", name="? differential").click()
    manual = page.get_by_role("dialog", name="drive differential")
    expect(manual).to_contain_text("Two driven wheels on one axle")
    expect(manual.get_by_role("rowheader", name="track", exact=True)).to_be_visible()
    assert axe_violations(page) == []
    page.keyboard.press("Escape")
    expect(manual).to_have_count(0)
    said = window.ask(do="manual", kind="drive", name="nothing")
    assert "with a manual" in said["error"]
