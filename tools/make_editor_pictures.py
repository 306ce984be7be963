"""Makes the pictures of "Your first simulation" and "Teach with the window", in headless Chromium, as a user would.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_editor_pictures.py [FOLDER]

Needs the extra "dev" and Debian's chromium.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from make_screenshots import save  # noqa: E402 - beside us, not installed

from tests.ui.lecture import give_it  # noqa: E402
from tests.ui.test_window_editor import Editor  # noqa: E402
from tests.ui.windows import CHROMIUM, FLAGS, SIMULATOR, add_thing  # noqa: E402

__all__ = ["do_it", "make"]

PICTURES = ROOT / "docs" / "pictures"


def make(folder: Path) -> None:
    """Write the pictures into `folder`."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as work:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        editor = Editor(browser, Path(work))
        try:

            def show(name: str) -> None:
                editor.page.wait_for_timeout(300)
                save(editor.page.screenshot(), folder / f"editor-{name}.png")

            do_it(editor, show)
        finally:
            editor.server.close()
        (Path(work) / "lecture").mkdir()
        lecture = Editor(browser, Path(work) / "lecture")
        lecture.page.set_viewport_size({"width": 1280, "height": 720})
        try:
            give_it(lecture, lambda name: save(lecture.page.screenshot(), folder / f"lecture-{name}.png"))
        finally:
            lecture.server.close()
            browser.close()


def do_it(editor: Editor, show: Callable[[str], None]) -> None:
    """The tutorial, from the empty page to the running simulation; `show` is called with the name of each picture."""
    page = editor.page
    show("empty")

    editor.look_near(4.0, 3.0, 78.0)
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(8.0, 6.0))
    page.keyboard.press("w")
    editor.click(5.0, 0.0)
    editor.step(lambda: editor.click(5.0, 6.0))
    page.keyboard.press("d")
    editor.step(lambda: editor.click(5.0, 2.0))
    page.mouse.move(*editor.at(5.0, 4.2))
    show("room")

    page.keyboard.press("Escape")
    add_thing(page, "pioneer2dx")
    editor.step(lambda: editor.drag((1.5, 1.5), (2.5, 2.5)))
    editor.until("stage.selection.only?.path === 'robots.0'")
    editor.unfold("robots.0.controller")
    editor.step(lambda: page.select_option("[id='use-robots.0.controller']", "wander"))
    page.wait_for_selector('[data-path="robots.0.controller.speed"]')  # what was chosen is there to be seen
    _scroll_to(editor, "robots.0.controller")
    show("robot")

    add_thing(page, "post")
    editor.step(lambda: editor.click(6.0, 4.8))
    editor.until("stage.selection.only?.kind === 'obstacle'")
    path = str(editor.see("stage.selection.only.path"))
    editor.unfold(f"{path}.motion")
    editor.step(lambda: page.select_option(f"[id='use-{path}.motion']", "loop"))
    page.click("text=draw the waypoints")
    for x, y in ((6.0, 4.8), (7.4, 4.8), (7.4, 3.4)):
        editor.click(x, y)
    editor.step(lambda: page.keyboard.press("Escape"))
    editor.step(lambda: editor.drag((6.7, 4.1), (6.2, 3.2)))
    show("path")

    page.click('[data-key="robots.0"]')
    page.wait_for_selector('[data-section="robots.0.errors"]')
    editor.unfold("robots.0.errors")
    page.select_option("[id='add-robots.0.errors']", "drive.wheel_radius_left")
    editor.step(lambda: page.click("[aria-label='add an error']"))
    editor.unfold("robots.0.errors.drive.wheel_radius_left")
    scale = page.locator('[data-path="robots.0.errors.drive.wheel_radius_left.scale"] input').first
    scale.fill("1.005")
    editor.step(lambda: scale.press("Enter"))
    page.click("text=try on a square of 10 m")
    page.wait_for_selector("dialog canvas", timeout=240_000)
    show("errors")
    page.keyboard.press("Escape")

    page.click(".run")
    page.wait_for_url("**/run/untitled**", timeout=120_000)
    page.wait_for_function(f"() => {SIMULATOR}?.stage.frame", timeout=120_000)
    page.keyboard.press("Space")
    page.wait_for_function(f"() => {SIMULATOR}.newest.tick > 300", timeout=240_000)
    page.keyboard.press("Space")
    show("run")
    page.click("text=← edit")
    editor.until("state && !state.is_behind && stage.still")


def _scroll_to(editor: Editor, section: str) -> None:
    """Bring a section of the inspector into sight, in one go: the inspector may be made again meanwhile."""
    editor.page.evaluate(
        "section => document.querySelector(`[data-section='${section}']`).scrollIntoView({ block: 'end' })", section
    )


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
