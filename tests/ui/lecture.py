"""A lecturer's quarter of an hour, as told in `docs/how-to/teach-with-the-window.md`: for its test and its pictures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.ui.test_window_editor import Editor
from tests.ui.windows import Window, expect

__all__ = ["give_it"]

LEFT_WHEEL = "errors.drive.wheel_radius_left.scale"


def give_it(editor: Editor, show: Callable[[str], None]) -> Path:
    """From an empty page to the page for the students, which is returned; `show` gets the name of each picture."""
    page = editor.page
    # An office, from the gallery.
    page.keyboard.press("a")
    page.get_by_label("search").fill("office")
    office = page.locator("dialog .card-choice:visible", has=page.locator("strong", has_text="office"))
    expect(office).to_contain_text("corridors")
    page.wait_for_timeout(300)
    show("gallery")
    editor.step(lambda: office.click())
    editor.until("stage.still.extent[2] > 20")
    # A wall, and a door in it: the generated walls become a file that can be drawn in.
    page.keyboard.press("w")
    page.get_by_role("button", name="make the walls a file").click()
    editor.until("toolName === 'line' && !wallsFixed && !state.is_behind")
    editor.look_near(6.0, 4.0, 55.0)
    editor.click(3.7, 3.4)
    editor.step(lambda: editor.click(7.8, 3.4))
    page.keyboard.press("d")
    editor.step(lambda: editor.click(5.8, 3.4))
    page.keyboard.press("Escape")
    # A robot that wanders, with a left wheel 0.3 % larger than it believes.
    page.keyboard.press("a")
    page.get_by_label("search").fill("pioneer2dx")
    page.locator("dialog .card-choice:visible", has_text="two driven wheels and a castor").first.click()
    editor.step(lambda: editor.click(2.0, 6.6))
    editor.until("stage.selection.only?.path === 'robots.0'")
    editor.unfold("robots.0.controller")
    editor.step(lambda: page.select_option("[id='use-robots.0.controller']", "wander"))
    editor.unfold("robots.0.knowledge")
    editor.step(lambda: page.select_option("[id='use-robots.0.knowledge']", "the world's"))
    editor.unfold("robots.0.errors")
    page.select_option("[id='add-robots.0.errors']", "drive.wheel_radius_left")
    editor.step(lambda: page.click("[aria-label='add an error']"))
    editor.unfold("robots.0.errors.drive.wheel_radius_left")
    scale = page.locator('[data-path="robots.0.errors.drive.wheel_radius_left.scale"] input').first
    scale.fill("1.003")
    editor.step(lambda: scale.press("Enter"))
    editor.until("!faults.length")
    show("drawn")
    # It runs, and drifts.
    page.click(".run")
    page.wait_for_url("**/run/untitled**", timeout=120_000)
    window = Window(page)
    window.until("stage.frame")
    _play(window, 575)
    show("drift")
    # Forty seconds back, and on with a smaller error.
    window.do(do="scrub", tick=200)
    page.wait_for_selector("#continue:visible")
    page.locator("#continue").click()
    window.until("futures.list.length === 1")
    number = window.field(LEFT_WHEEL).locator("input[type=text]")
    number.fill("1.001")
    number.press("Enter")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1.001")
    page.evaluate("document.activeElement.blur()")
    _play(window, 530)
    expect(page.locator(".futures li")).to_contain_text("m away")
    # For the class, and for the students.
    page.keyboard.press("c")
    page.wait_for_timeout(300)
    show("lecture")
    page.keyboard.press("c")
    with page.expect_download(timeout=240_000) as download:
        page.click("button:text-is('save ▾')")
        page.locator(".save-list").get_by_role("button", name="page", exact=True).click()
    kept = editor.folder / download.value.suggested_filename
    download.value.save_as(kept)
    return kept


def _play(window: Window, tick: int) -> None:
    """Let it run to a tick, fast enough to wait for."""
    window.do(do="speed", factor=20.0)
    window.do(do="run")
    window.until(f"newest.tick >= {tick}", seconds=240.0)
    window.do(do="pause")
