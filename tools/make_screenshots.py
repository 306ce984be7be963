"""Makes the pictures of the Simulator's window for the docs, in headless Chromium.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_screenshots.py [FOLDER]

Needs the extra "dev" and Debian's chromium.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

import amorsim

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from tests.ui.windows import CHROMIUM, FLAGS, Server, Window  # noqa: E402 - beside us, not installed

__all__ = ["make", "save"]

PICTURES = ROOT / "docs" / "pictures"
WIDTH, HEIGHT = 1366, 768


def make(folder: Path) -> None:
    """Write the pictures into `folder`."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as work:
        for name in ("demo.toml", "find-the-way.toml", "office.wld"):
            shutil.copy(Path(amorsim.__file__).parent / "scenarios" / name, work)
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        try:
            for scenario, pictures in (
                ("demo", (drift, lecture, overlay, past, futures)),
                ("find-the-way", (intended,)),
            ):
                server = Server(Path(work) / f"{scenario}.toml")
                try:
                    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
                    window = Window(page).open(server.address)
                    for picture in pictures:
                        picture(window)
                        page.mouse.move(WIDTH - 5, 5)
                        page.wait_for_timeout(400)
                        save(page.screenshot(), folder / f"simulator-{picture.__name__}.png")
                    page.close()
                finally:
                    server.close()
        finally:
            browser.close()


def drift(window: Window) -> None:
    """The demo after a minute: readings beside the walls."""
    _play(window, 600)
    window.see("plots.choose('apart')")


def lecture(window: Window) -> None:
    """The same, large, for a class."""
    window.page.set_viewport_size({"width": 1280, "height": 720})
    window.page.keyboard.press("c")


def overlay(window: Window) -> None:
    """One pane, dark: a left wheel five per cent too large, ten seconds later."""
    window.page.keyboard.press("c")
    window.page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
    number = window.field("errors.drive.wheel_radius_left.scale").locator("input[type=text]")
    number.fill("1.05")
    number.press("Enter")
    window.until("form.fields.get('errors.drive.wheel_radius_left.scale').parameter.value === 1.05")
    window.page.evaluate("document.activeElement.blur()")
    _play(window, 100)
    window.page.keyboard.press("l")
    window.page.keyboard.press("o")
    window.page.keyboard.press("f")
    window.see("stage.camera.zoom(2.6)")


def past(window: Window) -> None:
    """Driven by hand into a wall, and gone back to that moment by a click on its event."""
    window.page.keyboard.press("l")
    window.page.keyboard.press("o")
    window.do(do="restore", robot="rover")
    window.do(do="reset")
    window.do(do="hand_over", robot="rover", to="hand")
    window.do(do="drive", robot="rover", forward=0.8, turn=0.3)
    _play(window, 80)
    window.do(do="stop", robot="rover")
    window.page.locator(".events-list button", has_text="met").first.click()
    window.until("newest.states & 4")
    window.see("stage.camera.zoom(1.2)")
    window.see("plots.choose('forward')")
    window.see("plots.first.setMode('values')")


def futures(window: Window) -> None:
    """The drift of a left wheel 0.3 % too large beside that of one 0.1 % too large."""
    window.see("plots.choose('apart')")
    window.see("plots.first.setMode('difference')")
    window.do(do="restore", robot="rover")
    window.do(do="reset")
    _play(window, 300)
    window.do(do="scrub", tick=100)
    window.page.wait_for_selector("#continue:visible")
    window.page.locator("#continue").click()
    window.until("futures.list.length === 1")
    window.do(do="set", robot="rover", path="errors.drive.wheel_radius_left.scale", value=1.001)
    _play(window, 180)
    window.see("stage.fit()")
    window.see("stage.camera.zoom(1.2)")


def intended(window: Window) -> None:
    """The path, what was searched for it, and the arcs of a robot that finds its way."""
    window.do(do="step", steps=80)
    window.until("stage.intended.key.includes(' 80 ')")
    window.page.keyboard.press("f")
    window.see("stage.camera.zoom(1.7)")


def _play(window: Window, steps: int) -> None:
    """Let it run for `steps` steps, fast enough to wait for, slowly enough for the plots."""
    end = window.see("newest.tick") + steps
    window.do(do="speed", factor=20.0)
    window.do(do="run")
    window.until(f"newest.tick >= {end}", seconds=120.0)
    window.do(do="pause")
    window.do(do="speed", factor=1.0)


def save(data: bytes, target: Path) -> None:
    """Write a picture of a window, as small as it can be without a loss."""
    with Image.open(io.BytesIO(data)) as opened:
        opened.convert("RGB").save(target, optimize=True)  # fewer colours would change what they mean


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
